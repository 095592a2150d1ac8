//! Where in a block nothing shows, and how far that goes.
//!
//! *Theory.* Empty space is leapt over by its distance to what is not (Zuiderveld, Koning and Viergever 1992).
//! *Practice.* A packet at a plane is no larger than a cell, so it meets at most two of them along each axis: it is asked for by the cell
//! of its lowest corner and by which axes it goes on to the next cell along. All is found when the transfer function changes, not in a
//! frame.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::voxels::CastTarget;
use crate::math::Aabb;
use crate::projection::VisibleValues;
use crate::target::{Block, CELL, CellRanges, Lattice, Target};

/// The farthest that distances are counted, in cells.
const FARTHEST: u8 = 15;

/// What shows of a block.
pub struct ShownBlock {
    /// The box of all that shows, in lattice coordinates.
    pub bounds: Aabb,
    /// Where in it nothing does.
    pub gaps: Gaps,
}

impl ShownBlock {
    /// What shows of each block of a target if `values` do; `None` of a block of which nothing does. Packets are at most as large as a cell
    /// times `2^level`.
    pub fn all(target: &Target, cast: &CastTarget, values: &VisibleValues, level: u32) -> Vec<Option<Self>> {
        let blocks = target.blocks.par_iter().zip(&cast.cells).zip(&cast.blocks);
        let new = |((block, cells), stored): ((&Block, &CellRanges), _)| {
            let stored: &super::voxels::CastBlock = stored;
            Self::new(&target.lattice, block, cells, DVec3::from_array(stored.first.map(f64::from)), values, level)
        };
        blocks.map(new).collect()
    }

    fn new(
        lattice: &Lattice,
        block: &Block,
        cells: &CellRanges,
        stored_from: DVec3,
        values: &VisibleValues,
        level: u32,
    ) -> Option<Self> {
        let shown: Vec<bool> = cells.ranges.iter().map(|range| values.any_in(*range)).collect();
        let bounds = extent(&shown, cells.dims)?;
        let begin = cells.begin(lattice);
        let corner = |n: [usize; 3]| begin + CELL as f64 * DVec3::from_array(n.map(|n| n as f64));
        Some(Self {
            bounds: Aabb::new(corner(bounds[0]), corner(bounds[1])).intersect(&block.bounds()),
            gaps: Gaps::new(&shown, cells.dims, level, (begin - stored_from).as_vec3()),
        })
    }
}

/// The first of the cells that show along each axis, and one behind the last; `None` if none does.
fn extent(shown: &[bool], dims: [usize; 3]) -> Option<[[usize; 3]; 2]> {
    let (mut first, mut end) = (dims, [0; 3]);
    for n in (0..shown.len()).filter(|n| shown[*n]) {
        let cell = [n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]];
        for axis in 0..3 {
            first[axis] = first[axis].min(cell[axis]);
            end[axis] = end[axis].max(cell[axis] + 1);
        }
    }
    (end != [0; 3]).then_some([first, end])
}

/// The cells of a block by what shows of them and of their neighbours.
pub struct Gaps {
    /// The low corner of the first cell, in stored voxels.
    begin: Vec3,
    /// Voxels along a cell's edge.
    edge: f32,
    dims: [usize; 3],
    cells: Vec<Cell>,
}

#[derive(Clone, Copy, Default)]
struct Cell {
    /// Bit `s` says that something shows of this cell and of those next to it, upwards along the axes of which `s` has the bit, all
    /// together a box of one, two, four or eight.
    shown: u8,
    /// How many cells the box of eight can be moved along any axes without that anything shows in it, and one more; 0 if something does.
    free: u8,
}

impl Gaps {
    /// Of cells of which `all` says whether anything shows, the first of which begins at `begin`, in stored voxels; `2^level` of them along
    /// each axis are taken for one.
    fn new(all: &[bool], all_dims: [usize; 3], level: u32, begin: Vec3) -> Self {
        let dims = all_dims.map(|n| n.div_ceil(1 << level));
        let mut shown = vec![0u8; dims.iter().product()];
        let [width, height, _] = all_dims;
        for (row, all) in all.chunks_exact(width.max(1)).enumerate() {
            let (y, z) = (row % height >> level, row / height >> level);
            let cells = &mut shown[dims[0] * (y + dims[1] * z)..][..dims[0]];
            for (x, one) in all.iter().enumerate() {
                cells[x >> level] |= if *one { u8::MAX } else { 0 };
            }
        }
        // The axes along which a box of cells goes on are the bits of its number.
        for (axis, goes_on) in [0b1010_1010, 0b1100_1100, 0b1111_0000].into_iter().enumerate() {
            spread(&mut shown, dims, axis, |here, next| here | next & goes_on, |here, _| here);
        }
        let free = free(&shown, dims);
        Self {
            begin,
            edge: (CELL << level) as f32,
            dims,
            cells: shown.iter().zip(free).map(|(&shown, free)| Cell { shown, free }).collect(),
        }
    }

    /// How far what is between `low` and `high`, stored voxels less than a cell apart, can be moved along each axis, in voxels, without
    /// that anything shows in it; `None` if something may.
    #[inline(always)]
    pub fn free(&self, low: [f32; 3], high: [f32; 3]) -> Option<f32> {
        let (mut at, mut goes_on, mut stride) = (0, 0, 1);
        for axis in 0..3 {
            let last = self.dims[axis] as f32 - 1.0;
            let cell = |place: f32| ((place - self.begin[axis]) / self.edge).floor().clamp(0.0, last) as u32 as usize;
            let [low, high] = [cell(low[axis]), cell(high[axis])];
            at += low * stride;
            goes_on |= usize::from(high > low) << axis;
            stride *= self.dims[axis];
        }
        let cell = self.cells[at];
        (cell.shown >> goes_on & 1 == 0).then(|| self.edge * f32::from(cell.free.saturating_sub(1)))
    }
}

/// How many cells the box of eight at each cell can be moved, and one more: see [`Cell::free`].
fn free(shown: &[u8], dims: [usize; 3]) -> Vec<u8> {
    let mut near: Vec<u8> = shown.iter().map(|shown| shown >> 7).collect();
    let mut free = vec![0; shown.len()];
    for _ in 0..FARTHEST {
        if near.iter().all(|near| *near == 1) {
            break;
        }
        free.iter_mut().zip(&near).for_each(|(free, near)| *free += 1 - near);
        for axis in 0..3 {
            spread(&mut near, dims, axis, |here, next| here | next, |here, before| here | before);
        }
    }
    free
}

/// Changes each cell by the next one along an axis, and by the one before.
fn spread(
    cells: &mut [u8],
    dims: [usize; 3],
    axis: usize,
    by_next: impl Fn(u8, u8) -> u8,
    by_before: impl Fn(u8, u8) -> u8,
) {
    let stride: usize = dims[..axis].iter().product();
    let line = stride * dims[axis];
    let mut old = vec![0; line];
    for cells in cells.chunks_exact_mut(line.max(1)) {
        old.copy_from_slice(cells);
        let (low, high) = (line - stride, stride);
        for (here, next) in cells[..low].iter_mut().zip(&old[high..]) {
            *here = by_next(*here, *next);
        }
        for (here, before) in cells[high..].iter_mut().zip(&old[..low]) {
            *here = by_before(*here, *before);
        }
    }
}
