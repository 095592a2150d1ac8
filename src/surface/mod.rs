//! Surfaces of constant value as triangle meshes, on the processor (LC87).

mod assemble;
mod blocks;
mod cases;
mod cell;
mod cells;
mod components;
mod connect;
mod crossings;
mod edges;
mod extract;
mod inside;
pub mod io;
mod manifold;
mod measure;
mod mesh;
mod nearest;
pub mod reference;
mod simplify;
mod slices;
mod solid;
mod sound;
mod subset;
mod texture;
pub mod trilinear;
mod vertices;
mod view;
mod weld;

pub use blocks::extract_target;
pub use connect::{Component, components, keep_largest, keep_touching};
pub use extract::{ExtractError, Topology, extract, marching_cubes};
pub use measure::Measures;
pub use mesh::{Mesh, Part};
pub use simplify::{Simplified, SimplifyGoal, simplify};
pub use solid::{Border, Creases, Cutter, Operation, SolidOptions, combine};
pub use texture::{gray_window, paint, transfer_colors};
pub use view::{MeshColor, MeshLook, MeshShading, SurfaceView, unit_normal};
