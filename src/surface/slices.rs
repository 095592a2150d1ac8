//! Rows of voxels and the differences between them (LC87 §4, equations 2–4).

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

    #[inline(always)]
    fn row(&self, j: usize, k: usize) -> &'a [T] {
        let width = self.dims[0];
        &self.voxels[width * (j + self.dims[1] * (k - self.first_slice))..][..width]
    }

    /// The rows that the edges along `axis` which start in row `j` of slice `k` lead from and to. Beyond the lattice's
    /// border, where there are no edges, and on voxels, which are no axis, it is the same row twice.
    #[inline(always)]
    pub fn ends(&self, axis: usize, j: usize, k: usize) -> [Stencil<'a, T>; 2] {
        let [_, ny, nz] = self.dims;
        let to = match axis {
            0 => [j, k],
            1 => [(j + 1).min(ny - 1), k],
            2 => [j, (k + 1).min(nz - 1)],
            _ => [j, k],
        };
        [self.stencil(j, k), self.stencil(to[0], to[1])]
    }

    #[inline(always)]
    fn stencil(&self, j: usize, k: usize) -> Stencil<'a, T> {
        let [_, ny, nz] = self.dims;
        let (down, up) = (j.saturating_sub(1), (j + 1).min(ny - 1));
        let (below, above) = (k.saturating_sub(1), (k + 1).min(nz - 1));
        Stencil {
            here: self.row(j, k),
            y: [self.row(down, k), self.row(up, k)],
            z: [self.row(j, below), self.row(j, above)],
            scale: [1.0 / (up - down).max(1) as f64, 1.0 / (above - below).max(1) as f64],
        }
    }
}

/// A row of voxels with its neighbours: itself again where the lattice ends.
#[derive(Clone, Copy)]
pub(super) struct Stencil<'a, T> {
    here: &'a [T],
    y: [&'a [T]; 2],
    z: [&'a [T]; 2],
    /// What differences in y and z are multiplied by: one over the rows or slices between the neighbours.
    pub scale: [f64; 2],
}

/// Places in a [`Stencil::values`].
pub(super) const HERE: usize = 0;

/// The lower and the upper neighbour on each axis in a [`Stencil::values`].
pub(super) const NEIGHBOURS: [[usize; 2]; 3] = [[1, 2], [3, 4], [5, 6]];

impl<T: Voxel> Stencil<'_, T> {
    /// Voxel `i` and its neighbours, and what their difference in x is multiplied by.
    #[inline(always)]
    pub fn values(&self, i: usize) -> ([T; 7], f64) {
        let last = self.here.len() - 1;
        let (before, after) = (i.saturating_sub(1), (i + 1).min(last));
        let values = [
            self.here[i],
            self.here[before],
            self.here[after],
            self.y[0][i],
            self.y[1][i],
            self.z[0][i],
            self.z[1][i],
        ];
        (values, if after - before == 2 { 0.5 } else { 1.0 })
    }
}
