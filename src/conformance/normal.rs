//! Soft normals as they are stored: in 16 bits, of which 32768 stands for 0 and a step for 1/32767.

use super::precision::ULP;
use super::span::Span;
use super::storage::fraction_rounding;
use crate::projection::{FrameSpec, SoftNormals};
use glam::DVec3;

/// Makes the normals that a voxel may have been given.
pub(super) struct StoredNormals {
    soft: SoftNormals,
    /// Error of a part of a normal in single precision.
    error: f64,
}

impl StoredNormals {
    /// For a frame that is lit.
    pub(super) fn of(spec: &FrameSpec) -> Option<Self> {
        let shading = spec.shading()?;
        let soft = SoftNormals::new(&spec.target.lattice, shading.soft_gradient);
        let m = soft.matrix();
        let steepest = (0..3).map(|row| m.row(row).abs().element_sum()).fold(0.0, f64::max);
        // A difference of fractions, which are first smoothed along two axes (of numbers of up to 1.5, by eight operations and
        // two rounded weights), times the matrix (its softening only shrinks errors), and six operations up to the rounding to 16
        // bits on numbers of up to 1.
        let gradient = steepest * (fraction_rounding(spec.target.value_range) + 20.0 * ULP);
        Some(Self {
            soft,
            error: gradient + 6.0 * ULP,
        })
    }

    /// From the exact normal for half the differences of a voxel's neighbours to the stored one, so that the exact picture is
    /// within bounds too. Which way a part was rounded is known, unless it lies next to the middle between two steps.
    pub(super) fn at(&self, half_difference: DVec3) -> [Span; 3] {
        let stored = |part: f64| ((32767.0 * part + 32768.5).floor() - 32768.0) / 32767.0;
        let normal = self.soft.normal(half_difference).to_array();
        normal.map(|part| Span::around(part, self.error).rising(stored).with(part))
    }
}
