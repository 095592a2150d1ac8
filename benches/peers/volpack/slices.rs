//! VolPack's rays, and what it makes of them: a picture at the volume's resolution, warped to the frame.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::causes::Cause;
use super::model::{Model, Ray};

/// The number of weights in the table of the warp.
const WEIGHTS: f64 = 64.0;

/// VolPack's rays: one for each voxel of the slice that is first in each direction, and of what others stand out.
pub struct SliceRays {
    /// Across the slices.
    axis: usize,
    /// The other two axes.
    across: [usize; 2],
    along: DVec3,
    /// Ray (0, 0), where it meets slice 0.
    first: DVec2,
    size: [usize; 2],
}

/// What they show.
pub struct SlicePicture {
    rays: SliceRays,
    light: Vec<f64>,
}

impl SliceRays {
    /// Those of a model's view.
    pub fn new(model: &Model) -> Self {
        let along = model.ray(DVec2::ZERO).along;
        let axis = along.abs().max_position();
        let across = [(axis + 1) % 3, (axis + 2) % 3];
        let dims = model.dims();
        let last = dims[axis] as f64 - 1.0;
        // How far rays go across from each slice to the next.
        let drift = across.map(|a| along[a] / along[axis]);
        Self {
            axis,
            across,
            along,
            // Rays that drift down go through the voxels of slice 0, others through those of the last; one more lies before them.
            first: DVec2::from_array(drift.map(|d| -d.max(0.0) * last - 1.0)),
            size: std::array::from_fn(|a| dims[across[a]] + 1 + (last * drift[a].abs()).ceil() as usize),
        }
    }

    /// Casts them.
    pub fn draw(self, model: &Model) -> SlicePicture {
        let [width, height] = self.size;
        let rays = (0..width * height).into_par_iter();
        let light = rays.map(|n| model.cast(self.ray(n % width, n / width))).collect();
        SlicePicture { rays: self, light }
    }

    fn ray(&self, u: usize, v: usize) -> Ray {
        let mut through = DVec3::ZERO;
        through[self.across[0]] = self.first.x + u as f64;
        through[self.across[1]] = self.first.y + v as f64;
        Ray {
            through,
            along: self.along,
        }
    }
}

impl SlicePicture {
    /// Bilinear at a place in the frame.
    pub fn at(&self, model: &Model, px: DVec2) -> f64 {
        let met = model.ray(px).in_slice(self.rays.axis, 0.0);
        let [a, b] = self.rays.across;
        let place = DVec2::new(met[a], met[b]) - self.rays.first;
        let base = place.floor();
        let fraction = match model.is(Cause::Rounding) {
            true => ((place - base) * WEIGHTS).floor() / (WEIGHTS - 1.0),
            false => place - base,
        };
        let light = |u: f64, v: f64| {
            let [width, height] = self.rays.size;
            let inside = u >= 0.0 && v >= 0.0 && u < width as f64 && v < height as f64;
            if inside {
                self.light[u as usize + width * v as usize]
            } else {
                0.0
            }
        };
        let row = |v: f64| (1.0 - fraction.x) * light(base.x, v) + fraction.x * light(base.x + 1.0, v);
        (1.0 - fraction.y) * row(base.y) + fraction.y * row(base.y + 1.0)
    }
}
