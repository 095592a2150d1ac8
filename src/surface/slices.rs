//! Slices of voxels, and where the neighbours of a voxel are (LC87 §4, equations 2–4).

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

    /// The place of the first voxel of slice `k` among those held.
    pub fn first_voxel(&self, k: usize) -> usize {
        (k - self.first_slice) * self.dims[0] * self.dims[1]
    }
}

/// Places in [`EdgeSteps`]: the voxel at an end of an edge.
pub(super) const HERE: usize = 0;

/// Places in [`EdgeSteps`]: the lower and the upper neighbour of that voxel on each axis.
pub(super) const NEIGHBOURS: [[usize; 2]; 3] = [[1, 2], [3, 4], [5, 6]];

/// For both ends of an edge, the steps in memory from the voxel that the edge starts from to the end and its neighbours.
pub(super) type EdgeSteps = [[isize; 7]; 2];

/// The steps for edges along `axis`, or for voxels if there is no such axis, that start from row `j` of slice `k` of a lattice
/// of `dims`. At the lattice's border an end is its own neighbour, but in x, as if that had no border.
pub(super) fn edge_steps(dims: [usize; 3], axis: usize, [j, k]: [usize; 2]) -> EdgeSteps {
    let strides = [1, dims[0], dims[0] * dims[1]].map(|stride| stride as isize);
    [0, 1].map(|end| {
        let mut steps = [0; 7];
        let mut at = [0, j, k];
        if end == 1 && axis < 3 {
            at[axis] += 1;
            steps[HERE] = strides[axis];
        }
        for (axis, [lower, upper]) in NEIGHBOURS.into_iter().enumerate() {
            let (is_first, is_last) = (at[axis] == 0, at[axis] + 1 >= dims[axis]);
            steps[lower] = steps[HERE] - if is_first && axis > 0 { 0 } else { strides[axis] };
            steps[upper] = steps[HERE] + if is_last && axis > 0 { 0 } else { strides[axis] };
        }
        steps
    })
}
