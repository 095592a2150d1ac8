//! The template of a frame's packets: where samples lie round a packet's low corner.
//!
//! *Theory.* Seen in parallel, all blocks of a size cover the same pixels and sampling points but for a displacement, so what they cover is
//! worked out once (VCSG §3.3.1).
//! *Changes from the paper.* What is moved is a packet of rays, not a block: at a plane all packets of a frame are alike, wherever they are,
//! also in perspective, where it is another template at each plane.
//! *Practice.* Each packet's low corner is in double precision, and all else in whole parts of a voxel counted from there, so that nothing
//! depends on the block. A cell and the place in it are then bits of the same number. Of numbers of 32 bits the low halves are all that
//! is needed among few voxels; there are as many parts of a voxel as those have room for.

use std::marker::PhantomData;

use super::kind::Kind;
use super::places::{self, Place};
use super::rays::Rays;
use super::simd::{EDGE, PAIRS, PART_BITS, Places, RAYS, Sampling, each};
use super::voxels::Voxels;

/// Bits more that samples are apart by, before they are rounded.
const MORE: u32 = 10;

/// How far apart the rays of a packet may be along any axis, voxels, for all its cells to be among [`EDGE`]³ voxels wherever it is; a
/// little less, for rounding.
pub const FEW: f64 = (EDGE - 2) as f64 - 1e-3;

/// Pairs of vectors of a packet of `n`, the last one of which may be of one alone.
pub const fn pairs(n: usize) -> usize {
    n.div_ceil(2)
}

/// Vectors along an edge of a packet of `n`: 1 or 2.
pub const fn side(n: usize) -> usize {
    if n == 1 { 1 } else { 2 }
}

/// Pixels along an edge of a packet of `n` vectors.
pub const fn edge(n: usize) -> usize {
    EDGE * side(n)
}

/// The columns and the rows of a vector's rays.
const WITHIN: [[i32; RAYS]; 2] = {
    let mut within = [[0; RAYS]; 2];
    let mut n = 0;
    while n < RAYS {
        within[0][n] = (n % EDGE) as i32;
        within[1][n] = (n / EDGE) as i32;
        n += 1;
    }
    within
};

/// The samples of any packet at a plane.
pub struct Template<S: Sampling, K: Kind, const N: usize> {
    plane: i32,
    /// How far each is from the packet's low corner along each axis, in parts of a voxel.
    away: [[S::Int; N]; 3],
    /// The low halves of that.
    low: [[S::Short; PAIRS]; 3],
    /// How far they are from it at most along each axis, and a little more, for rounding; no more than is too far for [`EDGE`]³ voxels.
    extents: Place,
    kind: PhantomData<K>,
}

impl<S: Sampling, K: Kind, const N: usize> Template<S, K, N> {
    /// At `plane`.
    #[inline(always)]
    pub fn new(rays: &Rays, plane: i32) -> Self {
        let apart = rays.apart(plane);
        let last = (edge(N) - 1) as i32;
        let extents = each!(axis of [0, 1, 2] => f64::from(last) * (apart[axis][0].abs() + apart[axis][1].abs()));
        let away = each!(axis of [0, 1, 2] => away::<S, N>(apart[axis], rays.lowest[axis]));
        let low = each!(axis of [0, 1, 2] => {
            let mut low = [S::shorts(away[axis][0], away[axis][N.min(2) - 1]); PAIRS];
            for m in 1..pairs(N) {
                low[m] = S::shorts(away[axis][2 * m], away[axis][2 * m + 1]);
            }
            low
        });
        Self {
            plane,
            away,
            low,
            extents: each!(axis of [0, 1, 2] => places::fixed((extents[axis] + ROUNDING).min(EDGE as f64))),
            kind: PhantomData,
        }
    }

    /// The one at `plane`, if it is another one.
    #[inline(always)]
    pub fn turn_to(&mut self, rays: &Rays, plane: i32) {
        if !rays.parallel && self.plane != plane {
            *self = Self::new(rays, plane);
        }
    }

    /// Moved to a packet whose low corner is `at`, counted from the first one of `voxels`.
    #[inline(always)]
    pub fn moved(&self, voxels: &Voxels, at: &Place) -> Moved {
        let few = K::FEW || (voxels.has_few && self.is_small(at));
        let mut first = voxel(at);
        let mut parts = each!(axis of [0, 1, 2] => (at[axis] as u32 >> (places::BITS - PART_BITS)) as i32);
        if few && !voxels.holds_few(first) {
            // The voxels that are read are stored; samples that are not among them are not in the block.
            for axis in 0..3 {
                let stored = first[axis].min(voxels.dims[axis] - EDGE as i32).max(0);
                parts[axis] = parts[axis].wrapping_add(first[axis].wrapping_sub(stored).wrapping_shl(PART_BITS));
                first[axis] = stored;
            }
        }
        Moved {
            first: voxels.index(first),
            parts,
            few,
        }
    }

    /// Whether the cells of a packet whose low corner is there are among [`EDGE`]³ voxels.
    #[inline(always)]
    fn is_small(&self, at: &Place) -> bool {
        const CELLS: i64 = (EDGE as i64 - 1) << places::BITS;
        let [x, y, z] = each!(axis of [0, 1, 2] => i64::from(at[axis] as u32) + self.extents[axis] < CELLS);
        x & y & z
    }

    /// Where the samples of pair `m` of vectors are among the voxels of the packet that is `moved` there; of samples that are not in the block,
    /// anywhere.
    #[inline(always)]
    pub fn places(&self, m: usize, moved: &Moved) -> Places<S> {
        let low = each!(axis of [0, 1, 2] => self.low[axis][m]);
        S::places(&low, each!(axis of [0, 1, 2] => moved.parts[axis] as i16), N.min(2))
    }

    /// Which stored voxel is at the low corner of the cells of vector `n` of the packet that is `moved` there; of samples that are not `inside`,
    /// the first one.
    #[inline(always)]
    pub fn cells(&self, n: usize, voxels: &Voxels, moved: &Moved, inside: S::Mask) -> S::Int {
        let [x, y, z] = each!(axis of [0, 1, 2] => {
            S::shift_right(self.away[axis][n] + S::int(moved.parts[axis]), S::int(PART_BITS as i32))
        });
        let [row, plane] = each!(stride of [voxels.strides[0], voxels.strides[1]] => S::int(stride as i32));
        let cell = x + y * row + z * plane + S::int(moved.first as i32);
        S::choose_int(inside, cell, S::int(0))
    }
}

/// The most that places are off in a packet, and more, voxels: a low corner is rounded down to a part, and what samples are away from it is a
/// part more, rounded down.
const ROUNDING: f64 = 4.0 / (1 << PART_BITS) as f64;

/// How far samples are from the low corner along an axis along which pixels are so far `apart`, in parts of a voxel. They are half a part
/// farther, since the low corner is rounded down by as much on average.
#[inline(always)]
fn away<S: Sampling, const N: usize>(apart: [f64; 2], lowest: [bool; 2]) -> [S::Int; N] {
    let last = (edge(N) - 1) as i32;
    // Whole parts, and what is behind them.
    let fine = each!(a of [0, 1] => (apart[a].abs() * f64::from(1u32 << (PART_BITS + MORE))).round() as i64);
    let whole = each!(a of [0, 1] => S::int((fine[a] >> MORE) as i32));
    let rest = each!(a of [0, 1] => S::int(fine[a] as i32 & ((1 << MORE) - 1)));
    let mut away = [S::int(0); N];
    for (n, away) in away.iter_mut().enumerate() {
        let first = [n % side(N) * EDGE, n / side(N) * EDGE];
        // The half a part, and another one, by which rounding down is to the nearest.
        let mut behind = S::int(1 << MORE);
        for a in 0..2 {
            let from_first = S::int(first[a] as i32) + S::ints(WITHIN[a]);
            let from_lowest = if lowest[a] {
                S::int(last) - from_first
            } else {
                from_first
            };
            *away = *away + from_lowest * whole[a];
            behind = behind + from_lowest * rest[a];
        }
        *away = *away + S::shift_right(behind, S::int(MORE as i32));
    }
    away
}

/// A packet's template among a block's voxels.
pub struct Moved {
    /// Where the voxel is stored that cells are counted from.
    pub first: isize,
    /// How far the low corner is from it along each axis, in parts of a voxel.
    parts: [i32; 3],
    /// See [`Self::is_few`].
    few: bool,
}

impl Moved {
    /// Whether all samples in the block are among [`EDGE`]³ of its voxels.
    #[inline(always)]
    pub fn is_few<K: Kind>(&self) -> bool {
        K::FEW || self.few
    }
}

/// The voxel at the low corner of a place's cell.
#[inline(always)]
pub fn voxel(at: &Place) -> [i32; 3] {
    each!(axis of [0, 1, 2] => (at[axis] >> places::BITS) as i32)
}
