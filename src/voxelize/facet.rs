//! What a plane polygon takes from the density: the exact feature densities of faces, edges and vertices.
//!
//! *Theory.* A solid bounded by plane faces is, seen from a point, a signed sum of cones over its faces. Its density is 1 or 0,
//! as the point lies inside or outside, less for each face what the face cuts off the filter's ball. That is a sum over the
//! face's sides, each of two right-angled pieces: from the point to the face (distance a), on to the side's line (b), along the
//! side to its end (c).
//! *Changes from the paper.* WK94 tabulates faces, edges and vertices by distance and angle. Here a dihedral or corner angle
//! needs no table of its own: it shows in a, b and c, and the three have one closed form.
//! *Practice.* Lengths are in units of the filter's radius.

use std::f64::consts::PI;

use glam::DVec3;

use super::filter;

/// What the part of a plane at distance `a` in (0, 1) leaves uncut that lies beyond a line of it: `b > 0` away from the foot
/// of the point on the plane, from the foot on the line to `c > 0` along it.
fn beyond_side(a: f64, b: f64, c: f64) -> f64 {
    let rim = 1.0 - a * a - b * b;
    if rim <= 0.0 {
        return 0.0;
    }
    // Beyond the ball nothing is added.
    let c = c.min(rim.sqrt());
    let rho = (a * a + b * b + c * c).sqrt();
    let angle = c.atan2(b);
    // asinh(c / √(a² + b²)), of which nothing cancels.
    let log = 0.5 * ((c + rho) * (c + rho) / (a * a + b * b)).ln();
    let a4 = (a * a) * (a * a);
    let steep = (1.0 - a4) * (a * c).atan2(b * rho);
    let rest = 2.0 * b * c - 0.5 * b * ((b * b + 3.0 * a * a) * log + c * rho) - 2.0 * (1.0 - a * a) * angle;
    (steep + a * rest) / (4.0 * PI)
}

/// [`beyond_side`] for the stretch of a line between two places on it.
fn beyond_stretch(a: f64, b: f64, [from, to]: [f64; 2]) -> f64 {
    let reach = (1.0 - a * a - b * b).max(0.0).sqrt();
    if from <= -reach && to >= reach {
        return 2.0 * beyond_side(a, b, reach);
    }
    let up_to = |c: f64| {
        if c == 0.0 {
            0.0
        } else {
            beyond_side(a, b, c.abs()).copysign(c)
        }
    };
    up_to(to) - up_to(from)
}

/// What the half of a plane at distance `a` cuts off the ball that ends at a line `b` from the foot, above 0 where the foot
/// lies in it.
pub fn half_plane(a: f64, b: f64) -> f64 {
    let a = a.abs().max(LEAST);
    if a >= 1.0 {
        return 0.0;
    }
    let lost = 2.0 * beyond_side(a, b.abs(), 1.0);
    if b >= 0.0 { filter::half_space(a) - lost } else { lost }
}

/// A side of a face, seen from the foot of the sample on the face's plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// How far out its line runs; above 0 where the foot lies on the face's side of it.
    pub out: f64,
    /// Where on the line it begins and ends, counted from the point nearest to the foot, counter-clockwise about the face.
    pub along: [f64; 2],
}

/// What a face in a plane at distance `a` cuts off the ball, by its sides: a convex polygon. Always at least 0.
pub fn face(a: f64, sides: impl IntoIterator<Item = Side>) -> f64 {
    let a = a.abs().max(LEAST);
    if a >= 1.0 {
        return 0.0;
    }
    let rim = (1.0 - a * a).sqrt();
    let mut holds_foot = true;
    let mut lost = 0.0;
    for side in sides {
        holds_foot &= side.out >= 0.0;
        let out = side.out.abs();
        if out < rim {
            lost += side.out.signum() * beyond_stretch(a, out, side.along);
        }
    }
    let whole = if holds_foot { filter::half_space(a) } else { 0.0 };
    (whole - lost).max(0.0)
}

/// What a face cuts off the ball about the origin: a convex polygon at distance `a` whose corners run counter-clockwise seen
/// from the tip of `normal`. Always at least 0.
pub fn polygon(corners: &[DVec3], normal: DVec3, a: f64) -> f64 {
    let foot = normal * a;
    let sides = corners.iter().enumerate().filter_map(|(n, &from)| {
        let to = corners[(n + 1) % corners.len()];
        let along = (to - from).try_normalize()?;
        Some(Side {
            out: (from - foot).dot(along.cross(normal)),
            along: [from, to].map(|end| (end - foot).dot(along)),
        })
    });
    face(a, sides)
}

/// The density of a wedge, what lies behind two planes at the signed distances `first` and `second` whose outward normals
/// have the dot product `cosine`; above 0 is outside.
pub fn wedge(first: f64, second: f64, cosine: f64) -> f64 {
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    if sine < 1e-6 {
        return filter::half_space(first.max(second));
    }
    let cut = |own: f64, other: f64| {
        let inside = (own * cosine - other) / sine;
        let cut = half_plane(own, inside);
        if own <= 0.0 { cut } else { -cut }
    };
    let inside = f64::from(u8::from(first.max(second) <= 0.0));
    (inside - cut(first, second) - cut(second, first)).clamp(0.0, 1.0)
}

/// How near, in radii, a sample is on the surface.
pub const ON_SURFACE: f64 = 1e-5;

/// A direction that no face of a made thing is parallel to.
const ASIDE: DVec3 = DVec3::new(0.535_210_8, -0.341_877_3, 0.772_440_1);

/// The density at `p`, at `distance` from the surface of a solid with plane faces, by `density`, which is not to be asked on that
/// surface: there it has as many limits as sides meet. In their place is the mean of two points beside it.
///
/// A plane counts as no nearer than 1e-9, which as far from a side as the two are is felt by 1e-4 / 2π at most, and only in a
/// face's own plane. The mean is off by at most half of the density's second derivative, at most 3, times the square of the way.
pub fn through_surface(p: DVec3, distance: f64, radius: f64, density: impl Fn(DVec3) -> f64) -> f64 {
    let aside = ON_SURFACE * radius;
    if distance.abs() >= aside {
        return density(p);
    }
    0.5 * (density(p + ASIDE * aside) + density(p - ASIDE * aside))
}

/// Nearer planes count as this near: the forms have a limit at 0 which rounding spoils.
const LEAST: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quadrature::GaussLegendre;

    /// The density of `inside` about the origin, by a product rule over directions and distances.
    fn numeric(inside: impl Fn(DVec3) -> bool) -> f64 {
        let (rings, spokes, shells) = (GaussLegendre::<64>::new(), 128, GaussLegendre::<64>::new());
        let mut sum = 0.0;
        for (z, w) in rings.over(-1.0, 1.0) {
            for n in 0..spokes {
                let (sin, cos) = (2.0 * PI * (f64::from(n) + 0.5) / f64::from(spokes)).sin_cos();
                let ring = (1.0 - z * z).sqrt();
                let towards = DVec3::new(ring * cos, ring * sin, z);
                let ray = shells.integrate(0.0, 1.0, |r| {
                    r * r * filter::weight(r) * f64::from(u8::from(inside(towards * r)))
                });
                sum += w * 2.0 * PI / f64::from(spokes) * ray;
            }
        }
        sum
    }

    #[test]
    fn wedges_of_all_angles() {
        for (first, second, cosine) in [(-0.2, -0.3, 0.0), (0.2, -0.5, 0.5), (-0.1, 0.15, -0.7), (0.3, 0.2, 0.2)] {
            let sine = f64::sqrt(1.0 - cosine * cosine);
            let [n1, n2] = [DVec3::X, DVec3::new(cosine, sine, 0.0)];
            let truth = numeric(|p| n1.dot(p) + first <= 0.0 && n2.dot(p) + second <= 0.0);
            let exact = wedge(first, second, cosine);
            assert!(
                (exact - truth).abs() < 2e-3,
                "{first} {second} {cosine}: {exact} is not {truth}"
            );
        }
    }

    #[test]
    fn a_wedge_of_one_plane_is_a_half_space() {
        for u in [-0.8, -0.2, 0.0, 0.4] {
            // Planes nearer than LEAST count as that near, and densities fall by at most 1 a radius.
            assert!((wedge(u, -2.0, 0.3) - filter::half_space(u)).abs() <= 2.0 * LEAST);
            assert!((wedge(u, u, 1.0) - filter::half_space(u)).abs() <= 2.0 * LEAST);
            assert!((half_plane(u, 0.0) - 0.5 * filter::half_space(u.abs())).abs() <= 2.0 * LEAST);
        }
    }

    #[test]
    fn a_polygon_is_the_sum_of_its_parts() {
        let at = |x: f64, y: f64| DVec3::new(x, y, 0.4);
        let square = [at(-0.3, -0.5), at(0.6, -0.5), at(0.6, 0.2), at(-0.3, 0.2)];
        let halves = [[square[0], square[1], square[2]], [square[0], square[2], square[3]]];
        let sum: f64 = halves.iter().map(|half| polygon(half, DVec3::Z, 0.4)).sum();
        assert!((polygon(&square, DVec3::Z, 0.4) - sum).abs() < 1e-12);
        let aside = square.map(|p| p + DVec3::X * 0.5);
        assert!(polygon(&aside, DVec3::Z, 0.4) > 0.0);
        let far = square.map(|p| p + DVec3::X * 2.0);
        assert_eq!(polygon(&far, DVec3::Z, 0.4), 0.0);
    }
}
