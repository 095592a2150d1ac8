//! A spline that is proven to be one to one within a box.
//!
//! *Theory.* The box is split until in every part each Jacobian is proven to have an inverse ([`Local`]). In a part that is still
//! in doubt when it is small, what the determinant is decides.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use rayon::prelude::*;

use super::bound::Local;
use super::spline::Spline;
use super::warp::Frame;
use crate::math::Aabb;

/// A spline without folds within a box.
#[derive(Clone, Debug, PartialEq)]
pub struct Morph {
    pub(super) spline: Spline,
    within: Aabb,
    smallest_stretch: f64,
}

/// A place where a spline is not one to one.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "space folds over itself about {:.2} {:.2} {:.2} mm (before the deformation), near landmark {nearest}: det J is {determinant:.3} \
     there, and must be above 0; move that landmark less, add landmarks round it, or raise the stiffness",
    .place_mm.x, .place_mm.y, .place_mm.z
)]
pub struct Fold {
    /// Where, before the deformation.
    pub place_mm: DVec3,
    /// The determinant of the Jacobian there, the least beside a landmark.
    pub determinant: f64,
    /// The landmark nearest to it.
    pub nearest: String,
}

/// Parts along each edge of the box that are looked at in parallel.
const PARTS: usize = 8;

/// How often a part is halved at most: to 1/8192 of the box's edges.
const HALVINGS: u32 = 10;

impl Morph {
    /// `spline`, for what lies within `within` (mm).
    ///
    /// # Errors
    /// If the spline folds there.
    pub fn new(spline: Spline, within: Aabb) -> Result<Self, Fold> {
        let parts: Vec<Result<f64, Fold>> = (0..PARTS.pow(3))
            .into_par_iter()
            .map(|n| unfolded(&spline, &part(&within, n), HALVINGS))
            .collect();
        let smallest_stretch = parts
            .into_iter()
            .try_fold(f64::INFINITY, |least, part| part.map(|p| least.min(p)))?;
        Ok(Self {
            spline,
            within,
            smallest_stretch,
        })
    }

    /// The spline.
    pub fn spline(&self) -> &Spline {
        &self.spline
    }

    /// The box in which it does not fold, millimetres.
    pub fn within(&self) -> &Aabb {
        &self.within
    }

    /// A box that holds what it makes of a box.
    pub(in crate::model) fn image_bounds(&self, source: &Aabb) -> Aabb {
        match source.is_finite() {
            true => Frame::new(&Arc::new(self.clone()), [&DAffine3::IDENTITY; 2], 1.0, 1.0).image_bounds(source),
            false => *source,
        }
    }

    /// The least determinant of the Jacobian seen within the box: by how much space is squeezed where it is most.
    pub fn smallest_stretch(&self) -> f64 {
        self.smallest_stretch
    }
}

/// The `n`th of a box's parts.
fn part(whole: &Aabb, n: usize) -> Aabb {
    let at = DVec3::from([n % PARTS, n / PARTS % PARTS, n / (PARTS * PARTS)].map(|i| i as f64));
    let size = whole.size() / PARTS as f64;
    Aabb::new(whole.min + at * size, whole.min + (at + 1.0) * size)
}

/// The least determinant seen in `cell`.
fn unfolded(spline: &Spline, cell: &Aabb, halvings: u32) -> Result<f64, Fold> {
    let (x, radius) = (cell.center(), 0.5 * cell.size().length());
    let local = Local::bounded(spline, x, radius);
    let here = spline.point_and_jacobian(x).1.determinant();
    let proven = local.inverse().is_some() && here > 0.0;
    if !proven && here > 0.0 && halvings > 0 {
        return (0..8).try_fold(here, |least, octant| {
            let half = Aabb::of_points([cell.corners()[octant], x]);
            unfolded(spline, &half, halvings - 1).map(|d| least.min(d))
        });
    }
    let least = match local.kinks > 0.0 && halvings == 0 {
        true => here.min(beside_landmark(spline, &local, x)),
        false => here,
    };
    if least > 0.0 {
        return Ok(least);
    }
    Err(Fold {
        place_mm: x,
        determinant: least,
        nearest: spline.nearest(x).to_owned(),
    })
}

/// The least determinant beside the landmark nearest to `x`. At a landmark of weight w the Jacobian is S + w nᵀ with every unit
/// vector n, and its determinant det S (1 + nᵀ S⁻¹ w).
fn beside_landmark(spline: &Spline, local: &Local, x: DVec3) -> f64 {
    let weight = spline.columns.weight(spline.nearest_index(x));
    local.jacobian.determinant() * (1.0 - (local.jacobian.inverse() * weight).length())
}
