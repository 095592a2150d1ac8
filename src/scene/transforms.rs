//! Nodes that move their children (VCSG §2.2, *transforming*).

use glam::{DAffine3, DMat3, DVec3};

use super::element::Element;
use super::error::{Problem, SceneError};
use crate::math::affine;

/// The map of a transform node, or `None` for another kind of node.
///
/// # Errors
/// If a value is missing or wrong, or the map has no inverse.
pub(super) fn parent_from_child(element: &Element) -> Result<Option<DAffine3>, SceneError> {
    let map = match element.name() {
        "translate" => DAffine3::from_translation(element.argument(0).vector()?),
        "rotate" => rotation(element)?,
        "scale" => scaling(element)?,
        "mirror" => reflection(element)?,
        "shear" => shear(element)?,
        "matrix" => matrix(element.argument(0).numbers()?),
        _ => return Ok(None),
    };
    let node = element.name();
    match affine::invert(&map) {
        Some(_) => Ok(Some(map)),
        None => Err(element.error(Problem::Singular { node })),
    }
}

/// The step of a `repeat` node: a turn about its centre, then a shift.
pub(super) fn step(element: &Element) -> Result<DAffine3, SceneError> {
    let shift = element.get("by").map_or(Ok(DVec3::ZERO), |v| v.vector())?;
    let axis = element.get("axis").map_or(Ok(DVec3::Z), |v| v.direction())?;
    let angle_deg = element.get("angle").map_or(Ok(0.0), |v| v.number())?;
    let turn = DMat3::from_axis_angle(axis, angle_deg.to_radians());
    Ok(DAffine3::from_translation(shift) * about_center(element, turn)?)
}

fn rotation(element: &Element) -> Result<DAffine3, SceneError> {
    let axis = element.require("axis")?.direction()?;
    let angle_deg = element.require("angle")?.number()?;
    let turn = DMat3::from_axis_angle(axis, angle_deg.to_radians());
    about_center(element, turn)
}

fn scaling(element: &Element) -> Result<DAffine3, SceneError> {
    let factor = element.argument(0);
    let factors = match factor.string() {
        Ok(_) => factor.vector()?,
        Err(_) => DVec3::splat(factor.number()?),
    };
    about_center(element, DMat3::from_diagonal(factors))
}

/// p ↦ p − 2 n (n · (p − point)).
fn reflection(element: &Element) -> Result<DAffine3, SceneError> {
    let normal = element.require("normal")?.direction()?;
    let point = element.get("point").map_or(Ok(DVec3::ZERO), |v| v.vector())?;
    let outer = DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
    Ok(fixing(point, DMat3::IDENTITY - outer * 2.0))
}

/// Property `ab` is how far axis a moves for each millimetre along axis b.
fn shear(element: &Element) -> Result<DAffine3, SceneError> {
    let amount = |key| element.get(key).map_or(Ok(0.0), |v| v.number());
    let linear = DMat3::from_cols(
        DVec3::new(1.0, amount("yx")?, amount("zx")?),
        DVec3::new(amount("xy")?, 1.0, amount("zy")?),
        DVec3::new(amount("xz")?, amount("yz")?, 1.0),
    );
    about_center(element, linear)
}

/// Three rows of four.
fn matrix(m: [f64; 12]) -> DAffine3 {
    DAffine3 {
        matrix3: DMat3::from_cols(
            DVec3::new(m[0], m[4], m[8]),
            DVec3::new(m[1], m[5], m[9]),
            DVec3::new(m[2], m[6], m[10]),
        ),
        translation: DVec3::new(m[3], m[7], m[11]),
    }
}

fn about_center(element: &Element, linear: DMat3) -> Result<DAffine3, SceneError> {
    let center = element.get("center").map_or(Ok(DVec3::ZERO), |v| v.vector())?;
    Ok(fixing(center, linear))
}

/// The map with linear part `linear` that leaves `point` where it is.
fn fixing(point: DVec3, linear: DMat3) -> DAffine3 {
    DAffine3 {
        matrix3: linear,
        translation: point - linear * point,
    }
}
