//! Sections across a cell, on which the interpolant is bilinear.

use super::cell::{edge_between, edge_corners, is_inside};
use super::contour::{is_ambiguous, is_joined};

/// The section at a height along an axis; its corners lie on the four edges along the axis, here called columns.
pub(super) struct Section<'a> {
    values: &'a [f64; 8],
    axis: u8,
    /// The value on each column.
    at: [f64; 4],
}

impl<'a> Section<'a> {
    /// The section at `height`, 0 to 1.
    pub fn new(values: &'a [f64; 8], axis: u8, height: f64) -> Self {
        let at = columns(values, axis).map(|[lower, upper]| lower + (upper - lower) * height);
        Self { values, axis, at }
    }

    /// Whether the signs of the corners alternate.
    pub fn is_ambiguous(&self) -> bool {
        is_ambiguous(self.around())
    }

    /// Two sides, each as two columns, that an arc of the level set in this ambiguous section connects.
    pub fn arc(&self) -> [[u8; 2]; 2] {
        let cuts_off_first = is_inside(self.at[0]) != is_joined(self.around());
        if cuts_off_first { [[0, 1], [0, 2]] } else { [[0, 1], [1, 3]] }
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

    /// The two columns on the lower (0) or upper (1) face across another axis.
    pub fn side(&self, axis: u8, side: u8) -> [u8; 2] {
        let first_other = u8::from(self.axis == 0);
        let step = if axis == first_other { 1 } else { 2 };
        [side * step, side * step + 3 - step]
    }

    /// Where the bilinear interpolant of an ambiguous section has its saddle, along the other axes in increasing order; 0 to 1.
    pub fn saddle(&self) -> [f64; 2] {
        let [a, b, c, d] = self.at;
        let twist = (a - b) + (d - c);
        [(a - c) / twist, (a - b) / twist].map(|t| t.clamp(0.0, 1.0))
    }

    fn around(&self) -> [f64; 4] {
        let [a, b, c, d] = self.at;
        [a, b, d, c]
    }
}

/// The heights at which the saddles of the sections along an axis lie on the level set, from the lower to the upper: none if there
/// are not two.
///
/// The decider of the sections is a quadratic in the height; both are its extreme's height if it touches zero there.
pub(super) fn saddle_heights(values: &[f64; 8], axis: u8) -> Option<[f64; 2]> {
    let column = columns(values, axis);
    let lower = column.map(|[lower, _]| lower);
    let slope = column.map(|[lower, upper]| upper - lower);
    let decider = |a: [f64; 4], b: [f64; 4]| a[0] * b[3] - a[1] * b[2];
    let square = decider(slope, slope);
    let extreme = -(decider(lower, slope) + decider(slope, lower)) / (2.0 * square);
    let there = Section::new(values, axis, extreme).at;
    let reach = (-decider(there, there) / square).sqrt();
    let heights = [extreme - reach, extreme + reach];
    (heights[0] >= 0.0 && heights[1] <= 1.0).then_some(heights)
}

/// The values at the lower and upper end of each column.
fn columns(values: &[f64; 8], axis: u8) -> [[f64; 2]; 4] {
    [0, 1, 2, 3].map(|column| edge_corners(4 * axis + column).map(|c| values[c as usize]))
}
