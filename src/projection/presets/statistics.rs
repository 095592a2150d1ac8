//! What a preset needs to know of the data.

use rayon::prelude::*;

use super::Modes;
use crate::math::Interval;
use crate::target::{Block, RowEvaluator, Target};

/// Extremes and percentiles of a volume's values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DataStatistics {
    /// Smallest value.
    pub min: f32,
    /// Largest value.
    pub max: f32,
    /// The value at [`DataStatistics::LOW`].
    pub low: f32,
    /// The value at [`DataStatistics::HIGH`].
    pub high: f32,
    /// Where values pile up, if they do about two tissues and a background.
    pub found_modes: Option<Modes>,
}

impl DataStatistics {
    /// The fraction of values below the window.
    pub const LOW: f64 = 0.01;

    /// The fraction of values up to the window's end; a few bright voxels (vessels, ghosts) do not darken the rest.
    pub const HIGH: f64 = 0.995;

    /// The statistics of a sample of values; NaN does not count. `None` when nothing is left.
    pub fn of_sample(mut values: Vec<f32>) -> Option<Self> {
        values.retain(|v| !v.is_nan());
        values.sort_unstable_by(f32::total_cmp);
        let last = values.len().checked_sub(1)?;
        let at = |fraction: f64| values[(fraction * last as f64).round() as usize];
        let (min, high) = (values[0], at(Self::HIGH));
        Some(Self {
            min,
            max: values[last],
            low: at(Self::LOW),
            high,
            found_modes: (min < high)
                .then(|| Modes::of(&values, Interval::new(min, high)))
                .flatten(),
        })
    }

    /// The statistics of a target's covered voxels, from whole rows that are spread evenly over its blocks. `None` when the
    /// target is empty.
    pub fn of_target(target: &Target) -> Option<Self> {
        let voxels: usize = target.blocks.iter().map(|b| b.extent.iter().product::<usize>()).sum();
        let stride = voxels.div_ceil(Self::SAMPLE).max(1);
        let rows = target
            .blocks
            .par_iter()
            .flat_map_iter(|block| sampled_rows(target, block, stride));
        Self::of_sample(rows.flatten().collect())
    }

    /// About how many voxels of a target are looked at.
    const SAMPLE: usize = 1 << 20;

    /// The window that shows most of the data: between the percentiles; where they coincide, between the extremes; round
    /// the value when all are the same.
    pub fn window(&self) -> Interval {
        if self.low < self.high {
            Interval::new(self.low, self.high)
        } else if self.min < self.max {
            Interval::new(self.min, self.max)
        } else {
            Interval::new(self.min - 0.5, self.min + 0.5)
        }
    }

    /// Where values pile up. Where they do not about two tissues, what T1-weighted heads have on average: parts of the window.
    pub fn modes(&self) -> Modes {
        let window = self.window();
        let at = |part: f32| window.lo + part * window.width();
        self.found_modes.unwrap_or(Modes {
            background: window.lo,
            tissues: [at(0.45), at(0.65)],
        })
    }

    /// Whether values look like Hounsfield units: air near −1000 and something denser than any soft tissue.
    pub fn looks_like_ct(&self) -> bool {
        (-4096.0..=-900.0).contains(&self.min) && self.max > 300.0
    }
}

/// The covered values of every `stride`-th row of a block, but at least of one.
fn sampled_rows<'a>(target: &'a Target, block: &'a Block, stride: usize) -> impl Iterator<Item = Vec<f32>> + use<'a> {
    let [width, height, depth] = block.extent;
    let columns = block.origin[0]..block.origin[0] + width;
    let mut evaluator = RowEvaluator::new(target);
    let middle = (height * depth / 2) % stride.min(height * depth);
    (middle..height * depth).step_by(stride).map(move |n| {
        let row = [block.origin[1] + n % height, block.origin[2] + n / height];
        let (mut premultiplied, mut coverage) = (vec![0.0; width], vec![0.0; width]);
        evaluator.evaluate(
            target.path(block),
            columns.clone(),
            row,
            &mut premultiplied,
            Some(&mut coverage),
        );
        let samples = premultiplied.iter().zip(&coverage);
        samples.filter(|(_, c)| **c > 0.0).map(|(v, c)| v / c).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_of_a_ramp_are_its_values() {
        let ramp = (0..=1000).map(|v| v as f32).chain([f32::NAN]).collect();
        let statistics = DataStatistics::of_sample(ramp).unwrap();
        assert_eq!((statistics.low, statistics.high), (10.0, 995.0));
        assert_eq!((statistics.min, statistics.max), (0.0, 1000.0));
        assert_eq!(DataStatistics::of_sample(vec![f32::NAN]), None);
    }

    #[test]
    fn a_window_always_has_width() {
        let sparse = DataStatistics {
            min: 0.0,
            max: 9.0,
            low: 0.0,
            high: 0.0,
            found_modes: None,
        };
        assert_eq!(sparse.window(), Interval::new(0.0, 9.0));
        let flat = DataStatistics {
            min: 4.0,
            max: 4.0,
            low: 4.0,
            high: 4.0,
            found_modes: None,
        };
        assert_eq!(flat.window(), Interval::new(3.5, 4.5));
    }
}
