//! Rays in lattice coordinates, and where they cross the faces of boxes.
//!
//! *Practice.* The sampling points of a ray are equally far apart, with parallel rays and from an eye: point `k` is at
//! `origin + k·step`, `k` counted from the first plane of the frame. Whether a point is before or behind a face is decided by
//! [`TileRays::crossing`] alone, from the ray and the face's coordinate, so boxes that share a face agree on it.

use glam::{DAffine3, DVec3};

use crate::math::affine;
use crate::projection::{Camera, FrameSpec, Lens, Planes, ProjectError, eye_from_lattice};

/// Pixels along a tile's edge.
pub const TILE: usize = 16;

/// Pixels of a tile.
pub const TILE_PIXELS: usize = TILE * TILE;

/// The most planes that rays are sampled at: plane numbers are exact in single precision.
const MOST_PLANES: i64 = 1 << 24;

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

/// The rays of a frame.
pub struct Rays<'a> {
    camera: &'a Camera,
    lattice_from_eye: DAffine3,
    /// Depth of the first plane that may meet the target, and distance between planes, millimetres.
    first_mm: f64,
    step_mm: f64,
    /// Planes from the first to the last.
    pub planes: i32,
}

impl<'a> Rays<'a> {
    /// The rays of the frame of `spec` in `depths`.
    ///
    /// # Errors
    /// If there are too many planes.
    pub fn new(spec: &FrameSpec<'a>, depths: &Depths) -> Result<Self, ProjectError> {
        let [near_mm, far_mm] = depths.within_mm;
        let range = depths.planes.between(near_mm.max(spec.camera.near_mm()), far_mm);
        let planes = range.end.saturating_sub(range.start).max(0);
        if planes > MOST_PLANES {
            let (samples_per_voxel, limit) = (spec.settings.samples_per_voxel, MOST_PLANES);
            return Err(ProjectError::Planes {
                samples_per_voxel,
                limit,
            });
        }
        Ok(Self {
            camera: spec.camera,
            lattice_from_eye: eye_from_lattice(&spec.target.lattice, spec.camera).inverse(),
            first_mm: depths.planes.depth(range.start),
            step_mm: depths.planes.step_mm,
            planes: planes as i32,
        })
    }

    /// Depth of plane `k`, millimetres: `first + k·step`.
    pub fn depth_mm(&self) -> [f64; 2] {
        [self.first_mm, self.step_mm]
    }

    /// The first sampling point of a pixel's ray, and the way from one to the next.
    fn ray(&self, x: u32, y: u32) -> [DVec3; 2] {
        let begin = self.camera.point_at_depth(x, y, self.first_mm);
        let along = match self.camera.lens {
            Lens::Orthographic { .. } => DVec3::Z,
            Lens::Perspective { .. } => self.camera.point_at_depth(x, y, 1.0),
        };
        let step = self.lattice_from_eye.matrix3 * (along * self.step_mm);
        [affine::point(&self.lattice_from_eye, begin), step]
    }
}

/// The rays of a tile's pixels, row by row; of pixels beyond the frame too.
pub struct TileRays {
    origin: [[f64; TILE_PIXELS]; 3],
    step: [[f64; TILE_PIXELS]; 3],
    inverse: [[f64; TILE_PIXELS]; 3],
}

/// Stands for the inverse of no movement: with it a face is crossed before the first plane or behind the last.
const STILL: f64 = f64::MAX;

impl TileRays {
    /// The rays of the tile whose first pixel is `first`.
    pub fn new(rays: &Rays, first: [u32; 2]) -> Self {
        let mut tile = Self {
            origin: [[0.0; TILE_PIXELS]; 3],
            step: [[0.0; TILE_PIXELS]; 3],
            inverse: [[0.0; TILE_PIXELS]; 3],
        };
        for n in 0..TILE_PIXELS {
            let [origin, step] = rays.ray(first[0] + (n % TILE) as u32, first[1] + (n / TILE) as u32);
            for axis in 0..3 {
                tile.origin[axis][n] = origin[axis];
                tile.step[axis][n] = step[axis];
                tile.inverse[axis][n] = if step[axis] == 0.0 { STILL } else { step[axis].recip() };
            }
        }
        tile
    }

    /// Where sampling point 0 of a pixel is along an axis, and how far the next one is from it.
    #[inline(always)]
    pub fn axis(&self, axis: usize, pixel: usize) -> [f64; 2] {
        [self.origin[axis][pixel], self.step[axis][pixel]]
    }

    /// The first plane, as a whole number, at or behind which a ray is at or beyond coordinate `face` of an axis, whichever way
    /// it goes.
    #[inline(always)]
    fn crossing(&self, axis: usize, pixel: usize, face: f64) -> f64 {
        ((face - self.origin[axis][pixel]) * self.inverse[axis][pixel]).ceil()
    }

    /// The planes at which a pixel's ray enters and leaves the box between `low` and `high`, at least 0; it is not in the box if
    /// the first is not below the second.
    #[inline(always)]
    pub fn interval(&self, pixel: usize, low: &[f64; 3], high: &[f64; 3]) -> [f64; 2] {
        let (mut enter, mut leave) = (0.0, f64::from(i32::MAX));
        for axis in 0..3 {
            let [a, b] = [low, high].map(|corner| self.crossing(axis, pixel, corner[axis]));
            let rises = self.inverse[axis][pixel] > 0.0;
            let (first, last) = if rises { (a, b) } else { (b, a) };
            enter = if first > enter { first } else { enter };
            leave = if last < leave { last } else { leave };
        }
        [enter, leave]
    }
}
