//! The density near a smooth curved surface, from a table.
//!
//! *Theory.* Away from edges the filter's ball sees a surface by its distance and its two principal curvatures (WK94's tables
//! for the sides of cylinders, cones and tori, indexed by size).
//! *Changes from the paper.* One table serves all shapes: what is kept is how far the density is from that of the tangent
//! plane, by distance and both curvatures, and interpolated linearly in all three. It is the exact integral for a surface whose
//! sections are circles: spheres, cylinders, and tori on their equators; others differ from it in the third order of size.
//! *Practice.* Lengths are in units of the filter's radius. Curvatures up to [`MAX_CURVATURE`] are covered, that is radii of at
//! least twice the filter's. The table has 49 · 9 · 9 entries and is filled once, when first asked. One thread does it:
//! one that waits for others may take up work that asks for the table.

use std::sync::LazyLock;

use super::filter;
use crate::math::quadrature::GaussLegendre;

/// The largest curvature of either sign that the table covers.
pub const MAX_CURVATURE: f64 = 0.5;

/// Entries along the distance, from -1 to 1.
const DISTANCES: usize = 49;

/// Entries along each curvature, from -[`MAX_CURVATURE`] to [`MAX_CURVATURE`].
const CURVATURES: usize = 9;

static TABLE: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let at = |n: usize, count: usize, end: f64| end * (2.0 * n as f64 / (count - 1) as f64 - 1.0);
    // By one thread: others that wait for the table must not be handed work that asks for it.
    (0..CURVATURES * CURVATURES * DISTANCES)
        .map(|n| {
            let distance = at(n % DISTANCES, DISTANCES, 1.0);
            let first = at(n / DISTANCES % CURVATURES, CURVATURES, MAX_CURVATURE);
            let second = at(n / (DISTANCES * CURVATURES), CURVATURES, MAX_CURVATURE);
            (integrate(distance, first, second) - filter::half_space(distance)) as f32
        })
        .collect()
});

/// The density at `distance` from a surface (above 0 outside) with these principal curvatures, above 0 where the solid
/// bulges. Curvatures beyond the table count as its last.
#[inline(always)] // A straight side's curvature of 0 is half of the work when it is known here.
pub fn density(distance: f64, curvatures: [f64; 2]) -> f64 {
    if distance >= 1.0 {
        return 0.0;
    }
    if distance <= -1.0 {
        return 1.0;
    }
    let (d, ft) = cell(distance, 1.0, DISTANCES);
    let (i, fi) = cell(curvatures[0], MAX_CURVATURE, CURVATURES);
    let (j, fj) = cell(curvatures[1], MAX_CURVATURE, CURVATURES);
    let along = |i: usize, j: usize| between(&TABLE[DISTANCES * (i + CURVATURES * j) + d..], ft);
    let mut ends = [along(i, j), along(i, j + 1)];
    // The sides of cylinders and cones are straight one way, which is a curvature of the table.
    if fi != 0.0 {
        let next = [along(i + 1, j), along(i + 1, j + 1)];
        ends = std::array::from_fn(|n| ends[n] * (1.0 - fi) + next[n] * fi);
    }
    let bent = ends[0] * (1.0 - fj) + ends[1] * fj;
    (filter::half_space(distance) + bent).clamp(0.0, 1.0)
}

/// The value `t` of the way from the first entry to the second.
#[inline(always)]
fn between(entries: &[f32], t: f64) -> f64 {
    f64::from(entries[0]) * (1.0 - t) + f64::from(entries[1]) * t
}

/// The entry at or below `x`, and how far it is on the way to the next.
#[inline]
fn cell(x: f64, end: f64, count: usize) -> (usize, f64) {
    let t = ((x + end) * ((count - 1) as f64 / (2.0 * end))).clamp(0.0, (count - 1) as f64);
    // To 32 bits the conversion is one instruction.
    let n = (t as i32 as usize).min(count - 2);
    (n, t - n as f64)
}

/// The density by integration over lines along the normal.
fn integrate(distance: f64, first: f64, second: f64) -> f64 {
    static RADII: LazyLock<GaussLegendre<12>> = LazyLock::new(GaussLegendre::new);
    static ANGLES: LazyLock<GaussLegendre<8>> = LazyLock::new(GaussLegendre::new);
    // The tighter bend is the one that is swept, so that swapping the curvatures changes nothing.
    let (tube, ring) = if first.abs() >= second.abs() {
        (first, second)
    } else {
        (second, first)
    };
    let mut sum = 0.0;
    for (q, wq) in RADII.over(0.0, 1.0) {
        for (angle, wa) in ANGLES.over(0.0, std::f64::consts::FRAC_PI_2) {
            let (sin, cos) = angle.sin_cos();
            let surface = -drop(tube, ring, q * cos, q * sin);
            sum += 4.0 * wq * wa * q * filter::chord(q, -1.0, surface - distance);
        }
    }
    sum
}

/// How far the surface has fallen away from its tangent plane, `along` the tube and `across` on the ring.
fn drop(tube: f64, ring: f64, across: f64, along: f64) -> f64 {
    let first = arc_drop(tube, across);
    first + arc_drop(ring / (1.0 - ring * first), along)
}

/// How far a circle of this curvature has fallen away from its tangent at distance `x`.
fn arc_drop(curvature: f64, x: f64) -> f64 {
    let turned = 1.0 - (curvature * x) * (curvature * x);
    curvature * x * x / (1.0 + turned.max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxelize::ball;

    /// Linear interpolation errs by at most an eighth of the squared step times the second derivative; of what is tabulated
    /// that is below 1.5 along the distance (at ±1/24) and below 0.6 along each curvature: 3.3e-4 and twice 1.2e-3 at the most
    /// extreme, where they are taken together.
    const TABLE_ERROR: f64 = 2.5e-3;

    #[test]
    fn balls_are_met() {
        for n in 0..400 {
            let (distance, curvature) = (f64::from(n % 40) / 20.0 - 0.99, 0.02 + 0.48 * f64::from(n / 40) / 10.0);
            let radius = 1.0 / curvature;
            let exact = ball::density(distance + radius, radius);
            let apart = (density(distance, [curvature; 2]) - exact).abs();
            assert!(apart < TABLE_ERROR, "{distance} {curvature}: {apart}");
            // A hollow of the same shape is what is left of space.
            let hollow = 1.0 - density(-distance, [-curvature; 2]);
            assert!((hollow - exact).abs() < TABLE_ERROR, "{distance} -{curvature}");
        }
    }

    #[test]
    fn flat_is_flat() {
        for n in 0..50 {
            let distance = f64::from(n) / 25.0 - 1.0;
            assert!((density(distance, [0.0; 2]) - filter::half_space(distance)).abs() < 1e-4);
        }
    }
}
