//! Rays in lattice coordinates, and where they cross the faces of boxes.
//!
//! *Practice.* The sampling points of a ray are equally far apart, with parallel rays and from an eye: point `k` is at
//! `origin + k·step`, `k` counted from the first plane of the frame. Both change by the same from each pixel to the next, so they are worked
//! out once for the frame's first pixel. Whether a point is before or behind a face is decided by
//! [`PacketRays::crossing`] alone, from the ray and the face's coordinate, so boxes that share a face agree on it.

use glam::{DAffine3, DVec2, DVec3};

use super::simd::{EDGE, RAYS, Simd, each};
use super::template::edge;
use crate::math::affine;
use crate::projection::{Camera, FrameSpec, Lens, Planes, ProjectError, eye_from_lattice};

/// The most planes that rays are sampled at: plane numbers are exact in single precision.
pub const MOST_PLANES: i32 = 1 << 24;

/// A stretch of depth, as a frame samples it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Depths {
    /// The sampling planes.
    pub planes: Planes,
    /// Where it begins and ends, millimetres from the eye; it is what is not before the one and is before the other.
    pub within_mm: [f64; 2],
    /// The depths that a depth cue spans, millimetres.
    pub cue_mm: [f64; 2],
}

impl Depths {
    /// All of a frame.
    pub fn of(spec: &FrameSpec) -> Self {
        let lattice = &spec.target.lattice;
        let depths = lattice.bounds().transformed(&eye_from_lattice(lattice, spec.camera));
        Self {
            planes: spec.planes(),
            within_mm: [depths.min.z, depths.max.z],
            cue_mm: [depths.min.z, depths.max.z],
        }
    }
}

/// The rays of a frame, in lattice coordinates.
pub struct Rays {
    /// The first sampling points.
    pub origin: OverFrame,
    /// The ways from one sampling point to the next.
    pub step: OverFrame,
    /// Whether all go the same way.
    pub parallel: bool,
    /// Whether it is the last column, and the last row, of a packet that has the lowest coordinate along each axis, at any plane, instead of the
    /// first one; the ray across from it has the highest.
    pub lowest: [[bool; 2]; 3],
    /// Depth of the first plane that may meet the target, and distance between planes, millimetres.
    first_mm: f64,
    step_mm: f64,
    /// Planes from the first to the last.
    pub planes: i32,
}

/// A vector of each pixel of a frame.
pub struct OverFrame {
    /// That of the first pixel.
    first: DVec3,
    /// What is added from column to column.
    column: DVec3,
    /// What is added from row to row.
    row: DVec3,
}

impl OverFrame {
    /// Of what `f` makes of a place in the frame, in pixels.
    fn new(f: impl Fn(DVec2) -> DVec3) -> Self {
        let first = f(DVec2::splat(0.5));
        Self {
            first,
            column: f(DVec2::new(1.5, 0.5)) - first,
            row: f(DVec2::new(0.5, 1.5)) - first,
        }
    }

    /// Along an axis, those of the vector whose first pixel is `first`.
    #[inline(always)]
    fn packet<S: Simd>(&self, axis: usize, first: [u32; 2]) -> S::Double {
        self.at::<S>(
            axis,
            each!(a of [0, 1] => S::double(f64::from(first[a])) + S::doubles(WITHIN[a])),
        )
    }

    /// Along an axis, that of the pixel in this column and row.
    #[inline(always)]
    fn of_pixel(&self, axis: usize, [x, y]: [f64; 2]) -> f64 {
        self.first[axis] + (x * self.column[axis] + y * self.row[axis])
    }

    /// Along an axis, those of pixels in these columns and rows.
    #[inline(always)]
    pub fn at<S: Simd>(&self, axis: usize, [x, y]: [S::Double; 2]) -> S::Double {
        S::double(self.first[axis]) + (x * S::double(self.column[axis]) + y * S::double(self.row[axis]))
    }
}

/// The columns and the rows of a vector's rays.
const WITHIN: [[f64; RAYS]; 2] = {
    let mut within = [[0.0; RAYS]; 2];
    let mut n = 0;
    while n < RAYS {
        within[0][n] = (n % EDGE) as f64;
        within[1][n] = (n / EDGE) as f64;
        n += 1;
    }
    within
};

impl Rays {
    /// The rays of the frame of `spec` in `depths`.
    ///
    /// # Errors
    /// If there are too many planes.
    pub fn new(spec: &FrameSpec, depths: &Depths) -> Result<Self, ProjectError> {
        let [near_mm, far_mm] = depths.within_mm;
        let range = depths.planes.between(near_mm.max(spec.camera.near_mm()), far_mm);
        let planes = range.end.saturating_sub(range.start).max(0);
        if planes > i64::from(MOST_PLANES) {
            let (samples_per_voxel, limit) = (spec.settings.samples_per_voxel, i64::from(MOST_PLANES));
            return Err(ProjectError::Planes {
                samples_per_voxel,
                limit,
            });
        }
        let (camera, step_mm) = (spec.camera, depths.planes.step_mm);
        let first_mm = depths.planes.depth(range.start);
        let lattice_from_eye = eye_from_lattice(&spec.target.lattice, camera).inverse();
        let begin = |px: DVec2| affine::point(&lattice_from_eye, camera.unproject(px, first_mm));
        let origin = OverFrame::new(begin);
        let step = OverFrame::new(|px| step(camera, &lattice_from_eye, px, step_mm));
        Ok(Self {
            parallel: step.column == DVec3::ZERO && step.row == DVec3::ZERO,
            lowest: lowest(&origin, &step, planes as f64),
            origin,
            step,
            first_mm,
            step_mm,
            planes: planes as i32,
        })
    }

    /// Depth of plane `k`, millimetres: `first + k·step`.
    pub fn depth_mm(&self) -> [f64; 2] {
        [self.first_mm, self.step_mm]
    }

    /// How far it is along each axis from a column to the next, and from a row to the next, at a plane.
    #[inline(always)]
    pub fn apart(&self, plane: i32) -> [[f64; 2]; 3] {
        let planes = f64::from(plane);
        let column = self.origin.column + planes * self.step.column;
        let row = self.origin.row + planes * self.step.row;
        each!(axis of [0, 1, 2] => [column[axis], row[axis]])
    }

    /// How far the rays of a packet of `N` vectors are at most apart along any axis, anywhere in the frame.
    pub fn packet_extent<const N: usize>(&self) -> f64 {
        let extent = |plane: i32| {
            let apart = self.apart(plane).map(|[column, row]| column.abs() + row.abs());
            (edge(N) - 1) as f64 * apart.into_iter().fold(0.0, f64::max)
        };
        extent(0).max(extent(self.planes))
    }

    /// In how many planes the fastest ray of a frame with this last pixel passes a voxel along some axis.
    pub fn planes_per_voxel(&self, [width, height]: [u32; 2]) -> f64 {
        let corners = [[0, 0], [width, 0], [0, height], [width, height]].map(|corner| corner.map(f64::from));
        let fastest = corners
            .into_iter()
            .flat_map(|corner| [0, 1, 2].map(|axis| self.step.of_pixel(axis, corner).abs()));
        1.0 / fastest.fold(f64::MIN_POSITIVE, f64::max)
    }

    /// The lowest place along each axis of the packet of `N` vectors that begins at `first`: at plane 0, and from plane to plane.
    #[inline(always)]
    pub fn low<const N: usize>(&self, first: [u32; 2]) -> [[f64; 2]; 3] {
        each!(axis of [0, 1, 2] => {
            let pixel = each!(a of [0, 1] => {
                let last = if self.lowest[axis][a] { edge(N) - 1 } else { 0 };
                f64::from(first[a]) + last as f64
            });
            [self.origin.of_pixel(axis, pixel), self.step.of_pixel(axis, pixel)]
        })
    }
}

/// See [`Rays::lowest`]; the last plane is `last` from the first.
fn lowest(origin: &OverFrame, step: &OverFrame, last: f64) -> [[bool; 2]; 3] {
    let falls = |part: fn(&OverFrame) -> DVec3, axis: usize| part(origin)[axis] + last * part(step)[axis] < 0.0;
    [0, 1, 2].map(|axis| [falls(|of| of.column, axis), falls(|of| of.row, axis)])
}

/// The way from one sampling point to the next, of the ray through a place in the frame.
fn step(camera: &Camera, lattice_from_eye: &DAffine3, px: DVec2, step_mm: f64) -> DVec3 {
    let along = match camera.lens {
        Lens::Orthographic { .. } => DVec3::Z,
        Lens::Perspective { .. } => camera.unproject(px, 1.0),
    };
    lattice_from_eye.matrix3 * (along * step_mm)
}

/// The rays of a vector.
pub struct PacketRays<S: Simd> {
    /// Where sampling point 0 is along each axis.
    pub origin: [S::Double; 3],
    /// How far the next one is from it.
    pub step: [S::Double; 3],
}

/// Stands for the inverse of no movement: with it a face is crossed before the first plane or behind the last.
const STILL: f64 = f64::MAX;

/// One over steps, or [`STILL`].
#[inline(always)]
pub fn inverse<S: Simd>(step: S::Double) -> S::Double {
    let zero = S::double(0.0);
    let moves = S::greater_double(step, zero) | S::greater_double(zero, step);
    S::choose_double(moves, S::inverse(step), S::double(STILL))
}

/// The planes at which rays enter and leave a box, at least 0; a ray is not in the box if the first is not below the second.
#[derive(Clone, Copy)]
pub struct Intervals<S: Simd> {
    /// The first covered sampling point of each ray.
    pub begin: S::Int,
    /// The first one behind the covered ones.
    pub end: S::Int,
}

impl<S: Simd> Intervals<S> {
    /// Of rays that meet nothing.
    #[inline(always)]
    pub fn none() -> Self {
        Self {
            begin: S::int(0),
            end: S::int(0),
        }
    }
}

impl<S: Simd> PacketRays<S> {
    /// The rays of the vector whose first pixel is `first`; of pixels beyond the frame too.
    #[inline(always)]
    pub fn new(rays: &Rays, first: [u32; 2]) -> Self {
        Self {
            origin: each!(axis of [0, 1, 2] => rays.origin.packet::<S>(axis, first)),
            step: each!(axis of [0, 1, 2] => rays.step.packet::<S>(axis, first)),
        }
    }

    /// The first plane, as a whole number, at or behind which rays are at or beyond coordinate `face` of an axis, whichever way
    /// they go; `inverse` is that of their steps.
    #[inline(always)]
    fn crossing(&self, axis: usize, inverse: S::Double, face: f64) -> S::Double {
        S::ceil_double((S::double(face) - self.origin[axis]) * inverse)
    }

    /// The covered sampling points of the box between `low` and `high`.
    #[inline(always)]
    pub fn intervals(&self, low: &[f64; 3], high: &[f64; 3]) -> Intervals<S> {
        let last = S::double((1 << 30) as f64);
        let (mut begin, mut end) = (S::double(0.0), last);
        for axis in 0..3 {
            let inverse = inverse::<S>(self.step[axis]);
            let rises = S::greater_double(inverse, S::double(0.0));
            let [a, b] = each!(corner of [low, high] => self.crossing(axis, inverse, corner[axis]));
            let (first, leaves) = (S::choose_double(rises, a, b), S::choose_double(rises, b, a));
            begin = S::choose_double(S::greater_double(first, begin), first, begin);
            end = S::choose_double(S::greater_double(end, leaves), leaves, end);
        }
        begin = S::choose_double(S::greater_double(begin, last), last, begin);
        end = S::choose_double(S::greater_double(end, S::double(0.0)), end, S::double(0.0));
        Intervals {
            begin: S::whole_double(begin),
            end: S::whole_double(end),
        }
    }
}
