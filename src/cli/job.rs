//! From a scene to a frame.

use std::sync::Arc;

use super::CliError;
use super::console::{Stages, progress};
use crate::gpu::{Device, DeviceSelector, Instance, Validation};
use crate::image::Frame;
use crate::math::Aabb;
use crate::projection::presets::DataStatistics;
use crate::projection::{FrameSpec, Projector, Reference, TransferFunction};
use crate::render::{PagedTarget, SliceRenderer, soft_normals};
use crate::scene::{Scene, TransferSpec};
use crate::target::Target;

/// Draws a frame with what it is given.
pub(super) enum Renderer {
    /// 3D-texture slices on a Vulkan device.
    Slices(SliceRenderer),
    /// The slow reference on the processor.
    Reference,
}

impl Renderer {
    /// Slices on the device that `selector` chooses.
    pub fn on_device(selector: &DeviceSelector, validation: Validation) -> Result<Self, CliError> {
        let instance = Instance::new(validation)?;
        let device = Device::open(&instance, selector, &SliceRenderer::REQUIREMENTS)?;
        Ok(Self::Slices(SliceRenderer::new(&device)?))
    }

    /// The device's name, where there is one.
    pub fn device_name(&self) -> Option<&str> {
        match self {
            Self::Slices(renderer) => Some(&renderer.device().info().name),
            Self::Reference => None,
        }
    }

    /// Draws `spec`.
    ///
    /// # Errors
    /// If the device fails, or its validation layer has a message.
    pub fn draw(&mut self, spec: &FrameSpec, stages: &mut Stages) -> Result<Frame, CliError> {
        match self {
            Self::Slices(renderer) => draw_slices(renderer, spec, stages),
            Self::Reference => Ok(stages.time("reference", || Reference.project(spec))?),
        }
    }
}

fn draw_slices(renderer: &mut SliceRenderer, spec: &FrameSpec, stages: &mut Stages) -> Result<Frame, CliError> {
    let device = Arc::clone(renderer.device());
    let normals = soft_normals(spec);
    let voxels = spec
        .target
        .blocks
        .iter()
        .map(|b| b.extent.iter().product::<usize>() as u64)
        .sum();
    let bar = progress("reconstruct", voxels);
    let paged = PagedTarget::new(&device, spec.target, normals.as_ref(), &mut |n| bar.inc(n as u64))?;
    bar.finish_and_clear();
    stages.add("reconstruct", paged.reconstruct);
    stages.add("upload", paged.upload);
    let (frame, times) = renderer.draw(spec, &paged, &[])?;
    stages.add("plan", times.plan);
    stages.add("prepare", times.prepare);
    stages.add("draw", times.draw);
    stages.add("read back", times.read_back);
    match device.instance().messages() {
        messages if messages.is_empty() => Ok(frame),
        messages => Err(CliError::Validation(messages)),
    }
}

/// The transfer function that `scene` has on `target`.
pub(super) fn transfer_function(scene: &Scene, target: &Target) -> TransferFunction {
    let nothing = DataStatistics {
        min: 0.0,
        max: 0.0,
        low: 0.0,
        high: 0.0,
    };
    let data = DataStatistics::of_target(target).unwrap_or(nothing);
    let spec = scene.transfer.as_ref().unwrap_or(&TransferSpec::AUTOMATIC);
    spec.function(&data, model_bounds(scene).size().length())
}

/// The world box of a scene's model.
pub(super) fn model_bounds(scene: &Scene) -> Aabb {
    let root = scene.model.root();
    root.map_or(Aabb::EMPTY, |root| scene.model.bounds()[root.index()])
}
