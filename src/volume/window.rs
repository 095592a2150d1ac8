//! The values that matter in a scan, for an automatic window.
//!
//! *Theory.* A scan is objects in air. Otsu (A threshold selection method from gray-level histograms, 1979) splits values in
//! two classes so that the variance between them is largest; the upper class is the objects.
//! *Practice.* An even choice of at most 2¹⁸ finite voxels is sorted, so there are no bins for an outlier to spoil; the split
//! is sought between the permilles 1 and 999.

use super::grid::{Grid, Voxels};
use super::voxel::{Voxel, for_type};

/// The most voxels looked at.
const SAMPLES: usize = 1 << 18;

impl Grid {
    /// For each fraction in `[0, 1]` the value that this part of the foreground's voxels does not exceed; the foreground is
    /// what lies above the air, or everything where no two classes can be told apart. `None` without finite voxels.
    pub fn foreground_percentiles<const N: usize>(&self, fractions: [f64; N]) -> Option<[f64; N]> {
        let values = for_type!(Voxels, self.voxels(), v => sorted_choice(v));
        let foreground = &values[otsu_split(&values)..];
        let last = foreground.len().checked_sub(1)?;
        Some(fractions.map(|f| foreground[(f.clamp(0.0, 1.0) * last as f64).round() as usize]))
    }
}

/// An even choice of the finite voxels, sorted. The stride is odd, so that it does not stay on a few columns of a grid whose
/// sides are powers of two.
fn sorted_choice<T: Voxel>(voxels: &[T]) -> Vec<f64> {
    let stride = voxels.len().div_ceil(SAMPLES) | 1;
    let chosen = voxels.iter().step_by(stride).map(|v| v.to_f64());
    let mut values: Vec<f64> = chosen.filter(|v| v.is_finite()).collect();
    values.sort_unstable_by(f64::total_cmp);
    values
}

/// Where the upper class starts in sorted values: at 0 when all are equal.
fn otsu_split(values: &[f64]) -> usize {
    let trim = values.len() / 1000;
    let middle = &values[trim..values.len() - trim];
    let total: f64 = middle.iter().sum();
    let (mut below, mut best, mut split) = (0.0, 0.0, 0);
    for i in 1..middle.len() {
        below += middle[i - 1];
        if middle[i - 1] == middle[i] {
            continue;
        }
        let (n, m) = (i as f64, (middle.len() - i) as f64);
        let apart = (total - below) / m - below / n;
        let variance = n * m * apart * apart;
        if variance > best {
            (best, split) = (variance, trim + i);
        }
    }
    split
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;

    fn percentiles(voxels: Vec<f32>) -> Option<[f64; 3]> {
        let grid = Grid::new(
            [voxels.len(), 1, 1],
            DAffine3::IDENTITY,
            Voxels::F32(voxels),
        );
        grid.unwrap().foreground_percentiles([0.0, 0.5, 1.0])
    }

    #[test]
    fn air_is_left_out() {
        let voxels = (0..9000).map(|i| match i % 3 {
            0 => 100.0 + (i % 101) as f32,
            _ => (i % 7) as f32,
        });
        assert_eq!(percentiles(voxels.collect()), Some([100.0, 150.0, 200.0]));
    }

    #[test]
    fn one_outlier_changes_little() {
        let mut voxels: Vec<f32> = (0..9000).map(|i| (i % 2 * 100) as f32).collect();
        voxels[0] = 1e30;
        let [low, middle, _] = percentiles(voxels).unwrap();
        assert_eq!([low, middle], [100.0, 100.0]);
    }

    #[test]
    fn equal_voxels_are_foreground_and_none_is_none() {
        assert_eq!(percentiles(vec![5.0; 10]), Some([5.0; 3]));
        assert_eq!(percentiles(vec![f32::NAN; 10]), None);
    }
}
