//! The order in which blocks hide one another (VCSG §3.2).
//!
//! *Theory.* The signs of the viewing vector decide the order in which a node's eight octants are visited; a depth-first
//! traversal then meets the blocks from back to front.
//! *Changes from the paper.* Under perspective the signs are taken at each node, from the side of the node's centre that the
//! eye is on. The three planes through the centre separate the octants, so what is on the eye's side of one can hide what is
//! not, and never the other way.

use glam::DVec3;

use crate::math::{Aabb, Viewpoint};

/// An octree cube of the lattice: its first voxel and its edge in voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cube {
    /// First voxel.
    pub origin: [usize; 3],
    /// Edge, a power of two.
    pub size: usize,
}

impl Cube {
    /// Octant `index`; bit `a` says that it lies on the high side of axis `a`.
    pub fn octant(&self, index: usize) -> Self {
        let half = self.size / 2;
        Self {
            origin: std::array::from_fn(|a| self.origin[a] + half * (index >> a & 1)),
            size: half,
        }
    }

    /// The point where the octants meet, in lattice coordinates (cells begin half a voxel before their voxel).
    pub fn center(&self) -> DVec3 {
        DVec3::from_array(self.origin.map(|o| o as f64)) + (self.size as f64 * 0.5 - 0.5)
    }

    /// The voxels of the cube that lie in a lattice of `dims`, along each axis.
    pub fn extent(&self, dims: [usize; 3]) -> [usize; 3] {
        std::array::from_fn(|a| self.size.min(dims[a].saturating_sub(self.origin[a])))
    }

    /// The box of the cells of `extent` voxels from the cube's origin.
    pub fn bounds(&self, extent: [usize; 3]) -> Aabb {
        let origin = DVec3::from_array(self.origin.map(|o| o as f64));
        let size = DVec3::from_array(extent.map(|n| n as f64));
        Aabb::new(origin - 0.5, origin + size - 0.5)
    }
}

/// The octants of `cube` in an order in which none is hidden by an earlier one. `viewpoint` is in lattice coordinates.
pub fn octants_back_to_front(cube: &Cube, viewpoint: Viewpoint) -> [usize; 8] {
    let towards = match viewpoint {
        Viewpoint::Direction(d) => d,
        Viewpoint::Point(eye) => eye - cube.center(),
    };
    let far = (0..3).filter(|&a| towards[a] <= 0.0).fold(0, |far, a| far | 1 << a);
    std::array::from_fn(|i| far ^ i)
}
