//! The ranges of values in the cells of a brick.
//!
//! *Practice.* The rows of a row of cells are joined first, all along x at a time, which a processor does for many voxels at once; only
//! then what is in each cell. Rows that two cells share are read twice.

use super::typed::{EDGE, Y_STRIDE, Z_STRIDE};
use crate::math::Interval;
use crate::volume::voxel::Voxel;

/// log₂ of a cell's edge.
pub(super) const CELL_SHIFT: u32 = 3;

/// A cell's edge.
const CELL: usize = 1 << CELL_SHIFT;

/// Cells along a brick's edge.
const CELLS: usize = EDGE / CELL;

/// The smallest and the largest of each voxel of a row and of those of other rows. NaN is none of them.
struct Extremes<T> {
    lo: [T; Y_STRIDE],
    hi: [T; Y_STRIDE],
}

impl<T: Voxel> Extremes<T> {
    fn none() -> Self {
        Self {
            lo: [T::nearest(f64::INFINITY); Y_STRIDE],
            hi: [T::nearest(f64::NEG_INFINITY); Y_STRIDE],
        }
    }

    #[inline(always)]
    fn join(&mut self, row: &[T]) {
        for ((lo, hi), v) in self.lo.iter_mut().zip(&mut self.hi).zip(row) {
            *lo = if *v < *lo { *v } else { *lo };
            *hi = if *v > *hi { *v } else { *hi };
        }
    }

    /// The range in the cell at place `x`.
    fn range(&self, x: usize) -> Interval {
        let cell = x * CELL..=(x + 1) * CELL;
        let ends = self.lo[cell.clone()].iter().zip(&self.hi[cell]);
        let none = (T::nearest(f64::INFINITY), T::nearest(f64::NEG_INFINITY));
        let (lo, hi) = ends.fold(none, |(lo, hi), (l, h)| {
            (if *l < lo { *l } else { lo }, if *h > hi { *h } else { hi })
        });
        match lo <= hi {
            true => Interval {
                lo: lo.to_f32(),
                hi: hi.to_f32(),
            },
            false => Interval::EMPTY,
        }
    }
}

/// The ranges of the cells of 8³ voxels, and of those behind them, of a brick of these `voxels`, of which so many along each axis lie in
/// the volume. Cells beyond its end are empty.
pub(super) fn cell_ranges<T: Voxel>(voxels: &[T], inside: [usize; 3]) -> [Interval; CELLS * CELLS * CELLS] {
    let mut ranges = [Interval::EMPTY; CELLS * CELLS * CELLS];
    let cells = inside.map(|n| n.div_ceil(CELL).min(CELLS));
    for (z, y) in (0..cells[2]).flat_map(|z| (0..cells[1]).map(move |y| (z, y))) {
        let mut extremes = Extremes::none();
        for plane in voxels.chunks_exact(Z_STRIDE).skip(z * CELL).take(CELL + 1) {
            let rows = &plane[y * CELL * Y_STRIDE..][..(CELL + 1) * Y_STRIDE];
            rows.chunks_exact(Y_STRIDE).for_each(|row| extremes.join(row));
        }
        for x in 0..cells[0] {
            ranges[(z * CELLS + y) * CELLS + x] = extremes.range(x);
        }
    }
    ranges
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The range of the cell at place `c`, voxel by voxel.
    fn slow_range(voxels: &[f32], inside: [usize; 3], c: [usize; 3]) -> Interval {
        let mut range = Interval::EMPTY;
        if (0..3).any(|a| c[a] * CELL >= inside[a]) {
            return range;
        }
        let planes = voxels.len() / Z_STRIDE;
        for k in (c[2] * CELL..=(c[2] + 1) * CELL).filter(|k| *k < planes) {
            for j in c[1] * CELL..=(c[1] + 1) * CELL {
                for i in c[0] * CELL..=(c[0] + 1) * CELL {
                    range = range.hull(Interval::point(voxels[k * Z_STRIDE + j * Y_STRIDE + i]));
                }
            }
        }
        range
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        #[test]
        fn ranges_are_those_of_each_cell_voxel_by_voxel(
            inside in [1usize..70, 1usize..70, 1usize..70], seed: u32, missing in prop_oneof![Just(0), Just(2), Just(1000)],
        ) {
            let mut state = seed;
            let voxels: Vec<f32> = (0..Z_STRIDE * (inside[2].min(EDGE) + 1)).map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                if (state >> 16) % 1001 < missing { f32::NAN } else { (state >> 8) as f32 - 8e6 }
            }).collect();
            let fast = cell_ranges(&voxels, inside);
            for (n, range) in fast.iter().enumerate() {
                let slow = slow_range(&voxels, inside, [n & 3, n >> 2 & 3, n >> 4]);
                prop_assert_eq!(*range, slow, "{}", n);
            }
        }
    }
}
