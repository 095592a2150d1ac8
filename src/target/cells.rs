//! Value ranges of a block's cells: what visibility is decided on.
//!
//! *Changes from the paper.* VCSG draws every block that the tree reaches. Here the conservative ranges prune too (design
//! §4): parts of a block that the transfer function makes invisible are not drawn, nor are those that others hide. Blocks stay as
//! large as their paths allow; only what is drawn of them is cut down.
//! *Practice.* Ranges are made axis after axis: of rows, then of planes, then along a row. Rows are long, so most of it is done for
//! many voxels side by side.

use rayon::prelude::*;

use super::{Block, BlockVoxels};
use crate::math::Interval;

/// Edge of a cell in voxels.
pub const CELL: usize = 4;

/// What a picture of each cell depends on: its own voxels and one more on each side.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellRanges {
    /// Cells along each axis.
    pub dims: [usize; 3],
    /// The covered values of each cell, x fastest; empty where nothing is.
    pub ranges: Vec<Interval>,
    /// Whether all of a cell's voxels are fully covered.
    pub covered: Vec<bool>,
}

impl CellRanges {
    /// The cells of a reconstructed block with at least one voxel of apron.
    pub fn new(block: &Block, voxels: &BlockVoxels) -> Self {
        let mut cells = Self::empty(block);
        let layers: Vec<Self> = (0..cells.dims[2])
            .into_par_iter()
            .map(|z| layer(block, voxels, z))
            .collect();
        layers.iter().for_each(|layer| cells.append(layer));
        cells
    }

    /// The cells of a block before any range is known: they are to be [appended](Self::append), slab by slab.
    pub fn empty(block: &Block) -> Self {
        Self {
            dims: block.extent.map(|n| n.div_ceil(CELL)),
            ..Self::default()
        }
    }

    /// One range for all cells of a block that stores one value.
    pub fn uniform(block: &Block) -> Self {
        let mut cells = Self::empty(block);
        let count = cells.dims.iter().product();
        cells.ranges = vec![block.range.value; count];
        cells.covered = vec![true; count];
        cells
    }

    /// Adds the cells of the slab that follows.
    pub fn append(&mut self, slab: &Self) {
        self.ranges.extend(&slab.ranges);
        self.covered.extend(&slab.covered);
    }

    /// The range of a cell.
    pub fn range(&self, cell: [usize; 3]) -> Interval {
        self.ranges[self.index(cell)]
    }

    /// The place of a cell among [`Self::ranges`].
    pub fn index(&self, cell: [usize; 3]) -> usize {
        cell[0] + self.dims[0] * (cell[1] + self.dims[1] * cell[2])
    }
}

/// The cells whose place along z is `z`.
fn layer(block: &Block, voxels: &BlockVoxels, z: usize) -> CellRanges {
    let mut cells = CellRanges::default();
    let mut ends = Ends::new(voxels.dims[0]);
    for y in 0..block.extent[1].div_ceil(CELL) {
        ends.clear();
        for k in voxels_of(block, voxels, 2, z) {
            for j in voxels_of(block, voxels, 1, y) {
                ends.add(voxels, voxels.dims[0] * (j + voxels.dims[1] * k));
            }
        }
        for x in 0..block.extent[0].div_ceil(CELL) {
            let (range, covered) = ends.of(voxels_of(block, voxels, 0, x));
            cells.ranges.push(range);
            cells.covered.push(covered);
        }
    }
    cells
}

/// The voxels, apron counted, that cell `cell` depends on along an axis.
fn voxels_of(block: &Block, voxels: &BlockVoxels, axis: usize, cell: usize) -> std::ops::Range<usize> {
    let before = voxels.apron - 1;
    let end = (cell * CELL + CELL).min(block.extent[axis]);
    cell * CELL + before..end + before + 2
}

/// The least and the greatest of several rows, voxel by voxel.
struct Ends {
    lo: Vec<f32>,
    hi: Vec<f32>,
    covered: Vec<bool>,
}

impl Ends {
    fn new(len: usize) -> Self {
        Self {
            lo: vec![0.0; len],
            hi: vec![0.0; len],
            covered: vec![true; len],
        }
    }

    fn clear(&mut self) {
        self.lo.fill(f32::INFINITY);
        self.hi.fill(f32::NEG_INFINITY);
        self.covered.fill(true);
    }

    /// Adds the row that begins at `begin`.
    fn add(&mut self, voxels: &BlockVoxels, begin: usize) {
        let row = begin..begin + self.lo.len();
        let values = &voxels.premultiplied[row.clone()];
        let ends = self.lo.iter_mut().zip(&mut self.hi);
        match &voxels.coverage {
            None => {
                for ((lo, hi), &v) in ends.zip(values) {
                    (*lo, *hi) = (lo.min(v), hi.max(v));
                }
            }
            Some(coverage) => {
                let coverage = &coverage[row];
                let covered = coverage.iter().zip(&mut self.covered);
                covered.for_each(|(c, covered)| *covered &= *c >= 1.0);
                for ((lo, hi), (&v, &c)) in ends.zip(values.iter().zip(coverage)).filter(|(_, (_, c))| **c > 0.0) {
                    (*lo, *hi) = (lo.min(v / c), hi.max(v / c));
                }
            }
        }
    }

    /// The range of some voxels, and whether they are covered.
    fn of(&self, part: std::ops::Range<usize>) -> (Interval, bool) {
        let lo = self.lo[part.clone()].iter().copied().fold(f32::INFINITY, f32::min);
        let hi = self.hi[part.clone()].iter().copied().fold(f32::NEG_INFINITY, f32::max);
        (Interval { lo, hi }, self.covered[part].iter().all(|covered| *covered))
    }
}
