//! The min/max pyramid: conservative value ranges over boxes.
//!
//! *Theory.* A trilinear sample lies between the smallest and the largest of the eight voxels round it, so the range of the
//! voxels that a box's samples can touch holds all of its samples.
//! *Practice.* A base cell holds the samples whose lower voxel is one of its 8³, and so covers 9³ voxels; a position in the
//! half voxel beyond the outermost centres is clamped to them and lies in the outermost cell. Each further level joins 2³
//! cells. The levels of cells smaller than a brick are kept for each brick that is not constant; those above are arrays. A query
//! reads one level: the finest on which the box spans at most [`SPAN`] cells an axis.

use rayon::prelude::*;

use super::ranges::{CELL_SHIFT as BASE_SHIFT, cell_ranges};
use super::typed::{Brick, EDGE, SHIFT, TypedBricks};
use crate::math::Interval;
use crate::volume::voxel::Voxel;

/// The most cells that a query reads along an axis.
const SPAN: usize = 8;

/// Ranges of the voxels' `f32` values over boxes of voxels. NaN voxels are in none of them.
#[derive(Debug)]
pub(super) struct Pyramid {
    /// The levels within a brick, for each; `None` where it is constant.
    within: Vec<Option<Box<Within>>>,
    /// From the bricks up to one cell.
    levels: Vec<Level>,
}

/// The ranges in a brick, level by level from the base on. Cells beyond the volume's end are empty.
#[derive(Debug)]
struct Within {
    base: [Interval; 64],
    joined: [Interval; 8],
}

#[derive(Debug)]
struct Level {
    dims: [usize; 3],
    ranges: Vec<Interval>,
}

impl Pyramid {
    /// Bytes for each constant brick, at least.
    pub const BYTES_OF_BRICK: usize = size_of::<Option<Box<Within>>>() + size_of::<Interval>();

    pub(super) fn new<T: Voxel>(bricks: &TypedBricks<T>) -> Self {
        let (within, ranges) = (0..bricks.count() as u64)
            .into_par_iter()
            .map(|index| match bricks.at(index) {
                Brick::Constant(v) => (None, Interval::point(v.to_f32()).hull(Interval::EMPTY)),
                Brick::Voxels(voxels) => {
                    let place = bricks.place(index);
                    let inside = std::array::from_fn(|a| bricks.dims()[a] - place[a] * EDGE);
                    let within = Within::new(voxels, inside);
                    let range = hull(within.joined);
                    (Some(Box::new(within)), range)
                }
            })
            .unzip();
        let dims = bricks.brick_dims();
        let mut levels = vec![Level { dims, ranges }];
        while let Some(above) = levels[levels.len() - 1].above() {
            levels.push(above);
        }
        Self { within, levels }
    }

    /// The range over everything.
    pub(super) fn root(&self) -> Interval {
        self.levels[self.levels.len() - 1].ranges[0]
    }

    /// The range of the voxels that samples can touch whose lower voxels are `first..=last`.
    pub(super) fn range(&self, first: [usize; 3], last: [usize; 3]) -> Interval {
        let cells = |shift: u32| (first.map(|i| i >> shift), last.map(|i| i >> shift));
        let is_near = |(lo, hi): &([usize; 3], [usize; 3])| (0..3).all(|a| hi[a] - lo[a] < SPAN);
        for shift in BASE_SHIFT..SHIFT {
            if let (lo, hi) = cells(shift)
                && is_near(&(lo, hi))
            {
                return self.hull_within(shift, lo, hi);
            }
        }
        for (level, shift) in self.levels.iter().zip(SHIFT..) {
            if let (lo, hi) = cells(shift)
                && is_near(&(lo, hi))
            {
                return level.hull(lo, hi);
            }
        }
        self.root()
    }

    /// The hull of the cells `lo..=hi` of edge 2 to the `shift`, smaller than a brick.
    fn hull_within(&self, shift: u32, lo: [usize; 3], hi: [usize; 3]) -> Interval {
        let bits = SHIFT - shift;
        let [first, last] = [lo, hi].map(|cell| cell.map(|c| c >> bits));
        if first == last {
            return self.hull_in(first, shift, lo, hi);
        }
        let mut hull = Interval::EMPTY;
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                for x in first[0]..=last[0] {
                    let brick = [x, y, z];
                    let start = brick.map(|b| b << bits);
                    let end = start.map(|s| s + (1 << bits) - 1);
                    let lo = std::array::from_fn(|a| lo[a].max(start[a]));
                    let hi = std::array::from_fn(|a| hi[a].min(end[a]));
                    hull = hull.hull(self.hull_in(brick, shift, lo, hi));
                }
            }
        }
        hull
    }

    /// The hull of the cells `lo..=hi` of edge 2 to the `shift`, all of them in one brick.
    #[inline(always)]
    fn hull_in(&self, brick: [usize; 3], shift: u32, lo: [usize; 3], hi: [usize; 3]) -> Interval {
        let index = self.levels[0].index(brick);
        let mask = (1 << (SHIFT - shift)) - 1;
        match &self.within[index] {
            None => self.levels[0].ranges[index],
            Some(within) => within.hull(shift, lo.map(|c| c & mask), hi.map(|c| c & mask)),
        }
    }

    pub(super) fn bytes(&self) -> usize {
        let cells: usize = self.levels.iter().map(|l| l.ranges.len()).sum();
        let within = self.within.iter().flatten().count() * size_of::<Within>();
        cells * size_of::<Interval>() + within + size_of_val(&*self.within)
    }
}

impl Within {
    /// The ranges of a brick of these `voxels`, of which so many along each axis lie in the volume.
    fn new<T: Voxel>(voxels: &[T], inside: [usize; 3]) -> Self {
        let base = cell_ranges(voxels, inside);
        let joined = std::array::from_fn(|n| {
            let lo = [n & 1, n >> 1 & 1, n >> 2].map(|c| 2 * c);
            hull_of(&base, 2, lo, lo.map(|c| c + 1))
        });
        Self { base, joined }
    }

    /// The hull of the cells `lo..=hi` of edge 2 to the `shift`.
    fn hull(&self, shift: u32, lo: [usize; 3], hi: [usize; 3]) -> Interval {
        match shift {
            BASE_SHIFT => hull_of(&self.base, 2, lo, hi),
            _ => hull_of(&self.joined, 1, lo, hi),
        }
    }
}

/// The hull of the cells `lo..=hi` of a cube of cells, 2 to the `bits` an axis.
fn hull_of(cells: &[Interval], bits: u32, lo: [usize; 3], hi: [usize; 3]) -> Interval {
    let mut all = Interval::EMPTY;
    for k in lo[2]..=hi[2] {
        for j in lo[1]..=hi[1] {
            let row = ((k << bits) + j) << bits;
            all = all.hull(hull(cells[row + lo[0]..=row + hi[0]].iter().copied()));
        }
    }
    all
}

fn hull(ranges: impl IntoIterator<Item = Interval>) -> Interval {
    ranges.into_iter().fold(Interval::EMPTY, Interval::hull)
}

impl Level {
    /// The level of half the resolution; `None` above a single cell.
    fn above(&self) -> Option<Self> {
        if self.dims == [1; 3] {
            return None;
        }
        let dims = self.dims.map(|n| n.div_ceil(2));
        let [nx, ny, nz] = dims;
        let join = |c: usize| {
            let lo = [c % nx, c / nx % ny, c / (nx * ny)].map(|c| 2 * c);
            let hi = std::array::from_fn(|a| (lo[a] + 1).min(self.dims[a] - 1));
            self.hull(lo, hi)
        };
        let ranges = (0..nx * ny * nz).into_par_iter().map(join).collect();
        Some(Self { dims, ranges })
    }

    /// Where a cell is among all.
    fn index(&self, cell: [usize; 3]) -> usize {
        (cell[2] * self.dims[1] + cell[1]) * self.dims[0] + cell[0]
    }

    /// The hull of the cells `lo..=hi`.
    fn hull(&self, lo: [usize; 3], hi: [usize; 3]) -> Interval {
        let mut all = Interval::EMPTY;
        for k in lo[2]..=hi[2] {
            for j in lo[1]..=hi[1] {
                let row = self.index([0, j, k]);
                all = all.hull(hull(self.ranges[row + lo[0]..=row + hi[0]].iter().copied()));
            }
        }
        all
    }
}
