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
        let mut shown: Vec<u8> = cells
            .shown
            .iter()
            .map(|shown| if *shown { u8::MAX } else { 0 })
            .collect();
        // The axes along which a box of cells goes on are the bits of its number.
        for (axis, goes_on) in [0b1010_1010, 0b1100_1100, 0b1111_0000].into_iter().enumerate() {
            spread(
                &mut shown,
                dims,
                axis,
                |here, next| here | next & goes_on,
                |here, _| here,
            );
        }
        let free = free(&shown, dims);
        Self {
            begin: cells.begin.as_vec3(),
            edge: cells.edge as f32,
            dims,
            cells: shown
                .iter()
                .zip(free)
                .map(|(&shown, free)| u16::from_le_bytes([shown, free]))
                .collect(),
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
            spread(
                &mut near,
                dims,
                axis,
                |here, next| here | next,
                |here, before| here | before,
            );
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

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use proptest::prelude::*;

    use super::super::simd::{Portable, RAYS};
    use super::*;

    fn cells() -> impl Strategy<Value = Cells> {
        let dims = prop::array::uniform3(1usize..7);
        let begin = prop::array::uniform3(-9i32..9);
        (dims, begin, 1u32..4, 0.0..0.4f64).prop_flat_map(|(dims, begin, level, density)| {
            let shown = prop::collection::vec(prop::bool::weighted(density), dims.iter().product::<usize>());
            shown.prop_map(move |shown| Cells {
                edge: 1 << level,
                begin: DVec3::from_array(begin.map(|n| f64::from(n) + 0.5)),
                dims,
                shown,
            })
        })
    }

    /// Whether any cell that shows meets the box between `low` and `high`.
    fn shows(cells: &Cells, low: [f32; 3], high: [f32; 3]) -> bool {
        let [width, height, _] = cells.dims;
        let begin = cells.begin.as_vec3().to_array();
        (0..cells.shown.len()).filter(|n| cells.shown[*n]).any(|n| {
            let cell = [n % width, n / width % height, n / width / height];
            (0..3).all(|a| {
                let face = begin[a] + (cells.edge * cell[a]) as f32;
                high[a] >= face && low[a] < face + cells.edge as f32
            })
        })
    }

    proptest! {
        /// What is said to be free shows nothing, wherever it is moved as far as is said; and of cells that are met, what shows is seen.
        #[test]
        fn what_is_free_shows_nothing(
            cells in cells(),
            at in prop::array::uniform3(-0.2f32..1.2),
            extent in prop::array::uniform3(0.0f32..0.99),
            moved in prop::array::uniform3(-1.0f32..=1.0),
        ) {
            let gaps = Gaps::new(&cells);
            let edge = cells.edge as f32;
            let low: [f32; 3] = std::array::from_fn(|a| gaps.begin[a] + at[a] * edge * cells.dims[a] as f32);
            let high: [f32; 3] = std::array::from_fn(|a| low[a] + extent[a] * edge);
            let splat = |corner: [f32; 3]| corner.map(Portable::float);
            let (free, voxels) = gaps.free::<Portable>(&splat(low), &splat(high));
            let voxels = Portable::side_by_side([voxels; 4]).map(|voxels| voxels[0]);
            prop_assert_eq!(voxels, [voxels[0]; RAYS]);
            let inside = (0..3).all(|a| (0.0..1.0).contains(&at[a]));
            match Portable::bits(free) {
                0 if inside => prop_assert!(shows(&cells, low, high)),
                0 => {}
                bits => {
                    prop_assert_eq!(bits, u16::MAX);
                    let by: [f32; 3] = std::array::from_fn(|a| moved[a] * voxels[0]);
                    let corner = |corner: [f32; 3]| std::array::from_fn(|a| corner[a] + by[a]);
                    prop_assert!(!shows(&cells, corner(low), corner(high)));
                }
            }
        }
    }
}
