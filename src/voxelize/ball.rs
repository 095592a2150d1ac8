//! Balls, in closed form at any size.
//!
//! *Theory.* The hypercone is a stack of balls: 3/π · (1 − ρ) is the integral of 3/π over the radii t from ρ to 1. So a
//! density is 3/π times the integral over t of the volume that a ball of radius t shares with the solid, and what two balls
//! share is a lens of known volume, a polynomial in t.

use std::f64::consts::{FRAC_1_PI, PI};
use std::sync::LazyLock;

use crate::math::quadrature::GaussLegendre;

/// Exact for the lens, whose volume has degree 4 in t.
static LENS_RULE: LazyLock<GaussLegendre<3>> = LazyLock::new(GaussLegendre::new);

/// The density at distance `d ≥ 0` from the middle of a ball of radius `radius`, both in units of the filter's radius.
pub fn density(d: f64, radius: f64) -> f64 {
    if d >= radius + 1.0 {
        return 0.0;
    }
    if d <= radius - 1.0 {
        return 1.0;
    }
    // Filter balls small enough to lie in the ball, those that cut it, those that hold it.
    let within = (radius - d).max(0.0);
    let (first, last) = ((d - radius).abs(), (d + radius).min(1.0));
    let inner = within.powi(4) / 4.0;
    let lenses = match first < last {
        true => LENS_RULE.integrate(first, last, |t| lens(d, radius, t)),
        false => 0.0,
    };
    let holding = radius.powi(3) * (1.0 - d - radius).max(0.0);
    (4.0 * inner + 3.0 * FRAC_1_PI * lenses + 4.0 * holding).clamp(0.0, 1.0)
}

/// The volume shared by balls of radius `a` and `b` that cut each other with middles `d` apart.
fn lens(d: f64, a: f64, b: f64) -> f64 {
    let overlap = a + b - d;
    PI * overlap * overlap * (d * d + 2.0 * d * (a + b) - 3.0 * (a - b) * (a - b)) / (12.0 * d)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxelize::filter;

    #[test]
    fn a_ball_is_a_stack_of_shells() {
        let rule = GaussLegendre::<40>::new();
        for (d, radius) in [(0.0, 0.5), (0.3, 0.2), (1.1, 0.4), (4.6, 5.0), (5.5, 5.0), (0.6, 1.2)] {
            // The part of a shell of radius t about the sample that lies in the ball.
            let share = |t: f64| match d {
                0.0 => f64::from(u8::from(t <= radius)),
                _ => (0.5 * (1.0 - (d * d + t * t - radius * radius) / (2.0 * d * t))).clamp(0.0, 1.0),
            };
            let shells = |t: f64| 4.0 * PI * t * t * filter::weight(t) * share(t);
            let mut knots = [0.0, 1.0, (d - radius).abs().min(1.0), (d + radius).min(1.0)];
            knots.sort_by(f64::total_cmp);
            let numeric: f64 = knots.windows(2).map(|k| rule.integrate(k[0], k[1], shells)).sum();
            let exact = density(d, radius);
            assert!((exact - numeric).abs() < 1e-9, "{d} {radius}: {exact} is not {numeric}");
        }
    }

    #[test]
    fn a_large_ball_is_a_half_space() {
        let apart = (density(1e5 + 0.3, 1e5) - filter::half_space(0.3)).abs();
        assert!(apart < 1e-5, "{apart}");
    }
}
