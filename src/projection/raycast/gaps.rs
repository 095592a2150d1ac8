//! Where in a block nothing shows, and how far that goes.
//!
//! *Theory.* Empty space is leapt over by its distance to what is not (Zuiderveld, Koning and Viergever 1992).
//! *Practice.* A packet at a plane is no larger than a cell, so it meets at most two of them along each axis: it is asked for by the cell
//! of its low corner alone. All is found when the transfer function changes, not in a frame.

use glam::DVec3;

use super::places::{self, Place};
use super::rays::MOST_PLANES;
use super::shown::Cells;
use super::simd::{Simd, each};

/// The farthest that distances are counted, in cells.
pub const FARTHEST: u8 = 31;

/// How far around a packet's places is asked whether anything shows, for their rounding, voxels.
pub const MARGIN: f64 = 0.01;

/// The most voxels along an axis for whose places single precision will do: a place, a step, and what comes of them are each rounded once, by
/// at most 2⁻²⁴ of that, which together is less than a third of [`MARGIN`].
const LONGEST: usize = 1 << 14;

/// The cells of a block by what shows of them and of their neighbours.
pub struct Gaps {
    /// The low corner of the first cell, counted from the block's first stored voxel.
    begin: Place,
    /// Bits of a place behind the number of its cell.
    shift: u32,
    /// How far apart rows and planes of cells are.
    strides: [i64; 2],
    /// How many cells the box of eight that begins at each cell can be moved along any axes without that anything shows in it, and one
    /// more; 0 if something does. There is a cell more on each side, of which nothing shows, and behind them are three bytes more: see
    /// [`Simd::bytes`].
    free: Vec<u8>,
    /// Whether there are more than [`LONGEST`] voxels along any axis, or too many cells for 31 bits.
    is_long: bool,
}

impl Gaps {
    /// Those of `cells`.
    pub fn new(cells: &Cells) -> Self {
        let edge = cells.edge as f64;
        let dims = cells.dims.map(|n| n + 2);
        let mut shown = vec![0; dims.iter().product()];
        for (row, of) in cells.shown.chunks_exact(cells.dims[0].max(1)).enumerate() {
            let [y, z] = [row % cells.dims[1], row / cells.dims[1]];
            let begin = 1 + dims[0] * (y + 1 + dims[1] * (z + 1));
            for (shown, of) in shown[begin..].iter_mut().zip(of) {
                *shown = u8::from(*of);
            }
        }
        for axis in 0..3 {
            spread(&mut shown, dims, axis, |here, next| here | next, |here, _| here);
        }
        Self {
            begin: (cells.begin + DVec3::splat(MARGIN - edge))
                .to_array()
                .map(places::fixed),
            shift: places::BITS + cells.edge.ilog2(),
            strides: [dims[0], dims[0] * dims[1]].map(|n| n as i64),
            is_long: dims.iter().any(|n| n * cells.edge > LONGEST) || shown.len() > i32::MAX as usize,
            free: [free(shown, dims), vec![0; 3]].concat(),
        }
    }

    /// How many cells a packet whose low corner is `low` can be moved along any axes without that anything of the block shows, and one
    /// more; 0 if something may show where it is. Its low corner is among the cells, or no farther before them than a cell is long.
    #[inline(always)]
    pub fn free(&self, low: &Place) -> u8 {
        let [x, y, z] = each!(axis of [0, 1, 2] => {
            low[axis].wrapping_sub(self.begin[axis]) >> self.shift
        });
        let [row, plane] = self.strides;
        let cell = x.wrapping_add(y.wrapping_mul(row)).wrapping_add(z.wrapping_mul(plane));
        self.free.get(cell as usize).copied().unwrap_or(0)
    }

    /// The low corner of the first cell, in voxels from the block's first stored one.
    #[inline(always)]
    pub fn first_cell(&self) -> [f64; 3] {
        each!(axis of [0, 1, 2] => self.begin[axis] as f64 / (1u64 << places::BITS) as f64)
    }

    /// How many cells long a voxel is.
    #[inline(always)]
    pub fn cells_per_voxel(&self) -> f64 {
        1.0 / (1u64 << (self.shift - places::BITS)) as f64
    }

    /// [`Self::free`] for sixteen packets, whose low corners are so many cells from that of the first cell; 0 in blocks that are too long for
    /// that to be told by numbers of single precision.
    #[inline(always)]
    pub fn free_at<S: Simd>(&self, cells: [S::Float; 3]) -> S::Int {
        if self.is_long {
            return S::int(0);
        }
        // The cell that a place is in, or the one before if it is at a face.
        let [x, y, z] = each!(axis of [0, 1, 2] => S::whole(cells[axis] - S::float(0.5)));
        let [row, plane] = each!(stride of [self.strides[0], self.strides[1]] => S::int(stride as i32));
        S::bytes(&self.free, x + y * row + z * plane)
    }
}

/// How many planes a packet hops where [`Gaps::free`] says so many, at least 1, if it passes a voxel in so many planes; cells have an
/// `edge` of so many voxels.
pub fn hops(edge: usize, planes_per_voxel: f64) -> [i32; FARTHEST as usize + 1] {
    std::array::from_fn(|free| {
        let voxels = free.saturating_sub(1) * edge;
        (voxels as f64 * planes_per_voxel).min(f64::from(MOST_PLANES)) as i32 + 1
    })
}

/// How many cells the box of eight at each cell can be moved, and one more: see [`Gaps::free`].
fn free(mut near: Vec<u8>, dims: [usize; 3]) -> Vec<u8> {
    let mut free = vec![0; near.len()];
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

    use super::super::simd::Portable;
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
    fn shows(cells: &Cells, low: [f64; 3], high: [f64; 3]) -> bool {
        let [width, height, _] = cells.dims;
        let begin = cells.begin.to_array();
        (0..cells.shown.len()).filter(|n| cells.shown[*n]).any(|n| {
            let cell = [n % width, n / width % height, n / width / height];
            (0..3).all(|a| {
                let face = begin[a] + (cells.edge * cell[a]) as f64;
                high[a] >= face && low[a] < face + cells.edge as f64
            })
        })
    }

    /// What is free of one packet, found as for sixteen.
    fn free_by<S: Simd>(gaps: &Gaps, cells: [f64; 3]) -> i32 {
        let free = gaps.free_at::<S>(cells.map(|at| S::float(at as f32)));
        S::int_array(free)[0]
    }

    proptest! {
        /// What is said to be free shows nothing, wherever it is moved as far as is said; and of eight cells of which none shows, it is said.
        #[test]
        fn what_is_free_shows_nothing(
            cells in cells(),
            at in prop::array::uniform3(0.0f64..1.0),
            before in prop::array::uniform3(prop::bool::weighted(0.2)),
            extent in prop::array::uniform3(0.0f64..0.99),
            moved in prop::array::uniform3(-1.0f64..=1.0),
        ) {
            let gaps = Gaps::new(&cells);
            let edge = cells.edge as f64;
            // Among the cells, or up to one before them.
            let low: [f64; 3] = std::array::from_fn(|a| {
                let cells_on = if before[a] { -at[a] } else { at[a] * cells.dims[a] as f64 };
                cells.begin[a] + cells_on * edge
            });
            let free = gaps.free(&std::array::from_fn(|a| places::fixed(low[a])));
            // Nearly at a face both cells will do.
            let in_cells: [f64; 3] = std::array::from_fn(|a| (low[a] - gaps.first_cell()[a]) * gaps.cells_per_voxel());
            if in_cells.iter().all(|at| (at - at.round()).abs() > 1e-5) {
                prop_assert_eq!(free_by::<Portable>(&gaps, in_cells), i32::from(free));
            }
            let extents = edge - 2.0 * MARGIN;
            let high = std::array::from_fn(|a| low[a] + extent[a] * extents);
            if free > 0 {
                let voxels = f64::from(free - 1) * edge;
                let corner = |corner: [f64; 3]| std::array::from_fn(|a| corner[a] + moved[a] * voxels);
                prop_assert!(!shows(&cells, corner(low), corner(high)));
            } else {
                prop_assert!(shows(&cells, low.map(|at| at - edge), low.map(|at| at + 2.0 * edge)));
            }
        }

        /// Of long blocks nothing is told by single precision.
        #[test]
        fn long_blocks_are_told_by_whole_numbers(more in 0usize..3) {
            let length = LONGEST / 8 - 2 + more;
            let cells = Cells { edge: 8, begin: DVec3::ZERO, dims: [length, 1, 1], shown: vec![false; length] };
            let gaps = Gaps::new(&cells);
            prop_assert!(gaps.free(&[0; 3]) > 0);
            prop_assert_eq!(free_by::<Portable>(&gaps, [0.5; 3]) > 0, more == 0);
        }

        /// A packet that hops comes no farther than it may.
        #[test]
        fn hops_are_short_enough(edge in 1usize..64, planes_per_voxel in 0.01f64..9.0) {
            for (free, planes) in hops(edge, planes_per_voxel).into_iter().enumerate().skip(1) {
                let voxels = f64::from(planes - 1) / planes_per_voxel;
                prop_assert!(voxels <= ((free - 1) * edge) as f64 * (1.0 + 1e-12));
            }
        }
    }
}
