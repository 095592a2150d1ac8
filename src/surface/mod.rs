//! Surfaces of constant value as triangle meshes, on the processor (LC87).

mod assemble;
mod blocks;
mod cases;
mod cells;
mod extract;
mod inside;
pub mod io;
mod manifold;
mod mesh;
pub mod reference;
mod slices;
mod solid;
mod texture;
pub mod trilinear;
mod vertices;
mod view;
mod weld;

pub use blocks::extract_target;
pub use extract::{ExtractError, Topology, extract, marching_cubes};
pub use mesh::{Mesh, Part};
pub use solid::{Border, Creases, Cutter, Operation, SolidOptions, combine};
pub use texture::{gray_window, paint, transfer_colors};
pub use view::{MeshColor, MeshLook, MeshShading, SurfaceView, unit_normal};
