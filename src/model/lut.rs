//! Value rules by look-up: `u(v₁, v₂) = lut(v₁, v₂)` (VCSG §2.3).
//!
//! *Practice.* Entries stand on a grid over two intervals, bilinear between them and constant beyond. Beside the entries their
//! ranges over 2ⁿ × 2ⁿ of them are kept, so that asking what a table can give over a rectangle costs a few look-ups.

use crate::math::Interval;

/// A table of two values.
#[derive(Clone, Debug, PartialEq)]
pub struct Lut {
    first: Axis,
    second: Axis,
    values: Vec<f32>,
    /// Ranges over squares of 2, 4, 8, … entries, up to one square that holds all.
    ranges: Vec<Squares>,
}

/// The entries along one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axis {
    span: Interval,
    entries: usize,
}

/// Ranges over squares of one size, `width` to a row.
#[derive(Clone, Debug, PartialEq)]
struct Squares {
    width: usize,
    ranges: Vec<Interval>,
}

/// Why a table cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LutError {
    /// No entry, or rows of several lengths.
    #[error("its rows must have one length, of at least one entry")]
    Ragged,
    /// An axis without extent.
    #[error("an axis of a table must rise from one finite value to another")]
    Axis,
    /// An entry that is no number.
    #[error("its entries must be finite")]
    NotFinite,
}

impl Lut {
    /// The table of rows of `width` entries: along a row v₁ rises over `first`, from row to row v₂ over `second`.
    ///
    /// # Errors
    /// If rows have no or several lengths, an axis does not rise, or a number is not finite.
    pub fn new(first: Interval, second: Interval, width: usize, values: Vec<f32>) -> Result<Self, LutError> {
        let rises = |axis: Interval| axis.lo < axis.hi && axis.width().is_finite();
        if !rises(first) || !rises(second) {
            return Err(LutError::Axis);
        }
        if width == 0 || values.is_empty() || !values.len().is_multiple_of(width) {
            return Err(LutError::Ragged);
        }
        if values.iter().any(|v| !v.is_finite()) {
            return Err(LutError::NotFinite);
        }
        let mut lut = Self {
            first: Axis {
                span: first,
                entries: width,
            },
            second: Axis {
                span: second,
                entries: values.len() / width,
            },
            ranges: Vec::new(),
            values,
        };
        lut.ranges = lut.squares();
        Ok(lut)
    }

    /// The values that entries stand on: v₁ along a row, v₂ from row to row.
    pub fn axes(&self) -> [Interval; 2] {
        [self.first.span, self.second.span]
    }

    /// Entries in a row.
    pub fn width(&self) -> usize {
        self.first.entries
    }

    /// All entries, row after row.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    fn squares(&self) -> Vec<Squares> {
        let points = self.values.iter().copied().map(Interval::point).collect();
        let mut levels = vec![Squares {
            width: self.first.entries,
            ranges: points,
        }];
        while let Some(finest) = levels.last()
            && finest.ranges.len() > 1
        {
            let coarser = finest.halved();
            levels.push(coarser);
        }
        // The entries themselves are at hand.
        levels.split_off(1)
    }

    /// The table's value for two values.
    pub fn at(&self, v1: f32, v2: f32) -> f32 {
        let ((i, s), (j, t)) = (self.first.place(v1), self.second.place(v2));
        let row = |j: usize| mix(self.entry(i, j), self.entry(i + 1, j), s);
        mix(row(j), row(j + 1), t)
    }

    /// An entry; beyond the last ones these go on.
    fn entry(&self, i: usize, j: usize) -> f32 {
        let (i, j) = (i.min(self.first.entries - 1), j.min(self.second.entries - 1));
        self.values[i + self.first.entries * j]
    }

    /// All that the table can give for values in two ranges: the hull of the entries round them.
    pub fn range(&self, r1: Interval, r2: Interval) -> Interval {
        if r1.is_empty() || r2.is_empty() {
            return Interval::EMPTY;
        }
        let (columns, rows) = (self.first.touched(r1), self.second.touched(r2));
        let hull = self.hull(columns, rows);
        // Two interpolations of two products and a sum each, rounded.
        if hull.is_point() { hull } else { hull.widen_ulps(8.0) }
    }

    /// The hull of the entries between two columns and two rows, or of a few more.
    fn hull(&self, columns: [usize; 2], rows: [usize; 2]) -> Interval {
        const FEW: usize = 4;
        let spread =
            |level: usize| ((columns[1] >> level) - (columns[0] >> level)).max((rows[1] >> level) - (rows[0] >> level));
        let level = (0..)
            .find(|&level| spread(level) < FEW)
            .unwrap_or(0)
            .min(self.ranges.len());
        let mut hull = Interval::EMPTY;
        for j in rows[0] >> level..=rows[1] >> level {
            for i in columns[0] >> level..=columns[1] >> level {
                hull = hull.hull(match level {
                    0 => Interval::point(self.entry(i, j)),
                    _ => self.ranges[level - 1].at(i, j),
                });
            }
        }
        hull
    }
}

impl Axis {
    /// The entry at or before `v`, and the part of the way from it to the next. Every step rounds monotonically.
    fn place(&self, v: f32) -> (usize, f32) {
        let last = (self.entries - 1) as f32;
        let t = ((v - self.span.lo) / self.span.width()).clamp(0.0, 1.0) * last;
        let before = (t as usize).min((self.entries - 1).saturating_sub(1));
        (before, t - before as f32)
    }

    /// The first and the last entry that values in `range` are made of.
    fn touched(&self, range: Interval) -> [usize; 2] {
        let last = self.entries - 1;
        // NaN is nowhere in a range, so no value of it is placed elsewhere.
        [self.place(range.lo).0, (self.place(range.hi).0 + 1).min(last)]
    }
}

impl Squares {
    fn at(&self, i: usize, j: usize) -> Interval {
        self.ranges[i + self.width * j]
    }

    /// Squares twice as wide.
    fn halved(&self) -> Self {
        let height = self.ranges.len() / self.width;
        let width = self.width.div_ceil(2);
        let mut ranges = vec![Interval::EMPTY; width * height.div_ceil(2)];
        for (n, range) in self.ranges.iter().enumerate() {
            let (i, j) = (n % self.width, n / self.width);
            let square = &mut ranges[i / 2 + width * (j / 2)];
            *square = square.hull(*range);
        }
        Self { width, ranges }
    }
}

/// Linear between two numbers; one number where they are one.
fn mix(a: f32, b: f32, t: f32) -> f32 {
    if a == b { a } else { (1.0 - t) * a + t * b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn lut() -> impl Strategy<Value = Lut> {
        let size = (1usize..20, 1usize..20);
        (size, -50.0f32..50.0, 1.0f32..90.0).prop_flat_map(|((width, height), lo, span)| {
            prop::collection::vec(-9.0f32..9.0, width * height).prop_map(move |values| {
                let axis = Interval::new(lo, lo + span);
                Lut::new(axis, Interval::new(0.0, 1.0), width, values).expect("a sound table")
            })
        })
    }

    #[test]
    fn entries_are_met_and_bilinear_between() {
        let lut = Lut::new(
            Interval::new(0.0, 2.0),
            Interval::new(10.0, 20.0),
            3,
            vec![0.0, 1.0, 2.0, 4.0, 5.0, 6.0],
        );
        let lut = lut.expect("a sound table");
        for (n, (v1, v2)) in [(0.0, 10.0), (1.0, 10.0), (2.0, 10.0)].into_iter().enumerate() {
            assert_eq!(lut.at(v1, v2), n as f32);
            assert_eq!(lut.at(v1, 20.0), n as f32 + 4.0);
        }
        assert_eq!(lut.at(0.5, 15.0), 2.5);
        assert_eq!(lut.at(-9.0, 99.0), 4.0, "constant beyond");
    }

    #[test]
    fn what_is_no_table_is_refused() {
        let unit = Interval::new(0.0, 1.0);
        assert_eq!(Lut::new(unit, unit, 2, vec![0.0; 3]), Err(LutError::Ragged));
        assert_eq!(Lut::new(unit, unit, 0, vec![]), Err(LutError::Ragged));
        assert_eq!(Lut::new(Interval::point(1.0), unit, 1, vec![0.0]), Err(LutError::Axis));
        assert_eq!(Lut::new(Interval::ALL, unit, 1, vec![0.0]), Err(LutError::Axis));
        assert_eq!(Lut::new(unit, unit, 1, vec![f32::NAN]), Err(LutError::NotFinite));
    }

    proptest! {
        #[test]
        fn ranges_hold(lut in lut(), at in [-60.0f32..150.0, -0.2f32..1.2], by in [0.0f32..40.0, 0.0f32..1.0], part in [0.0f32..=1.0, 0.0f32..=1.0]) {
            let range = |n: usize| Interval::new(at[n], at[n] + by[n]);
            let inside = |n: usize| (at[n] + part[n] * by[n]).clamp(range(n).lo, range(n).hi);
            let value = lut.at(inside(0), inside(1));
            let whole = lut.range(range(0), range(1));
            prop_assert!(whole.contains(value), "{value} is not in {whole:?}");
            let every = lut.range(Interval::ALL, Interval::ALL);
            prop_assert!(every.contains(value), "{value} is not in {every:?}");
        }
    }
}
