//! Scalar volumes: typed grids, sparse bricks, closed-form fields, and files.

pub mod analytic;
mod bricks;
mod field;
mod grid;
pub mod io;

pub use bricks::Bricks;
pub use field::{Field, Sample, SampleRange};
pub use grid::{Grid, Voxels};
