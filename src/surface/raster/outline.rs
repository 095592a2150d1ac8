//! A triangle as linear functions over the frame.

use std::ops::Range;

use glam::{DVec2, DVec3};

use crate::math::Aabb;
use crate::projection::{Camera, Lens};

/// What one rounding in double precision is off, relative to its result.
const U: f64 = 0.5 * f64::EPSILON;

/// The weights of a triangle's corners at each pixel, but for their sum.
pub(super) struct Outline {
    /// Of column and row off the frame's middle and 1, each weight is the sum.
    weights: [DVec3; 3],
    /// What is as good as 0 of each.
    off: [f64; 3],
    depths_mm: [f64; 3],
}

/// The point of a triangle that a pixel shows.
#[derive(Clone, Copy)]
pub(super) struct Point {
    /// The parts that the corners have in its place.
    pub weights: [f64; 3],
    /// Its depth.
    pub depth_mm: f64,
}

impl Outline {
    /// Of the triangle with these corners in the eye frame.
    pub fn new(camera: &Camera, corners: &[DVec3; 3]) -> Self {
        let farthest_px = DVec3::new(0.5 * f64::from(camera.size[0]), 0.5 * f64::from(camera.size[1]), 1.0);
        let placed = corners.map(|corner| homogeneous(camera, corner));
        let edges = [0, 1, 2].map(|n| {
            let from = placed[(n + 1) % 3];
            (from, placed[(n + 2) % 3] - from)
        });
        Self {
            weights: edges.map(|(from, along)| from.cross(along)),
            // Each part is a difference of two products with a difference (4 roundings of either product), and goes into a sum of
            // three products (4 more).
            off: edges.map(|(from, along)| 8.0 * U * farthest_px.dot(sizes(from.abs(), along.abs()))),
            depths_mm: corners.map(|corner| corner.z),
        }
    }

    /// What is seen at a place so far off the frame's middle, pixels.
    #[inline]
    pub fn at(&self, off_middle: DVec2) -> Option<Point> {
        let at = off_middle.extend(1.0);
        let [a, b, c] = self.weights.map(|weight| weight.dot(at));
        let side = a + b + c;
        if side.abs() <= self.off[0] + self.off[1] + self.off[2] {
            return None;
        }
        let turned = [a, b, c].map(|weight| weight * side.signum());
        let outside = (0..3).any(|n| turned[n] < -self.off[n]);
        if outside {
            return None;
        }
        let inside = turned.map(|weight| weight.max(0.0));
        let all = inside[0] + inside[1] + inside[2];
        let weights = inside.map(|weight| weight / all);
        let depth_mm = (0..3).map(|n| weights[n] * self.depths_mm[n]).sum();
        Some(Point { weights, depth_mm })
    }
}

/// A point of the eye frame in homogeneous coordinates of the camera's frame: pixels off its middle, times w; and w.
fn homogeneous(camera: &Camera, eye: DVec3) -> DVec3 {
    match camera.lens {
        Lens::Orthographic { pixels_per_mm } => (pixels_per_mm * eye.truncate()).extend(1.0),
        Lens::Perspective { focal_px, .. } => (focal_px * eye.truncate()).extend(eye.z),
    }
}

/// The sizes of the terms of a cross product.
fn sizes(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::new(a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x)
}

/// The columns and rows of the frame whose pixels may show the triangle with these corners (eye frame), if any do.
pub(super) fn reach(camera: &Camera, corners: &[DVec3; 3]) -> Option<[Range<u16>; 2]> {
    let near_mm = camera.near_mm();
    let seen = behind(corners, near_mm);
    let nearest_mm = seen.clone().map(|p| p.z).fold(f64::INFINITY, f64::min);
    let bounds = Aabb::of_points(seen.map(|p| camera.project(p).extend(0.0)));
    let sideways = corners
        .iter()
        .map(|p| p.truncate().abs().max_element())
        .fold(0.0, f64::max);
    let frame = f64::from(camera.size[0].max(camera.size[1]));
    // Where an edge is cut, and its place in the frame: fewer than 32 roundings of numbers of these sizes.
    let off = 32.0 * U * (sideways * camera.pixels_per_mm(nearest_mm) + frame);
    let ranges = [0, 1].map(|axis| {
        let size = f64::from(camera.size[axis]);
        let first = (bounds.min[axis] - 0.5 - off).ceil().clamp(0.0, size);
        let end = (bounds.max[axis] - 0.5 + off).floor() + 1.0;
        first as u16..end.clamp(0.0, size) as u16
    });
    ranges.iter().all(|range| !range.is_empty()).then_some(ranges)
}

/// The corners of the part of a triangle that is not before a depth.
fn behind(corners: &[DVec3; 3], near_mm: f64) -> impl Iterator<Item = DVec3> + Clone {
    let edges = [0, 1, 2].map(|n| (corners[n], corners[(n + 1) % 3]));
    edges.into_iter().flat_map(move |(a, b)| {
        let crosses = (a.z < near_mm) != (b.z < near_mm);
        let cut = crosses.then(|| a.lerp(b, (near_mm - a.z) / (b.z - a.z)).with_z(near_mm));
        [(a.z >= near_mm).then_some(a), cut].into_iter().flatten()
    })
}
