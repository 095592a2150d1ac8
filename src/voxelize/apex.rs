//! The density near the tip of a cone, from a table.
//!
//! *Theory.* Near its tip a cone bends too much for [`curved`](super::curved). What the filter's ball sees there depends on
//! three numbers: the distance to the side, the place along it, and the angle at the tip (WK94's table of a vertex).
//! *Changes from the paper.* One table serves all cones, those of frustums whose tip is cut off out of sight too. It is
//! interpolated by cubics, which need fewer entries than lines do.
//! *Practice.* Lengths are in units of the filter's radius. Half angles from 20° to 70° are covered. The table has 13 · 33 · 13
//! entries and is filled once, when first asked, on one thread: see [`curved`](super::curved).

use std::f64::consts::PI;
use std::ops::RangeInclusive;
use std::sync::LazyLock;

use glam::DVec2;

use super::cubic;
use super::profile::Profile;
use super::revolved;

/// Entries along the distance, from -1 to 1; along the side; and along the half angle.
const ENTRIES: [usize; 3] = [13, 33, 13];

/// The least and the greatest half angle of the table: an entry beyond what it is asked for, so that cubics have four.
const HALF_ANGLES: [f64; 2] = [PI / 12.0, 5.0 * PI / 12.0];

/// The half angles that are covered.
const COVERED: RangeInclusive<f64> = PI / 9.0..=7.0 * PI / 18.0;

/// Where on the side the table begins: there the ball is beyond the tip.
const FIRST: f64 = -1.0;

/// How far from the tip the ball meets the axis at most, and so does not see how the cone bends beyond it.
fn last(half_angle: f64) -> f64 {
    1.0 / (0.5 * half_angle).tan()
}

static TABLE: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let part = |n: usize, axis: usize| n as f64 / (ENTRIES[axis] - 1) as f64;
    let between = |[lo, hi]: [f64; 2], t: f64| lo + t * (hi - lo);
    let entries = (0..ENTRIES.iter().product()).map(|n: usize| {
        let half_angle = between(HALF_ANGLES, part(n / (ENTRIES[0] * ENTRIES[1]), 2));
        let along = between([FIRST, last(half_angle)], part(n / ENTRIES[0] % ENTRIES[1], 1));
        integrate(between([-1.0, 1.0], part(n % ENTRIES[0], 0)), along, half_angle) as f32
    });
    entries.collect()
});

/// The density at `distance` from the side of a cone, above 0 outside, `along` it from the tip, where its half angle has the
/// tangent `tangent`; `None` where the table does not go.
pub fn density(distance: f64, along: f64, tangent: f64) -> Option<f64> {
    let half_angle = tangent.atan();
    let last = last(half_angle);
    if !COVERED.contains(&half_angle) || along > last {
        return None;
    }
    let place = |part: f64, axis: usize| cubic::clamped(part * (ENTRIES[axis] - 1) as f64, ENTRIES[axis]);
    let (d, by_distance) = place(0.5 * (distance + 1.0), 0);
    let (s, by_place) = place((along - FIRST) / (last - FIRST), 1);
    let (a, by_angle) = place((half_angle - HALF_ANGLES[0]) / (HALF_ANGLES[1] - HALF_ANGLES[0]), 2);
    let table = &*TABLE;
    let row = |s: usize, a: usize| {
        let start = ENTRIES[0] * (s + ENTRIES[1] * a);
        cubic::weigh(d.map(|d| f64::from(table[start + d])), by_distance)
    };
    let sheet = |a: usize| cubic::weigh(s.map(|s| row(s, a)), by_place);
    Some(cubic::weigh(a.map(sheet), by_angle).clamp(0.0, 1.0))
}

/// The density by integration over lines along the axis.
fn integrate(distance: f64, along: f64, half_angle: f64) -> f64 {
    // The ball of the last entry reaches no farther than this down the axis.
    let height = last(half_angle) + 3.0;
    let corners = [(0.0, -height), (height * half_angle.tan(), -height), (0.0, 0.0)];
    let (sin, cos) = half_angle.sin_cos();
    let p = DVec2::new(sin, -cos) * along + DVec2::new(cos, sin) * distance;
    // Beyond the axis all is as before it.
    let p = DVec2::new(p.x.abs(), p.y);
    revolved::integrated_in_ball(&Profile::polygon(&corners.map(DVec2::from)), p, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cubics err by at most 3/128 of the fourth power of the step times the fourth derivative, which is below 40 where a
    /// density falls from 1 to 0 on a length of 2: 1e-3 by distance (steps of a sixth), as much along the narrowest cone's side
    /// (a quarter, where it changes a third as fast), and less by angle.
    const TABLE_ERROR: f64 = 2.5e-3;

    #[test]
    fn places_between_entries_are_integrals() {
        let mut worst = 0f64;
        for n in 0..6000 {
            let part = |step: f64| (f64::from(n) * step).fract();
            let half_angle = COVERED.start() + (COVERED.end() - COVERED.start()) * part(0.754_877_666);
            let along = FIRST + (last(half_angle) - FIRST) * part(0.569_840_29);
            let distance = 2.0 * part(0.618_033_988) - 1.0;
            // Off the axis's far side, where no sample is.
            if along * half_angle.sin() + distance * half_angle.cos() >= 0.0 {
                let exact = integrate(distance, along, half_angle);
                let found = density(distance, along, half_angle.tan()).expect("in the table");
                worst = worst.max((found - exact).abs());
            }
        }
        println!("at most {worst}");
        assert!(worst < TABLE_ERROR, "{worst}");
    }
}
