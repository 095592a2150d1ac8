//! The slice projector: a [`SlicePlan`] drawn on a Vulkan device (VCSG §3.3.2).

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::depths::DepthScale;
use super::job::{self, Job, read_back};
use super::mesh::{ShownMesh, mesh_bounds};
use super::pages::{FORMATS, PagedTarget};
use super::pipelines::Pipelines;
use super::submissions::Submissions;
use super::surfaces::{Shown, Surfaces};
use crate::gpu::{Buffer, Device, Filter, Format, GpuError, Requirements, Sampler};
use crate::image::{Frame, Rgba};
use crate::interface::TABLE_LEN;
use crate::projection::{
    Camera, DrawCost, FrameSpec, Horizon, Planes, ProjectError, Projector, Settings, SlicePlan, SoftNormals,
    TransferTable, Visibility, VisibleValues,
};
use crate::projection::{bands, composite};
use crate::surface::SurfaceView;

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

/// What is on the device when a frame is drawn.
pub(super) struct Accumulated {
    /// Of the slices, as the mode's blending leaves it.
    pub samples: Frame,
    /// The meshes, if there are any.
    pub surfaces: Option<Frame>,
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

    /// Draws one frame of a target that is on the device, and of opaque meshes in it, at which its slices stop: premultiplied,
    /// without background.
    ///
    /// A slice is drawn at a pixel if its plane is nearer than the mesh there, and then stands for its whole slab. So of the slab
    /// that the surface lies in, up to half too much or too little is seen. How the volume lies over a mesh in each mode is at
    /// [`composite::over_surfaces`].
    ///
    /// # Errors
    /// If the device has not enough memory or is lost, or the frame's size is impossible.
    pub fn draw(
        &mut self,
        spec: &FrameSpec,
        paged: &PagedTarget,
        meshes: &[ShownMesh],
    ) -> Result<(Frame, Timings), ProjectError> {
        let begin = Instant::now();
        let plan = plan(spec, paged);
        let planned = begin.elapsed();
        let (frame, timings) = self.draw_plan(spec, paged, &plan, meshes)?;
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
        meshes: &[ShownMesh],
    ) -> Result<(Frame, Timings), ProjectError> {
        let (accumulated, timings) = self.accumulate(spec, paged, plan, meshes)?;
        let begin = Instant::now();
        let mode = spec.settings.mode;
        let projection = composite::resolve(mode, &accumulated.samples, spec.target.value_range, spec.transfer);
        let frame = match accumulated.surfaces {
            Some(surfaces) => composite::over_surfaces(mode, &projection, &surfaces),
            None => projection,
        };
        let read_back = timings.read_back + begin.elapsed();
        Ok((frame, Timings { read_back, ..timings }))
    }

    /// Draws what `plan` says, the last step apart.
    pub(super) fn accumulate(
        &mut self,
        spec: &FrameSpec,
        paged: &PagedTarget,
        plan: &SlicePlan,
        meshes: &[ShownMesh],
    ) -> Result<(Accumulated, Timings), ProjectError> {
        self.require_size(spec.camera)?;
        spec.check()?;
        let begin = Instant::now();
        let job = Job::new(self, spec, paged, plan, meshes).map_err(device_error)?;
        let prepared = Instant::now();
        job.run(&self.device).map_err(device_error)?;
        let drawn = Instant::now();
        let accumulated = Accumulated {
            samples: job.accumulated(&self.device).map_err(device_error)?,
            surfaces: job.surfaces(&self.device).map_err(device_error)?,
        };
        let timings = Timings {
            plan: Duration::ZERO,
            prepare: prepared - begin,
            draw: drawn - prepared,
            read_back: drawn.elapsed(),
        };
        Ok((accumulated, timings))
    }

    /// Draws meshes alone: premultiplied, without background. The depth cue spans them.
    ///
    /// # Errors
    /// As [`Self::draw`].
    pub fn draw_meshes(
        &mut self,
        camera: &Camera,
        settings: &Settings,
        meshes: &[ShownMesh],
    ) -> Result<Frame, ProjectError> {
        self.draw_alone(camera, settings, meshes, Shown::Color)
    }

    /// The depth of the nearest mesh at each pixel in millimetres, top row first; infinite where there is none.
    ///
    /// # Errors
    /// As [`Self::draw`].
    pub fn mesh_depths(&mut self, camera: &Camera, meshes: &[ShownMesh]) -> Result<Vec<f32>, ProjectError> {
        let frame = self.draw_alone(camera, &Settings::default(), meshes, Shown::Depth)?;
        let depth = |[depth, .., there]: &Rgba| if *there > 0.0 { *depth } else { f32::INFINITY };
        Ok(frame.pixels().iter().map(depth).collect())
    }

    fn draw_alone(
        &mut self,
        camera: &Camera,
        settings: &Settings,
        meshes: &[ShownMesh],
        shown: Shown,
    ) -> Result<Frame, ProjectError> {
        self.require_size(camera)?;
        let bounds = mesh_bounds(meshes);
        let view = SurfaceView::alone(camera, settings, &bounds);
        let scale = DepthScale::new(camera, &bounds.transformed(&camera.eye_from_world));
        let mut submissions = Submissions::default();
        let drawn = Surfaces::new(self, &view, &scale, meshes, shown, &mut submissions).and_then(|surfaces| {
            submissions.run(&self.device)?;
            read_back(&self.device, &surfaces.image)
        });
        drawn.map_err(device_error)
    }

    fn require_size(&self, camera: &Camera) -> Result<(), ProjectError> {
        let [width, height] = camera.size;
        let limit = self.device.info().limits.image_dimension_2d;
        if (1..=limit).contains(&width) && (1..=limit).contains(&height) {
            Ok(())
        } else {
            Err(ProjectError::FrameSize { width, height, limit })
        }
    }
}

/// An error of the device as one of projecting.
pub(super) fn device_error(error: GpuError) -> ProjectError {
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
        Ok(self.renderer.draw(spec, &paged, &[])?.0)
    }
}

/// How the normals of a spec's target are made, if it is lit.
pub fn soft_normals(spec: &FrameSpec) -> Option<SoftNormals> {
    let shading = spec.shading()?;
    Some(SoftNormals::new(&spec.target.lattice, shading.soft_gradient))
}

/// What [`SliceRenderer::draw`] draws of a target: its visible boxes, back to front.
pub fn plan(spec: &FrameSpec, paged: &PagedTarget) -> SlicePlan {
    let planes = spec.planes();
    let horizon = bands::can_hide(spec).then(|| Horizon::new(spec, &paged.cells));
    bands::cut(plan_before(horizon.as_ref(), planes, spec, paged), spec)
}

/// What is drawn on `planes`, in one band.
pub(super) fn plan_on(planes: Planes, spec: &FrameSpec, paged: &PagedTarget) -> SlicePlan {
    plan_before(None, planes, spec, paged)
}

/// What is drawn on `planes` that does not lie behind `horizon`, in one band.
fn plan_before(horizon: Option<&Horizon>, planes: Planes, spec: &FrameSpec, paged: &PagedTarget) -> SlicePlan {
    let values = VisibleValues::in_frame(spec);
    let visibility = Visibility {
        target: spec.target,
        cells: &paged.cells,
        values: &values,
        min_cube: MIN_CUBE,
        horizon,
        cost: DrawCost::new(&spec.target.lattice, spec.camera, &planes),
    };
    SlicePlan::new(&visibility, spec.camera, planes)
}
