//! One frame on a device: its buffers and tables, its draws in submissions of bounded time, and its pixels.

use std::ops::Range;
use std::sync::Arc;

use super::frame;
use super::layers::Layers;
use super::pages::{Page, PagedTarget};
use super::slices::{SliceRenderer, TABLE_FORMAT};
use crate::gpu::{
    Binding, Bindings, Buffer, BufferRole, Device, Draw, Elements, Extent, GpuError, GraphicsPipeline, Image,
    ImageRole, Push, Recording, RenderPass,
};
use crate::image::Frame;
use crate::interface::{MAX_VERTICES, TABLE_LEN};
use crate::projection::{FrameSpec, SlicePlan, TransferTable, bands};

/// Fragments of one submission, about: it ends within a second even on a processor.
const SUBMISSION_FRAGMENTS: f64 = 5e7;

/// A fan of four triangles over six vertices.
const FAN: [u32; 12] = [0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5];

const _: () = assert!(FAN.len() == 3 * (MAX_VERTICES as usize - 2));

/// Most slices of a draw. (An instance a slice would want fewer indices, but six vertices fill no wave of a graphics card; lavapipe
/// draws both equally fast.)
const DRAW_SLICES: u32 = 4096;

/// The indices of a draw: a fan for each of its slices.
pub fn fans() -> Vec<u32> {
    (0..DRAW_SLICES)
        .flat_map(|slice| FAN.map(|vertex| MAX_VERTICES * slice + vertex))
        .collect()
}

/// Everything that one frame needs on the device.
pub struct Job {
    layers: Layers,
    read_back: Arc<Buffer>,
    recordings: Vec<Recording>,
}

impl Job {
    /// Uploads what `plan` needs and records its draws.
    pub fn new(
        renderer: &mut SliceRenderer,
        spec: &FrameSpec,
        paged: &PagedTarget,
        plan: &SlicePlan,
        table: &TransferTable,
        size: [u32; 2],
    ) -> Result<Self, GpuError> {
        let device = Arc::clone(&renderer.device);
        let layers = Layers::new(renderer, size, !plan.band_faces_mm.is_empty())?;
        let read_back = Buffer::new(&device, "frame", BufferRole::Readback, layers.accumulated.bytes())?;
        let mut submissions = Submissions::default();
        let shared = Shared::new(renderer, spec, paged, plan, table, submissions.last())?;
        submissions.last().render(layers.clear());
        for (n, band) in bands::ranges(plan).into_iter().enumerate() {
            let mut parts = parts(plan, band).into_iter();
            if let Some((part, fragments)) = parts.next() {
                let draws = shared.draws(renderer, spec, paged, plan, part)?;
                submissions.render(layers.begin(n, draws), fragments);
            }
            for (part, fragments) in parts {
                let draws = shared.draws(renderer, spec, paged, plan, part)?;
                submissions.render(layers.go_on(draws), fragments);
            }
            if let Some(end) = layers.end() {
                submissions.last().render(end);
            }
        }
        Ok(Self {
            layers,
            read_back,
            recordings: submissions.recordings,
        })
    }

    /// Draws.
    pub fn run(&self, device: &Arc<Device>) -> Result<(), GpuError> {
        for recording in &self.recordings {
            device.submit(recording)?.wait()?;
        }
        Ok(())
    }

    /// What was accumulated.
    pub fn read_back(&self, device: &Arc<Device>) -> Result<Frame, GpuError> {
        let mut recording = Recording::new();
        let accumulated = &self.layers.accumulated;
        recording.read_back(accumulated, &self.read_back);
        device.submit(&recording)?.wait()?;
        let pixels = self.read_back.read_vec::<[f32; 4]>()?;
        let [width, height, _] = accumulated.extent().edges();
        Ok(Frame::from_pixels(width, height, pixels).unwrap_or_else(|_| Frame::transparent(width, height)))
    }
}

/// The passes of a frame, in recordings that each end in bounded time.
#[derive(Default)]
struct Submissions {
    recordings: Vec<Recording>,
    /// Fragments of the last one.
    fragments: f64,
}

impl Submissions {
    fn last(&mut self) -> &mut Recording {
        if self.recordings.is_empty() {
            self.recordings.push(Recording::new());
        }
        let last = self.recordings.len() - 1;
        &mut self.recordings[last]
    }

    fn render(&mut self, pass: RenderPass, fragments: f64) {
        self.fragments += fragments;
        if self.fragments > SUBMISSION_FRAGMENTS {
            self.recordings.push(Recording::new());
            self.fragments = fragments;
        }
        self.last().render(pass);
    }
}

/// Parts of a band that each fit a submission, and their fragments.
fn parts(plan: &SlicePlan, band: Range<usize>) -> Vec<(Range<usize>, f64)> {
    let mut parts = Vec::new();
    let (mut begin, mut fragments) = (band.start, 0.0);
    for n in band.clone() {
        let more = plan.fragments(&plan.slices[n]);
        if fragments + more > SUBMISSION_FRAGMENTS && n > begin {
            parts.push((begin..n, fragments));
            (begin, fragments) = (n, 0.0);
        }
        fragments += more;
    }
    parts.push((begin..band.end, fragments));
    parts
}

/// Buffers and tables of a frame, and the bindings of each page.
struct Shared {
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
            return Ok(Self { bindings: Vec::new() });
        }
        let extent = Extent::D1(TABLE_LEN);
        let table_image = Image::new(device, "transfer table", ImageRole::Sampled, TABLE_FORMAT, extent)?;
        let entries = Buffer::with_data(device, "transfer table", table.entries())?;
        recording.upload(&entries, &table_image);
        let data = frame::frame_data(spec, plan);
        let uniform = Buffer::with_data(device, "frame data", &[data])?;
        let boxes = Buffer::with_data(device, "boxes", &frame::boxes(spec, plan, paged))?;
        let vertices = Buffer::with_data(device, "moving vertices", &frame::vertices(plan))?;
        let slices = Buffer::with_data(device, "slices", &frame::slices(plan))?;
        let bind = |page: &Page| {
            let sampled = |image: &Arc<Image>| Binding::SampledImage(Arc::clone(image), Arc::clone(&renderer.linear));
            let entries = [
                sampled(&page.values),
                sampled(page.normals.as_ref().unwrap_or(&page.values)),
                Binding::SampledImage(Arc::clone(&table_image), Arc::clone(&renderer.nearest)),
                Binding::Uniform(Arc::clone(&uniform)),
                Binding::Storage(Arc::clone(&boxes)),
                Binding::Storage(Arc::clone(&vertices)),
                Binding::Storage(Arc::clone(&slices)),
            ];
            Bindings::new(device, "page", &entries)
        };
        Ok(Self {
            bindings: paged.pages.iter().map(bind).collect::<Result<_, _>>()?,
        })
    }

    /// A draw for each run of slices of one page, or several if it is long.
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
            paged.slots[slice_box.visible.block as usize].page
        };
        let mut draws = Vec::new();
        let mut begin = part.start;
        while begin < part.end {
            let page = page_of(begin);
            let mut end = begin + 1;
            while end < part.end && end - begin < DRAW_SLICES as usize && page_of(end) == page {
                end += 1;
            }
            let pipeline = renderer.pipelines.slices(
                &renderer.device,
                spec,
                paged.pages[page].mixed,
                !plan.band_faces_mm.is_empty(),
            )?;
            draws.push(self.draw(renderer, pipeline, page, begin..end));
            begin = end;
        }
        Ok(draws)
    }

    fn draw(
        &self,
        renderer: &SliceRenderer,
        pipeline: Arc<GraphicsPipeline>,
        page: usize,
        slices: Range<usize>,
    ) -> Draw {
        Draw {
            pipeline,
            bindings: Some(Arc::clone(&self.bindings[page])),
            push: Push::NONE,
            stream: None,
            elements: Elements::Indices {
                buffer: Arc::clone(&renderer.fans),
                range: 0..(FAN.len() * slices.len()) as u32,
                base_vertex: (MAX_VERTICES as usize * slices.start) as i32,
            },
            instances: 0..1,
        }
    }
}
