//! The hypercone filter (WK94, *volume-sampled models*): what a density is the convolution with.
//!
//! *Theory.* The weight falls linearly from the middle of a ball to 0 at its rim. In units of the ball's radius the normalised
//! weight at distance ρ is 3/π · (1 − ρ).
//! *Changes from the paper.* WK94 tabulates filtered densities. What has a closed form needs no table: the weight's integrals
//! over a half-space, along a line and over a cone are polynomials, square roots and logarithms.
//! *Practice.* All lengths are in units of the radius, so 1 is the rim.

use std::f64::consts::FRAC_1_PI;

use glam::{DMat3, DVec3};

/// The radius in voxels unless another is asked for (WK94, table 1).
pub const DEFAULT_RADIUS_VOXELS: f64 = 2.0;

/// The weight at distance `rho` from the middle; its integral over space is 1.
pub fn weight(rho: f64) -> f64 {
    3.0 * FRAC_1_PI * (1.0 - rho).max(0.0)
}

/// The density of a half-space whose face is `distance` away, above 0 outside: `½ − u + u³ − u⁴/2` for u in [0, 1], and 1 less
/// that of the opposite distance for u < 0.
#[inline]
pub fn half_space(distance: f64) -> f64 {
    let u = distance.abs().min(1.0);
    let outside = 0.5 - u * (1.0 - u * u * (1.0 - 0.5 * u));
    if distance >= 0.0 { outside } else { 1.0 - outside }
}

/// The distance at which a half-space has density `density`, within [-1, 1], from a first guess.
pub fn half_space_distance(density: f64, guess: f64) -> f64 {
    if density <= 0.0 || density >= 1.0 {
        return if density <= 0.0 { 1.0 } else { -1.0 };
    }
    let mut u = guess.clamp(-1.0, 1.0);
    for _ in 0..24 {
        let slope = -1.0 + u * u * (3.0 - 2.0 * u.abs());
        // The slope is 0 at the ends; elsewhere Newton's method.
        let step = (half_space(u) - density) / slope.min(-1e-9);
        u = (u - step).clamp(-1.0, 1.0);
        // The next step would be some square of this one.
        if step.abs() < 1e-4 {
            break;
        }
    }
    u
}

/// The integral of the weight over the part from `from` to `to` of a line that passes the middle at distance `q`; positions
/// count from the point nearest to it. With ρ = √(q² + t²) it is 3/2π · [t (2 − ρ) − q² asinh(t/q)].
#[inline]
pub fn chord(q: f64, from: f64, to: f64) -> f64 {
    let half_squared = 1.0 - q * q;
    if half_squared <= 0.0 {
        return 0.0;
    }
    let half = half_squared.sqrt();
    let [from, to] = [from, to].map(|end| end.clamp(-half, half));
    if from >= to {
        return 0.0;
    }
    let [rho_from, rho_to] = [from, to].map(|t| (q * q + t * t).sqrt());
    let twice = to * (2.0 - rho_to) - from * (2.0 - rho_from);
    // The difference of two asinh is one logarithm; t + ρ is q² / (ρ − t) where t < 0 would cancel.
    let rise = |t: f64, rho: f64| if t >= 0.0 { t + rho } else { q * q / (rho - t) };
    let bent = if q > 1e-12 {
        q * q * (rise(to, rho_to) / rise(from, rho_from)).ln()
    } else {
        0.0
    };
    1.5 * FRAC_1_PI * (twice - bent)
}

/// The most that a density can be at `distance` from a solid: all weight farther than that from the middle; 1 inside.
pub fn most_at(distance: f64) -> f64 {
    let d = distance.clamp(0.0, 1.0);
    // Near the rim the terms cancel, and what is left may round to below 0.
    (1.0 - d * d * d * (4.0 - 3.0 * d)).max(0.0)
}

/// The filter's ball as a solid's frame sees it: a ball of `radius`, or an ellipsoid where the solid is stretched or sheared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Support {
    /// From the unit ball to the ball's place about a sample in the solid's frame.
    pub local_from_unit: DMat3,
    /// Its inverse.
    pub unit_from_local: DMat3,
    /// The farthest that the filter reaches in the solid's frame.
    pub reach: f64,
    /// Whether it is a ball there too, but for rounding.
    pub is_ball: bool,
}

impl Support {
    /// A ball of radius `radius`, above 0.
    pub fn ball(radius: f64) -> Self {
        Self::new(DMat3::from_diagonal(DVec3::splat(radius)))
    }

    /// The image of the unit ball under an invertible map.
    pub fn new(local_from_unit: DMat3) -> Self {
        let squares = local_from_unit.transpose() * local_from_unit;
        let [x, y, z] = [squares.x_axis, squares.y_axis, squares.z_axis];
        let largest = x.x.max(y.y).max(z.z);
        let skew = x.y.abs().max(x.z.abs()).max(y.z.abs());
        let smallest = x.x.min(y.y).min(z.z);
        let is_ball = largest - smallest <= 1e-9 * largest && skew <= 1e-9 * largest;
        // A row of the matrix of squares sums to no less than the largest eigenvalue (Gershgorin).
        let row = |v: DVec3| v.abs().element_sum();
        let bound = if is_ball {
            largest
        } else {
            row(x).max(row(y)).max(row(z))
        };
        Self {
            local_from_unit,
            unit_from_local: local_from_unit.inverse(),
            reach: bound.sqrt(),
            is_ball,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::math::quadrature::GaussLegendre;

    #[test]
    fn the_weight_integrates_to_one() {
        let shells = GaussLegendre::<4>::new().integrate(0.0, 1.0, |r| 4.0 * PI * r * r * weight(r));
        assert!((shells - 1.0).abs() < 1e-14);
    }

    #[test]
    fn lines_integrate_the_weight() {
        let rule = GaussLegendre::<32>::new();
        for (q, from, to) in [(0.0, -0.3, 0.9), (0.2, -2.0, 0.1), (0.7, 0.2, 5.0), (0.99, -1.0, 1.0)] {
            let half = (1.0f64 - q * q).sqrt();
            let along = |t: f64| weight((q * q + t * t).sqrt());
            let numeric = rule.integrate(f64::clamp(from, -half, half), f64::clamp(to, -half, half), along);
            let error = (chord(q, from, to) - numeric).abs();
            // The weight has a kink in the middle of the ball, which a Gauss rule does not see.
            assert!(error < if q == 0.0 { 1e-3 } else { 1e-6 }, "{q} {from} {to}: {error}");
        }
        assert_eq!(chord(1.0, -1.0, 1.0), 0.0);
    }

    #[test]
    fn half_spaces_are_stacks_of_discs() {
        let rule = GaussLegendre::<32>::new();
        let disc = |x: f64| {
            let radius = (1.0 - x * x).max(0.0).sqrt();
            rule.integrate(0.0, radius, |q| 2.0 * PI * q * weight((x * x + q * q).sqrt()))
        };
        for distance in [-0.9, -0.4, 0.0, 0.3, 0.8] {
            // The discs' areas have a kink at the middle.
            let numeric =
                rule.integrate(distance, distance.max(0.0), disc) + rule.integrate(distance.max(0.0), 1.0, disc);
            assert!((half_space(distance) - numeric).abs() < 1e-5, "{distance}: {numeric}");
            assert!((half_space_distance(half_space(distance), 0.1) - distance).abs() < 1e-6);
        }
        assert_eq!([half_space(1.0), half_space(-1.5)], [0.0, 1.0]);
    }

    #[test]
    fn a_stretched_support_reaches_no_farther_than_it_says() {
        let stretched = Support::new(DMat3::from_cols(
            DVec3::new(2.0, 0.1, 0.0),
            DVec3::new(0.5, 1.0, 0.3),
            DVec3::new(0.0, -0.4, 0.7),
        ));
        assert!(!stretched.is_ball && Support::ball(3.0).is_ball);
        assert_eq!(Support::ball(3.0).reach, 3.0);
        for n in 0..1000 {
            let n = f64::from(n);
            let on_ball = DVec3::new(n.sin(), (n * 1.7).cos(), (n * 0.3).sin()).normalize();
            assert!((stretched.local_from_unit * on_ball).length() <= stretched.reach);
        }
    }
}
