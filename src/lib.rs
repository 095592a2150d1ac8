//! vcsg: model with volumes, see the result at once, and prove the picture is right.

#![warn(missing_docs)]

pub mod conformance;
pub mod gpu;
pub mod image;
pub mod interface;
pub mod math;
pub mod model;
pub mod output;
pub mod projection;
pub mod render;
pub mod scene;
pub mod target;
pub mod volume;

/// The SPIR-V of `shaders/`, a constant a shader.
pub mod shaders {
    include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
}
