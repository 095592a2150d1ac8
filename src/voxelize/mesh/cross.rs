//! Whether triangles pass through each other.
//!
//! *Theory.* Two flat convex things have no point of their interiors in common if some axis separates them: a normal, a
//! direction across a side in its plane, or one across a side of each (the separating axis theorem). Neighbours that share
//! a corner or a side are separated by an axis on which they touch, and folded ones by none.

use glam::DVec3;
use rayon::prelude::*;

use super::TriangleSolid;
use super::error::MeshError;
use crate::math::Aabb;

/// # Errors
/// If two triangles of the solid cross; which is found does not depend on the threads.
pub fn check(solid: &TriangleSolid) -> Result<(), MeshError> {
    let found = (0..solid.faces.len())
        .into_par_iter()
        .find_map_first(|n| crossing_of(solid, n));
    found.map_or(Ok(()), |at| Err(MeshError::Crosses { at }))
}

/// Where triangle `n` crosses one behind it.
fn crossing_of(solid: &TriangleSolid, n: usize) -> Option<DVec3> {
    let (own, mut found) = (solid.faces[n], None);
    let bounds = own.bounds();
    let meets = |other: &Aabb| !other.intersect(&bounds).is_empty();
    solid.hierarchy.visit(meets, |m| {
        let other = solid.faces[m];
        let shared = bounds.intersect(&other.bounds());
        if m > n && found.is_none() && !shared.is_empty() && cross(own.corners, other.corners) {
            found = Some(shared.center());
        }
    });
    found
}

/// Whether the interiors of two triangles with areas have a point in common.
fn cross(first: [DVec3; 3], second: [DVec3; 3]) -> bool {
    let origin = first[0];
    let [first, second] = [first, second].map(|corners| corners.map(|corner| corner - origin));
    let corners = first.iter().chain(&second);
    let size = corners.map(|corner| corner.abs().max_element()).fold(0.0, f64::max);
    let [sides, other_sides] = [first, second].map(|[a, b, c]| [b - a, c - b, a - c]);
    let [normal, other_normal] = [sides, other_sides].map(|[ab, bc, _]| ab.cross(bc).normalize_or_zero());
    let in_planes = sides
        .map(|side| side.cross(normal))
        .into_iter()
        .chain(other_sides.map(|side| side.cross(other_normal)));
    let across_both = sides
        .into_iter()
        .flat_map(|side| other_sides.map(|other| side.cross(other)));
    let mut axes = [normal, other_normal].into_iter().chain(in_planes).chain(across_both);
    !axes.any(|axis| separates(axis.normalize_or_zero(), first, second, size))
}

/// Whether the shadows of the triangles on an axis touch at most. Where both are points that tells nothing.
fn separates(axis: DVec3, first: [DVec3; 3], second: [DVec3; 3], size: f64) -> bool {
    // Three products and two sums of lengths of at most `size` each.
    let rounding = 8.0 * f64::EPSILON * size;
    let [(lo, hi), (other_lo, other_hi)] = [first, second].map(|corners| {
        let [a, b, c] = corners.map(|corner| corner.dot(axis));
        (a.min(b).min(c), a.max(b).max(c))
    });
    let touch = hi <= other_lo + rounding || other_hi <= lo + rounding;
    touch && hi.max(other_hi) - lo.min(other_lo) > 4.0 * rounding
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(x, y, z)
    }

    fn both(first: [DVec3; 3], second: [DVec3; 3]) -> bool {
        let crosses = cross(first, second);
        assert_eq!(crosses, cross(second, first));
        crosses
    }

    #[test]
    fn crossing_triangles_are_told_from_those_that_touch() {
        let flat = [at(0.0, 0.0, 0.0), at(4.0, 0.0, 0.0), at(0.0, 4.0, 0.0)];
        let upright = |z: f64| [at(1.0, 1.0, z), at(1.5, 1.0, z + 2.0), at(1.0, 1.5, z + 2.0)];
        assert!(both(flat, upright(-1.0)));
        assert!(!both(flat, upright(0.0)), "a corner on a face");
        assert!(!both(flat, upright(0.1)));
        let beside = |x: f64| flat.map(|p| p + at(x, 0.0, 0.0));
        assert!(both(flat, beside(1.0)), "in one plane");
        assert!(both(flat, flat));
        assert!(!both(flat, beside(4.0)), "corner to corner");
        assert!(!both(flat, [at(4.0, 0.0, 0.0), at(4.0, 4.0, 0.0), at(0.0, 4.0, 0.0)]));
    }

    #[test]
    fn neighbours_cross_only_if_folded() {
        let flat = [at(0.0, 0.0, 0.0), at(4.0, 0.0, 0.0), at(1.0, 4.0, 0.0)];
        let over = |apex: DVec3| [flat[1], flat[0], apex];
        assert!(!both(flat, over(at(2.0, -3.0, 0.0))));
        assert!(!both(flat, over(at(2.0, 3.0, 1e-6))));
        assert!(both(flat, over(at(2.0, 3.0, 0.0))));
        let at_corner = |p: DVec3, q: DVec3| [flat[0], p, q];
        assert!(!both(flat, at_corner(at(-1.0, 2.0, 1.0), at(-1.0, 2.0, -1.0))));
        assert!(both(flat, at_corner(at(2.0, 1.0, 1.0), at(2.0, 1.0, -1.0))));
    }
}
