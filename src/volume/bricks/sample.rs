//! The trilinear kernel.
//!
//! *Theory.* Linear interpolation along x, then y, then z between the eight voxels round a position.
//! *Practice.* Positions are `f64`, clamped to the outermost voxel centres and rounded to 2⁻²⁴ voxel: adding 2²⁸ leaves
//! index and fraction in a number's bits, which is cheaper than `floor` and needs no check. Values are `f32`, and
//! `a + t·(b − a)` returns `a` at `t = 0` and the common value of equal corners, both exactly. A row is done in chunks of
//! three plain loops, of which the compiler makes vector code: where the samples are, what the corners there hold, and their
//! interpolation. Each sample looks its brick up: that costs less than the wrong guesses of where a row leaves a brick. A
//! point is a chunk of one, so that points and rows agree bit for bit.

use glam::{DAffine3, DVec3};

use super::typed::{Brick, EDGE, SHIFT, TypedBricks, Y_STRIDE, Z_STRIDE};
use crate::math::affine;
use crate::volume::voxel::Voxel;

/// Samples of a chunk: as many as a small block's row has, and enough that a chunk's first corners, stored one by one, have
/// reached the cache when wide registers read them.
const LANES: usize = 32;

/// Bits of a position's fraction of a voxel.
const FRACTION_BITS: u32 = 24;

/// Stored bits of an `f64`'s mantissa.
const MANTISSA_BITS: u32 = f64::MANTISSA_DIGITS - 1;

/// 2²⁸: in the sum with a position in `[0, 2²⁸)` the last place is 2⁻²⁴.
const BIAS: f64 = (1u64 << (MANTISSA_BITS - FRACTION_BITS)) as f64;

/// Where `N` samples are.
struct Sites<const N: usize> {
    /// Where their bricks are among all.
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
    (p + BIAS).to_bits() & ((1 << MANTISSA_BITS) - 1)
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
    fn new<T: Voxel>(position: impl Fn(usize) -> DVec3, bricks: &TypedBricks<T>) -> Self {
        let last = bricks.last();
        let mut sites = Self {
            brick: [0; N],
            offset: [0; N],
            t: [[0.0; N]; 3],
        };
        for n in 0..N {
            let p = position(n);
            let c = [fixed(p.x, last.x), fixed(p.y, last.y), fixed(p.z, last.z)];
            sites.brick[n] = bricks.index(c.map(|c| c >> (FRACTION_BITS + SHIFT)));
            let [x, y, z] = c.map(|c| (c as u32 >> FRACTION_BITS) & (EDGE as u32 - 1));
            sites.offset[n] = x + Y_STRIDE as u32 * (y + Y_STRIDE as u32 * z);
            for (t, c) in sites.t.iter_mut().zip(c) {
                t[n] = fraction(c);
            }
        }
        sites
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
    for (chunk, out) in out.chunks_mut(LANES).enumerate() {
        let start = chunk * LANES;
        let position = |n: usize| affine::step(index_from_lattice, row, i0 + (start + n) as f64);
        if out.len() > LANES / 2 {
            bricks.sample_chunk::<LANES>(position, out);
        } else {
            bricks.sample_chunk::<{ LANES / 2 }>(position, out);
        }
    }
}

/// [`TypedBricks::sample_points`], compiled for wide registers too.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn sample_points<T: Voxel>(
    bricks: &TypedBricks<T>,
    index_from_frame: &DAffine3,
    [xs, ys, zs]: [&[f64]; 3],
    out: &mut [f32],
) {
    let chunks = xs.chunks(LANES).zip(ys.chunks(LANES)).zip(zs.chunks(LANES));
    for (((xs, ys), zs), out) in chunks.zip(out.chunks_mut(LANES)) {
        // A chunk's last point goes on beyond the row's end.
        let last = xs.len().min(ys.len()).min(zs.len()) - 1;
        let mut points = [[0.0; LANES]; 3];
        for (lanes, row) in points.iter_mut().zip([xs, ys, zs]) {
            lanes.fill(row[last]);
            lanes[..row.len()].copy_from_slice(row);
        }
        let position = |n: usize| {
            let p = DVec3::new(points[0][n], points[1][n], points[2][n]);
            affine::point(index_from_frame, p)
        };
        bricks.sample_chunk::<LANES>(position, out);
    }
}

impl<T: Voxel> TypedBricks<T> {
    /// The trilinear sample at the voxel position `p`, clamped to the outermost voxel centres.
    pub fn sample(&self, p: DVec3) -> f32 {
        let mut sample = [0.0];
        self.sample_chunk::<1>(|_| p, &mut sample);
        sample[0]
    }

    /// [`Self::sample`] at `affine::step(index_from_lattice, row, i0 + n)` for each `n` of `out`.
    pub fn sample_row(&self, index_from_lattice: &DAffine3, row: DVec3, i0: f64, out: &mut [f32]) {
        sample_row(self, index_from_lattice, row, i0, out);
    }

    /// [`Self::sample`] at `affine::point(index_from_frame, p)` for each of the points.
    pub fn sample_points(&self, index_from_frame: &DAffine3, points: [&[f64]; 3], out: &mut [f32]) {
        sample_points(self, index_from_frame, points, out);
    }

    /// The samples at `position(n)` for each `n` of `out`, which is at most `N` long.
    #[inline(always)]
    fn sample_chunk<const N: usize>(&self, position: impl Fn(usize) -> DVec3, out: &mut [f32]) {
        let sites = Sites::<N>::new(position, self);
        let mut corners = [[[T::zeroed(); 2]; N]; 4];
        self.gather(&sites, out.len(), &mut corners);
        out.copy_from_slice(&sites.blend(&corners)[..out.len()]);
    }

    /// Fetches the corners of the first `count` samples.
    #[inline(always)]
    fn gather<const N: usize>(&self, sites: &Sites<N>, count: usize, corners: &mut Corners<T, N>) {
        const REACH: usize = Z_STRIDE + Y_STRIDE + 2;
        for n in 0..count {
            match self.at(sites.brick[n]) {
                Brick::Constant(v) => corners.iter_mut().for_each(|c| c[n] = [*v; 2]),
                Brick::Voxels(voxels) => {
                    let offset = sites.offset[n] as usize;
                    let v = &voxels[offset..offset + REACH];
                    let pair = |o: usize| [v[o], v[o + 1]];
                    corners[0][n] = pair(0);
                    corners[1][n] = pair(Y_STRIDE);
                    corners[2][n] = pair(Z_STRIDE);
                    corners[3][n] = pair(Z_STRIDE + Y_STRIDE);
                }
            }
        }
    }

    /// The last voxel's index, as a position.
    fn last(&self) -> DVec3 {
        DVec3::from_array(self.dims().map(|n| (n - 1) as f64))
    }
}
