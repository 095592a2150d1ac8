//! What a look-up in a transfer table can give.

use super::precision::{Precision, ULP};
use super::span::Span;
use crate::projection::TransferTable;

/// A table with the extremes of every run of 2ⁿ entries.
pub(super) struct TableSpans {
    /// `levels[n][i]` spans entries `i .. i + 2ⁿ`, channel by channel.
    levels: Vec<Vec<[Span; 4]>>,
    /// Error of a place in the table, entries.
    entry: f64,
    /// Error of a filtered entry, relative.
    sum: f64,
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
            let level = pairs
                .map(|(a, b)| std::array::from_fn(|c| a[c].hull(b[c])))
                .collect();
            levels.push(level);
            run *= 2;
        }
        Self {
            levels,
            // The shader scales, adds and divides before the texture unit sees the coordinate.
            entry: TransferTable::LEN as f64 * (precision.coordinate + 3.0 * ULP)
                + precision.weight,
            sum: precision.sum,
        }
    }

    /// Premultiplied colour and opacity over `fraction` of the value range.
    pub(super) fn over(&self, fraction: Span) -> [Span; 4] {
        let last = (TransferTable::LEN - 1) as f64;
        let x = fraction
            .scaled(last)
            .widened(self.entry)
            .rising(|x| x.clamp(0.0, last));
        let ends = [self.at(x.lo), self.at(x.hi)];
        let (first, end) = (x.lo.ceil() as usize, x.hi.floor() as usize + 1);
        let inner = (first < end).then(|| self.entries(first, end));
        std::array::from_fn(|c| {
            let span = ends[0][c].hull(ends[1][c]);
            let span = inner.map_or(span, |inner| span.hull(inner[c]));
            span.relaxed(self.sum).not_negative()
        })
    }

    fn at(&self, x: f64) -> [Span; 4] {
        let i = (x as usize).min(TransferTable::LEN - 2);
        let t = x - i as f64;
        let (a, b) = (&self.levels[0][i], &self.levels[0][i + 1]);
        std::array::from_fn(|c| Span::point(a[c].lo + t * (b[c].lo - a[c].lo)))
    }

    fn entries(&self, first: usize, end: usize) -> [Span; 4] {
        let level = (end - first).ilog2() as usize;
        let (a, b) = (
            &self.levels[level][first],
            &self.levels[level][end - (1 << level)],
        );
        std::array::from_fn(|c| a[c].hull(b[c]))
    }
}
