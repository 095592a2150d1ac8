//! A target block: a cube of the lattice with its own path.

use super::VoxelBox;
use crate::math::Aabb;
use crate::volume::SampleRange;

/// What a block's voxels need to store (design §3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Layout {
    /// Every voxel, apron included, is fully covered: the value alone.
    Covered,
    /// Value times coverage, and coverage.
    Mixed,
    /// Fully covered by one value as far as the block's gradients reach: that value, once.
    Uniform,
}

/// A leaf of the target octree.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Its first voxel that lies in the lattice.
    pub origin: [usize; 3],
    /// Edge of the octree cube, a power of two.
    pub size: usize,
    /// Voxels of the cube that lie in the lattice.
    pub extent: [usize; 3],
    /// Its path, an index into [`Target::paths`](super::Target).
    pub path: u32,
    /// What it stores.
    pub layout: Layout,
    /// What samples in the block and its apron can be.
    pub range: SampleRange,
}

impl Block {
    /// Voxels of apron on each side (design §5).
    pub const APRON: usize = 1;

    /// Voxels beyond the block that its picture can depend on: the apron's gradients look one voxel further.
    pub const REACH: usize = 2;

    /// Voxels along each axis that the block stores, apron included.
    pub fn stored_dims(&self) -> [usize; 3] {
        match self.layout {
            Layout::Uniform => [1; 3],
            Layout::Covered | Layout::Mixed => self.extent.map(|n| n + 2 * Self::APRON),
        }
    }

    /// Stored voxels, apron included.
    pub fn stored_len(&self) -> usize {
        self.stored_dims().iter().product()
    }

    /// Its voxels.
    pub fn voxels(&self) -> VoxelBox {
        VoxelBox {
            origin: self.origin,
            extent: self.extent,
        }
    }

    /// The box of its voxels' cells, in lattice coordinates.
    pub fn bounds(&self) -> Aabb {
        self.voxels().bounds()
    }
}
