//! The frames between which a device's picture must lie.

use glam::DVec2;
use rayon::prelude::*;

use super::blend::{blend, resolve};
use super::field::VoxelField;
use super::hiding::Hiding;
use super::mesh::MeshBounds;
use super::place::Places;
use super::precision::{Precision, ULP};
use super::source::{Sources, Spans};
use super::span::Span;
use super::storage::Storage;
use crate::image::Frame;
use crate::math::Aabb;
use crate::projection::{FrameSpec, Lens, SliceBox, SlicePlan};

/// How a device draws a frame, as far as its bounds depend on it.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// The boxes that are drawn.
    pub boxes: Vec<DrawnBox>,
    /// How voxels are held.
    pub storage: Storage,
    /// What arithmetic is good for.
    pub precision: Precision,
    /// In how many bands it is drawn.
    pub bands: usize,
}

/// A box, and between which depths it is drawn: in bands, others may hold the same voxels at other depths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnBox {
    /// In lattice coordinates.
    pub bounds: Aabb,
    /// From the first of its planes to the last, and half a slab on either side, millimetres.
    pub depths_mm: [f64; 2],
}

impl DrawnBox {
    /// The boxes of `plan` that have slices.
    fn of(plan: &SlicePlan) -> Vec<Self> {
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let mut depths = vec![none; plan.boxes.len()];
        for slice in &plan.slices {
            let ([nearest, farthest], depth) = (&mut depths[slice.slice_box as usize], plan.depth_mm(slice));
            (*nearest, *farthest) = (nearest.min(depth), farthest.max(depth));
        }
        let half = 0.5 * plan.planes.step_mm;
        let boxes = plan.boxes.iter().zip(depths).filter(|(_, depths)| *depths != none);
        let drawn = |(b, [nearest, farthest]): (&SliceBox, [f64; 2])| Self {
            bounds: b.visible.bounds(),
            depths_mm: [nearest - half, farthest + half],
        };
        boxes.map(drawn).collect()
    }
}

impl Drawing {
    /// The boxes of `plan`, drawn from `storage` with `precision`.
    pub fn new(plan: &SlicePlan, storage: Storage, precision: Precision) -> Self {
        Self {
            boxes: DrawnBox::of(plan),
            storage,
            precision,
            bands: plan.band_faces_mm.len() + 1,
        }
    }
}

/// The least and the most that each channel of a frame may be.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameBounds {
    /// Lower ends.
    pub low: Frame,
    /// Upper ends.
    pub high: Frame,
}

impl FrameBounds {
    /// The bounds of `spec` for a device that draws it as `drawing` says.
    pub fn new(spec: &FrameSpec, drawing: &Drawing) -> Self {
        Self::of(spec, Walker::new(spec, drawing))
    }

    /// Likewise, among meshes.
    pub fn among(spec: &FrameSpec, drawing: &Drawing, meshes: &MeshBounds) -> Self {
        let walker = Walker::new(spec, drawing);
        Self::of(
            spec,
            Walker {
                meshes: Some(meshes),
                ..walker
            },
        )
    }

    fn of(spec: &FrameSpec, walker: Walker) -> Self {
        let [width, height] = spec.camera.size;
        let pixel = |n: usize| {
            let (x, y) = (n as u32 % width, n as u32 / width);
            walker.pixel(x, y)
        };
        let pixels: Vec<Spans> = (0..width as usize * height as usize)
            .into_par_iter()
            .map(pixel)
            .collect();
        let frame = |end: fn(Span) -> f32| {
            let mut frame = Frame::transparent(width, height);
            for (pixel, spans) in frame.pixels_mut().iter_mut().zip(&pixels) {
                *pixel = spans.map(end);
            }
            frame
        };
        Self {
            low: frame(|span| (span.lo as f32).next_down()),
            high: frame(|span| (span.hi as f32).next_up()),
        }
    }

    /// The mean width of the bounds over all channels.
    pub fn mean_width(&self) -> f64 {
        let widths = self.widths();
        let count = widths.len().max(1) as f64;
        widths.into_iter().sum::<f64>() / count
    }

    /// The width of each channel's bounds, pixel by pixel.
    pub fn widths(&self) -> Vec<f64> {
        let low = self.low.pixels().as_flattened().iter();
        let high = self.high.pixels().as_flattened().iter();
        low.zip(high).map(|(lo, hi)| f64::from(*hi) - f64::from(*lo)).collect()
    }

    /// How far each channel of `frame` is from the middle of its bounds, in half widths: above 1 is outside.
    pub fn deviations(&self, frame: &Frame) -> Vec<f64> {
        let low = self.low.pixels().as_flattened().iter();
        let ends = low.zip(self.high.pixels().as_flattened());
        let channels = frame.pixels().as_flattened().iter();
        channels
            .zip(ends)
            .map(|(&v, (&lo, &hi))| {
                let [v, lo, hi] = [v, lo, hi].map(f64::from);
                (2.0 * v - lo - hi).abs() / (hi - lo)
            })
            .collect()
    }

    /// How many pixels of `frame` have a channel out of bounds. NaN is out of any bounds.
    pub fn pixels_outside(&self, frame: &Frame) -> usize {
        let bounds = self.low.pixels().iter().zip(self.high.pixels());
        let pixels = frame.pixels().iter().zip(bounds);
        pixels
            .filter(|(pixel, (low, high))| (0..4).any(|c| !(low[c]..=high[c]).contains(&pixel[c])))
            .count()
    }
}

struct Walker<'a> {
    spec: &'a FrameSpec<'a>,
    field: VoxelField,
    places: Places,
    sources: Sources<'a>,
    precision: Precision,
    hiding: Hiding,
    meshes: Option<&'a MeshBounds>,
}

impl<'a> Walker<'a> {
    fn new(spec: &'a FrameSpec<'a>, drawing: &Drawing) -> Self {
        let Drawing {
            boxes,
            storage,
            precision,
            bands,
        } = drawing;
        let places = Places::new(spec, boxes.clone(), storage.page_edge, precision);
        let eye = *places.eye_bounds();
        Self {
            spec,
            field: VoxelField::new(spec),
            sources: Sources::new(spec, storage, precision, [eye.min.z, eye.max.z]),
            places,
            precision: *precision,
            hiding: Hiding::new(spec, *bands),
            meshes: None,
        }
    }

    fn pixel(&self, x: u32, y: u32) -> Spans {
        let Self { spec, places, .. } = self;
        let n = y as usize * spec.camera.size[0] as usize + x as usize;
        let eye_bounds = places.eye_bounds();
        let unsure = places.depth_mm();
        let near = (eye_bounds.min.z - unsure).max(spec.camera.near_mm());
        let far = eye_bounds.max.z + unsure;
        let planes = spec.planes();
        let blending = spec.settings.mode.blending();
        let mut pixel = [Span::ZERO; 4];
        let mut samples = 0;
        for k in planes.between(near, far).rev() {
            let eye = spec.camera.point_at_depth(x, y, planes.depth(k));
            let Some(place) = places.at(eye) else {
                continue;
            };
            if let Some(hull) = self.field.hull(&place.texels) {
                let source = self.sources.over(&hull, eye.z, self.path(x, y, eye.z));
                let stop = self.meshes.map_or([1, 1], |meshes| meshes.times(n, eye.z, unsure));
                let times = [0, 1].map(|end| stop[end] * place.times[end]);
                pixel = blend(blending, &source, &pixel, times);
                samples += times[1];
            }
        }
        let settings = spec.settings;
        let pixel = self.hiding.of(&pixel, samples);
        let pixel = resolve(settings.mode, &pixel, spec.target.value_range, spec.transfer);
        let mode = settings.mode;
        self.meshes.map_or(pixel, |meshes| meshes.behind(n, mode, &pixel))
    }

    /// Millimetres of ray a millimetre of depth: the root of 1 and the squares of an interpolated slope. It changes with the
    /// slope by no more than the slope does.
    fn path(&self, x: u32, y: u32, depth: f64) -> Span {
        let Lens::Perspective { focal_px, .. } = self.spec.camera.lens else {
            return Span::ONE;
        };
        let eye = self.spec.camera.point_at_depth(x, y, 1.0);
        let size = DVec2::from(self.spec.camera.size.map(f64::from));
        let steepest = size.max_element().max(2.0 * focal_px * eye.truncate().length()) / focal_px;
        let slope = self.places.vertex_px(depth) / focal_px + self.precision.interpolated * steepest;
        let path = self.spec.camera.path_per_depth(x, y);
        Span::around(path, 2.0 * slope).relaxed(6.0 * ULP)
    }
}
