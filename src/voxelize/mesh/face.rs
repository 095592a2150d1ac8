//! One triangle: how far it is, what it cuts off a filter, and whether a ray crosses it.
//!
//! *Practice.* Rays run in one oblique direction that faces and edges of made things do not. Seen along it, an edge of two
//! triangles decides for both alike on which side of it a ray passes, however it rounds: no ray slips between the two.

use glam::{DVec2, DVec3};

use crate::math::{Aabb, Plane};
use crate::voxelize::facet;

/// How far a ray moves along x and y while it moves by 1 along z, both above 0.
const SLANT: DVec2 = DVec2::new(0.371_834_652_9, 0.220_659_128_7);

/// A triangle with an area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Counter-clockwise seen from outside.
    pub corners: [DVec3; 3],
    /// With its normal outwards.
    pub plane: Plane,
}

impl Face {
    /// `None` for a triangle without area: rounding may make up 4 ε of the product of two sides.
    pub fn new(corners: [DVec3; 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let double_area = (b - a).cross(c - a);
        let rounding = 4.0 * f64::EPSILON * (b - a).length() * (c - a).length();
        let plane = Plane::through(a, double_area)?;
        (double_area.length() > rounding).then_some(Self { corners, plane })
    }

    /// A box that holds it.
    pub fn bounds(&self) -> Aabb {
        Aabb::of_points(self.corners)
    }

    /// The middle of its corners.
    pub fn middle(&self) -> DVec3 {
        self.corners.iter().sum::<DVec3>() / 3.0
    }

    /// The square of the distance from `p`.
    pub fn distance_squared(&self, p: DVec3) -> f64 {
        let [a, b, c] = self.corners;
        let normal = self.plane.normal;
        let is_above = |from: DVec3, to: DVec3| (to - from).cross(p - from).dot(normal) >= 0.0;
        if is_above(a, b) && is_above(b, c) && is_above(c, a) {
            return self.plane.distance(p).powi(2);
        }
        let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| to_segment(p, from, to));
        sides.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// What it takes from the density at `p` of a ball of `radius`; below 0 where `p` is outside of its plane.
    pub fn cut(&self, p: DVec3, radius: f64) -> f64 {
        let a = self.plane.distance(p) / radius;
        if a.abs() >= 1.0 {
            return 0.0;
        }
        let corners = self.corners.map(|corner| (corner - p) / radius);
        let cut = facet::polygon(&corners, self.plane.normal, -a);
        if a <= 0.0 { cut } else { -cut }
    }

    /// Whether the line along the ray through `p` crosses it: 1 if it leaves the solid here, -1 if it enters it, or 0.
    pub fn crossing(&self, p: DVec3) -> i32 {
        let [a, b, c] = self.corners.map(|corner| seen_from(p, corner));
        passes(a, b) + passes(b, c) + passes(c, a)
    }

    /// [`Self::crossing`] of the ray alone, which begins at `p`.
    pub fn crossing_ahead(&self, p: DVec3) -> i32 {
        let crossing = self.crossing(p);
        let is_behind_plane = self.plane.distance(p) <= 0.0;
        if is_behind_plane == (crossing > 0) { crossing } else { 0 }
    }
}

fn to_segment(p: DVec3, from: DVec3, to: DVec3) -> f64 {
    let along = to - from;
    let t = ((p - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    (from + along * t).distance_squared(p)
}

/// Where `corner` is beside the ray through `p`.
fn seen_from(p: DVec3, corner: DVec3) -> DVec2 {
    let offset = corner - p;
    offset.truncate() - SLANT * offset.z
}

/// How a side passes the half-line from the origin along x: 1 upwards, -1 downwards, or 0. A side and its opposite add to 0.
fn passes(from: DVec2, to: DVec2) -> i32 {
    let (way, lower, upper) = match (from.y <= 0.0, to.y <= 0.0) {
        (true, false) => (1, from, to),
        (false, true) => (-1, to, from),
        _ => return 0,
    };
    if lower.perp_dot(upper) > 0.0 { way } else { 0 }
}

/// Whether the ray from `p` meets a box that is wide enough for what rounds here.
pub fn ray_meets(p: DVec3, bounds: &Aabb) -> bool {
    let (to, beyond) = ((bounds.min.z - p.z).max(0.0), bounds.max.z - p.z);
    if beyond < 0.0 {
        return false;
    }
    let (near, far) = (p.truncate() + SLANT * to, p.truncate() + SLANT * beyond);
    near.cmple(bounds.max.truncate()).all() && far.cmpge(bounds.min.truncate()).all()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [DVec3; 3] = [DVec3::ZERO, DVec3::new(4.0, 0.0, 0.0), DVec3::new(0.0, 3.0, 0.0)];

    #[test]
    fn the_nearest_point_may_be_a_face_a_side_or_a_corner() {
        let face = Face::new(CORNERS).expect("a triangle");
        let squared = |x, y, z| face.distance_squared(DVec3::new(x, y, z));
        assert_eq!(squared(1.0, 1.0, -2.0), 4.0);
        assert_eq!(squared(2.0, -3.0, 4.0), 25.0);
        assert_eq!(squared(7.0, -4.0, 0.0), 25.0);
        assert!((squared(5.0, 5.5, 0.0) - 25.0).abs() < 1e-13);
    }

    #[test]
    fn a_line_is_no_face() {
        let x = DVec3::new(0.1, 0.2, 0.3);
        assert_eq!(Face::new([DVec3::ZERO, x, x * 3.0]), None);
        assert_eq!(Face::new([x; 3]), None);
    }

    #[test]
    fn a_ray_leaves_upwards_and_enters_downwards() {
        let face = Face::new(CORNERS).expect("a triangle");
        let [a, b, c] = CORNERS;
        let turned = Face::new([a, c, b]).expect("a triangle");
        let below = DVec3::new(0.5, 0.5, -1.0);
        assert_eq!([face.crossing_ahead(below), turned.crossing_ahead(below)], [1, -1]);
        let above = DVec3::new(1.0, 1.0, 1.0);
        assert_eq!([face.crossing_ahead(above), turned.crossing_ahead(above)], [0, 0]);
        assert_eq!(face.crossing_ahead(DVec3::new(-1.0, 0.5, -1.0)), 0);
    }
}
