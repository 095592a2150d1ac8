//! Surfaces of constant value as triangle meshes, on the processor (LC87).

mod cases;
mod cells;
mod components;
mod connect;
mod edges;
mod extract;
mod inside;
pub mod io;
mod measure;
mod mesh;
mod nearest;
mod simplify;
mod slices;
mod sound;
mod subset;
pub mod trilinear;
mod vertices;
mod weld;

pub use connect::{Component, components, keep_largest, keep_touching};
pub use extract::{ExtractError, marching_cubes};
pub use measure::Measures;
pub use mesh::{Mesh, Part};
pub use simplify::{Simplified, SimplifyGoal, simplify};
