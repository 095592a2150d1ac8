//! From a plan to a frame on a device: the flow's last step, carried out by `gpu`.

mod arrange;
mod depths;
mod frame;
mod job;
mod layers;
mod levels;
mod look;
mod mesh;
mod mesh_pieces;
mod pages;
mod pieces;
mod pipelines;
mod slices;
mod submissions;
mod surfaces;
mod sweep;
mod texels;

pub use depths::DepthScale;
pub use mesh::{DeviceMesh, DeviceMeshError, ShownMesh};
pub use pages::{Page, PagedTarget, Slot};
pub use slices::{Drawn, SliceRenderer, Slices, Timings, plan, soft_normals};
