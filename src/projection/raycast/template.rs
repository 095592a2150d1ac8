//! The template of a frame's packets: where samples lie round a packet's low corner.
//!
//! *Theory.* Seen in parallel, all blocks of a size cover the same pixels and sampling points but for a displacement, so what they cover is
//! worked out once (VCSG §3.3.1).
//! *Changes from the paper.* What is moved is a packet of rays, not a block: at a plane all packets of a frame are alike, wherever they are,
//! also in perspective, where it is another template at each plane.
//! *Practice.* Each packet's low corner is in double precision, and all else in whole parts of a voxel counted from there, so that nothing
//! depends on the block. A cell and the place in it are then bits of the same number.

use std::marker::PhantomData;

use super::kind::Kind;
use super::places::{self, Place};
use super::rays::Rays;
use super::simd::{EDGE, RAYS, Simd, Within, each};
use super::voxels::Voxels;

/// Bits of the parts of a voxel, if packets are not so large that they need more for whole ones: with parts of 2⁻²⁴ voxel there is room for
/// packets of 255 voxels.
const FINEST: u32 = 24;

/// How far apart the rays of a packet may be along any axis, voxels, for all its cells to be among [`EDGE`]³ voxels wherever it is; a
/// little less, for rounding.
pub const FEW: f64 = (EDGE - 2) as f64 - 1e-3;

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
pub struct Template<S: Simd, K: Kind, const N: usize> {
    plane: i32,
    /// How far each is from the packet's low corner along each axis, in parts of 2 to the minus `bits` of a voxel.
    away: [[S::Int; N]; 3],
    bits: u32,
    /// How far they are from it at most along each axis, and a little more, for rounding; no more than is too far for [`EDGE`]³ voxels.
    extents: Place,
    kind: PhantomData<K>,
}

impl<S: Simd, K: Kind, const N: usize> Template<S, K, N> {
    /// At `plane`.
    #[inline(always)]
    pub fn new(rays: &Rays, plane: i32) -> Self {
        let apart = rays.apart(plane);
        let last = (edge(N) - 1) as i32;
        let extents = each!(axis of [0, 1, 2] => f64::from(last) * (apart[axis][0].abs() + apart[axis][1].abs()));
        let bits = bits(extents[0].max(extents[1]).max(extents[2]));
        let unit = f64::from(1u32 << bits);
        let mut away = [[S::int(0); N]; 3];
        for axis in 0..3 {
            let lowest = rays.lowest[axis];
            for (n, away) in away[axis].iter_mut().enumerate() {
                let first = [n % side(N) * EDGE, n / side(N) * EDGE];
                for a in 0..2 {
                    let from_first = S::int(first[a] as i32) + S::ints(WITHIN[a]);
                    let from_lowest = if lowest[a] {
                        S::int(last) - from_first
                    } else {
                        from_first
                    };
                    let pixel = (apart[axis][a].abs() * unit).round() as i32;
                    *away = *away + from_lowest * S::int(pixel);
                }
            }
        }
        Self {
            plane,
            away,
            bits,
            extents: each!(axis of [0, 1, 2] => places::fixed((extents[axis] + 1e-6).min(EDGE as f64))),
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

    /// Bits behind the point; small packets are in the finest parts.
    #[inline(always)]
    fn bits(&self) -> u32 {
        if K::FEW { FINEST } else { self.bits }
    }

    /// Moved to a packet whose low corner is `at`, counted from the first one of `voxels`.
    #[inline(always)]
    pub fn moved(&self, voxels: &Voxels, at: &Place) -> Moved {
        let bits = self.bits();
        let few = K::FEW || (voxels.has_few && self.is_small(at));
        let mut first = voxel(at);
        let mut parts = each!(axis of [0, 1, 2] => (at[axis] as u32 >> (places::BITS - bits)) as i32);
        if few && !voxels.holds_few(first) {
            // The voxels that are read are stored; samples that are not among them are not in the block.
            for axis in 0..3 {
                let stored = first[axis].min(voxels.dims[axis] - EDGE as i32).max(0);
                parts[axis] = parts[axis].wrapping_add(first[axis].wrapping_sub(stored).wrapping_shl(bits));
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

    /// The cells of vector `n` of the packet that is `moved` there, and the places in them; of samples that are not `inside`, any.
    #[inline(always)]
    pub fn places(&self, n: usize, voxels: &Voxels, moved: &Moved, inside: S::Mask) -> Places<S> {
        let at = each!(axis of [0, 1, 2] => self.away[axis][n] + S::int(moved.parts[axis]));
        if moved.is_few::<K>() {
            return few_places(at);
        }
        let bits = self.bits as i32;
        let [x, y, z] = each!(axis of [0, 1, 2] => S::shift_right(at[axis], S::int(bits)));
        // What is behind the point, from the highest bit on.
        let part = each!(axis of [0, 1, 2] => S::shift_left(at[axis], S::int(32 - bits)));
        // The nearest of 2^15 parts.
        let second = S::shift_right(S::shift_right(part[0], S::int(16)) + S::int(1), S::int(1));
        let [row, plane] = each!(stride of [voxels.strides[0], voxels.strides[1]] => S::int(stride as i32));
        let cell = x + y * row + z * plane + S::int(moved.first as i32);
        Places {
            cells: S::choose_int(inside, cell, S::int(0)),
            within: Within {
                weights: S::weights(second),
                parts: each!(axis of [1, 2] => fraction::<S>(S::shift_right(part[axis], S::int(32 - FINEST as i32)))),
            },
        }
    }
}

/// The cells and the places in them of samples that are so far from the first of few voxels along each axis, in parts of [`FINEST`] bits.
#[inline(always)]
fn few_places<S: Simd>([x, y, z]: [S::Int; 3]) -> Places<S> {
    const BITS: i32 = FINEST as i32;
    // The nearest of 2^15 parts along x; all of them are the next cell.
    let x = x + S::int(1 << (BITS - 16));
    let xy = S::shift_right(x, S::int(BITS)) | (S::shift_right(y, S::int(BITS - 2)) & S::int(0b1100));
    let cell = xy | (S::shift_right(z, S::int(BITS - 4)) & S::int(0b11_0000));
    Places {
        cells: (cell | S::shift_left(cell, S::int(16))) + S::int(1 << 16),
        within: Within {
            weights: S::weights(S::shift_right(x, S::int(BITS - 15)) & S::int(0x7fff)),
            parts: each!(of of [y, z] => fraction::<S>(of & S::int((1 << BITS) - 1))),
        },
    }
}

/// So many parts of [`FINEST`] bits as a number.
#[inline(always)]
fn fraction<S: Simd>(parts: S::Int) -> S::Float {
    S::to_float(parts) * S::float(1.0 / (1u32 << FINEST) as f32)
}

/// See [`Template`].
fn bits(extent: f64) -> u32 {
    /// Voxels that there is room for beside the finest parts.
    const ROOM: f64 = 255.0;
    let more = (extent / ROOM).max(1.0).log2().ceil();
    FINEST.saturating_sub(more as u32).max(1)
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

/// Where samples lie among a block's voxels.
#[derive(Clone, Copy)]
pub struct Places<S: Simd> {
    /// Of few voxels see [`Simd::take`], of others the stored voxel at each cell's low corner.
    pub cells: S::Int,
    pub within: Within<S>,
}
