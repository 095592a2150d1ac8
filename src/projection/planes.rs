//! The global set of sampling planes (design §5).
//!
//! *Changes from the paper.* VCSG gives each block its own consecutive planes. Here all blocks share the planes
//! `z = z₀ + k·δ` of eye space, so samples keep their phase across block faces, and every projector takes the same samples.
//! *Practice.* z₀ lies half a step from a corner of the lattice: in a view along an axis, with a whole number of samples a
//! voxel, no plane then falls on a face between blocks.

use std::ops::Range;

use glam::DAffine3;

use super::Camera;
use crate::math::affine;
use crate::target::Lattice;

/// Equally spaced planes across the line of sight, numbered by rising depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Planes {
    /// Depth of plane 0, millimetres from the eye.
    pub first_mm: f64,
    /// Distance between planes, millimetres, above 0.
    pub step_mm: f64,
}

impl Planes {
    /// The planes of `lattice` seen by `camera`, `samples_per_voxel` of them for each smallest lattice spacing.
    pub fn new(lattice: &Lattice, camera: &Camera, samples_per_voxel: f64) -> Self {
        let step_mm = lattice.spacing_mm().min_element() / samples_per_voxel;
        let eye_from_lattice = eye_from_lattice(lattice, camera);
        let corner = affine::point(&eye_from_lattice, lattice.bounds().min);
        Self {
            first_mm: corner.z + 0.5 * step_mm,
            step_mm,
        }
    }

    /// Depth of plane `k`, millimetres.
    pub fn depth(&self, k: i64) -> f64 {
        self.first_mm + k as f64 * self.step_mm
    }

    /// The planes in `[near, far)`: half-open, so a plane on the face between two boxes belongs to one of them.
    pub fn between(&self, near_mm: f64, far_mm: f64) -> Range<i64> {
        self.not_before(near_mm)..self.not_before(far_mm)
    }

    /// The first plane at or behind `depth`.
    fn not_before(&self, depth: f64) -> i64 {
        ((depth - self.first_mm) / self.step_mm).ceil() as i64
    }
}

/// From lattice coordinates to the eye frame.
pub fn eye_from_lattice(lattice: &Lattice, camera: &Camera) -> DAffine3 {
    camera.eye_from_world * lattice.world_from_lattice
}
