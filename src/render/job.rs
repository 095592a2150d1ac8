//! One frame on a device: its buffers and tables, its draws in submissions of bounded time, and its pixels.

use std::ops::Range;
use std::sync::Arc;

use super::frame;
use super::pages::{Page, PagedTarget};
use super::slices::{SliceRenderer, TABLE_FORMAT, TARGET_FORMAT};
use crate::gpu::{
    Binding, Bindings, Buffer, BufferRole, Device, Draw, Elements, Extent, GpuError, GraphicsPipeline, Image,
    ImageRole, Load, Push, Recording, RenderPass, Stream, Target as ColorTarget,
};
use crate::image::Frame;
use crate::interface::{MAX_VERTICES, TABLE_LEN};
use crate::projection::{FrameSpec, Lens, SlicePlan, TransferTable};

/// Fragments of one submission, about: it ends within a second even on a processor.
const SUBMISSION_FRAGMENTS: f64 = 5e7;

/// A fan of four triangles over six vertices.
pub const FAN: [u32; 12] = [0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5];

const _: () = assert!(FAN.len() == 3 * (MAX_VERTICES as usize - 2));

/// Everything that one frame needs on the device.
pub struct Job {
    target: Arc<Image>,
    read_back: Arc<Buffer>,
    passes: Vec<Recording>,
}

impl Job {
    /// Uploads what `plan` needs and records its draws.
    pub fn new(
        renderer: &mut SliceRenderer,
        spec: &FrameSpec,
        paged: &PagedTarget,
        plan: &SlicePlan,
        table: &TransferTable,
        [width, height]: [u32; 2],
    ) -> Result<Self, GpuError> {
        let device = Arc::clone(&renderer.device);
        let extent = Extent::D2(width, height);
        let target = Image::new(&device, "frame", ImageRole::ColorTarget, TARGET_FORMAT, extent)?;
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

    /// Draws.
    pub fn run(&self, device: &Arc<Device>) -> Result<(), GpuError> {
        for recording in &self.passes {
            device.submit(recording)?.wait()?;
        }
        Ok(())
    }

    /// What was accumulated.
    pub fn read_back(&self, device: &Arc<Device>) -> Result<Frame, GpuError> {
        let mut recording = Recording::new();
        recording.read_back(&self.target, &self.read_back);
        device.submit(&recording)?.wait()?;
        let pixels = self.read_back.read_vec::<[f32; 4]>()?;
        let [width, height, _] = self.target.extent().edges();
        Ok(Frame::from_pixels(width, height, pixels).unwrap_or_else(|_| Frame::transparent(width, height)))
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
        let table_image = Image::new(device, "transfer table", ImageRole::Sampled, TABLE_FORMAT, extent)?;
        let entries = Buffer::with_data(device, "transfer table", table.entries())?;
        recording.upload(&entries, &table_image);
        let data = frame::frame_data(spec, plan, paged.encoding);
        let uniform = Buffer::with_data(device, "frame data", &[data])?;
        let boxes = Buffer::with_data(device, "boxes", &frame::boxes(spec, plan, paged))?;
        let templates = Buffer::with_data(device, "templates", &frame::templates(plan))?;
        let bind = |page: &Page| {
            let sampled = |image: &Arc<Image>| Binding::SampledImage(Arc::clone(image), Arc::clone(&renderer.linear));
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
            let pipeline = renderer
                .pipelines
                .get(&renderer.device, spec, paged.pages[page].mixed)?;
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
