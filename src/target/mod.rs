//! The target: a lattice, its octree of blocks, and what each block holds (VCSG §3.1–3.2).

mod block;
mod cells;
mod cube;
mod lattice;
mod levels;
mod octree;
mod order;
mod program;
mod reconstruct;
mod update;
mod voxels;

pub use block::{Block, Layout};
pub use cells::{CELL, CellRanges};
pub use cube::{Cube, VoxelBox};
pub use lattice::{Lattice, LatticeError};
pub use levels::Levels;
pub use octree::{Octree, OctreeNode, Subdivision, Target, TargetError};
pub use order::octants_back_to_front;
pub use reconstruct::RowEvaluator;
pub use update::Update;
pub use voxels::{BlockVoxels, VoxelTarget};
