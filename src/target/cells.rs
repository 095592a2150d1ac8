//! Value ranges of a block's cells: what visibility is decided on.
//!
//! *Changes from the paper.* VCSG draws every block that the tree reaches. Here the conservative ranges prune too (design
//! §4): parts of a block that the transfer function makes invisible are not drawn, nor are those that others hide. Blocks stay as
//! large as their paths allow; only what is drawn of them is cut down.
//! *Practice.* Cells lie at multiples of their edge on the lattice's grid, as cubes do, and so may be cut by the lattice. Ranges are made axis after axis: of rows, then of planes, then along a row. Rows are long, so most of it is done for
//! many voxels side by side.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::{Block, BlockVoxels, Lattice, VoxelBox};
use crate::math::Interval;

/// Edge of a cell in voxels.
pub const CELL: usize = 4;

/// What a picture of each cell depends on: its own voxels and one more on each side.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellRanges {
    /// The first cell's place among those of the grid.
    pub first: [i64; 3],
    /// Cells along each axis.
    pub dims: [usize; 3],
    /// The covered values of each cell, x fastest; empty where nothing is.
    pub ranges: Vec<Interval>,
    /// Whether all of a cell's voxels are fully covered.
    pub covered: Vec<bool>,
}

impl CellRanges {
    /// The cells of a reconstructed block with at least one voxel of apron.
    pub fn new(lattice: &Lattice, block: &Block, voxels: &BlockVoxels) -> Self {
        let mut cells = Self::empty(lattice, &block.voxels());
        let parts = [0, 1, 2].map(|axis| cells.voxels_along(axis, lattice, block));
        let [x, y, z] = parts.map(|parts| parts.map(|part| with_neighbours(part, voxels)).collect::<Vec<_>>());
        let layers: Vec<Self> = z.into_par_iter().map(|z| layer(voxels, [&x, &y], z)).collect();
        layers.iter().for_each(|layer| cells.append(layer));
        cells
    }

    /// The cells of some voxels before any range is known: they are to be [appended](Self::append), slab by slab.
    pub fn empty(lattice: &Lattice, voxels: &VoxelBox) -> Self {
        let [first, dims] = on_grid(lattice, voxels);
        Self {
            first,
            dims: dims.map(|n| n as usize),
            ..Self::default()
        }
    }

    /// One range for all cells of a block that stores one value.
    pub fn uniform(lattice: &Lattice, block: &Block) -> Self {
        let mut cells = Self::empty(lattice, &block.voxels());
        let count = cells.dims.iter().product();
        cells.ranges = vec![block.range.value; count];
        cells.covered = vec![true; count];
        cells
    }

    /// The corner from which the cells go on, in lattice coordinates.
    pub fn begin(&self, lattice: &Lattice) -> DVec3 {
        let voxel = |a: usize| self.first[a] * CELL as i64 - lattice.first()[a];
        DVec3::from_array([0, 1, 2].map(|a| voxel(a) as f64)) - 0.5
    }

    /// The cells along each axis that some voxels of the block lie in.
    pub fn meeting(&self, lattice: &Lattice, voxels: &VoxelBox) -> [Range<usize>; 3] {
        let [first, dims] = on_grid(lattice, voxels);
        std::array::from_fn(|a| {
            let begin = (first[a] - self.first[a]) as usize;
            begin..begin + dims[a] as usize
        })
    }

    /// The voxels of the block in each cell along an axis.
    fn voxels_along<'a>(
        &self,
        axis: usize,
        lattice: &Lattice,
        block: &'a Block,
    ) -> impl Iterator<Item = Range<usize>> + use<'a> {
        let begin = self.first[axis] * CELL as i64 - lattice.first()[axis] - block.origin[axis] as i64;
        let extent = block.extent[axis] as i64;
        let within = move |at: i64| at.clamp(0, extent) as usize;
        let begins = (0..self.dims[axis] as i64).map(move |n| begin + n * CELL as i64);
        begins.map(move |begin| within(begin)..within(begin + CELL as i64))
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

/// The cells of the grid that some voxels lie in: the first, and how many along each axis.
fn on_grid(lattice: &Lattice, voxels: &VoxelBox) -> [[i64; 3]; 2] {
    let ends = |a: usize| {
        let begin = lattice.first()[a] + voxels.origin[a] as i64;
        [begin, begin + voxels.extent[a] as i64 - 1].map(|n| n.div_euclid(CELL as i64))
    };
    let ends = [ends(0), ends(1), ends(2)];
    [ends.map(|[first, _]| first), ends.map(|[first, last]| last - first + 1)]
}

/// Some voxels of a block along an axis and one more on each side, apron counted.
fn with_neighbours(part: Range<usize>, voxels: &BlockVoxels) -> Range<usize> {
    let before = voxels.apron - 1;
    part.start + before..part.end + before + 2
}

/// The cells in planes `z`, which along x and y have these voxels.
fn layer(voxels: &BlockVoxels, [x, y]: [&[Range<usize>]; 2], z: Range<usize>) -> CellRanges {
    let mut cells = CellRanges::default();
    let mut ends = Ends::new(voxels.dims[0]);
    for rows in y {
        ends.clear();
        for k in z.clone() {
            for j in rows.clone() {
                ends.add(voxels, voxels.dims[0] * (j + voxels.dims[1] * k));
            }
        }
        for columns in x {
            let (range, covered) = ends.of(columns.clone());
            cells.ranges.push(range);
            cells.covered.push(covered);
        }
    }
    cells
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
    fn of(&self, part: Range<usize>) -> (Interval, bool) {
        let lo = self.lo[part.clone()].iter().copied().fold(f32::INFINITY, f32::min);
        let hi = self.hi[part.clone()].iter().copied().fold(f32::NEG_INFINITY, f32::max);
        (Interval { lo, hi }, self.covered[part].iter().all(|covered| *covered))
    }
}
