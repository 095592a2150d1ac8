//! Surfaces of constant value as triangle meshes, on the processor (LC87).

pub mod io;
mod mesh;

pub use mesh::{Mesh, Part};
