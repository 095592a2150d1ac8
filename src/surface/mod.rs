//! Surfaces of constant value as triangle meshes, on the processor (LC87).

mod mesh;
pub mod trilinear;

pub use mesh::{Mesh, Part};
