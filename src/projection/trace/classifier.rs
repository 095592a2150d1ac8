//! Samples to colour, opacity and density.
//!
//! *Theory.* The classifier maps filtered values to opacities, and not to a threshold's yes or no, so that the smoothness of the
//! model goes over into the picture.
//! *Changes from the paper.* A solid is where the classifier says that it is: its *density* at a point is coverage times opacity, in
//! parts of the largest opacity there is.

use crate::math::Interval;
use crate::model::TransferFunction;
use crate::projection::TransferTable;
use crate::target::Target;

/// A trilinear sample of a target.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Value (or opacity) times coverage.
    pub premultiplied: f64,
    /// Coverage.
    pub coverage: f64,
    /// In a target of colours: red, green and blue times opacity and coverage.
    pub rgb: [f64; 3],
}

impl Sample {
    /// `part` of another sample, and the rest of this.
    pub fn mixed(&self, other: &Self, part: f64) -> Self {
        let mix = |a: f64, b: f64| a + part * (b - a);
        Self {
            premultiplied: mix(self.premultiplied, other.premultiplied),
            coverage: mix(self.coverage, other.coverage),
            rgb: [0, 1, 2].map(|c| mix(self.rgb[c], other.rgb[c])),
        }
    }
}

/// What is at a point, where anything is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tissue {
    /// Straight colour.
    pub color: [f64; 3],
    /// The logarithm of what it lets through over a millimetre, not above 0.
    pub log_clear: f64,
}

impl Tissue {
    /// Its opacity over a length.
    pub fn opacity(&self, length_mm: f64) -> f64 {
        1.0 - (self.log_clear * length_mm).exp()
    }
}

fn log_clear(opacity: f64, unit_mm: f64) -> f64 {
    (1.0 - opacity.clamp(0.0, 1.0)).ln() / unit_mm
}

/// The classifier of one object.
pub struct Classifier {
    range: Interval,
    /// Straight colour and opacity over the unit length of each value; empty where samples are colours.
    table: Vec<[f32; 4]>,
    /// The logarithm of what each value lets through over a millimetre.
    log_clear: Vec<f64>,
    extremes: Extremes,
    unit_mm: f64,
    peak: f64,
}

impl Classifier {
    /// For the samples of `target`, which `transfer` makes colours of unless they are colours.
    pub fn new(target: &Target, transfer: &TransferFunction) -> Self {
        let range = target.value_range;
        if let Some(unit_mm) = target.tree.color_unit_mm() {
            return Self {
                range,
                table: Vec::new(),
                log_clear: Vec::new(),
                extremes: Extremes::default(),
                unit_mm,
                peak: f64::from(range.hi.clamp(0.0, 1.0)),
            };
        }
        let last = (TransferTable::LEN - 1) as f32;
        let entry = |n: usize| {
            let ([r, g, b], opacity) = transfer.evaluate(range.lo + n as f32 / last * range.width().max(0.0));
            [r, g, b, opacity]
        };
        let table: Vec<[f32; 4]> = (0..TransferTable::LEN).map(entry).collect();
        Self {
            range,
            peak: f64::from(table.iter().fold(0.0, |peak: f32, entry| peak.max(entry[3]))),
            extremes: Extremes::new(table.iter().map(|entry| entry[3])),
            log_clear: table
                .iter()
                .map(|entry| log_clear(f64::from(entry[3]), transfer.unit_mm()))
                .collect(),
            table,
            unit_mm: transfer.unit_mm(),
        }
    }

    /// Whether anything can be seen.
    pub fn shows(&self) -> bool {
        self.peak > 0.0
    }

    /// The colour and opacity of what is at a sample that is covered.
    pub fn tissue(&self, sample: &Sample) -> Tissue {
        let value = sample.premultiplied / sample.coverage;
        if self.table.is_empty() {
            let part = 1.0 / sample.premultiplied.max(f64::MIN_POSITIVE);
            return Tissue {
                color: sample.rgb.map(|c| (c * part).clamp(0.0, 1.0)),
                log_clear: log_clear(value, self.unit_mm),
            };
        }
        let entry = self.entry(value) as usize;
        let [r, g, b, _] = self.table[entry].map(f64::from);
        Tissue {
            color: [r, g, b],
            log_clear: self.log_clear[entry],
        }
    }

    /// The density at a sample, in [0, 1].
    pub fn density(&self, sample: &Sample) -> f64 {
        if sample.coverage <= 0.0 || self.peak <= 0.0 {
            return 0.0;
        }
        let opacity = match self.table.is_empty() {
            true => sample.premultiplied / sample.coverage,
            false => f64::from(self.table[self.entry(sample.premultiplied / sample.coverage) as usize][3]),
        };
        (sample.coverage * opacity / self.peak).clamp(0.0, 1.0)
    }

    /// What gradients are of, as in [`SoftNormals`](crate::projection::SoftNormals): the fraction of the value range times coverage,
    /// above how far empty space lies below it.
    pub fn height(&self, sample: &Sample) -> f64 {
        let below = f64::from(crate::projection::EMPTY_BELOW) * sample.coverage;
        let width = f64::from(self.range.hi) - f64::from(self.range.lo);
        if width <= 0.0 {
            return below;
        }
        (sample.premultiplied - f64::from(self.range.lo) * sample.coverage) / width + below
    }

    /// The least and the largest opacity over the unit length that values in `range` have, in parts of the largest there is; an entry of
    /// the table more on each side for rounding.
    pub fn densities(&self, range: Interval) -> [f64; 2] {
        if range.is_empty() || self.peak <= 0.0 {
            return [0.0; 2];
        }
        if self.table.is_empty() {
            return [range.lo, range.hi].map(|opacity| f64::from(opacity) / self.peak);
        }
        let first = (self.entry(f64::from(range.lo)) as usize).saturating_sub(1);
        let last = (self.entry(f64::from(range.hi)) as usize + 1).min(self.table.len() - 1);
        let [least, most] = self.extremes.over(first, last);
        [least, most].map(|opacity| f64::from(opacity) / self.peak)
    }

    fn entry(&self, value: f64) -> u32 {
        let width = f64::from(self.range.width()).max(f64::from(f32::MIN_POSITIVE));
        let fraction = ((value - f64::from(self.range.lo)) / width).clamp(0.0, 1.0);
        (fraction * (TransferTable::LEN - 1) as f64 + 0.5) as u32
    }
}

/// The least and the largest of any numbers in a row: row k holds those of 2^k numbers from each on.
#[derive(Default)]
struct Extremes(Vec<Vec<[f32; 2]>>);

impl Extremes {
    fn new(numbers: impl Iterator<Item = f32>) -> Self {
        let mut rows = vec![numbers.map(|n| [n, n]).collect::<Vec<_>>()];
        while let Some(last) = rows.last().filter(|row| row.len() > 1 << (rows.len() - 1)) {
            let half = 1 << (rows.len() - 1);
            let row = last.iter().zip(&last[half..]).map(|(a, b)| both(*a, *b)).collect();
            rows.push(row);
        }
        Self(rows)
    }

    /// Those from `first` to `last`, both counted in and not beyond the numbers.
    fn over(&self, first: usize, last: usize) -> [f32; 2] {
        let k = (last + 1 - first).ilog2() as usize;
        both(self.0[k][first], self.0[k][last + 1 - (1 << k)])
    }
}

fn both([a, b]: [f32; 2], [c, d]: [f32; 2]) -> [f32; 2] {
    [a.min(c), b.max(d)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_of_all_ranges() {
        for len in 1..20usize {
            let number = |n: usize| (n * 7 % 11) as f32;
            let extremes = Extremes::new((0..len).map(number));
            for first in 0..len {
                for last in first..len {
                    let numbers = (first..=last).map(number);
                    let slow = numbers.fold([f32::INFINITY, f32::NEG_INFINITY], |e, n| both(e, [n, n]));
                    assert_eq!(extremes.over(first, last), slow, "{first}..={last} of {len}");
                }
            }
        }
    }
}
