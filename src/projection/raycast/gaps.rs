//! Where in a block nothing shows, and how far that goes.
//!
//! *Theory.* Empty space is leapt over by its distance to what is not (Zuiderveld, Koning and Viergever 1992).
//! *Practice.* A packet at a plane is no larger than a cell, so it meets at most two of them along each axis: it is asked for by the cell
//! of its lowest corner and by which axes it goes on to the next cell along. All is found when the transfer function changes, not in a
//! frame.

use glam::Vec3;

use super::shown::Cells;
use super::simd::{Simd, each, larger, smaller};

/// The farthest that distances are counted, in cells.
const FARTHEST: u8 = 31;

/// The cells of a block by what shows of them and of their neighbours.
pub struct Gaps {
    /// The low corner of the first cell, in stored voxels.
    begin: Vec3,
    /// Voxels along a cell's edge.
    edge: f32,
    dims: [usize; 3],
    /// Bit `s` of the low half of each cell's word says that something shows of this cell and of those next to it, upwards along the axes
    /// of which `s` has the bit, all together a box of one, two, four or eight. The high half says how many cells the box of eight can be
    /// moved along any axes without that anything shows in it, and one more; 0 if something does.
    cells: Vec<u16>,
}

impl Gaps {
    /// Those of `cells`.
    pub fn new(cells: &Cells) -> Self {
        let dims = cells.dims;
        let mut shown: Vec<u8> = cells.shown.iter().map(|shown| if *shown { u8::MAX } else { 0 }).collect();
        // The axes along which a box of cells goes on are the bits of its number.
        for (axis, goes_on) in [0b1010_1010, 0b1100_1100, 0b1111_0000].into_iter().enumerate() {
            spread(&mut shown, dims, axis, |here, next| here | next & goes_on, |here, _| here);
        }
        let free = free(&shown, dims);
        Self {
            begin: cells.begin.as_vec3(),
            edge: cells.edge as f32,
            dims,
            cells: shown.iter().zip(free).map(|(&shown, free)| u16::from_le_bytes([shown, free])).collect(),
        }
    }

    /// Between which of sixteen places `low` and `high`, stored voxels less than a cell apart, nothing shows, and how far each can be moved
    /// along all axes without that anything does, in voxels.
    #[inline(always)]
    pub fn free<S: Simd>(&self, low: &[S::Float; 3], high: &[S::Float; 3]) -> (S::Mask, S::Float) {
        let (mut at, mut goes_on, mut stride) = (S::int(0), S::int(0), 1);
        for axis in 0..3 {
            let [low, high] = each!(place of [low[axis], high[axis]] => self.cell::<S>(axis, place));
            at = at + low * S::int(stride);
            goes_on = goes_on + (high - low) * S::int(1 << axis);
            stride *= self.dims[axis] as i32;
        }
        let word = S::look_up(&self.cells, at);
        let shown = S::and(S::shift_right(word, goes_on), S::int(1));
        let voxels = S::to_float(S::shift_right(word, S::int(8))) * S::float(self.edge) - S::float(self.edge);
        (!S::greater_int(shown, S::int(0)), larger::<S>(voxels, S::float(0.0)))
    }

    /// The cells along an axis that places are in, or nearest to.
    #[inline(always)]
    fn cell<S: Simd>(&self, axis: usize, place: S::Float) -> S::Int {
        let cell = S::floor((place - S::float(self.begin[axis])) * S::float(1.0 / self.edge));
        let last = S::float((self.dims[axis] - 1) as f32);
        S::whole(larger::<S>(smaller::<S>(cell, last), S::float(0.0)))
    }
}

/// How many cells the box of eight at each cell can be moved, and one more: see [`Gaps::cells`].
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
