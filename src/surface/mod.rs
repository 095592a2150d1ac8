//! Surfaces of constant value as triangle meshes, on the processor (LC87).

mod mesh;
pub mod reference;
mod view;

pub use mesh::{Mesh, Part};
pub use view::{MeshColor, MeshLook, MeshShading, SurfaceView, unit_normal};
