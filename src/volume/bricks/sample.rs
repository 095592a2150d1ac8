//! The trilinear kernel.
//!
//! *Theory.* Linear interpolation along x, then y, then z between the eight voxels round a position.
//! *Practice.* Positions are `f64`, clamped to the outermost voxel centres and rounded to 2⁻²⁴ voxel: adding 2²⁸ leaves
//! index and fraction in a number's bits, which is cheaper than `floor` and needs no check. Values are `f32`, and
//! `a + t·(b − a)` returns `a` at `t = 0` and the common value of equal corners, both exactly. A row is done in chunks of
//! three plain loops, of which the compiler makes vector code: where the samples are, what the corners there hold, and their
//! interpolation. A point is a chunk of one, so that points and rows agree bit for bit.

use std::array::from_fn;

use glam::{DAffine3, DVec3};

use super::typed::{Brick, EDGE, SHIFT, TypedBricks, Y_STRIDE, Z_STRIDE};
use crate::math::affine;
use crate::volume::voxel::Voxel;

/// Samples of a chunk.
const LANES: usize = 16;

/// Bits of a position's fraction of a voxel.
const FRACTION_BITS: u32 = 24;

/// 2²⁸: in the sum with a position in `[0, 2²⁸)` the last place is 2⁻²⁴.
const BIAS: f64 = (1u64 << (52 - FRACTION_BITS)) as f64;

/// Bits of a brick's place along an axis in [`Sites::brick`]: enough for [`Grid::MAX_DIM`](crate::volume::Grid::MAX_DIM).
const BRICK_BITS: u32 = 21;

/// Where `N` samples are.
struct Sites<const N: usize> {
    /// The bricks' places along x, y, z, packed.
    brick: [u64; N],
    /// The lower voxels' offsets in their bricks.
    offset: [u32; N],
    /// Fractions of a voxel along x, y, z, in `[0, 1)`.
    t: [[f32; N]; 3],
}

/// The voxels round `N` samples: pairs along x, at y and y + 1 of z, then of z + 1.
type Corners<T, const N: usize> = [[[T; 2]; N]; 4];

/// `p` clamped to `[0, last]`, in units of 2⁻²⁴. Written with comparisons whose answer for NaN is known.
#[inline(always)]
fn fixed(p: f64, last: f64) -> u64 {
    let p = if p > 0.0 { p } else { 0.0 };
    let p = if p < last { p } else { last };
    (p + BIAS).to_bits() - BIAS.to_bits()
}

/// The fraction of a fixed-point coordinate.
#[inline(always)]
fn fraction(c: u64) -> f32 {
    const UNIT: f32 = 1.0 / (1u32 << FRACTION_BITS) as f32;
    (c as u32 & ((1 << FRACTION_BITS) - 1)) as i32 as f32 * UNIT
}

/// Linear interpolation; exact at `t = 0` and for `a == b`.
#[inline(always)]
fn lerp(a: f32, b: f32, t: f32) -> f32 {
    a + t * (b - a)
}

impl<const N: usize> Sites<N> {
    /// The sites of `position(0..N)`, clamped to the voxel centres `0..=last`.
    #[inline(always)]
    fn new(position: impl Fn(usize) -> DVec3, last: DVec3) -> Self {
        let mut sites = Self {
            brick: [0; N],
            offset: [0; N],
            t: [[0.0; N]; 3],
        };
        for n in 0..N {
            let p = position(n);
            let c = [fixed(p.x, last.x), fixed(p.y, last.y), fixed(p.z, last.z)];
            let [x, y, z] = c.map(|c| c >> (FRACTION_BITS + SHIFT));
            sites.brick[n] = x | y << BRICK_BITS | z << (2 * BRICK_BITS);
            let [x, y, z] = c.map(|c| (c as u32 >> FRACTION_BITS) & (EDGE as u32 - 1));
            sites.offset[n] = x + Y_STRIDE as u32 * (y + Y_STRIDE as u32 * z);
            for (t, c) in sites.t.iter_mut().zip(c) {
                t[n] = fraction(c);
            }
        }
        sites
    }

    /// The place of the `n`th sample's brick.
    #[inline(always)]
    fn place(&self, n: usize) -> [usize; 3] {
        let bits = (1 << BRICK_BITS) - 1;
        from_fn(|axis| (self.brick[n] >> (axis as u32 * BRICK_BITS) & bits) as usize)
    }

    /// The samples, from their corners.
    #[inline(always)]
    fn blend<T: Voxel>(&self, corners: &Corners<T, N>) -> [f32; N] {
        // A loop, as `from_fn` is not compiled into the versions for wide registers.
        let mut values = [0.0; N];
        for (n, value) in values.iter_mut().enumerate() {
            let [tx, ty, tz] = [self.t[0][n], self.t[1][n], self.t[2][n]];
            let edge = |c: usize| {
                let [a, b] = corners[c][n];
                lerp(a.to_f32(), b.to_f32(), tx)
            };
            let face = |c: usize| lerp(edge(c), edge(c + 1), ty);
            *value = lerp(face(0), face(2), tz);
        }
        values
    }
}

/// [`TypedBricks::sample_row`], compiled for wide registers too. No operation is fused or reordered, so every version gives
/// the same bits.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn sample_row<T: Voxel>(bricks: &TypedBricks<T>, index_from_lattice: &DAffine3, row: DVec3, i0: f64, out: &mut [f32]) {
    let last = bricks.last();
    let mut corners = [[[T::zeroed(); 2]; LANES]; 4];
    for (chunk, out) in out.chunks_mut(LANES).enumerate() {
        let start = chunk * LANES;
        let position = |n: usize| affine::step(index_from_lattice, row, i0 + (start + n) as f64);
        let sites = Sites::<LANES>::new(position, last);
        let mut n = 0;
        while n < out.len() {
            n = bricks.gather(&sites, n..out.len(), &mut corners);
        }
        out.copy_from_slice(&sites.blend(&corners)[..out.len()]);
    }
}

impl<T: Voxel> TypedBricks<T> {
    /// The trilinear sample at the voxel position `p`, clamped to the outermost voxel centres.
    pub fn sample(&self, p: DVec3) -> f32 {
        let sites = Sites::new(|_| p, self.last());
        let mut corners = [[[T::zeroed(); 2]; 1]; 4];
        self.gather(&sites, 0..1, &mut corners);
        let [v] = sites.blend(&corners);
        v
    }

    /// [`Self::sample`] at `affine::step(index_from_lattice, row, i0 + n)` for each `n` of `out`.
    pub fn sample_row(&self, index_from_lattice: &DAffine3, row: DVec3, i0: f64, out: &mut [f32]) {
        sample_row(self, index_from_lattice, row, i0, out);
    }

    /// Fetches the corners of the samples of a range that are in the first one's brick; returns where they end.
    #[inline(always)]
    fn gather<const N: usize>(
        &self,
        sites: &Sites<N>,
        range: std::ops::Range<usize>,
        corners: &mut Corners<T, N>,
    ) -> usize {
        let start = range.start;
        let brick = sites.brick[start];
        let run = range.take_while(|&n| sites.brick[n] == brick);
        let mut end = start;
        match self.brick(sites.place(start)) {
            Brick::Constant(v) => {
                for n in run {
                    corners.iter_mut().for_each(|c| c[n] = [*v; 2]);
                    end = n + 1;
                }
            }
            Brick::Voxels(voxels) => {
                for n in run {
                    const REACH: usize = Z_STRIDE + Y_STRIDE + 2;
                    let v = &voxels[sites.offset[n] as usize..][..REACH];
                    let pair = |o: usize| [v[o], v[o + 1]];
                    corners[0][n] = pair(0);
                    corners[1][n] = pair(Y_STRIDE);
                    corners[2][n] = pair(Z_STRIDE);
                    corners[3][n] = pair(Z_STRIDE + Y_STRIDE);
                    end = n + 1;
                }
            }
        }
        end
    }

    /// The last voxel's index, as a position.
    fn last(&self) -> DVec3 {
        DVec3::from_array(self.dims().map(|n| (n - 1) as f64))
    }
}
