//! The min/max pyramid: conservative value ranges over boxes.
//!
//! *Theory.* A trilinear sample lies between the smallest and the largest of the eight voxels round it, so the range of the
//! voxels that a box's samples can touch holds all of its samples.
//! *Practice.* A base cell holds the samples whose lower voxel is one of its 8³, and so covers 9³ voxels; a position in the
//! half voxel beyond the outermost centres is clamped to them and lies in the outermost cell. Each further level joins 2³
//! cells. A query reads one level: the finest on which the box spans at most [`SPAN`] cells an axis.

use rayon::prelude::*;

use super::typed::TypedBricks;
use crate::math::Interval;
use crate::volume::voxel::Voxel;

/// log₂ of a base cell's edge.
const BASE_SHIFT: u32 = 3;

/// The most cells that a query reads along an axis.
const SPAN: usize = 8;

/// Ranges of the voxels' `f32` values over boxes of voxels. NaN voxels are in none of them.
#[derive(Debug)]
pub(super) struct Pyramid {
    /// From the base (cells of 8³ sample positions) up to one cell.
    levels: Vec<Level>,
}

#[derive(Debug)]
struct Level {
    dims: [usize; 3],
    ranges: Vec<Interval>,
}

impl Pyramid {
    pub(super) fn new<T: Voxel>(bricks: &TypedBricks<T>) -> Self {
        let mut levels = vec![Level::base(bricks)];
        while let Some(above) = levels[levels.len() - 1].above() {
            levels.push(above);
        }
        Self { levels }
    }

    /// The range over everything.
    pub(super) fn root(&self) -> Interval {
        self.levels[self.levels.len() - 1].ranges[0]
    }

    /// The range of the voxels that samples can touch whose lower voxels are `first..=last`.
    pub(super) fn range(&self, first: [usize; 3], last: [usize; 3]) -> Interval {
        let cells = |shift: u32| (first.map(|i| i >> shift), last.map(|i| i >> shift));
        for (level, shift) in self.levels.iter().zip(BASE_SHIFT..) {
            let (lo, hi) = cells(shift);
            if (0..3).all(|a| hi[a] - lo[a] < SPAN) {
                return level.hull(lo, hi);
            }
        }
        self.root()
    }

    pub(super) fn bytes(&self) -> usize {
        let cells: usize = self.levels.iter().map(|l| l.ranges.len()).sum();
        cells * size_of::<Interval>()
    }
}

impl Level {
    fn base<T: Voxel>(bricks: &TypedBricks<T>) -> Self {
        let dims = bricks.dims().map(|n| ((n - 1) >> BASE_SHIFT) + 1);
        Self::from_fn(dims, |cell| bricks.cell_range(cell, 1 << BASE_SHIFT))
    }

    /// The level of half the resolution; `None` above a single cell.
    fn above(&self) -> Option<Self> {
        if self.dims == [1; 3] {
            return None;
        }
        let dims = self.dims.map(|n| n.div_ceil(2));
        Some(Self::from_fn(dims, |cell| {
            let lo = cell.map(|c| 2 * c);
            let hi = std::array::from_fn(|a| (lo[a] + 1).min(self.dims[a] - 1));
            self.hull(lo, hi)
        }))
    }

    fn from_fn(dims: [usize; 3], range: impl Fn([usize; 3]) -> Interval + Sync) -> Self {
        let [nx, ny, nz] = dims;
        let ranges = (0..nx * ny * nz)
            .into_par_iter()
            .map(|c| range([c % nx, c / nx % ny, c / (nx * ny)]))
            .collect();
        Self { dims, ranges }
    }

    /// The hull of the cells `lo..=hi`.
    fn hull(&self, lo: [usize; 3], hi: [usize; 3]) -> Interval {
        let mut hull = Interval::EMPTY;
        for k in lo[2]..=hi[2] {
            for j in lo[1]..=hi[1] {
                let row = (k * self.dims[1] + j) * self.dims[0];
                for range in &self.ranges[row + lo[0]..=row + hi[0]] {
                    hull = hull.hull(*range);
                }
            }
        }
        hull
    }
}
