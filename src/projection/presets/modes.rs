//! Landmarks of a histogram, for data without a unit: where the background lies, and where the tissues that there is most of.
//!
//! *Theory.* The values of an MR head pile up at the background and at grey and white matter, wherever the scanner put them. Otsu's
//! threshold parts background from tissue: of all cuts the one with the greatest variance between its sides. A mode of the histogram is the
//! more prominent the deeper one must go down from it to reach a higher one.
//! *Practice.* Values are shared linearly between the two bins about them, and the histogram is smoothed, so whole numbers leave no comb. The
//! tissues are the two most prominent modes above the threshold.

use crate::math::Interval;

/// Where the values of some data pile up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modes {
    /// The background.
    pub background: f32,
    /// The two tissues that there is most of, by rising value.
    pub tissues: [f32; 2],
}

const BINS: usize = 128;

impl Modes {
    /// Those of `values` within `range`. `None` where the histogram has fewer than two modes above its background.
    pub(super) fn of(values: &[f32], range: Interval) -> Option<Self> {
        if range.width() <= 0.0 || !range.width().is_finite() {
            return None;
        }
        let histogram = smoothed(smoothed(smoothed(histogram(values, range))));
        let threshold = otsu(&histogram);
        let background = (0..=threshold).max_by(|a, b| histogram[*a].total_cmp(&histogram[*b]).then(b.cmp(a)))?;
        let mut peaks = peaks(&histogram[threshold + 1..]);
        peaks.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let [first, second] = *peaks.first_chunk()?;
        let value = |bin: usize| range.lo + bin as f32 / (BINS - 1) as f32 * range.width();
        let mut tissues = [first.0, second.0].map(|bin| value(threshold + 1 + bin));
        tissues.sort_by(f32::total_cmp);
        Some(Self {
            background: value(background),
            tissues,
        })
    }
}

/// How much lies at each of [`BINS`] places spread evenly over `range`.
fn histogram(values: &[f32], range: Interval) -> [f64; BINS] {
    let mut bins = [0.0; BINS];
    let last = (BINS - 1) as f32;
    for value in values {
        let place = (value - range.lo) / range.width() * last;
        if (0.0..=last).contains(&place) {
            let below = (place as usize).min(BINS - 2);
            let above = f64::from(place - below as f32);
            bins[below] += 1.0 - above;
            bins[below + 1] += above;
        }
    }
    bins
}

/// Weighted by 1, 4, 6, 4, 1; beyond the ends there is nothing.
fn smoothed(bins: [f64; BINS]) -> [f64; BINS] {
    let at = |i: usize, by: usize| {
        (i + by)
            .checked_sub(2)
            .and_then(|i| bins.get(i))
            .copied()
            .unwrap_or(0.0)
    };
    let weights = [1.0, 4.0, 6.0, 4.0, 1.0].map(|w| w / 16.0);
    std::array::from_fn(|i| (0..5).map(|by| weights[by] * at(i, by)).sum())
}

/// The last bin of the background.
fn otsu(bins: &[f64; BINS]) -> usize {
    let total: f64 = bins.iter().sum();
    let moment: f64 = bins.iter().enumerate().map(|(i, n)| i as f64 * n).sum();
    let (mut below, mut below_moment, mut best) = (0.0, 0.0, (0, -1.0));
    for (i, n) in bins.iter().enumerate().take(BINS - 1) {
        below += n;
        below_moment += i as f64 * n;
        let above = total - below;
        if below > 0.0 && above > 0.0 {
            let apart = below_moment / below - (moment - below_moment) / above;
            let variance = below * above * apart * apart;
            if variance > best.1 {
                best = (i, variance);
            }
        }
    }
    best.0
}

/// The modes of `bins`: where, and how prominent.
fn peaks(bins: &[f64]) -> Vec<(usize, f64)> {
    let lower = |from: f64, to: Option<&f64>| to.is_none_or(|to| *to < from);
    let is_peak = |i: usize| {
        let plateau_end = (i..bins.len()).find(|j| bins[*j] != bins[i]);
        let before = i.checked_sub(1).map(|j| &bins[j]);
        // What rises or is level to the left of its first bin begins before it.
        before.is_some() && lower(bins[i], before) && lower(bins[i], plateau_end.map(|j| &bins[j]))
    };
    let saddle = |side: &mut dyn Iterator<Item = &f64>, height: f64| {
        side.take_while(|n| **n <= height).copied().fold(height, f64::min)
    };
    let prominence = |i: usize| {
        let left = saddle(&mut bins[..i].iter().rev(), bins[i]);
        let right = saddle(&mut bins[i + 1..].iter(), bins[i]);
        bins[i] - left.max(right)
    };
    (0..bins.len())
        .filter(|i| is_peak(*i))
        .map(|i| (i, prominence(i)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values as whole numbers, piled up about `centre` as the binomial distribution is.
    fn pile(centre: i32, spread: i32, count: usize) -> Vec<f32> {
        let mut state = 7u64;
        let mut coin = move || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 60) & 1
        };
        let value = |_| (0..2 * spread).map(|_| coin() as i32).sum::<i32>() - spread + centre;
        (0..count).map(value).map(|v| v as f32).collect()
    }

    #[test]
    fn the_modes_of_three_piles_are_their_middles() {
        let values = [pile(12, 8, 9000), pile(90, 20, 3000), pile(140, 20, 3500)].concat();
        let modes = Modes::of(&values, Interval::new(0.0, 200.0)).unwrap();
        // A bin is 1.6 wide; a pile of thousands is even to some hundredths of its spread.
        assert!((modes.background - 12.0).abs() < 2.0, "{modes:?}");
        assert!(
            (modes.tissues[0] - 90.0).abs() < 4.0 && (modes.tissues[1] - 140.0).abs() < 4.0,
            "{modes:?}"
        );
    }

    #[test]
    fn one_pile_has_no_two_tissues() {
        assert_eq!(Modes::of(&[3.0; 50], Interval::new(0.0, 10.0)), None);
        assert_eq!(Modes::of(&[3.0; 50], Interval::new(3.0, 3.0)), None);
    }
}
