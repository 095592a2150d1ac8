//! From a plan to a frame on a device: the flow's last step, carried out by `gpu`.

mod frame;
mod job;
mod layers;
mod pages;
mod pieces;
mod pipelines;
mod slices;
mod texels;

pub use pages::{Page, PagedTarget, Slot};
pub use slices::{SliceRenderer, Slices, Timings, plan, soft_normals};
