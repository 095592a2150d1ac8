//! Where a frame is still open: what lies behind closed pixels alone is not drawn.
//!
//! *Theory.* A pixel through which less than one part in [`HIDES_ALL_BUT`](crate::interface::HIDES_ALL_BUT) of the light passes is
//! closed: nothing behind can show there. Of what lies behind a depth, then, only boxes need be drawn that some open pixel sees.
//! *Changes from the paper.* VCSG draws all slices, hidden or not.
//! *Practice.* Whoever draws tells which tiles of the frame have an open pixel. How many of them lie left of and above each is summed
//! up once (Crow's summed-area table, 1984), so that asking for a box takes four numbers, however large it is.

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::{Camera, eye_from_lattice};
use crate::interface::OPEN_TILE;
use crate::math::{Aabb, affine};
use crate::target::Lattice;

/// A rasteriser puts vertices on a grid of no less than 1/16 pixel (Vulkan's least), so pixels are taken to be reached from so far.
const UNSURE_PX: f64 = 1.0 / 16.0;

/// Which tiles of a frame have a pixel that is open.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenTiles {
    /// Tiles across and down.
    counts: [usize; 2],
    /// At column `x` of row `y`, of which there is one more than of tiles: the open tiles left of `x` and above `y`.
    before: Vec<u32>,
}

impl OpenTiles {
    /// The tiles across and down of a frame of so many pixels; the last ones may reach beyond it.
    pub fn dims(size: [u32; 2]) -> [u32; 2] {
        size.map(|n| n.div_ceil(OPEN_TILE))
    }

    /// All tiles of a frame.
    pub fn all(size: [u32; 2]) -> Self {
        Self::new(size, |_| true)
    }

    /// Those tiles of a frame that `is_open` says are so, by their number in rows from the top.
    pub fn new(size: [u32; 2], is_open: impl Fn(usize) -> bool) -> Self {
        let counts = Self::dims(size).map(|n| n as usize);
        let across = counts[0] + 1;
        let mut before = vec![0; across * (counts[1] + 1)];
        for y in 0..counts[1] {
            let mut in_row = 0;
            for x in 0..counts[0] {
                in_row += u32::from(is_open(y * counts[0] + x));
                before[(y + 1) * across + x + 1] = before[y * across + x + 1] + in_row;
            }
        }
        Self { counts, before }
    }

    /// How many tiles are open of those that a part of the frame touches, from its least to its greatest column and row in pixels.
    pub fn within(&self, [least, greatest]: [DVec2; 2]) -> u32 {
        let tile = |px: f64| (px / f64::from(OPEN_TILE)).floor();
        let [x, y] = [0, 1].map(|a| {
            let end = tile(greatest[a] + UNSURE_PX) + 1.0;
            let first = tile(least[a] - UNSURE_PX);
            [first, end].map(|n| n.clamp(0.0, self.counts[a] as f64) as usize)
        });
        let before = |x: usize, y: usize| self.before[y * (self.counts[0] + 1) + x];
        before(x[1], y[1]) + before(x[0], y[0]) - before(x[0], y[1]) - before(x[1], y[0])
    }
}

/// Where boxes of a lattice are seen.
#[derive(Clone, Debug)]
pub struct BoxView {
    camera: Camera,
    eye_from_lattice: DAffine3,
    /// How far a step along each lattice axis reaches along each axis of the eye frame.
    eye_reach: DMat3,
}

impl BoxView {
    /// Of boxes of `lattice` in the picture of `camera`.
    pub fn new(lattice: &Lattice, camera: &Camera) -> Self {
        let eye_from_lattice = eye_from_lattice(lattice, camera);
        let axes = eye_from_lattice.matrix3;
        Self {
            camera: *camera,
            eye_from_lattice,
            eye_reach: DMat3::from_cols(axes.x_axis.abs(), axes.y_axis.abs(), axes.z_axis.abs()),
        }
    }

    /// Who sees them.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// A box round a box, in the eye frame.
    pub fn eye_bounds(&self, bounds: &Aabb) -> Aabb {
        let middle = affine::point(&self.eye_from_lattice, bounds.center());
        let reach = self.eye_reach * (0.5 * bounds.size());
        Aabb::new(middle - reach, middle + reach)
    }

    /// The part of the frame that what lies in `eye`, a box of the eye frame, may be seen in: its least and its greatest column and
    /// row, in pixels. That is anywhere if some of it is not before the eye.
    pub fn seen_px(&self, eye: &Aabb) -> [DVec2; 2] {
        if eye.min.z <= self.camera.near_mm() {
            return [DVec2::NEG_INFINITY, DVec2::INFINITY];
        }
        // What is nearer lies farther from the middle of the frame, on either side of it.
        let ends = |end: DVec3| [eye.min.z, eye.max.z].map(|z| self.camera.project(end.with_z(z)));
        let [least, greatest] = [ends(eye.min), ends(eye.max)];
        [least[0].min(least[1]), greatest[0].max(greatest[1])]
    }
}

/// What is left to be drawn: between two depths, where the frame is open.
#[derive(Clone, Copy, Debug)]
pub struct Remaining<'a> {
    /// Where boxes are.
    pub view: &'a BoxView,
    /// From this depth on and before that one, millimetres.
    pub depths_mm: [f64; 2],
    /// Where something may show.
    pub open: &'a OpenTiles,
}

impl Remaining<'_> {
    /// Whether a box of the lattice may have to do with it.
    pub fn may_show(&self, bounds: &Aabb) -> bool {
        let eye = self.view.eye_bounds(bounds);
        let [near, far] = self.depths_mm;
        eye.min.z < far && eye.max.z >= near && self.open.within(self.view.seen_px(&eye)) > 0
    }
}
