//! Scalar volumes: typed grids, sparse bricks, closed-form fields, and files.

pub mod analytic;
mod bricks;
mod field;
mod grid;
pub mod io;
mod reduce;
mod voxel;

pub use bricks::{BrickBuilder, BrickStore, Bricks, BuildError, TypedBricks};
pub use field::{Field, Sample, SampleRange};
pub use grid::{Grid, GridError, Region, Stats, Voxels};
pub use reduce::averaged_slices;
pub(crate) use voxel::for_type;
pub use voxel::{Voxel, VoxelType};
