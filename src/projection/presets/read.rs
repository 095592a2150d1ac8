//! Presets from their KDL text.

use kdl::{KdlDocument, KdlNode, KdlValue};

use super::{Kind, Preset};
use crate::math::Interval;
use crate::projection::{ControlPoint, TransferFunction, rgb_from_hex};

/// The preset in `text`, or what is wrong with it.
pub(super) fn preset(text: &'static str) -> Result<Preset, String> {
    let document = KdlDocument::parse_v2(text).map_err(|e| e.to_string())?;
    let node = document.get("preset").ok_or("no `preset` node")?;
    let name = string(node, 0)?;
    let complain = |what: String| format!("{name}: {what}");
    let kind = match string(node, "kind")?.as_str() {
        "ct" => Kind::Ct,
        "mr" => Kind::Mr,
        "any" => Kind::Any,
        other => return Err(complain(format!("kind {other}"))),
    };
    let points = node
        .iter_children()
        .map(point)
        .collect::<Result<_, _>>()
        .map_err(complain)?;
    Ok(Preset {
        kind,
        description: Box::leak(string(node, "description")?.into_boxed_str()),
        range: Interval::new(number(node, "from")?, number(node, "to")?),
        function: TransferFunction::new(points, number(node, "unit-mm")?.into())
            .map_err(|e| complain(e.to_string()))?,
        name: Box::leak(name.clone().into_boxed_str()),
    })
}

fn point(node: &KdlNode) -> Result<ControlPoint, String> {
    let color = string(node, "color")?;
    Ok(ControlPoint {
        value: number(node, 0)?,
        color: rgb_from_hex(&color).ok_or_else(|| format!("colour {color}"))?,
        opacity: number(node, "opacity")?,
    })
}

fn string(node: &KdlNode, key: impl Into<kdl::NodeKey>) -> Result<String, String> {
    let value = node.get(key).and_then(KdlValue::as_string);
    value
        .map(str::to_owned)
        .ok_or_else(|| format!("a string is missing in `{node}`"))
}

fn number(node: &KdlNode, key: impl Into<kdl::NodeKey>) -> Result<f32, String> {
    match node.get(key) {
        Some(KdlValue::Float(f)) => Ok(*f as f32),
        Some(KdlValue::Integer(i)) => Ok(*i as f32),
        _ => Err(format!("a number is missing in `{node}`")),
    }
}
