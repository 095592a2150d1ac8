//! Densities by integration over lines along an axis of a solid: slow, and right for any size and any affine pose.
//!
//! *Theory.* A line meets the filter's ball in a chord, along which the weight has a closed integral ([`filter::chord`]). What
//! is left is an integral over the lines, by Gauss's rule between the places where the solid's thickness has kinks.
//! *Practice.* Lines run along z in the solid's own frame. An affine map keeps them lines, so a stretched solid costs no more.

use glam::{DVec2, DVec3};

use super::filter::{self, Support};

/// The filter's ball about a sample, seen along z of a solid's frame.
pub struct Lines {
    middle: DVec3,
    /// Images of the solid's x and y in the unit ball's frame, with the part along z's image taken off.
    across: [DVec3; 2],
    /// How far x, y and z of the solid's frame lead along z's image.
    along: DVec3,
    /// Volume of the unit ball's frame for each area across and length along.
    scale: f64,
    /// The farthest that the ball reaches across.
    pub reach: f64,
}

impl Lines {
    /// The lines of a ball about `middle`.
    pub fn new(middle: DVec3, support: &Support) -> Self {
        let unit = &support.unit_from_local;
        let length = unit.z_axis.length();
        let axis = unit.z_axis / length;
        let across = [unit.x_axis, unit.y_axis].map(|v| v - axis * v.dot(axis));
        // The ball's half-width across: rows of the map from the unit ball.
        let rows = support.local_from_unit.transpose();
        Self {
            middle,
            across,
            along: DVec3::new(unit.x_axis.dot(axis), unit.y_axis.dot(axis), length),
            scale: unit.determinant().abs() / length,
            reach: if support.is_ball {
                support.reach
            } else {
                rows.x_axis.length().hypot(rows.y_axis.length())
            },
        }
    }

    /// The middle, seen along z.
    pub fn middle(&self) -> DVec2 {
        self.middle.truncate()
    }

    /// What the stretch from `lo` to `hi` of the line at `at` adds, for each area of lines.
    #[inline]
    pub fn stretch(&self, at: DVec2, (lo, hi): (f64, f64)) -> f64 {
        let offset = at - self.middle.truncate();
        let q = (self.across[0] * offset.x + self.across[1] * offset.y).length();
        if q >= 1.0 {
            return 0.0;
        }
        let shift = self.along.x * offset.x + self.along.y * offset.y;
        let place = |z: f64| shift + self.along.z * (z - self.middle.z);
        self.scale * filter::chord(q, place(lo), place(hi))
    }
}

/// `lo`, `hi` and the `knots` between them, for each stretch from one to the next.
pub fn stretches(lo: f64, hi: f64, knots: &[f64]) -> impl Iterator<Item = (f64, f64)> + '_ {
    let inner = knots.iter().copied().filter(move |k| lo < *k && *k < hi);
    let mut from = lo;
    inner.chain([hi]).filter_map(move |to| {
        let stretch = (from, to);
        from = to;
        (stretch.0 < stretch.1).then_some(stretch)
    })
}
