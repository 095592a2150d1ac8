//! The slice projector: a [`SlicePlan`] drawn on a Vulkan device (VCSG §3.3.2).

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::depths::DepthScale;
use super::job::{Job, read_back};
use super::layers::Order;
use super::mesh::{ShownMesh, mesh_bounds};
use super::pages::{FORMATS, PagedTarget};
use super::pipelines::Pipelines;
use super::submissions::Submissions;
use super::surfaces::{Shown, Surfaces};
use crate::gpu::{Device, Feature, Filter, Format, GpuError, Requirements, Sampler};
use crate::image::{Frame, Rgba};
use crate::interface::TABLE_LEN;
use crate::projection::{
    Camera, DrawCost, FrameSpec, Planes, ProjectError, Projector, Remaining, Settings, ShownCells, SlicePlan,
    SoftNormals, TransferTable, Visibility, VisibleValues,
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

impl Accumulated {
    /// The frame, premultiplied and without background.
    fn resolve(self, spec: &FrameSpec) -> Frame {
        let mode = spec.settings.mode;
        let projection = composite::resolve(mode, self.samples, spec.target.value_range, spec.transfer);
        match &self.surfaces {
            Some(surfaces) => composite::over_surfaces(mode, &projection, surfaces),
            None => projection,
        }
    }
}

/// A frame, and what was done for it.
pub struct Drawn {
    /// Premultiplied, without background.
    pub frame: Frame,
    /// What was drawn.
    pub plan: SlicePlan,
    /// What it took.
    pub timings: Timings,
}

impl Drawn {
    fn new(spec: &FrameSpec, accumulated: Accumulated, plan: SlicePlan, timings: Timings) -> Self {
        let begin = Instant::now();
        let frame = accumulated.resolve(spec);
        let read_back = timings.read_back + begin.elapsed();
        Self {
            frame,
            plan,
            timings: Timings { read_back, ..timings },
        }
    }
}

/// Draws paged targets; keeps its pipelines between frames.
pub struct SliceRenderer {
    pub(super) device: Arc<Device>,
    pub(super) linear: Arc<Sampler>,
    pub(super) nearest: Arc<Sampler>,
    pub(super) pipelines: Pipelines,
}

impl SliceRenderer {
    /// What a device must have.
    pub const REQUIREMENTS: Requirements<'static> = Requirements {
        sampled_linear: &[FORMATS[0], FORMATS[1], FORMATS[2], TABLE_FORMAT],
        blended: &[TARGET_FORMAT],
        features: &[Feature::FragmentStores],
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
        let drawn = self.draw_told(spec, paged, meshes)?;
        Ok((drawn.frame, drawn.timings))
    }

    /// Likewise, and tells what was drawn. Where what is in front can hide what is behind, that is planned slab by slab, as the frame
    /// is closed; see [`bands`].
    ///
    /// # Errors
    /// As [`Self::draw`].
    pub fn draw_told(
        &mut self,
        spec: &FrameSpec,
        paged: &PagedTarget,
        meshes: &[ShownMesh],
    ) -> Result<Drawn, ProjectError> {
        self.require_size(spec.camera)?;
        spec.check()?;
        if bands::can_hide(spec) {
            let (accumulated, plan, timings) = self.sweep(spec, paged, meshes).map_err(device_error)?;
            return Ok(Drawn::new(spec, accumulated, plan, timings));
        }
        let begin = Instant::now();
        let plan = plan(spec, paged);
        let planned = begin.elapsed();
        let (accumulated, timings) = self.accumulate(spec, paged, &plan, meshes)?;
        let plan_time = Timings {
            plan: planned,
            ..timings
        };
        Ok(Drawn::new(spec, accumulated, plan, plan_time))
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
        let frame = accumulated.resolve(spec);
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
        let mut job = Job::new(self, spec, meshes, Order::of(plan), plan).map_err(device_error)?;
        job.add(self, spec, paged, plan).map_err(device_error)?;
        let prepared = Instant::now();
        job.submissions.run(&self.device).map_err(device_error)?;
        let drawn = Instant::now();
        let accumulated = job.accumulated(&self.device).map_err(device_error)?;
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

/// All that shows of a target: its visible boxes back to front, or in bands if that pays, whatever hides them.
pub fn plan(spec: &FrameSpec, paged: &PagedTarget) -> SlicePlan {
    bands::cut(plan_on(spec.planes(), spec, paged), spec)
}

/// What is drawn on `planes`, in one band.
pub(super) fn plan_on(planes: Planes, spec: &FrameSpec, paged: &PagedTarget) -> SlicePlan {
    let shown = ShownCells::new(&paged.cells, &VisibleValues::in_frame(spec, &spec.table()));
    let lattice = &spec.target.lattice;
    let visibility = Visibility {
        cost: DrawCost::new(lattice, spec.camera, &planes),
        ..visibility(spec, &shown, None)
    };
    SlicePlan::new(&visibility, spec.camera, planes)
}

/// What is drawn of a target of which such cells are shown.
pub(super) fn visibility<'a>(
    spec: &FrameSpec<'a>,
    shown: &'a ShownCells,
    remaining: Option<Remaining<'a>>,
) -> Visibility<'a> {
    Visibility {
        target: spec.target,
        shown,
        min_cube: MIN_CUBE,
        remaining,
        cost: DrawCost::new(&spec.target.lattice, spec.camera, &spec.planes()),
    }
}
