//! Vulkan 1.3: devices, memory, pipelines, and frames that are plain data.
//!
//! Everything that touches Vulkan lives here, and all of the crate's `unsafe`. A frame is a [`Recording`]: a list of
//! commands that says what each reads and writes. [`Device::submit`] derives the barriers from it, so no caller writes one.
//!
//! Lifetimes are in the types: every object holds the [`Device`] and a device its [`Instance`]; a [`Submission`] holds
//! what its commands use until the device is done with them.

mod access;
mod bindings;
mod buffer;
mod check;
mod compile;
mod device;
mod encode;
mod error;
mod format;
mod image;
mod info;
mod instance;
mod memory;
mod pipeline;
mod pipeline_parts;
mod recording;
mod sampler;
mod select;
mod submit;
mod track;
mod uses;
mod validation;

pub use ash::vk::Format;

pub use bindings::{Binding, BindingKind, Bindings};
pub use buffer::{Buffer, BufferRole};
pub use device::Device;
pub use error::GpuError;
pub use format::texel_bytes;
pub use image::{DEPTH_FORMAT, Extent, Image, ImageRole};
pub use info::{DeviceInfo, DeviceKind, DeviceLimits, Feature, Requirements};
pub use instance::Instance;
pub use pipeline::GraphicsPipeline;
pub use pipeline_parts::{Attribute, Blend, Depth, PipelineDesc, StepRate, Topology, VertexInput};
pub use recording::{
    BufferCopy, Command, DepthTarget, Draw, Elements, ImageCopy, Load, Push, Recording, Region, RenderPass, Stream,
    Target,
};
pub use sampler::{Filter, Sampler};
pub use select::DeviceSelector;
pub use submit::Submission;
pub use validation::Validation;
