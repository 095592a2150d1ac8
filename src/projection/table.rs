//! Transfer functions as tables.
//!
//! *Practice.* Projectors read a [`TransferTable`]: the function sampled at
//! 4096 values over the target's value range, corrected for the slab thickness and premultiplied. A value takes the nearest
//! entry: at this length the steps are finer than a picture's own, and no filtering is paid for. The table is what all
//! projectors share, so they agree on it exactly.

use crate::math::Interval;
use crate::model::TransferFunction;

/// A transfer function sampled over a value range for one slab thickness.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferTable {
    entries: Vec<[f32; 4]>,
}

impl TransferTable {
    /// Entries of a table; entry `i` is the function at fraction `i / (LEN − 1)` of the value range.
    pub const LEN: usize = 4096;

    /// Samples `function` over `range`, with opacities for slabs of `slab_mm` millimetres.
    pub fn new(function: &TransferFunction, range: Interval, slab_mm: f64) -> Self {
        let exponent = slab_mm / function.unit_mm();
        let entry = |i: usize| {
            let fraction = i as f32 / (Self::LEN - 1) as f32;
            let (color, opacity) = function.evaluate(range.lo + fraction * range.width().max(0.0));
            let alpha = if opacity > 0.0 && opacity < 1.0 {
                (1.0 - (1.0 - f64::from(opacity)).powf(exponent)) as f32
            } else {
                opacity
            };
            [color[0] * alpha, color[1] * alpha, color[2] * alpha, alpha]
        };
        Self {
            entries: (0..Self::LEN).map(entry).collect(),
        }
    }

    /// Premultiplied RGBA of each entry.
    pub fn entries(&self) -> &[[f32; 4]] {
        &self.entries
    }

    /// Premultiplied RGBA at a `fraction` of the value range, in [0, 1]: the nearest entry.
    pub fn at(&self, fraction: f64) -> [f64; 4] {
        let nearest = fraction.clamp(0.0, 1.0) * (Self::LEN - 1) as f64 + 0.5;
        self.entries[nearest as usize].map(f64::from)
    }
}

/// Which entries of a table values take that are known to lie in a range: those of its ends and all between, and one more on each
/// side for the rounding of stored values and of this.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TakenEntries {
    lo: f32,
    entries_per_unit: f32,
}

impl TakenEntries {
    /// In a table over `range`.
    pub(super) fn new(range: Interval) -> Self {
        Self {
            lo: range.lo,
            entries_per_unit: (TransferTable::LEN - 1) as f32 / range.width().max(f32::MIN_POSITIVE),
        }
    }

    fn entry(&self, value: f32) -> f32 {
        ((value - self.lo) * self.entries_per_unit).clamp(0.0, (TransferTable::LEN - 1) as f32)
    }

    /// The first of them.
    pub(super) fn first(&self, values: Interval) -> usize {
        (self.entry(values.lo) as usize).saturating_sub(1)
    }

    /// One beyond the last of them.
    pub(super) fn end(&self, values: Interval) -> usize {
        (self.entry(values.hi).ceil() as usize + 2).min(TransferTable::LEN)
    }
}

/// A premultiplied table entry for a path `length` times as long as the table's slab: `α' = 1 − (1−α)^length`, the colour
/// kept.
pub fn lengthened([r, g, b, a]: [f64; 4], length: f64) -> [f64; 4] {
    if length == 1.0 || a <= 0.0 {
        return [r, g, b, a];
    }
    // An opacity that rounding has brought above 1 is 1.
    let longer = 1.0 - (1.0 - a).max(0.0).powf(length);
    let scale = longer / a;
    [r * scale, g * scale, b * scale, longer]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::ControlPoint;

    fn ramp() -> TransferFunction {
        let point = |value, opacity| ControlPoint {
            value,
            color: [1.0, 0.5, 0.0],
            opacity,
        };
        TransferFunction::new(vec![point(0.0, 0.0), point(100.0, 0.5)], 1.0).unwrap()
    }

    #[test]
    fn two_thin_slabs_are_as_opaque_as_a_thick_one() {
        let range = Interval::new(0.0, 100.0);
        let thin = TransferTable::new(&ramp(), range, 0.7).at(0.8)[3];
        let thick = TransferTable::new(&ramp(), range, 1.4).at(0.8)[3];
        // f32 entries: a relative rounding of 2^-24 each.
        assert!((1.0 - (1.0 - thin) * (1.0 - thin) - thick).abs() < 3.0 * 2f64.powi(-24));
    }
}
