//! The filter between two levels of the hierarchy (WK94, figure 7).
//!
//! *Theory.* Each level is voxelised with a filter twice as wide as the one below. At a resolution between two levels the value
//! is found at both and interpolated.
//! *Practice.* What a pixel covers is linear in the position, so the share of the wider filter is a function of the point alone:
//! it knows nothing of blocks, and is the same in every target that holds the point.

use glam::{DAffine3, DVec3};

use crate::math::linear;

/// What a pixel covers at a point, millimetres: a linear form of the position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// How it grows with the position.
    pub gradient: DVec3,
    /// What it is at the frame's origin.
    pub offset: f64,
}

impl Footprint {
    /// The millimetres that a pixel covers at `p`; 0 or less at and behind the eye.
    #[inline]
    pub fn at(&self, p: DVec3) -> f64 {
        linear(self.gradient, self.offset, p)
    }

    /// The same in another frame.
    pub fn moved(&self, this_from_frame: &DAffine3) -> Self {
        Self {
            gradient: this_from_frame.matrix3.transpose() * self.gradient,
            offset: self.at(this_from_frame.translation),
        }
    }
}

/// From a level's own filter, where a pixel covers a voxel of it, to the next one's, where it covers two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grade {
    /// What a pixel covers.
    pub footprint: Footprint,
    /// Distance between the level's voxels, millimetres, above 0.
    pub voxel_mm: f64,
}

impl Grade {
    /// How much wider the next level's filter is.
    pub const WIDER: f64 = 2.0;

    /// The share of the next level's filter at `p`: the logarithm of what a pixel covers, in [0, 1].
    #[inline]
    pub fn share(&self, p: DVec3) -> f64 {
        let voxels = self.footprint.at(p) / self.voxel_mm;
        if voxels > 1.0 { voxels.log2().min(1.0) } else { 0.0 }
    }

    /// The same in another frame.
    pub fn moved(&self, this_from_frame: &DAffine3) -> Self {
        Self {
            footprint: self.footprint.moved(this_from_frame),
            ..*self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_rises_from_none_to_all_over_one_level() {
        let footprint = Footprint {
            gradient: DVec3::Z * 0.01,
            offset: 0.0,
        };
        let grade = Grade {
            footprint,
            voxel_mm: 0.5,
        };
        let at = |z: f64| grade.share(DVec3::new(3.0, -7.0, z));
        assert_eq!(
            [at(-10.0), at(0.0), at(50.0), at(100.0), at(1e9)],
            [0.0, 0.0, 0.0, 1.0, 1.0]
        );
        assert!((at(50.0 * 2f64.sqrt()) - 0.5).abs() < 1e-12);
        assert_eq!(grade.share(DVec3::splat(f64::NAN)), 0.0);
    }

    #[test]
    fn a_moved_grade_is_the_same_at_the_same_place() {
        let world_from_local = DAffine3::from_scale_rotation_translation(
            DVec3::new(2.0, 3.0, 0.5),
            glam::DQuat::from_rotation_x(0.4),
            DVec3::new(1.0, 2.0, 30.0),
        );
        let grade = Grade {
            footprint: Footprint {
                gradient: DVec3::new(0.1, 0.2, 0.3),
                offset: 1.0,
            },
            voxel_mm: 7.0,
        };
        for p in [DVec3::ZERO, DVec3::new(1.0, 5.0, -2.0), DVec3::new(-3.0, 0.5, 9.0)] {
            let there = grade.share(world_from_local.transform_point3(p));
            assert!((grade.moved(&world_from_local).share(p) - there).abs() < 1e-12);
        }
    }
}
