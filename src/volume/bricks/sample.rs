//! The trilinear kernel.
//!
//! *Theory.* Linear interpolation along x, then y, then z between the eight voxels round a position.
//! *Practice.* Positions are `f64`, clamped to the outermost voxel centres and rounded to 2⁻²⁴ voxel: adding 2²⁸ leaves
//! index and fraction in a number's bits, which is cheaper than `floor` and needs no check. Values are `f32`, and
//! `a + t·(b − a)` returns `a` at `t = 0` and the common value of equal corners, both exactly. One kernel serves points and
//! rows, so that they agree bit for bit; a row splits into runs in one brick.

use glam::{DAffine3, DVec3};

use super::typed::{Brick, SHIFT, TypedBricks, Y_STRIDE, Z_STRIDE, offset};
use crate::math::affine;
use crate::volume::voxel::Voxel;

/// Bits of a position's fraction of a voxel.
const FRACTION_BITS: u32 = 24;

/// 2²⁸: in the sum with a position in `[0, 2²⁸)` the last place is 2⁻²⁴.
const BIAS: f64 = (1u64 << (52 - FRACTION_BITS)) as f64;

/// A position in fixed point, with [`FRACTION_BITS`]: lower voxel and fraction.
#[derive(Clone, Copy)]
struct Fixed {
    x: u64,
    y: u64,
    z: u64,
}

impl Fixed {
    /// `p` clamped to the voxel centres `0..=last`; NaN becomes 0.
    #[inline(always)]
    fn new(p: DVec3, last: DVec3) -> Self {
        Self {
            x: fixed(p.x, last.x),
            y: fixed(p.y, last.y),
            z: fixed(p.z, last.z),
        }
    }

    /// The lower voxel.
    #[inline(always)]
    fn voxel(self) -> [usize; 3] {
        [self.x, self.y, self.z].map(|c| (c >> FRACTION_BITS) as usize)
    }

    /// Whether the lower voxels are in one brick.
    #[inline(always)]
    fn same_brick(self, other: Self) -> bool {
        let differ = (self.x ^ other.x) | (self.y ^ other.y) | (self.z ^ other.z);
        differ >> (FRACTION_BITS + SHIFT) == 0
    }
}

/// `p` clamped to `[0, last]`, in units of 2⁻²⁴. Written with comparisons whose answer for NaN is known.
#[inline(always)]
fn fixed(p: f64, last: f64) -> u64 {
    let p = if p > 0.0 { p } else { 0.0 };
    let p = if p < last { p } else { last };
    (p + BIAS).to_bits() - BIAS.to_bits()
}

/// The fraction of a fixed-point coordinate, in `[0, 1)`.
#[inline(always)]
fn fraction(c: u64) -> f32 {
    const UNIT: f32 = 1.0 / (1u32 << FRACTION_BITS) as f32;
    (c & ((1 << FRACTION_BITS) - 1)) as i32 as f32 * UNIT
}

/// Linear interpolation; exact at `t = 0` and for `a == b`.
#[inline(always)]
fn lerp(a: f32, b: f32, t: f32) -> f32 {
    a + t * (b - a)
}

/// The sample at `p` from its brick's voxels.
#[inline(always)]
fn interpolate<T: Voxel>(voxels: &[T], p: Fixed) -> f32 {
    const CORNERS: usize = Z_STRIDE + Y_STRIDE + 2;
    let c: &[T] = &voxels[offset(p.voxel())..][..CORNERS];
    let (tx, ty, tz) = (fraction(p.x), fraction(p.y), fraction(p.z));
    let edge = |o: usize| lerp(c[o].to_f32(), c[o + 1].to_f32(), tx);
    let face = |o: usize| lerp(edge(o), edge(o + Y_STRIDE), ty);
    lerp(face(0), face(Z_STRIDE), tz)
}

impl<T: Voxel> TypedBricks<T> {
    /// The last voxel's index, as a position.
    fn last(&self) -> DVec3 {
        DVec3::from_array(self.dims().map(|n| (n - 1) as f64))
    }

    /// The trilinear sample at the voxel position `p`, clamped to the outermost voxel centres.
    pub fn sample(&self, p: DVec3) -> f32 {
        let p = Fixed::new(p, self.last());
        match self.brick(p.voxel().map(|i| i >> SHIFT)) {
            Brick::Constant(v) => v.to_f32(),
            Brick::Voxels(voxels) => interpolate(voxels, p),
        }
    }

    /// [`Self::sample`] at `affine::step(index_from_lattice, row, i0 + n)` for each `n` of `out`.
    pub fn sample_row(&self, index_from_lattice: &DAffine3, row: DVec3, i0: f64, out: &mut [f32]) {
        let last = self.last();
        let position =
            |n: usize| Fixed::new(affine::step(index_from_lattice, row, i0 + n as f64), last);
        let mut n = 0;
        while n < out.len() {
            let start = position(n);
            let brick = self.brick(start.voxel().map(|i| i >> SHIFT));
            n = match brick {
                Brick::Constant(v) => {
                    let mut n = n;
                    while n < out.len() && position(n).same_brick(start) {
                        out[n] = v.to_f32();
                        n += 1;
                    }
                    n
                }
                Brick::Voxels(voxels) => {
                    let mut n = n;
                    let mut p = start;
                    while p.same_brick(start) {
                        out[n] = interpolate(voxels, p);
                        n += 1;
                        if n == out.len() {
                            break;
                        }
                        p = position(n);
                    }
                    n
                }
            }
        }
    }
}
