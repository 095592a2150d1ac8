//! Presets from their KDL text.

use kdl::{KdlDocument, KdlNode, KdlValue};

use super::{Kind, Look, Preset, Scale};
use crate::math::Interval;
use crate::projection::{ControlPoint, Material, Mode, TransferFunction, rgb_from_hex};

/// The preset in `text`, or what is wrong with it.
pub(super) fn preset(text: &'static str) -> Result<Preset, String> {
    let document = KdlDocument::parse_v2(text).map_err(|e| e.to_string())?;
    let node = document.get("preset").ok_or("no `preset` node")?;
    let name = string(node, 0)?;
    let complain = |what: String| format!("{name}: {what}");
    let named = |child: &&KdlNode| child.name().value() == "point";
    let points = node.iter_children().filter(named).map(point);
    let points = points.collect::<Result<_, _>>().map_err(complain)?;
    let function = TransferFunction::new(points, number(node, "unit-mm")?.into());
    Ok(Preset {
        text,
        kind: one_of(node, "kind", Kind::NAMES).map_err(complain)?,
        scale: one_of(node, "scale", Scale::NAMES).map_err(complain)?,
        description: Box::leak(string(node, "description")?.into_boxed_str()),
        range: Interval::new(number(node, "from")?, number(node, "to")?),
        function: function.map_err(|e| complain(e.to_string()))?,
        look: look(node).map_err(complain)?,
        name: Box::leak(name.clone().into_boxed_str()),
    })
}

/// The mode, and the `material` child that shading has.
fn look(node: &KdlNode) -> Result<Look, String> {
    let mut material = node.iter_children().filter(|child| child.name().value() == "material");
    Ok(Look {
        mode: one_of(node, "mode", Mode::NAMES)?,
        material: material.next().map(self::material).transpose()?,
    })
}

fn material(node: &KdlNode) -> Result<Material, String> {
    let shininess = number(node, "shininess")? as u32;
    if !shininess.is_power_of_two() {
        return Err(format!("shininess {shininess} is no power of two"));
    }
    Ok(Material {
        ambient: number(node, "ambient")?,
        diffuse: number(node, "diffuse")?,
        specular: number(node, "specular")?,
        shininess_log2: shininess.ilog2(),
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

fn one_of<T: Copy>(node: &KdlNode, key: &str, names: &[(&str, T)]) -> Result<T, String> {
    let found = string(node, key)?;
    let named = names.iter().find(|(name, _)| *name == found);
    named.map(|(_, value)| *value).ok_or_else(|| format!("{key} {found}"))
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
