//! Where in the lattice a device may sample for the centre of a pixel, and how often it may draw there.
//!
//! *Theory.* A slice polygon is planar and everything on it is interpolated linearly on the screen. If each vertex is moved by
//! at most δ, the value interpolated at a pixel is the exact one of a point at most δ away, since interpolation weights are
//! not negative and sum to 1; and a pixel more than δ within the polygon is drawn, one more than δ outside is not.
//! *Practice.* δ is the rasteriser's grid and what single precision does to a vertex; both become a box of the lattice, to which
//! the errors of texture coordinates and filter weights are added. A triangle thinner than δ may have no area on that grid, and
//! then nothing says what is interpolated on it: SwiftShader takes all of it from one corner. So at the rim of a
//! polygon, where it is on a triangle with so short an edge, anything on the polygon may be sampled.

use glam::{DAffine3, DVec3};

use super::bounds::DrawnBox;
use super::precision::{Precision, ULP};
use crate::math::{Aabb, affine};
use crate::projection::{FrameSpec, Lens};

/// The uncertainty of samples of one frame.
pub(super) struct Places {
    eye_from_lattice: DAffine3,
    lattice_from_eye: DAffine3,
    lattice: Aabb,
    eye_bounds: Aabb,
    lens: Lens,
    /// Pixel at the eye's axis, x and y.
    frame_px: f64,
    precision: Precision,
    /// Error of a vertex across the line of sight, millimetres.
    vertex_mm: f64,
    /// Error of a texture coordinate and of the weights, texels.
    texel: f64,
    boxes: Vec<DrawnBox>,
}

/// One place that a device may sample.
pub(super) struct Place {
    /// All positions that texels may be weighted for, lattice coordinates.
    pub texels: Aabb,
    /// How often it is drawn at least and at most.
    pub times: [u32; 2],
}

impl Places {
    pub(super) fn new(spec: &FrameSpec, boxes: Vec<DrawnBox>, page_edge: f64, precision: &Precision) -> Self {
        let lattice = spec.target.lattice.bounds();
        let eye_from_lattice = crate::projection::eye_from_lattice(&spec.target.lattice, spec.camera);
        let [width, height] = spec.camera.size;
        Self {
            eye_from_lattice,
            lattice_from_eye: eye_from_lattice.inverse(),
            lattice,
            eye_bounds: lattice.transformed(&eye_from_lattice),
            lens: spec.camera.lens,
            frame_px: f64::from(width.max(height)),
            precision: *precision,
            vertex_mm: vertex_rounding_mm(&eye_from_lattice, &lattice),
            // Origin and edge of a box in its page, their product and their sum, for coordinates up to 1.
            texel: page_edge * (precision.interpolated + precision.coordinate + 4.0 * ULP) + precision.weight,
            boxes,
        }
    }

    /// The box of the lattice in eye space.
    pub(super) fn eye_bounds(&self) -> &Aabb {
        &self.eye_bounds
    }

    /// What a vertex's depth is off at most, millimetres: two factors of a moving vertex and its depth, in steps of the box's
    /// depth. (Rounding moves a vertex along its edge, where position and texture stay together; only depth is off.)
    pub(super) fn depth_mm(&self) -> f64 {
        6.0 * ULP * self.eye_bounds.size().z
    }

    /// What the place of a vertex is off at most at `depth`, pixels.
    pub(super) fn vertex_px(&self, depth: f64) -> f64 {
        let pixels_per_mm = self.pixels_per_mm(depth);
        let farthest_px = self.frame_px + pixels_per_mm * self.sideways_mm();
        let divided = match self.lens {
            Lens::Orthographic { .. } => 1.0,
            Lens::Perspective { .. } => 1.0 + self.eye_bounds.max.z.abs() / depth,
        };
        // The lens, the division and the viewport are eight operations on numbers of up to `farthest_px`.
        self.precision.vertex_px + pixels_per_mm * self.vertex_mm + 8.0 * ULP * farthest_px * divided
    }

    fn sideways_mm(&self) -> f64 {
        let reach = self.eye_bounds.min.abs().max(self.eye_bounds.max.abs());
        reach.x.max(reach.y)
    }

    fn pixels_per_mm(&self, depth: f64) -> f64 {
        match self.lens {
            Lens::Orthographic { pixels_per_mm } => pixels_per_mm,
            Lens::Perspective { focal_px, .. } => focal_px / depth,
        }
    }

    /// The place that the ray to `eye` (eye frame) meets at its depth, if anything may be drawn there.
    pub(super) fn at(&self, eye: DVec3) -> Option<Place> {
        let at = affine::point(&self.lattice_from_eye, eye);
        let drawn = self.drawn(eye);
        let reach = Aabb::new(at - drawn, at + drawn);
        if reach.intersect(&self.lattice).is_empty() {
            return None;
        }
        let times = self.times(&reach, drawn, eye.z);
        let mut sampled = reach;
        if times != [1, 1] {
            let near = self.boxes_at(eye.z).filter(|b| !b.intersect(&reach).is_empty());
            for sliver in near.filter_map(|b| self.sliver(b, eye)) {
                sampled = sampled.hull(&sliver);
            }
        }
        Some(Place {
            texels: sampled.expand(DVec3::splat(self.texel)),
            times,
        })
    }

    /// The boxes that are drawn at a depth.
    fn boxes_at(&self, depth_mm: f64) -> impl Iterator<Item = &Aabb> {
        let at_depth = move |b: &&DrawnBox| (b.depths_mm[0]..=b.depths_mm[1]).contains(&depth_mm);
        self.boxes.iter().filter(at_depth).map(|b| &b.bounds)
    }

    /// The polygon that `b` has at the depth of `eye`, if `eye` is on a triangle of it that the rasteriser's grid may make a
    /// line: one with so short an edge, seen from any other vertex.
    fn sliver(&self, b: &Aabb, eye: DVec3) -> Option<Aabb> {
        let near_mm = 2.0 * self.vertex_px(eye.z) / self.pixels_per_mm(eye.z);
        let vertices = self.polygon(b, eye.z);
        let is_short =
            |n: usize| (0..vertices.len()).any(|m| m != n && vertices[n].1.distance(vertices[m].1) < near_mm);
        let short: Vec<DVec3> = (0..vertices.len())
            .filter(|&n| is_short(n))
            .map(|n| vertices[n].1)
            .collect();
        let touched = short
            .iter()
            .any(|a| vertices.iter().any(|c| distance_to_segment(eye, *a, c.1) < near_mm));
        touched.then(|| Aabb::of_points(vertices.iter().map(|vertex| vertex.0)))
    }

    /// The vertices of the polygon in which the plane at `depth` cuts a box, in the lattice and in the eye frame, in no order.
    fn polygon(&self, b: &Aabb, depth: f64) -> Vec<(DVec3, DVec3)> {
        let corners = b.corners();
        let eyes = corners.map(|corner| affine::point(&self.eye_from_lattice, corner));
        let edges = (0..8usize).flat_map(|from| [1, 2, 4].map(|bit| (from, from | bit)));
        edges
            .filter(|&(from, to)| from != to && (eyes[from].z < depth) != (eyes[to].z < depth))
            .map(|(from, to)| {
                let t = (depth - eyes[from].z) / (eyes[to].z - eyes[from].z);
                (corners[from].lerp(corners[to], t), eyes[from].lerp(eyes[to], t))
            })
            .collect()
    }

    /// How far the drawn point may be from the exact one, along each axis of the lattice.
    fn drawn(&self, eye: DVec3) -> DVec3 {
        let m = &self.lattice_from_eye.matrix3;
        let sideways = self.vertex_px(eye.z) / self.pixels_per_mm(eye.z);
        let ray = match self.lens {
            Lens::Orthographic { .. } => DVec3::Z,
            Lens::Perspective { .. } => eye / eye.z,
        };
        sideways * (m.x_axis.abs() + m.y_axis.abs()) + self.depth_mm() * (*m * ray).abs()
    }

    /// A place that is not near a face is drawn once; whether what is there shows at all is for its values to say.
    fn times(&self, reach: &Aabb, drawn: DVec3, depth_mm: f64) -> [u32; 2] {
        let middle = reach.center() + 0.5;
        let near_face = (middle - middle.round()).abs().cmple(drawn).any();
        if !near_face {
            return [1, 1];
        }
        let inside = self.boxes_at(depth_mm).any(|b| b.intersect(reach) == *reach);
        if inside {
            return [1, 1];
        }
        let possible = self
            .boxes_at(depth_mm)
            .filter(|b| !b.intersect(reach).is_empty())
            .count() as u32;
        if possible == 0 && self.lattice.intersect(reach) == *reach {
            return [1, 1];
        }
        [0, possible.max(1)]
    }
}

fn distance_to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let t = (p - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
    p.distance(a + along * t.clamp(0.0, 1.0))
}

/// Rounding of a vertex's place across the line of sight in single precision, millimetres: its place in the lattice (two
/// operations on rounded numbers), and a sum of four products with rounded factors.
fn vertex_rounding_mm(eye_from_lattice: &DAffine3, lattice: &Aabb) -> f64 {
    let reach = lattice.min.abs().max(lattice.max.abs());
    let m = &eye_from_lattice.matrix3;
    let terms = |row: usize| m.row(row).abs().dot(reach) + eye_from_lattice.translation[row].abs();
    8.0 * ULP * terms(0).max(terms(1))
}
