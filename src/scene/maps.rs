//! The `map` node: functions of one value (VCSG §2.2, *transfering*).

use super::element::Element;
use super::error::{Problem, SceneError};
use crate::model::ValueMap;

type Result<T> = std::result::Result<T, SceneError>;

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Linear,
    Quadratic,
    Table,
}

/// The function of a `map` node. Its `at` children are the points of a table.
///
/// # Errors
/// If a value is missing, wrong, or belongs to another kind of map.
pub(super) fn value_map(element: &Element, points: &[Element]) -> Result<ValueMap> {
    let kinds = [
        ("linear", Kind::Linear),
        ("quadratic", Kind::Quadratic),
        ("table", Kind::Table),
    ];
    let kind = element.argument(0).one_of(&kinds)?;
    let foreign: &[&'static str] = match kind {
        Kind::Linear => &["a", "b", "c"],
        Kind::Quadratic => &["scale", "offset"],
        Kind::Table => &["scale", "offset", "a", "b", "c"],
    };
    if let Some(&key) = foreign.iter().find(|key| element.get(key).is_some()) {
        let problem =
            Problem::Conflict("`scale` and `offset` are of a linear map, `a`, `b` and `c` of a quadratic one");
        return Err(element.error_of(key, problem));
    }
    if let (Some(point), true) = (points.first(), kind != Kind::Table) {
        return Err(point.error(Problem::Conflict("`at` points are of a table map")));
    }
    let number = |key, default| element.get(key).map_or(Ok(default), |v| v.single());
    Ok(match kind {
        Kind::Linear => ValueMap::Linear {
            scale: number("scale", 1.0)?,
            offset: number("offset", 0.0)?,
        },
        Kind::Quadratic => ValueMap::Quadratic {
            a: number("a", 0.0)?,
            b: number("b", 0.0)?,
            c: number("c", 0.0)?,
        },
        Kind::Table => table(element, points)?,
    })
}

fn table(element: &Element, points: &[Element]) -> Result<ValueMap> {
    let mut pairs: Vec<(f32, f32)> = Vec::with_capacity(points.len());
    for point in points {
        let input = point.argument(0);
        let pair = (input.single()?, point.argument(1).single()?);
        if pairs.last().is_some_and(|last| last.0 >= pair.0) {
            return Err(input.bad("above the point before it"));
        }
        pairs.push(pair);
    }
    if pairs.is_empty() {
        let (node, wanted) = (element.name(), "at least one point `at INPUT OUTPUT`");
        return Err(element.error(Problem::TooFewChildren { node, wanted, found: 0 }));
    }
    Ok(ValueMap::Table(pairs.into()))
}
