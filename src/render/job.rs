//! One frame on a device: its buffers and tables, its draws in submissions of bounded time, and its pixels.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec2;

use super::depths::DepthScale;
use super::frame::{self, BASE_SLICES};
use super::layers::{Layers, Meeting, Order};
use super::mesh::{ShownMesh, mesh_bounds};
use super::pages::{Page, PagedTarget};
use super::slices::{Accumulated, SliceRenderer, TABLE_FORMAT};
use super::submissions::{SUBMISSION_FRAGMENTS, Submissions};
use super::surfaces::{Shown, Surfaces};
use crate::gpu::{
    Binding, Bindings, Buffer, BufferRole, Device, Draw, Elements, Extent, GpuError, Image, ImageRole, Push, Recording,
};
use crate::image::Frame;
use crate::interface::{MAX_VERTICES, TABLE_LEN};
use crate::math::Aabb;
use crate::projection::{FrameSpec, SlicePlan, bands, eye_from_lattice};
use crate::surface::SurfaceView;

/// A frame that is being drawn on the device.
pub struct Job {
    pub layers: Layers,
    surfaces: Option<Surfaces>,
    shared: Shared,
    pub submissions: Submissions,
}

impl Job {
    /// Records the images, and `meshes`; slices can then be added in `order`, of plans that have view and depth cue of `like`.
    pub fn new(
        renderer: &mut SliceRenderer,
        spec: &FrameSpec,
        meshes: &[ShownMesh],
        order: Order,
        like: &SlicePlan,
    ) -> Result<Self, GpuError> {
        let mut submissions = Submissions::default();
        let scale = DepthScale::new(spec.camera, &drawn_bounds(spec, meshes));
        let surfaces = surfaces(renderer, spec, meshes, &scale, &mut submissions)?;
        let depth = surfaces.as_ref().map(|surfaces| &surfaces.depth);
        let layers = Layers::new(renderer, spec.camera.size, order, depth)?;
        let meeting = Meeting::new(spec, &layers);
        let shared = Shared::new(renderer, spec, like, &scale, meeting, submissions.last())?;
        submissions.last().render(layers.clear(depth));
        Ok(Self {
            layers,
            surfaces,
            shared,
            submissions,
        })
    }

    /// Records the slices of `plan`, and between its bands what closes pixels.
    pub fn add(
        &mut self,
        renderer: &mut SliceRenderer,
        spec: &FrameSpec,
        paged: &PagedTarget,
        plan: &SlicePlan,
    ) -> Result<(), GpuError> {
        if plan.slices.is_empty() {
            return Ok(());
        }
        let bound = Bound {
            bindings: self.shared.bind(renderer, spec, paged, plan)?,
            fans: Fans::new(&renderer.device, plan)?,
        };
        let mut drawn: Option<Range<usize>> = None;
        for band in bands::ranges(plan) {
            if let Some(before) = drawn {
                self.close(bands::seen_px(plan, before), None);
            }
            for (part, fragments) in parts(plan, band.clone()) {
                let draws = draws(renderer, spec, paged, plan, part, self.shared.meeting, &bound)?;
                self.submissions.render(self.layers.go_on(draws), fragments);
            }
            drawn = Some(band);
        }
        Ok(())
    }

    /// Closes pixels in a part of the frame, if pixels are closed at all, and then draws a `look`.
    pub fn close(&mut self, seen_px: [DVec2; 2], look: Option<Draw>) {
        if let Some(mut pass) = self.layers.close(seen_px) {
            pass.draws.extend(look);
            self.submissions.last().render(pass);
        }
    }

    /// What is drawn, once all is done that was handed over.
    pub fn accumulated(&self, device: &Arc<Device>) -> Result<Accumulated, GpuError> {
        let surfaces = self.surfaces.as_ref();
        Ok(Accumulated {
            samples: read_back(device, &self.layers.accumulated)?,
            surfaces: surfaces
                .map(|surfaces| read_back(device, &surfaces.image))
                .transpose()?,
        })
    }
}

/// The pixels of `image`.
pub fn read_back(device: &Arc<Device>, image: &Arc<Image>) -> Result<Frame, GpuError> {
    let buffer = Buffer::new(device, image.label(), BufferRole::Readback, image.bytes())?;
    let mut recording = Recording::new();
    recording.read_back(image, &buffer);
    device.submit(&recording)?.wait()?;
    let pixels = buffer.read_vec::<[f32; 4]>()?;
    let [width, height, _] = image.extent().edges();
    Ok(Frame::from_pixels(width, height, pixels).unwrap_or_else(|_| Frame::transparent(width, height)))
}

/// The box in the eye frame of all that may be drawn.
fn drawn_bounds(spec: &FrameSpec, meshes: &[ShownMesh]) -> Aabb {
    let lattice = &spec.target.lattice;
    let target = lattice.bounds().transformed(&eye_from_lattice(lattice, spec.camera));
    target.hull(&mesh_bounds(meshes).transformed(&spec.camera.eye_from_world))
}

fn surfaces(
    renderer: &mut SliceRenderer,
    spec: &FrameSpec,
    meshes: &[ShownMesh],
    scale: &DepthScale,
    submissions: &mut Submissions,
) -> Result<Option<Surfaces>, GpuError> {
    if meshes.is_empty() {
        return Ok(None);
    }
    let view = SurfaceView::beside(spec);
    Surfaces::new(renderer, &view, scale, meshes, Shown::Color, submissions).map(Some)
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

/// What all slices of a frame read.
struct Shared {
    table: Arc<Image>,
    frame_data: Arc<Buffer>,
    meeting: Meeting,
}

impl Shared {
    fn new(
        renderer: &SliceRenderer,
        spec: &FrameSpec,
        like: &SlicePlan,
        scale: &DepthScale,
        meeting: Meeting,
        recording: &mut Recording,
    ) -> Result<Self, GpuError> {
        let device = &renderer.device;
        let extent = Extent::D1(TABLE_LEN);
        let table = Image::new(device, "transfer table", ImageRole::Sampled, TABLE_FORMAT, extent)?;
        let entries = Buffer::with_data(device, "transfer table", spec.table().entries())?;
        recording.upload(&entries, &table);
        let view = SurfaceView {
            cue_mm: like.cue_mm,
            ..SurfaceView::beside(spec)
        };
        let mut data = frame::frame_data(&view, &like.eye_from_lattice, scale, spec.shading());
        data.cue[3] = spec.slab_units().unwrap_or(1.0) as f32;
        Ok(Self {
            table,
            frame_data: Buffer::with_data(device, "frame data", &[data])?,
            meeting,
        })
    }

    /// The bindings of each page for the slices of `plan`.
    fn bind(
        &self,
        renderer: &SliceRenderer,
        spec: &FrameSpec,
        paged: &PagedTarget,
        plan: &SlicePlan,
    ) -> Result<Vec<Arc<Bindings>>, GpuError> {
        let device = &renderer.device;
        let boxes = Buffer::with_data(device, "boxes", &frame::boxes(spec, plan, paged))?;
        let vertices = Buffer::with_data(device, "moving vertices", &frame::vertices(plan))?;
        let slices = Buffer::with_data(device, "slices", &frame::slices(plan))?;
        let bind = |page: &Page| {
            let sampled = |image: &Arc<Image>| Binding::SampledImage(Arc::clone(image), Arc::clone(&renderer.linear));
            let entries = [
                sampled(&page.values),
                sampled(page.normals.as_ref().unwrap_or(&page.values)),
                Binding::SampledImage(Arc::clone(&self.table), Arc::clone(&renderer.nearest)),
                Binding::Uniform(Arc::clone(&self.frame_data)),
                Binding::Storage(Arc::clone(&boxes)),
                Binding::Storage(Arc::clone(&vertices)),
                Binding::Storage(Arc::clone(&slices)),
            ];
            Bindings::new(device, "page", &entries)
        };
        paged.pages.iter().map(bind).collect()
    }
}

/// What the slices of a plan read and are drawn by.
struct Bound {
    /// Of each page.
    bindings: Vec<Arc<Bindings>>,
    fans: Fans,
}

/// The triangles of slices, on the device.
struct Fans {
    indices: Arc<Buffer>,
    /// Where those of each slice begin, and where the last ones end.
    begins: Vec<u32>,
}

impl Fans {
    fn new(device: &Arc<Device>, plan: &SlicePlan) -> Result<Self, GpuError> {
        let (indices, begins) = frame::fans(plan);
        Ok(Self {
            indices: Buffer::with_data(device, "fans", &indices)?,
            begins,
        })
    }

    /// Those of slices that have one base.
    fn of(&self, slices: Range<usize>) -> Elements {
        let base = slices.start - slices.start % BASE_SLICES;
        Elements::Indices {
            buffer: Arc::clone(&self.indices),
            range: self.begins[slices.start]..self.begins[slices.end],
            base_vertex: (MAX_VERTICES as usize * base) as i32,
        }
    }
}

/// A draw for each run of slices of one page.
fn draws(
    renderer: &mut SliceRenderer,
    spec: &FrameSpec,
    paged: &PagedTarget,
    plan: &SlicePlan,
    part: Range<usize>,
    meeting: Meeting,
    bound: &Bound,
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
        while end < part.end && !end.is_multiple_of(BASE_SLICES) && page_of(end) == page {
            end += 1;
        }
        let texels = paged.pages[page].texels;
        let pipeline = renderer.pipelines.slices(&renderer.device, spec, texels, meeting)?;
        draws.push(Draw {
            pipeline,
            bindings: Some(Arc::clone(&bound.bindings[page])),
            push: Push::NONE,
            stream: None,
            elements: bound.fans.of(begin..end),
            instances: 0..1,
        });
        begin = end;
    }
    Ok(draws)
}
