//! Deformations: where their landmarks come from (VCSG §2.2, *deformation*).

use std::path::Path;

use super::element::Element;
use super::error::{Problem, SceneError};
use crate::math::Aabb;
use crate::model::deform::files::{paired, read_pairs, read_points};
use crate::model::deform::{Landmark, Morph, Smoothness, Spline};

type Result<T> = std::result::Result<T, SceneError>;

/// What samples may be displaced by, in voxels, unless a scene says otherwise.
const ERROR_VOXELS: f64 = 0.1;

/// The part of its size by which the box that is proven free of folds is larger, for soft surfaces.
const BEYOND: f64 = 0.05;

/// Property `error`.
pub(super) fn error_voxels(element: &Element) -> Result<f64> {
    element.get("error").map_or(Ok(ERROR_VOXELS), |v| v.within(1e-3, 100.0))
}

/// The spline of a `deform` node, whose paths start in `base_dir`.
pub(super) fn spline(element: &Element, base_dir: &Path) -> Result<Spline> {
    let landmarks = landmarks(element, base_dir)?;
    let smoothness = Smoothness {
        stiffness: element.get("stiffness").map_or(Ok(0.0), |v| v.within(0.0, 1e12))?,
        support_mm: element.get("support").map(|v| v.positive()).transpose()?,
    };
    Spline::new(&landmarks, &smoothness).map_err(|e| element.error(Problem::Deformation(e.to_string())))
}

/// The spline where it deforms what lies in `bounds`.
pub(super) fn morph(element: &Element, spline: Spline, bounds: &Aabb) -> Result<Morph> {
    let fails = |message: String| element.error(Problem::Deformation(message));
    if !bounds.is_empty() && !bounds.is_finite() {
        let endless =
            "what is deformed is endless: intersect it with a volume, a box or a sphere inside the deformation";
        return Err(fails(endless.into()));
    }
    let within = match bounds.is_empty() {
        true => Aabb::of_points([Default::default()]),
        false => bounds.expand(bounds.size() * BEYOND),
    };
    Morph::new(spline, within).map_err(|fold| fails(fold.to_string()))
}

fn landmarks(element: &Element, base_dir: &Path) -> Result<Vec<Landmark>> {
    let inline = pairs(element)?;
    let [table, before, after] = ["landmarks", "from", "to"].map(|key| element.get(key));
    let fails = |key: &str, e: &dyn std::fmt::Display| element.error_of(key, Problem::Landmarks(e.to_string()));
    match (inline.is_empty(), table, before, after) {
        (false, None, None, None) => Ok(inline),
        (true, Some(file), None, None) => {
            let path = base_dir.join(file.string()?);
            read_pairs(&path).map_err(|e| fails("landmarks", &e))
        }
        (true, None, Some(before), Some(after)) => {
            let before = read_points(&base_dir.join(before.string()?)).map_err(|e| fails("from", &e))?;
            let after = read_points(&base_dir.join(after.string()?)).map_err(|e| fails("to", &e))?;
            paired(&before, &after).map_err(|e| fails("to", &e))
        }
        _ => Err(element.error(Problem::Conflict(
            "a deformation takes its landmarks from `pair` children, or a file `landmarks`, or two files `from` and `to`",
        ))),
    }
}

/// The `pair` children.
fn pairs(element: &Element) -> Result<Vec<Landmark>> {
    let mut landmarks = Vec::new();
    for child in element.children() {
        let child = child?;
        if child.name() != "pair" {
            continue;
        }
        let name = child.get("name").map(|v| v.string()).transpose()?;
        let number = landmarks.len() + 1;
        landmarks.push(Landmark {
            name: name.map_or_else(|| format!("{number}"), str::to_owned),
            from: child.require("from")?.vector()?,
            to: child.require("to")?.vector()?,
        });
    }
    Ok(landmarks)
}
