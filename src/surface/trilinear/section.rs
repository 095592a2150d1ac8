//! Sections across a cell, on which the interpolant is bilinear, and the one that decides about a tunnel.

use super::contour::{alternate, joins};
use super::interpolant::is_inside;
use crate::surface::cell::{edge_between, edge_corners};

/// The section across an axis where the asymptotic decider of the sections has its extreme.
///
/// The section's corners lie on the four edges along the axis, here called columns.
pub(super) struct Section<'a> {
    values: &'a [f64; 8],
    axis: u8,
    /// The interpolant on each column, times a positive number.
    at: [f64; 4],
    /// Where the section is, 0 to 1.
    height: f64,
    /// How far above and below it the decider is zero; 0 if it is nowhere.
    reach: f64,
}

impl<'a> Section<'a> {
    /// The section, if there is one strictly within the cell.
    ///
    /// The decider is a quadratic in the height. Values are kept times the denominator of its extreme's height, so that all is
    /// exact for small whole numbers. Zero on a column counts as inside as elsewhere, although the extreme moves when all values
    /// grow a little: the tunnel would have to open at a height where the interpolant is zero on a column of each kind, and there
    /// the decider, linear in the height up to terms of higher order, has one root only.
    pub fn at_extreme(values: &'a [f64; 8], axis: u8) -> Option<Self> {
        let [lower, slope] = lines(values, axis);
        let bend = decider(slope, slope);
        let scale = 2.0 * bend.abs();
        let height = -(decider(lower, slope) + decider(slope, lower)) * bend.signum();
        if !(0.0 < height && height < scale) {
            return None;
        }
        let at = [0, 1, 2, 3].map(|k| lower[k] * scale + slope[k] * height);
        Some(Self {
            values,
            axis,
            at,
            height: height / scale,
            reach: (-decider(at, at) / bend).max(0.0).sqrt() / scale,
        })
    }

    /// Whether the signs of the corners alternate.
    pub fn is_ambiguous(&self) -> bool {
        alternate(cyclic(self.at.map(is_inside)))
    }

    /// The first of the two columns that the level set's arcs in this ambiguous section do not cut off: 0 or 1. The other is the
    /// opposite one.
    pub fn bridged(&self) -> u8 {
        u8::from(is_inside(self.at[0]) != joins(cyclic(self.at)))
    }

    /// The two columns on the lower (0) or upper (1) face across another axis.
    pub fn side(&self, axis: u8, side: u8) -> [u8; 2] {
        let first_other = u8::from(self.axis == 0);
        let step = if axis == first_other { 1 } else { 2 };
        [side * step, side * step + 3 - step]
    }

    /// The edge whose vertex begins or ends the contour segment that this section meets on the face between two columns.
    ///
    /// Along the section the interpolant is linear between the columns, so that there is one such segment.
    pub fn edge_on(&self, [i, j]: [u8; 2]) -> u8 {
        let signs = [i, j].map(|column| is_inside(self.at[column as usize]));
        let [a, b] = [i, j].map(|column| edge_corners(4 * self.axis + column));
        let rim = (0..2).find(|&k| [a[k], b[k]].map(|c| is_inside(self.values[c as usize])) == signs);
        rim.map_or(4 * self.axis + i, |k| edge_between(a[k], b[k]))
    }

    /// The two heights at which the saddle of the section lies on the level set, from the lower to the upper, 0 to 1.
    pub fn saddle_heights(&self) -> [f64; 2] {
        [self.height - self.reach, self.height + self.reach].map(|height| height.clamp(0.0, 1.0))
    }
}

/// The saddles of the sections across an axis.
pub(super) struct Saddles {
    lower: [f64; 4],
    slope: [f64; 4],
}

impl Saddles {
    /// The saddles of a cell along `axis`.
    pub fn new(values: &[f64; 8], axis: u8) -> Self {
        let [lower, slope] = lines(values, axis);
        Self { lower, slope }
    }

    /// The saddle at a height where it lies in the cell, along the two other axes in increasing order; 0 to 1.
    pub fn at(&self, height: f64) -> [f64; 2] {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| self.lower[k] + self.slope[k] * height);
        let twist = (a - b) + (d - c);
        [(a - c) / twist, (a - b) / twist].map(|t| t.clamp(0.0, 1.0))
    }

    /// Whether the saddle moves up along the first of the other axes as the height grows.
    pub fn rises(&self) -> bool {
        let first = |f: [f64; 4]| f[0] - f[2];
        let twist = |f: [f64; 4]| (f[0] - f[1]) + (f[3] - f[2]);
        first(self.slope) * twist(self.lower) > first(self.lower) * twist(self.slope)
    }
}

/// The asymptotic decider of a section's corners, given twice. It is bilinear, so that the decider of sums has mixed terms.
fn decider(a: [f64; 4], b: [f64; 4]) -> f64 {
    a[0] * b[3] - a[1] * b[2]
}

/// The columns in their order around the section.
fn cyclic<T: Copy>([a, b, c, d]: [T; 4]) -> [T; 4] {
    [a, b, d, c]
}

/// The value at the lower end of each column and its growth up to the upper end.
fn lines(values: &[f64; 8], axis: u8) -> [[f64; 4]; 2] {
    let ends = [0, 1, 2, 3].map(|column| edge_corners(4 * axis + column).map(|c| values[c as usize]));
    [ends.map(|[lower, _]| lower), ends.map(|[lower, upper]| upper - lower)]
}
