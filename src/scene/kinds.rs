//! Values and colours: what a node makes, and what goes together.

use std::path::Path;

use super::appearance;
use super::element::Element;
use super::error::{Problem, SceneError};
use super::transfer::TransferChoice;
use crate::model::{BooleanOp, Kind, TransferFunction, ValueRule};
use crate::projection::presets;

type Result<T> = std::result::Result<T, SceneError>;

/// Whether two operands give the same; else the second is at fault.
pub(super) fn require_one(first: Element, gives: Kind, second: Element, other: Kind) -> Result<()> {
    if gives == other {
        return Ok(());
    }
    Err(second.error(Problem::Mixed {
        first: first.name(),
        line: first.line(),
        gives: named(gives),
        second: second.name(),
        other: named(other),
    }))
}

/// The rule of `node` for operands like `operand`: the one that is `asked` for if it suits them, or their usual one. Colours that are
/// united lie one over the other.
pub(super) fn rule_for(
    node: &Element,
    op: BooleanOp,
    asked: Option<ValueRule>,
    operand: Element,
    kind: Kind,
) -> Result<ValueRule> {
    match asked {
        Some(rule) if rule.is_for(kind) => Ok(rule),
        Some(_) => {
            let rule = node.get("rule").and_then(|v| v.string().ok()).unwrap_or("lut");
            Err(node.error_of(
                "rule",
                Problem::RuleKind {
                    rule: rule.into(),
                    operand: operand.name(),
                    line: operand.line(),
                    gives: named(kind),
                },
            ))
        }
        None => Ok(match (op, kind) {
            (BooleanOp::Union | BooleanOp::SubtractionWithRule, Kind::Color) => ValueRule::Over,
            (BooleanOp::SubtractionWithRule, Kind::Value) => ValueRule::Second,
            _ => ValueRule::First,
        }),
    }
}

fn named(kind: Kind) -> &'static str {
    match kind {
        Kind::Value => "values",
        Kind::Color => "colours",
    }
}

/// The transfer function of a `classify` node. Nothing is fitted to the data here: what a node is does not depend on the rest of
/// the scene.
pub(super) fn transfer_function(element: &Element) -> Result<TransferFunction> {
    let spec = appearance::transfer(element, Path::new(""))?;
    let preset = match &spec.choice {
        TransferChoice::Points(function) => return Ok(function.clone()),
        TransferChoice::File(property) => return Ok(spec.with_unit(&property.function)),
        TransferChoice::Preset(preset) => preset,
        TransferChoice::Automatic => {
            let (node, wanted) = (element.name(), "a `preset`, or at least one `point`");
            return Err(element.error(Problem::TooFewChildren { node, wanted, found: 0 }));
        }
    };
    let window = match (spec.window, preset.scale()) {
        (Some(window), _) => window,
        (None, presets::Scale::Absolute) => preset.range(),
        (None, _) => {
            let why = "this preset holds fractions of a window: give `window` and `level` too";
            return Err(element.error_of("preset", Problem::Conflict(why)));
        }
    };
    // Of a model without extent a preset takes its own unit.
    let unit_mm = spec.unit_mm.unwrap_or(preset.unit_for(0.0));
    Ok(preset.transfer_function(window, unit_mm))
}
