//! What is hidden is not drawn: a plan cut in depth into bands that are drawn from the nearest on.
//!
//! *Changes from the paper.* VCSG draws all slices from back to front, hidden or not. *Over* is associative, so slices may as well
//! come from the nearest on, each blended under what is in front of it. A plan that is cut is drawn so; and between two bands, a
//! pixel at which so little light still passes that nothing behind can show is closed to the bands that follow.
//! *Practice.* A pixel is closed when less than one part in [`HIDES_ALL_BUT`] passes, a quarter of a step of 8 bits. The more
//! bands, the sooner a ray ends and the more often pixels are looked at; only those that the last band can have drawn on are.
//! A plan can be [cut] when it is made. But what is closed also tells which boxes need not be planned at all, so whoever draws at once
//! [sweeps](Sweep) over slabs of depth instead, and plans each with what is [open](OpenTiles) by then.

use std::ops::Range;

use glam::DVec2;

use super::composite::Blending;
use super::{BoxView, FrameSpec, OpenTiles, Planes, Slice, SlicePlan};
use crate::interface::HIDES_ALL_BUT;
use crate::target::Lattice;

/// The bands of a plan that is cut. On lavapipe a head with opaque skin in 512² pixels drew equally fast with 8 to 14 of them.
const COUNT: usize = 10;

/// A plan is cut if a ray can end in this part of the way through it; later it saves less than bands cost.
const SOON: f64 = 0.25;

/// Planes of a slab while all of the frame is open. On lavapipe a head with opaque skin in 512² pixels drew equally fast with 12, 16 and 24.
const SLAB_PLANES: i64 = 16;

/// The most planes of a slab.
const THICKEST_SLAB: i64 = 64;

/// `plan`, cut into bands if it can pay.
pub fn cut(plan: SlicePlan, spec: &FrameSpec) -> SlicePlan {
    if can_hide(spec) { cut_into(plan, COUNT) } else { plan }
}

/// Whether what is in front can hide what is behind soon enough for it to pay.
pub fn can_hide(spec: &FrameSpec) -> bool {
    spec.settings.mode.blending() == Blending::Over && least_through(spec) * f64::from(HIDES_ALL_BUT) < 1.0
}

/// The least light that can pass [`SOON`] of all planes: the most opaque entry of the table at each of them.
fn least_through(spec: &FrameSpec) -> f64 {
    let table = spec.table();
    let most = table.entries().iter().map(|entry| entry[3]).fold(0.0, f32::max);
    let eye_from_lattice = super::eye_from_lattice(&spec.target.lattice, spec.camera);
    let depth = spec.target.lattice.bounds().transformed(&eye_from_lattice).size().z;
    (1.0 - f64::from(most))
        .max(0.0)
        .powf(SOON * depth / spec.planes().step_mm)
}

/// `plan` in at most `count` bands of about as many fragments each. If there are several, the nearest is the first, and within a
/// band the order is turned round.
pub fn cut_into(mut plan: SlicePlan, count: usize) -> SlicePlan {
    let was_cut = plan.is_cut();
    plan.band_faces_mm = faces(&plan, count);
    let mut slices = std::mem::take(&mut plan.slices);
    if plan.is_cut() != was_cut {
        slices.reverse();
    }
    slices.sort_by_cached_key(|slice| plan.band(slice));
    plan.slices = slices;
    plan
}

fn faces(plan: &SlicePlan, count: usize) -> Vec<f64> {
    let mut layers: Vec<(f64, f64)> = plan
        .slices
        .iter()
        .map(|slice| (plan.depth_mm(slice), plan.fragments(slice)))
        .collect();
    layers.sort_by(|a, b| a.0.total_cmp(&b.0));
    let share = layers.iter().map(|layer| layer.1).sum::<f64>() / count as f64;
    let mut faces: Vec<f64> = Vec::new();
    let mut before = 0.0;
    for (depth, fragments) in layers {
        let face = depth - 0.5 * plan.planes.step_mm;
        if before >= share * (faces.len() + 1) as f64 && faces.last().is_none_or(|last| face > *last) {
            faces.push(face);
        }
        before += fragments;
    }
    faces
}

/// Slabs of a frame's depth, the nearest first, that are planned one after another: each is as thick as pays with what is open by then.
#[derive(Clone, Debug)]
pub struct Sweep {
    planes: Planes,
    /// The planes that no slab holds yet.
    left: Range<i64>,
    /// The part of the frame that the lattice is seen in, and its tiles.
    seen_px: [DVec2; 2],
    tiles: u32,
}

impl Sweep {
    /// Of all `planes` that meet `lattice`, of which boxes are seen in `view`.
    pub fn new(lattice: &Lattice, planes: Planes, view: &BoxView) -> Self {
        let eye = view.eye_bounds(&lattice.bounds());
        let seen_px = view.seen_px(&eye);
        let camera = view.camera();
        Self {
            planes,
            left: planes.between(eye.min.z.max(camera.near_mm()), eye.max.z),
            seen_px,
            tiles: OpenTiles::all(camera.size).within(seen_px),
        }
    }

    /// The depths of the next slab in millimetres, from the first to before the second; `None` if nothing is left, or nothing open.
    pub fn next(&mut self, open: &OpenTiles) -> Option<[f64; 2]> {
        let open = i64::from(open.within(self.seen_px));
        if self.left.is_empty() || open == 0 {
            return None;
        }
        let thickness = (SLAB_PLANES * i64::from(self.tiles) / open).min(THICKEST_SLAB);
        let end = self.left.end.min(self.left.start + thickness);
        let begin = std::mem::replace(&mut self.left.start, end);
        Some([begin, end].map(|plane| self.planes.depth(plane) - 0.5 * self.planes.step_mm))
    }
}

/// The slices of each band, the nearest band first.
pub fn ranges(plan: &SlicePlan) -> Vec<Range<usize>> {
    let mut begin = 0;
    let bands = plan.slices.chunk_by(|a, b| plan.band(a) == plan.band(b));
    let range = |band: &[Slice]| {
        let range = begin..begin + band.len();
        begin = range.end;
        range
    };
    bands.map(range).collect()
}

/// The part of the frame that some slices lie in: its least and its greatest column and row, in pixels.
pub fn seen_px(plan: &SlicePlan, slices: Range<usize>) -> [DVec2; 2] {
    let boxes = plan.slices[slices].chunk_by(|a, b| a.slice_box == b.slice_box);
    let seen = boxes.map(|slices| plan.boxes[slices[0].slice_box as usize].seen_px);
    seen.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |a, b| {
        [a[0].min(b[0]), a[1].max(b[1])]
    })
}
