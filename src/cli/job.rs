//! From a scene to a frame.

use std::sync::Arc;

use super::CliError;
use super::console::{Stages, note, progress};
use super::surfaces::{DeviceSurfaces, Surface, shown};
use crate::gpu::{Device, DeviceSelector, GpuError, Instance, Validation};
use crate::image::Frame;
use crate::math::Aabb;
use crate::model::Model;
use crate::projection::presets::DataStatistics;
use crate::projection::raycast::{self, CastTarget};
use crate::projection::trace::{RayTracer, Sampling};
use crate::projection::{Camera, FrameSpec, LevelsFrame, LevelsSpec, Projector, Reference, Settings, TransferFunction};
use crate::render::{PagedTarget, SliceRenderer, soft_normals};
use crate::scene::{ObjectSpec, Scene, TransferSpec};
use crate::surface::{cast, raster};
use crate::target::Target;

/// Draws a frame with what it is given.
pub(super) enum Renderer {
    /// 3D-texture slices on a Vulkan device.
    Slices(SliceRenderer),
    /// Rays on the processor.
    RayCaster,
    /// Rays on the processor that spawn others.
    Tracer(Sampling),
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

    /// Slices `on_device`, or rays on the processor if there is no device, which is said.
    pub fn or_ray_caster(on_device: Result<Self, CliError>) -> Result<Self, CliError> {
        match on_device {
            Err(CliError::Gpu(missing @ (GpuError::NoLoader(_) | GpuError::OldLoader(_) | GpuError::NoDevice))) => {
                note(&format!("{missing}; rays are cast on the processor instead"));
                Ok(Self::RayCaster)
            }
            result => result,
        }
    }

    /// The device's name, where there is one.
    pub fn device_name(&self) -> Option<&str> {
        match self {
            Self::Slices(renderer) => Some(&renderer.device().info().name),
            Self::RayCaster | Self::Tracer(_) | Self::Reference => None,
        }
    }

    /// Draws `spec`, and `surfaces` in it.
    ///
    /// # Errors
    /// If the device fails, its validation layer has a message, or surfaces are to be traced.
    pub fn draw(&mut self, spec: &FrameSpec, surfaces: &[Surface], stages: &mut Stages) -> Result<Frame, CliError> {
        match self {
            Self::Slices(renderer) => draw_slices(renderer, spec, surfaces, stages),
            Self::RayCaster => cast_rays(spec, surfaces, stages),
            _ if !surfaces.is_empty() => Err(no_surfaces()),
            Self::Tracer(sampling) => {
                let mut tracer = RayTracer { sampling: *sampling };
                Ok(stages.time("trace", || tracer.project(spec))?)
            }
            Self::Reference => Ok(stages.time("reference", || Reference.project(spec))?),
        }
    }

    /// Draws a frame of several levels.
    ///
    /// # Errors
    /// As [`Self::draw`]; the reference has one level.
    pub fn draw_levels(&mut self, spec: &LevelsSpec) -> Result<LevelsFrame, CliError> {
        match self {
            Self::Slices(renderer) => {
                let device = Arc::clone(renderer.device());
                let drawn = renderer.draw_levels(spec)?;
                without_messages(&device, drawn)
            }
            Self::RayCaster => Ok(raycast::draw_levels(spec)?),
            Self::Tracer(_) | Self::Reference => {
                let why = "this renderer draws one level: set `levels` to 1, or take another --renderer";
                Err(CliError::Usage(why.into()))
            }
        }
    }

    /// Draws `surfaces` alone.
    ///
    /// # Errors
    /// As [`Self::draw`].
    pub fn draw_surfaces(
        &mut self,
        camera: &Camera,
        settings: &Settings,
        surfaces: &[Surface],
        stages: &mut Stages,
    ) -> Result<Frame, CliError> {
        match self {
            Self::Slices(renderer) => {
                let device = Arc::clone(renderer.device());
                let meshes = stages.time("upload meshes", || DeviceSurfaces::new(&device, surfaces))?;
                let frame = stages.time("draw", || renderer.draw_meshes(camera, settings, &meshes.shown()))?;
                without_messages(&device, frame)
            }
            Self::RayCaster => {
                let meshes = shown(surfaces);
                Ok(stages.time("draw", || raster::draw_alone(camera, settings, &meshes))?)
            }
            Self::Tracer(_) | Self::Reference => Err(no_surfaces()),
        }
    }
}

/// What traces rays, and the reference, draw samples alone.
pub(super) fn no_surfaces() -> CliError {
    let why = "surfaces are drawn beside slices and cast rays: take --renderer slices or raycast, or leave them out";
    CliError::Usage(why.into())
}

fn cast_rays(spec: &FrameSpec, surfaces: &[Surface], stages: &mut Stages) -> Result<Frame, CliError> {
    let target = stages.time("reconstruct", || CastTarget::of(spec));
    if surfaces.is_empty() {
        return Ok(stages.time("cast", || raycast::draw(spec, &target, None))?);
    }
    Ok(stages.time("cast", || cast(spec, &target, &shown(surfaces)))?)
}

fn draw_slices(
    renderer: &mut SliceRenderer,
    spec: &FrameSpec,
    surfaces: &[Surface],
    stages: &mut Stages,
) -> Result<Frame, CliError> {
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
    draw_paged(renderer, spec, &paged, surfaces, stages)
}

/// Draws a target that is on the device, and `surfaces` in it.
pub(super) fn draw_paged(
    renderer: &mut SliceRenderer,
    spec: &FrameSpec,
    paged: &PagedTarget,
    surfaces: &[Surface],
    stages: &mut Stages,
) -> Result<Frame, CliError> {
    let device = Arc::clone(renderer.device());
    let meshes = stages.time("upload meshes", || DeviceSurfaces::new(&device, surfaces))?;
    let (frame, times) = renderer.draw(spec, paged, &meshes.shown())?;
    stages.add("plan", times.plan);
    stages.add("prepare", times.prepare);
    stages.add("draw", times.draw);
    stages.add("read back", times.read_back);
    without_messages(&device, frame)
}

/// What was `drawn`, if the validation layer has nothing to say.
fn without_messages<T>(device: &Device, drawn: T) -> Result<T, CliError> {
    match device.instance().messages() {
        messages if messages.is_empty() => Ok(drawn),
        messages => Err(CliError::Validation(messages)),
    }
}

/// The transfer function that `scene` has on `target`.
pub(super) fn transfer_function(scene: &Scene, target: &Target) -> TransferFunction {
    let spec = scene.transfer.as_ref().unwrap_or(&TransferSpec::AUTOMATIC);
    spec.function(&statistics(target), bounds_of(&scene.model).size().length())
}

/// The transfer function that an object of `scene` has on `target`: its own, or the scene's.
pub(super) fn object_transfer(scene: &Scene, object: &ObjectSpec, target: &Target) -> TransferFunction {
    let spec = object.transfer.as_ref().or(scene.transfer.as_ref());
    let diagonal_mm = bounds_of(&object.model).size().length();
    spec.unwrap_or(&TransferSpec::AUTOMATIC)
        .function(&statistics(target), diagonal_mm)
}

/// What presets are fitted to; of an empty target, nothing.
pub(super) fn statistics(target: &Target) -> DataStatistics {
    let nothing = DataStatistics {
        min: 0.0,
        max: 0.0,
        low: 0.0,
        high: 0.0,
        found_modes: None,
    };
    DataStatistics::of_target(target).unwrap_or(nothing)
}

/// The world box of all that is in a scene.
pub(super) fn model_bounds(scene: &Scene) -> Aabb {
    let objects = scene.trace.objects.iter().map(|object| bounds_of(&object.model));
    objects.fold(bounds_of(&scene.model), |all, bounds| all.hull(&bounds))
}

fn bounds_of(model: &Model) -> Aabb {
    model.root().map_or(Aabb::EMPTY, |root| model.bounds()[root.index()])
}
