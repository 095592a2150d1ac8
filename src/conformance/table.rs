//! What a look-up in a transfer table can give.

use super::precision::{Precision, ULP};
use super::span::Span;
use crate::projection::TransferTable;

/// A table with the extremes of every run of 2ⁿ entries.
pub(super) struct TableSpans {
    /// `levels[n][i]` spans entries `i .. i + 2ⁿ`, channel by channel.
    levels: Vec<Vec<[Span; 4]>>,
    /// Error of a place in the table before it is rounded to an entry, entries.
    entry: f64,
}

impl TableSpans {
    pub(super) fn new(table: &TransferTable, precision: &Precision) -> Self {
        let entries = table.entries().iter();
        let mut levels = vec![
            entries
                .map(|e| e.map(|c| Span::point(f64::from(c))))
                .collect::<Vec<_>>(),
        ];
        let mut run = 1;
        while 2 * run <= TransferTable::LEN {
            let below = &levels[levels.len() - 1];
            let pairs = below.iter().zip(&below[run..]);
            let level = pairs.map(|(a, b)| std::array::from_fn(|c| a[c].hull(b[c]))).collect();
            levels.push(level);
            run *= 2;
        }
        Self {
            levels,
            // A product and a sum of rounded numbers, and the texture coordinate; the nearest entry is then read as it is.
            entry: TransferTable::LEN as f64 * (4.0 * ULP + precision.coordinate),
        }
    }

    /// Premultiplied colour and opacity over `fraction` of the value range.
    pub(super) fn over(&self, fraction: Span) -> [Span; 4] {
        let last = (TransferTable::LEN - 1) as f64;
        let x = fraction
            .scaled(last)
            .widened(self.entry)
            .rising(|x| x.clamp(0.0, last) + 0.5);
        self.entries(x.lo as usize, x.hi as usize + 1)
    }

    fn entries(&self, first: usize, end: usize) -> [Span; 4] {
        let level = (end - first).ilog2() as usize;
        let (a, b) = (&self.levels[level][first], &self.levels[level][end - (1 << level)]);
        std::array::from_fn(|c| a[c].hull(b[c]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Interval;
    use crate::projection::{ControlPoint, TransferFunction};
    use proptest::prelude::*;

    /// A tooth that rises and falls, so that extremes lie within and at ends.
    fn table() -> TransferTable {
        let point = |value, opacity| ControlPoint {
            value,
            opacity,
            color: [0.2, 0.5, 1.0],
        };
        let points = vec![point(0.0, 0.1), point(0.4, 0.9), point(1.0, 0.0)];
        let function = TransferFunction::new(points, 1.0).expect("rising values");
        TransferTable::new(&function, Interval::new(0.0, 1.0), 1.0)
    }

    proptest! {
        #[test]
        fn an_entry_is_in_the_span_round_it(lo in -0.1f64..1.1, width in 0.0f64..0.3, t in 0.0f64..=1.0) {
            let table = table();
            let spans = TableSpans::new(&table, &Precision::EXACT).over(Span::new(lo, lo + width));
            let entry = table.at(lo + t * width);
            for (span, c) in spans.into_iter().zip(entry) {
                prop_assert!(span.lo - 1e-12 <= c && c <= span.hi + 1e-12, "{c} is not in {span:?}");
            }
        }
    }

    #[test]
    fn a_span_is_no_wider_than_the_table_is() {
        let spans = TableSpans::new(&table(), &Precision::EXACT).over(Span::new(0.3, 0.5));
        // From 0.7 at 0.3 to the tip; the table's entries miss the tip by less than 2 / 4095.
        assert!((spans[3].lo - 0.7).abs() < 1e-3 && (spans[3].hi - 0.9).abs() < 1e-3);
    }
}
