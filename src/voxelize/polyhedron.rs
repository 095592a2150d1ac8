//! Convex solids with plane faces: boxes, prisms, and the hulls of points, in closed form.
//!
//! *Theory.* The density is 1 or 0 less what each face near the sample cuts off the filter's ball ([`facet`]).

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::facet::{self, Side};
use super::filter::{self, Support};
use crate::math::{Aabb, Plane, affine};

/// A convex polyhedron; shared, not copied.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyhedron {
    faces: Arc<[Face]>,
    bounds: Aabb,
}

/// A face and its corners, counter-clockwise seen from outside.
#[derive(Clone, Debug, PartialEq)]
struct Face {
    plane: Plane,
    corners: Vec<DVec3>,
    /// The side from each corner to the next: its direction, its outward normal in the plane, and its length.
    sides: Vec<(DVec3, DVec3, f64)>,
}

impl Face {
    /// The face with these corners, in order, turned so that `inside` lies behind it; `None` without area.
    fn behind(mut corners: Vec<DVec3>, inside: DVec3) -> Option<Self> {
        let area = corners.windows(2).fold(DVec3::ZERO, |sum, pair| {
            sum + (pair[0] - corners[0]).cross(pair[1] - corners[0])
        });
        let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let plane = Plane::through(middle, area)?;
        if plane.distance(inside) <= 0.0 {
            return Some(Self::new(plane, corners));
        }
        corners.reverse();
        Some(Self::new(Plane::through(middle, -area)?, corners))
    }

    fn new(plane: Plane, corners: Vec<DVec3>) -> Self {
        let side = |n: usize| {
            let span = corners[(n + 1) % corners.len()] - corners[n];
            let along = span.normalize_or_zero();
            (along, along.cross(plane.normal), span.length())
        };
        let sides = (0..corners.len()).map(side).collect();
        Self { plane, corners, sides }
    }

    /// What the face cuts off the filter's ball about `p`.
    fn cut(&self, p: DVec3, radius: f64) -> f64 {
        let scale = 1.0 / radius;
        let sides = self
            .corners
            .iter()
            .zip(&self.sides)
            .map(|(from, (along, outward, length))| {
                let from = *from - p;
                let start = from.dot(*along);
                Side {
                    out: from.dot(*outward) * scale,
                    along: [start * scale, (start + length) * scale],
                }
            });
        facet::face(self.plane.distance(p) * scale, sides)
    }
}

impl Polyhedron {
    /// The most points that a hull is made of.
    pub const MAX_POINTS: usize = 128;

    fn new(faces: Vec<Face>) -> Self {
        let bounds = Aabb::of_points(faces.iter().flat_map(|face| face.corners.iter().copied()));
        Self {
            faces: faces.into(),
            bounds,
        }
    }

    /// An axis-aligned box with an extent above 0 along each axis.
    pub fn cuboid(bounds: &Aabb) -> Self {
        let corners = bounds.corners();
        let faces = [
            [0, 1, 3, 2],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 3, 7, 6],
            [0, 2, 6, 4],
            [1, 3, 7, 5],
        ];
        let face = |loop_: [usize; 4]| Face::behind(loop_.map(|c| corners[c]).to_vec(), bounds.center());
        Self::new(faces.into_iter().filter_map(face).collect())
    }

    /// A regular prism along z about the origin: `sides` of at least 3, the distance `radius` from the axis to its edges, one of
    /// which lies over the x axis, and `height`.
    pub fn prism(sides: usize, radius: f64, height: f64) -> Self {
        let ring = |z: f64| -> Vec<DVec3> {
            let corner = |n: usize| DVec2::from_angle(n as f64 * std::f64::consts::TAU / sides as f64) * radius;
            (0..sides).map(|n| corner(n).extend(z)).collect()
        };
        let (bottom, top) = (ring(-0.5 * height), ring(0.5 * height));
        let side = |n: usize| {
            let next = (n + 1) % sides;
            vec![bottom[n], bottom[next], top[next], top[n]]
        };
        let outlines = (0..sides).map(side).chain([bottom.clone(), top.clone()]);
        Self::new(
            outlines
                .filter_map(|outline| Face::behind(outline, DVec3::ZERO))
                .collect(),
        )
    }

    /// The convex hull of at most [`Self::MAX_POINTS`] points; `None` if they are fewer than four, too many, or lie in a plane.
    pub fn hull(points: &[DVec3]) -> Option<Self> {
        if !(4..=Self::MAX_POINTS).contains(&points.len()) {
            return None;
        }
        let bounds = Aabb::of_points(points.iter().copied());
        let thickness = 1e-9 * bounds.size().max_element();
        let middle = points.iter().sum::<DVec3>() / points.len() as f64;
        let mut faces: Vec<Face> = Vec::new();
        for plane in supporting_planes(points, thickness) {
            let known = |face: &Face| {
                face.plane.normal.dot(plane.normal) > 1.0 - 1e-12
                    && face.plane.distance(plane.normal * -plane.offset).abs() <= thickness
            };
            if faces.iter().any(known) {
                continue;
            }
            let on: Vec<DVec3> = points
                .iter()
                .copied()
                .filter(|p| plane.distance(*p).abs() <= thickness)
                .collect();
            faces.extend(Face::behind(in_order(on, plane.normal), middle));
        }
        let solid = Self::new(faces);
        let deepest = solid
            .faces
            .iter()
            .map(|face| face.plane.distance(middle))
            .fold(f64::NEG_INFINITY, f64::max);
        (solid.faces.len() >= 4 && deepest < -thickness).then_some(solid)
    }

    /// The same solid moved by an invertible map.
    pub fn moved(&self, new_from_old: &DAffine3) -> Self {
        let inside = affine::point(new_from_old, self.middle());
        let moved = |face: &Face| {
            let corners = face.corners.iter().map(|c| affine::point(new_from_old, *c)).collect();
            Face::behind(corners, inside)
        };
        Self::new(self.faces.iter().filter_map(moved).collect())
    }

    /// What is left when each face moves inwards by `by`, above 0; `None` if that is nothing.
    pub fn inset(&self, by: f64) -> Option<Self> {
        let planes: Vec<Plane> = self
            .faces
            .iter()
            .map(|face| Plane {
                offset: face.plane.offset + by,
                ..face.plane
            })
            .collect();
        let tolerance = 1e-9 * self.bounds.size().max_element();
        let mut corners: Vec<DVec3> = Vec::new();
        for [a, b, c] in triples(planes.len()) {
            let corner = meet([&planes[a], &planes[b], &planes[c]]);
            let inside = |p: &DVec3| planes.iter().all(|plane| plane.distance(*p) <= tolerance);
            let fresh = |p: &DVec3| corners.iter().all(|known| known.distance(*p) > tolerance);
            corners.extend(corner.filter(inside).filter(fresh));
        }
        Self::hull(&corners)
    }

    /// A box that holds it.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The mean of the corners, a point inside.
    fn middle(&self) -> DVec3 {
        let corners = || self.faces.iter().flat_map(|face| &face.corners);
        corners().sum::<DVec3>() / corners().count().max(1) as f64
    }

    /// At most the distance to the surface, above 0 outside; within the solid it is that distance.
    pub fn distance(&self, p: DVec3) -> f64 {
        self.faces
            .iter()
            .map(|face| face.plane.distance(p))
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// [`Self::distance`] for many points at once.
    pub fn distances(&self, points: &[DVec3], distances: &mut [f64]) {
        distances.fill(f64::NEG_INFINITY);
        for face in self.faces.iter() {
            for (distance, p) in distances.iter_mut().zip(points) {
                *distance = distance.max(face.plane.distance(*p));
            }
        }
    }

    /// The density at `p`, where [`Self::distance`] is `distance` radii, of a filter whose support is a ball.
    pub fn density(&self, p: DVec3, distance: f64, support: &Support) -> f64 {
        let radius = support.reach;
        let meets = |face: &&Face| face.plane.distance(p) > -radius;
        if self.faces.iter().filter(meets).count() < 2 {
            // The ball meets no second plane, and so no side of the face that it meets.
            return filter::half_space(distance);
        }
        let on_surface = distance * radius;
        facet::through_surface(p, on_surface, radius, |p| self.density_beside(p, radius))
    }

    /// The density at a point that is not on the surface.
    fn density_beside(&self, p: DVec3, radius: f64) -> f64 {
        let mut density = f64::from(u8::from(self.distance(p) <= 0.0));
        for face in self.faces.iter().filter(|face| face.plane.distance(p) > -radius) {
            let cut = face.cut(p, radius);
            density -= if face.plane.distance(p) <= 0.0 { cut } else { -cut };
        }
        density.clamp(0.0, 1.0)
    }
}

/// The planes through three of the points that have all points behind or on them, with their normals outwards.
fn supporting_planes(points: &[DVec3], thickness: f64) -> Vec<Plane> {
    let mut found = Vec::new();
    for [a, b, c] in triples(points.len()) {
        let normal = (points[b] - points[a]).cross(points[c] - points[a]);
        for normal in [normal, -normal] {
            let plane = Plane::through(points[a], normal);
            found.extend(plane.filter(|plane| points.iter().all(|p| plane.distance(*p) <= thickness)));
        }
    }
    found
}

fn triples(n: usize) -> impl Iterator<Item = [usize; 3]> {
    (0..n).flat_map(move |a| (a + 1..n).flat_map(move |b| (b + 1..n).map(move |c| [a, b, c])))
}

/// The corners of a convex polygon, counter-clockwise about `normal`.
fn in_order(mut corners: Vec<DVec3>, normal: DVec3) -> Vec<DVec3> {
    let middle = corners.iter().sum::<DVec3>() / corners.len().max(1) as f64;
    let (u, v) = normal.any_orthonormal_pair();
    let angle = |p: &DVec3| (*p - middle).dot(v).atan2((*p - middle).dot(u));
    corners.sort_by(|p, q| angle(p).total_cmp(&angle(q)));
    corners
}

/// The point that three planes share.
fn meet(planes: [&Plane; 3]) -> Option<DVec3> {
    let normals = DMat3::from_cols(planes[0].normal, planes[1].normal, planes[2].normal).transpose();
    let offsets = DVec3::from_array(planes.map(|plane| -plane.offset));
    (normals.determinant().abs() > 1e-9).then(|| normals.inverse() * offsets)
}
