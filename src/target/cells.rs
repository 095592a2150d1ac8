//! Value ranges of a block's cells: what visibility is decided on.
//!
//! *Changes from the paper.* VCSG draws every block that the tree reaches. Here the conservative ranges prune too (design
//! §4): parts of a block that the transfer function makes invisible are not drawn. Blocks stay as large as their paths allow;
//! only what is drawn of them is cut down.

use rayon::prelude::*;

use super::{Block, BlockVoxels};
use crate::math::Interval;

/// Edge of a cell in voxels.
pub const CELL: usize = 8;

/// The ranges of the covered values that a picture of each cell depends on: its own voxels and one more on each side.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellRanges {
    /// Cells along each axis.
    pub dims: [usize; 3],
    /// Range of each cell, x fastest; empty where nothing is.
    pub ranges: Vec<Interval>,
}

impl CellRanges {
    /// The cells of a reconstructed block with at least one voxel of apron.
    pub fn new(block: &Block, voxels: &BlockVoxels) -> Self {
        let dims = block.extent.map(|n| n.div_ceil(CELL));
        let ranges = (0..dims.iter().product())
            .into_par_iter()
            .map(|n| {
                let cell = [n % dims[0], n / dims[0] % dims[1], n / (dims[0] * dims[1])];
                cell_range(block, voxels, cell)
            })
            .collect();
        Self { dims, ranges }
    }

    /// The cells of a block before any range is known: [`Self::ranges`] is to be filled, slab by slab.
    pub fn empty(block: &Block) -> Self {
        Self {
            dims: block.extent.map(|n| n.div_ceil(CELL)),
            ranges: Vec::new(),
        }
    }

    /// One range for all cells of a block that stores one value.
    pub fn uniform(block: &Block) -> Self {
        let dims = block.extent.map(|n| n.div_ceil(CELL));
        Self {
            dims,
            ranges: vec![block.range.value; dims.iter().product()],
        }
    }

    /// The range of a cell.
    pub fn range(&self, cell: [usize; 3]) -> Interval {
        self.ranges[cell[0] + self.dims[0] * (cell[1] + self.dims[1] * cell[2])]
    }
}

fn cell_range(block: &Block, voxels: &BlockVoxels, cell: [usize; 3]) -> Interval {
    let before = voxels.apron - 1;
    let first: [usize; 3] = cell.map(|c| c * CELL + before);
    let last: [usize; 3] = std::array::from_fn(|a| (cell[a] * CELL + CELL).min(block.extent[a]) + before + 2);
    let mut range = Interval::EMPTY;
    for k in first[2]..last[2] {
        for j in first[1]..last[1] {
            let row = voxels.dims[0] * (j + voxels.dims[1] * k);
            range = range.hull(row_range(voxels, row + first[0]..row + last[0]));
        }
    }
    range
}

fn row_range(voxels: &BlockVoxels, part: std::ops::Range<usize>) -> Interval {
    let values = &voxels.premultiplied[part.clone()];
    match &voxels.coverage {
        None => values.iter().fold(Interval::EMPTY, |r, &v| r.hull(Interval::point(v))),
        Some(coverage) => values
            .iter()
            .zip(&coverage[part])
            .filter(|(_, c)| **c > 0.0)
            .fold(Interval::EMPTY, |r, (v, c)| r.hull(Interval::point(v / c))),
    }
}
