//! Slices of voxels, and the neighbours of a voxel (LC87 §4, equations 2–4).

use std::ops::Range;

use crate::volume::Voxel;

/// Consecutive slices of a lattice of voxels, x fastest.
#[derive(Clone, Copy)]
pub(super) struct Slices<'a, T> {
    /// The voxels of the slices from `first_slice` on.
    pub voxels: &'a [T],
    pub first_slice: usize,
    /// Voxels along each axis of the whole lattice.
    pub dims: [usize; 3],
}

impl<'a, T: Voxel> Slices<'a, T> {
    /// The slices that are there.
    pub fn held(&self) -> Range<usize> {
        self.first_slice..self.first_slice + self.voxels.len() / (self.dims[0] * self.dims[1])
    }

    /// The voxels of slice `k`.
    pub fn slice(&self, k: usize) -> &'a [T] {
        let plane = self.dims[0] * self.dims[1];
        &self.voxels[(k - self.first_slice) * plane..][..plane]
    }

    /// The voxel `index` of the lattice.
    #[inline(always)]
    pub fn value(&self, [i, j, k]: [usize; 3]) -> f64 {
        self.row(j, k)[i].to_f64()
    }

    /// Whether the voxels next to `index` along the axes are all finite.
    pub fn has_finite_neighbours(&self, index: [usize; 3]) -> bool {
        (0..3).all(|axis| {
            let (mut before, mut after) = (index, index);
            before[axis] = before[axis].saturating_sub(1);
            after[axis] = (after[axis] + 1).min(self.dims[axis] - 1);
            self.value(before).is_finite() && self.value(after).is_finite()
        })
    }

    /// Row `j` of slice `k`.
    #[inline(always)]
    pub fn row(&self, j: usize, k: usize) -> &'a [T] {
        let width = self.dims[0];
        &self.voxels[width * (j + self.dims[1] * (k - self.first_slice))..][..width]
    }

    /// The rows round row `j` of slice `k`.
    #[inline(always)]
    pub fn round(&self, j: usize, k: usize) -> RowsRound<'a, T> {
        let [_, ny, nz] = self.dims;
        let (down, up, up2) = (j.saturating_sub(1), (j + 1).min(ny - 1), (j + 2).min(ny - 1));
        let (below, above, above2) = (k.saturating_sub(1), (k + 1).min(nz - 1), (k + 2).min(nz - 1));
        RowsRound {
            here: [self.row(down, k), self.row(j, k), self.row(up, k), self.row(up2, k)],
            below: [self.row(j, below), self.row(up, below)],
            above: [self.row(down, above), self.row(j, above), self.row(up, above)],
            above2: self.row(j, above2),
        }
    }
}

/// The rows that hold the ends of edges from a row, and the neighbours of these. Where the lattice ends its last row takes the
/// place of those beyond.
#[derive(Clone, Copy)]
pub(super) struct RowsRound<'a, T> {
    /// In the same slice: the row before, the row, the next and the one after it.
    here: [&'a [T]; 4],
    /// In the slice below: the row and the next.
    below: [&'a [T]; 2],
    /// In the slice above: the row before, the row and the next.
    above: [&'a [T]; 3],
    /// Two slices above: the row.
    above2: &'a [T],
}

/// A voxel, and its neighbours in x, y and z: before and after.
pub(super) type Neighbourhood<T> = [T; 7];

/// Places in a [`Neighbourhood`]: the voxel.
pub(super) const HERE: usize = 0;

/// Places in a [`Neighbourhood`]: the neighbours on each axis.
pub(super) const NEIGHBOURS: [[usize; 2]; 3] = [[1, 2], [3, 4], [5, 6]];

impl<T: Voxel> RowsRound<'_, T> {
    /// The two ends of the edge along `AXIS` from voxel `i` of the row; twice that voxel if there is no such axis. At the border
    /// of the lattice a voxel is its own neighbour.
    #[inline(always)]
    pub fn ends<const AXIS: usize>(&self, i: usize) -> [Neighbourhood<T>; 2] {
        let [down, here, up, up2] = self.here;
        let [below, below_up] = self.below;
        let [above_down, above, above_up] = self.above;
        let width = here.len();
        let (before, next) = (i.saturating_sub(1), (i + 1).min(width - 1));
        let end = |at: usize, x: [usize; 2], row: &[T], y: [&[T]; 2], z: [&[T]; 2]| {
            [row[at], row[x[0]], row[x[1]], y[0][at], y[1][at], z[0][at], z[1][at]]
        };
        let from = end(i, [before, next], here, [down, up], [below, above]);
        let to = match AXIS {
            0 => end(next, [i, (i + 2).min(width - 1)], here, [down, up], [below, above]),
            1 => end(i, [before, next], up, [here, up2], [below_up, above_up]),
            2 => end(i, [before, next], above, [above_down, above_up], [here, self.above2]),
            _ => from,
        };
        [from, to]
    }
}
