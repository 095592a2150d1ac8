//! The slice projector: a [`SlicePlan`] drawn on a Vulkan device (VCSG §3.3.2).

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::job::{self, Job};
use super::pages::{FORMATS, PagedTarget};
use super::pipelines::Pipelines;
use crate::gpu::{Buffer, Device, Filter, Format, GpuError, Requirements, Sampler};
use crate::image::Frame;
use crate::interface::TABLE_LEN;
use crate::projection::{
    DrawCost, FrameSpec, ProjectError, Projector, SlicePlan, SoftNormals, TransferTable, Visibility, VisibleValues,
};
use crate::projection::{bands, composite};

/// The format that slices are blended in.
pub const TARGET_FORMAT: Format = Format::R32G32B32A32_SFLOAT;

/// The format of transfer tables.
pub(super) const TABLE_FORMAT: Format = Format::R32G32B32A32_SFLOAT;

const _: () = assert!(TABLE_LEN as usize == TransferTable::LEN);

/// Edge of the smallest cubes that are drawn apart, voxels.
const MIN_CUBE: usize = 8;

/// Where the time of a frame goes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timings {
    /// Deciding what is visible, templates and plan.
    pub plan: Duration,
    /// Tables, boxes and slices to the device.
    pub prepare: Duration,
    /// Drawing.
    pub draw: Duration,
    /// Pixels back, and their last step.
    pub read_back: Duration,
}

/// Draws paged targets; keeps its pipelines between frames.
pub struct SliceRenderer {
    pub(super) device: Arc<Device>,
    pub(super) linear: Arc<Sampler>,
    pub(super) nearest: Arc<Sampler>,
    pub(super) fans: Arc<Buffer>,
    pub(super) pipelines: Pipelines,
}

impl SliceRenderer {
    /// What a device must have.
    pub const REQUIREMENTS: Requirements<'static> = Requirements {
        sampled_linear: &[FORMATS[0], FORMATS[1], FORMATS[2], TABLE_FORMAT],
        blended: &[TARGET_FORMAT],
        features: &[],
        image_dimension_3d: 256,
    };

    /// A renderer on `device`.
    ///
    /// # Errors
    /// If the device has not enough memory, or is lost.
    pub fn new(device: &Arc<Device>) -> Result<Self, GpuError> {
        Ok(Self {
            device: Arc::clone(device),
            linear: Sampler::new(device, Filter::Linear)?,
            nearest: Sampler::new(device, Filter::Nearest)?,
            fans: Buffer::with_data(device, "fans", &job::fans())?,
            pipelines: Pipelines::default(),
        })
    }

    /// The device.
    pub fn device(&self) -> &Arc<Device> {
        &self.device
    }

    /// Draws one frame of a target that is on the device: premultiplied, without background.
    ///
    /// # Errors
    /// If the device has not enough memory or is lost, or the frame's size is impossible.
    pub fn draw(&mut self, spec: &FrameSpec, paged: &PagedTarget) -> Result<(Frame, Timings), ProjectError> {
        let begin = Instant::now();
        let plan = plan(spec, paged);
        let planned = begin.elapsed();
        let (frame, timings) = self.draw_plan(spec, paged, &plan)?;
        Ok((
            frame,
            Timings {
                plan: planned,
                ..timings
            },
        ))
    }

    /// Draws what `plan` says, right or wrong, of a target that is on the device.
    ///
    /// # Errors
    /// As [`Self::draw`].
    pub fn draw_plan(
        &mut self,
        spec: &FrameSpec,
        paged: &PagedTarget,
        plan: &SlicePlan,
    ) -> Result<(Frame, Timings), ProjectError> {
        let size = self.checked_size(spec)?;
        let begin = Instant::now();
        let table = spec.table();
        let job = Job::new(self, spec, paged, plan, &table, size).map_err(device_error)?;
        let prepared = Instant::now();
        job.run(&self.device).map_err(device_error)?;
        let drawn = Instant::now();
        let accumulated = job.read_back(&self.device).map_err(device_error)?;
        let settings = spec.settings;
        let range = spec.target.value_range;
        let frame = composite::resolve(settings.mode, &accumulated, range, spec.transfer);
        let timings = Timings {
            plan: Duration::ZERO,
            prepare: prepared - begin,
            draw: drawn - prepared,
            read_back: drawn.elapsed(),
        };
        Ok((frame, timings))
    }

    fn checked_size(&self, spec: &FrameSpec) -> Result<[u32; 2], ProjectError> {
        let [width, height] = spec.camera.size;
        let limit = self.device.info().limits.image_dimension_2d;
        if (1..=limit).contains(&width) && (1..=limit).contains(&height) {
            Ok([width, height])
        } else {
            Err(ProjectError::FrameSize { width, height, limit })
        }
    }
}

/// An error of the device as one of projecting.
fn device_error(error: GpuError) -> ProjectError {
    ProjectError::Device(Box::new(error))
}

/// The slice projector for one frame: reconstructs and uploads the target, then draws it.
pub struct Slices {
    renderer: SliceRenderer,
}

impl Slices {
    /// A projector on `device`.
    ///
    /// # Errors
    /// If the device has not enough memory, or is lost.
    pub fn new(device: &Arc<Device>) -> Result<Self, GpuError> {
        Ok(Self {
            renderer: SliceRenderer::new(device)?,
        })
    }
}

impl Projector for Slices {
    fn project(&mut self, spec: &FrameSpec) -> Result<Frame, ProjectError> {
        let normals = soft_normals(spec);
        let device = Arc::clone(self.renderer.device());
        let paged = PagedTarget::new(&device, spec.target, normals.as_ref(), &mut |_| {}).map_err(device_error)?;
        Ok(self.renderer.draw(spec, &paged)?.0)
    }
}

/// How the normals of a spec's target are made, if it is lit.
pub fn soft_normals(spec: &FrameSpec) -> Option<SoftNormals> {
    let shading = spec.shading()?;
    Some(SoftNormals::new(&spec.target.lattice, shading.soft_gradient))
}

/// What [`SliceRenderer::draw`] draws of a target: its visible boxes, back to front.
pub fn plan(spec: &FrameSpec, paged: &PagedTarget) -> SlicePlan {
    let range = spec.target.value_range;
    let values = if spec.settings.mode.classifies() {
        VisibleValues::of(&spec.table(), range)
    } else {
        VisibleValues::all(range)
    };
    let visibility = Visibility {
        target: spec.target,
        cells: &paged.cells,
        values: &values,
        min_cube: MIN_CUBE,
        cost: DrawCost::new(&spec.target.lattice, spec.camera, &spec.planes()),
    };
    bands::cut(SlicePlan::new(&visibility, spec.camera, spec.planes()), spec)
}
