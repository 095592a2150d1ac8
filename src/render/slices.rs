//! The slice projector: a [`SlicePlan`] drawn on a Vulkan device (VCSG §3.3.2).

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::frame::{self, SliceData};
use super::pages::{FORMATS, Page, PagedTarget};
use crate::gpu::{
    Attribute, Binding, BindingKind, Bindings, Blend, Buffer, BufferRole, Device, Draw, Elements,
    Extent, Filter, Format, GpuError, GraphicsPipeline, Image, ImageRole, Load, PipelineDesc, Push,
    Recording, RenderPass, Requirements, Sampler, StepRate, Stream, Target as ColorTarget,
    Topology, VertexInput,
};
use crate::image::Frame;
use crate::interface::{MAX_VERTICES, TABLE_LEN};
use crate::projection::composite::{self, Blending};
use crate::projection::{
    FrameSpec, Lens, Mode, ProjectError, Projector, SlicePlan, SoftNormals, TransferTable,
    Visibility, VisibleValues,
};
use crate::shaders::{SLICES_FRAG, SLICES_VERT};

/// The format that slices are blended in.
pub const TARGET_FORMAT: Format = Format::R32G32B32A32_SFLOAT;

/// The format of transfer tables.
const TABLE_FORMAT: Format = Format::R32G32B32A32_SFLOAT;

const _: () = assert!(TABLE_LEN as usize == TransferTable::LEN);

/// Edge of the smallest cubes that are drawn apart, voxels.
const MIN_CUBE: usize = 16;

/// Fragments of one submission, about: it ends within a second even on a processor.
const SUBMISSION_FRAGMENTS: f64 = 5e7;

/// A fan of four triangles over six vertices.
const FAN: [u32; 12] = [0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5];

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

/// What distinguishes one pipeline from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Variant {
    mode: u32,
    mixed: bool,
    lights: u32,
    shininess_log2: u32,
    perspective: bool,
}

/// Draws paged targets; keeps its pipelines between frames.
pub struct SliceRenderer {
    device: Arc<Device>,
    linear: Arc<Sampler>,
    fan: Arc<Buffer>,
    pipelines: HashMap<Variant, Arc<GraphicsPipeline>>,
}

impl SliceRenderer {
    /// What a device must have.
    pub const REQUIREMENTS: Requirements<'static> = Requirements {
        sampled_linear: &[
            FORMATS[0],
            FORMATS[1],
            FORMATS[2],
            FORMATS[3],
            FORMATS[4],
            FORMATS[5],
            TABLE_FORMAT,
        ],
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
            fan: Buffer::with_data(device, "fan", &FAN)?,
            pipelines: HashMap::new(),
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
    pub fn draw(
        &mut self,
        spec: &FrameSpec,
        paged: &PagedTarget,
    ) -> Result<(Frame, Timings), ProjectError> {
        let size = self.checked_size(spec)?;
        let begin = Instant::now();
        let table = spec.table();
        let plan = plan(spec, paged);
        let planned = Instant::now();
        let job = Job::new(self, spec, paged, &plan, &table, size).map_err(device_error)?;
        let prepared = Instant::now();
        job.run(&self.device).map_err(device_error)?;
        let drawn = Instant::now();
        let accumulated = job.read_back(&self.device).map_err(device_error)?;
        let settings = spec.settings;
        let range = spec.target.value_range;
        let frame = composite::resolve(settings.mode, &accumulated, range, spec.transfer);
        let timings = Timings {
            plan: planned - begin,
            prepare: prepared - planned,
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
            Err(ProjectError::FrameSize {
                width,
                height,
                limit,
            })
        }
    }

    fn pipeline(
        &mut self,
        variant: Variant,
        blending: Blending,
    ) -> Result<Arc<GraphicsPipeline>, GpuError> {
        if let Some(pipeline) = self.pipelines.get(&variant) {
            return Ok(Arc::clone(pipeline));
        }
        let pipeline = create_pipeline(&self.device, &variant, blending)?;
        self.pipelines.insert(variant, Arc::clone(&pipeline));
        Ok(pipeline)
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
        let paged = PagedTarget::new(&device, spec.target, normals.as_ref(), &mut |_| {})
            .map_err(device_error)?;
        Ok(self.renderer.draw(spec, &paged)?.0)
    }
}

/// How the normals of a spec's target are made, if it is lit.
pub fn soft_normals(spec: &FrameSpec) -> Option<SoftNormals> {
    let shading = spec.shading()?;
    Some(SoftNormals::new(
        &spec.target.lattice,
        shading.soft_gradient,
    ))
}

/// What [`SliceRenderer::draw`] draws of a target: its visible cubes, back to front.
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
    };
    SlicePlan::new(&visibility, spec.camera, spec.planes())
}

const BINDINGS: [BindingKind; 6] = [
    BindingKind::SampledImage,
    BindingKind::SampledImage,
    BindingKind::SampledImage,
    BindingKind::Uniform,
    BindingKind::Storage,
    BindingKind::Storage,
];

fn create_pipeline(
    device: &Arc<Device>,
    variant: &Variant,
    blending: Blending,
) -> Result<Arc<GraphicsPipeline>, GpuError> {
    let blend = match blending {
        Blending::Over => Blend::Over,
        Blending::Add => Blend::Add,
        Blending::Max => Blend::Max,
    };
    GraphicsPipeline::new(
        device,
        &PipelineDesc {
            label: "slices",
            vertex_spirv: SLICES_VERT,
            fragment_spirv: SLICES_FRAG,
            specialization: &[
                (0, variant.mode),
                (1, u32::from(variant.mixed)),
                (2, variant.lights),
                (3, variant.shininess_log2),
                (4, u32::from(variant.perspective)),
            ],
            color_targets: &[(TARGET_FORMAT, Some(blend))],
            bindings: &BINDINGS,
            push_bytes: 0,
            topology: Topology::Triangles,
            vertex_input: Some(VertexInput {
                stride: size_of::<SliceData>() as u32,
                rate: StepRate::Instance,
                attributes: &[
                    Attribute {
                        location: 0,
                        format: Format::R32_UINT,
                        offset: 0,
                    },
                    Attribute {
                        location: 1,
                        format: Format::R32_SFLOAT,
                        offset: 4,
                    },
                ],
            }),
        },
    )
}

/// Everything that one frame needs on the device.
struct Job {
    target: Arc<Image>,
    read_back: Arc<Buffer>,
    passes: Vec<Recording>,
}

impl Job {
    fn new(
        renderer: &mut SliceRenderer,
        spec: &FrameSpec,
        paged: &PagedTarget,
        plan: &SlicePlan,
        table: &TransferTable,
        [width, height]: [u32; 2],
    ) -> Result<Self, GpuError> {
        let device = Arc::clone(&renderer.device);
        let extent = Extent::D2(width, height);
        let target = Image::new(
            &device,
            "frame",
            ImageRole::ColorTarget,
            TARGET_FORMAT,
            extent,
        )?;
        let read_back = Buffer::new(&device, "frame", BufferRole::Readback, target.bytes())?;
        let mut passes = Vec::new();
        let clear = ColorTarget {
            image: Arc::clone(&target),
            load: Load::Clear([0.0; 4]),
        };
        let mut first = Recording::new();
        let shared = Shared::new(renderer, spec, paged, plan, table, &mut first)?;
        first.render(RenderPass {
            targets: vec![clear],
            draws: Vec::new(),
        });
        passes.push(first);
        for part in submissions(plan, spec) {
            let mut recording = Recording::new();
            recording.render(RenderPass {
                targets: vec![ColorTarget {
                    image: Arc::clone(&target),
                    load: Load::Keep,
                }],
                draws: shared.draws(renderer, spec, paged, plan, part)?,
            });
            passes.push(recording);
        }
        Ok(Self {
            target,
            read_back,
            passes,
        })
    }

    fn run(&self, device: &Arc<Device>) -> Result<(), GpuError> {
        for recording in &self.passes {
            device.submit(recording)?.wait()?;
        }
        Ok(())
    }

    fn read_back(&self, device: &Arc<Device>) -> Result<Frame, GpuError> {
        let mut recording = Recording::new();
        recording.read_back(&self.target, &self.read_back);
        device.submit(&recording)?.wait()?;
        let pixels = self.read_back.read_vec::<[f32; 4]>()?;
        let [width, height, _] = self.target.extent().edges();
        Ok(Frame::from_pixels(width, height, pixels)
            .unwrap_or_else(|_| Frame::transparent(width, height)))
    }
}

/// The slices of each submission.
fn submissions(plan: &SlicePlan, spec: &FrameSpec) -> Vec<Range<usize>> {
    let pixels_per_voxel_face = {
        let spacing = spec.target.lattice.spacing_mm().max_element();
        let scale = match spec.camera.lens {
            Lens::Orthographic { pixels_per_mm } => pixels_per_mm,
            Lens::Perspective { focal_px, near_mm } => focal_px / near_mm.max(1.0),
        };
        (spacing * scale).powi(2)
    };
    let [width, height] = spec.camera.size.map(f64::from);
    let mut parts = Vec::new();
    let (mut begin, mut fragments) = (0, 0.0);
    for (n, slice) in plan.slices.iter().enumerate() {
        let extent = plan.boxes[slice.slice_box as usize].extent;
        let longest = extent.into_iter().max().unwrap_or(0) as f64;
        fragments += (longest * longest * pixels_per_voxel_face).min(width * height);
        if fragments > SUBMISSION_FRAGMENTS {
            parts.push(begin..n + 1);
            (begin, fragments) = (n + 1, 0.0);
        }
    }
    parts.push(begin..plan.slices.len());
    parts.retain(|p| !p.is_empty());
    parts
}

/// Buffers and tables of a frame, and the bindings of each page.
struct Shared {
    slices: Option<Arc<Buffer>>,
    bindings: Vec<Arc<Bindings>>,
}

impl Shared {
    fn new(
        renderer: &SliceRenderer,
        spec: &FrameSpec,
        paged: &PagedTarget,
        plan: &SlicePlan,
        table: &TransferTable,
        recording: &mut Recording,
    ) -> Result<Self, GpuError> {
        let device = &renderer.device;
        if plan.slices.is_empty() {
            return Ok(Self {
                slices: None,
                bindings: Vec::new(),
            });
        }
        let extent = Extent::D2(TABLE_LEN, 1);
        let table_image = Image::new(
            device,
            "transfer table",
            ImageRole::Sampled,
            TABLE_FORMAT,
            extent,
        )?;
        let entries = Buffer::with_data(device, "transfer table", table.entries())?;
        recording.upload(&entries, &table_image);
        let data = frame::frame_data(spec, plan, paged.encoding);
        let uniform = Buffer::with_data(device, "frame data", &[data])?;
        let boxes = Buffer::with_data(device, "boxes", &frame::boxes(spec, plan, paged))?;
        let templates = Buffer::with_data(device, "templates", &frame::templates(plan))?;
        let bind = |page: &Page| {
            let sampled = |image: &Arc<Image>| {
                Binding::SampledImage(Arc::clone(image), Arc::clone(&renderer.linear))
            };
            let entries = [
                sampled(&page.values),
                sampled(page.normals.as_ref().unwrap_or(&page.values)),
                sampled(&table_image),
                Binding::Uniform(Arc::clone(&uniform)),
                Binding::Storage(Arc::clone(&boxes)),
                Binding::Storage(Arc::clone(&templates)),
            ];
            Bindings::new(device, "page", &entries)
        };
        Ok(Self {
            slices: Some(Buffer::with_data(device, "slices", &frame::slices(plan))?),
            bindings: paged.pages.iter().map(bind).collect::<Result<_, _>>()?,
        })
    }

    /// One draw for each run of slices of one page.
    fn draws(
        &self,
        renderer: &mut SliceRenderer,
        spec: &FrameSpec,
        paged: &PagedTarget,
        plan: &SlicePlan,
        part: Range<usize>,
    ) -> Result<Vec<Draw>, GpuError> {
        let page_of = |n: usize| {
            let slice_box = &plan.boxes[plan.slices[n].slice_box as usize];
            paged.slots[slice_box.block as usize].page
        };
        let mut draws = Vec::new();
        let mut begin = part.start;
        while begin < part.end {
            let page = page_of(begin);
            let mut end = begin + 1;
            while end < part.end && page_of(end) == page {
                end += 1;
            }
            let pipeline = renderer.pipeline(
                variant(spec, paged.pages[page].mixed),
                spec.settings.mode.blending(),
            )?;
            draws.push(self.draw(renderer, pipeline, page, begin as u32..end as u32));
            begin = end;
        }
        Ok(draws)
    }

    fn draw(
        &self,
        renderer: &SliceRenderer,
        pipeline: Arc<GraphicsPipeline>,
        page: usize,
        instances: Range<u32>,
    ) -> Draw {
        Draw {
            pipeline,
            bindings: Some(Arc::clone(&self.bindings[page])),
            push: Push::NONE,
            stream: self.slices.as_ref().map(|buffer| Stream {
                buffer: Arc::clone(buffer),
                offset: 0,
            }),
            elements: Elements::Indices {
                buffer: Arc::clone(&renderer.fan),
                range: 0..FAN.len() as u32,
                base_vertex: 0,
            },
            instances,
        }
    }
}

const _: () = assert!(FAN.len() == 3 * (MAX_VERTICES as usize - 2));

fn variant(spec: &FrameSpec, mixed: bool) -> Variant {
    let shading = spec.shading();
    Variant {
        mode: frame::mode_constant(spec.settings.mode),
        mixed,
        lights: shading.map_or(0, |s| s.lights.len() as u32),
        shininess_log2: shading.map_or(0, |s| s.material.shininess_log2),
        perspective: matches!(spec.camera.lens, Lens::Perspective { .. }),
    }
}

impl Mode {
    /// All modes.
    pub const ALL: [Self; 6] = [
        Self::Composite,
        Self::Mip,
        Self::MinIp,
        Self::Average,
        Self::Additive,
        Self::XRay,
    ];
}
