//! Where a scene is seen from, in any affine frame.

use glam::{DAffine3, DVec3};

/// Where a viewer is seen from, in any affine frame: what decides the order of blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Viewpoint {
    /// Infinitely far away in this direction.
    Direction(DVec3),
    /// At this point.
    Point(DVec3),
}

impl Viewpoint {
    /// The same viewpoint in another frame.
    pub fn transformed(self, dst_from_src: &DAffine3) -> Self {
        match self {
            Self::Direction(d) => Self::Direction(dst_from_src.matrix3 * d),
            Self::Point(p) => Self::Point(dst_from_src.transform_point3(p)),
        }
    }
}
