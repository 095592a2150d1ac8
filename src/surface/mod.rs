//! Surfaces of constant value as triangle meshes, on the processor (LC87).

mod cases;
mod cells;
mod extract;
mod inside;
pub mod io;
mod mesh;
mod slices;
mod solid;
pub mod trilinear;
mod vertices;
mod weld;

pub use extract::{ExtractError, marching_cubes};
pub use mesh::{Mesh, Part};
pub use solid::{Border, Creases, Cutter, Operation, SolidOptions, combine};
