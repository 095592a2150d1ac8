//! Sixteen numbers side by side, those of the rays of a square of pixels.
//!
//! *Practice.* The ray caster is written once, for any [`Simd`]: [`Portable`] in arrays, which compilers turn into what vectors the
//! processor has, [`Avx512`] in registers of 512 bits. Each operation rounds as the other's does, so the bits of a frame are the same.

#[cfg(target_arch = "x86_64")]
mod avx512;
mod portable;

use std::ops::{Add, BitAnd, BitOr, Mul, Not, Sub};

#[cfg(target_arch = "x86_64")]
pub use avx512::Avx512;
pub use portable::Portable;

/// Pixels along an edge of a vector's square.
pub const EDGE: usize = 4;

/// Rays of a vector, row by row.
pub const RAYS: usize = EDGE * EDGE;

/// Voxels of a packet whose voxels are few: [`EDGE`] along each axis.
pub const FEW: usize = EDGE * EDGE * EDGE;

/// Pairs of vectors of the largest packets.
pub const PAIRS: usize = 2;

/// Bits of the parts of a voxel that samples are counted in: 16 but for two, which count [`EDGE`] voxels.
pub const PART_BITS: u32 = 16 - EDGE.ilog2();

/// What all weights of a sample of vectors sum up to, but for rounding, with its sign.
pub const ALL_WEIGHTS: f32 = -32767.0;

/// Where the samples of two vectors are in cells.
#[derive(Clone, Copy)]
pub struct Places<S: Simd> {
    /// Which of few voxels is at the low corner of each cell, x fastest.
    pub cell: S::Short,
    /// How far they are in their cells along each axis, in parts of 2¹⁵.
    pub within: [S::Short; 3],
}

/// Cells of a vector that are anywhere.
#[derive(Clone, Copy)]
pub struct Apart<S: Simd> {
    /// The stored voxel at each cell's low corner.
    pub voxels: S::Int,
    /// How far rows and planes of stored voxels are apart.
    pub strides: [usize; 2],
}

/// A way of doing sixteen operations at once.
pub trait Simd: Copy + 'static {
    /// Sixteen numbers of single precision.
    type Float: Copy + Add<Output = Self::Float> + Sub<Output = Self::Float> + Mul<Output = Self::Float>;
    /// Sixteen of double precision.
    type Double: Copy + Add<Output = Self::Double> + Sub<Output = Self::Double> + Mul<Output = Self::Double>;
    /// Some of sixteen.
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask> + Not<Output = Self::Mask>;
    /// Sixteen integers of 32 bits, which wrap.
    type Int: Copy
        + Add<Output = Self::Int>
        + Sub<Output = Self::Int>
        + Mul<Output = Self::Int>
        + BitAnd<Output = Self::Int>
        + BitOr<Output = Self::Int>;
    /// Thirty-two integers of 16 bits, those of two vectors.
    type Short: Copy;
    /// [`EDGE`]³ numbers of 16 bits, those of few voxels.
    type Few;

    /// Does something in this way, where the processor has it.
    fn run(kernel: impl Kernel<Self>);

    /// None of them.
    fn none() -> Self::Mask;
    /// A bit each.
    fn bits(mask: Self::Mask) -> u16;

    fn float(x: f32) -> Self::Float;
    fn floats(x: [f32; RAYS]) -> Self::Float;
    fn double(x: f64) -> Self::Double;
    fn doubles(x: [f64; RAYS]) -> Self::Double;
    fn int(x: i32) -> Self::Int;
    fn ints(x: [i32; RAYS]) -> Self::Int;
    fn int_array(x: Self::Int) -> [i32; RAYS];

    /// `a·b + c`, rounded once.
    fn mul_add(a: Self::Float, b: Self::Float, c: Self::Float) -> Self::Float;
    fn divide(a: Self::Float, b: Self::Float) -> Self::Float;
    fn root(x: Self::Float) -> Self::Float;
    fn absolute(x: Self::Float) -> Self::Float;
    /// Where `a > b`.
    fn greater(a: Self::Float, b: Self::Float) -> Self::Mask;
    /// `a` where `mask` says, else `b`.
    fn choose(mask: Self::Mask, a: Self::Float, b: Self::Float) -> Self::Float;
    /// The nearest whole number, the even one of two; all must be less than 2²².
    fn whole(x: Self::Float) -> Self::Int;

    fn inverse(x: Self::Double) -> Self::Double;
    fn floor_double(x: Self::Double) -> Self::Double;
    fn ceil_double(x: Self::Double) -> Self::Double;
    fn greater_double(a: Self::Double, b: Self::Double) -> Self::Mask;
    fn choose_double(mask: Self::Mask, a: Self::Double, b: Self::Double) -> Self::Double;
    /// The nearest whole number; all must be less than 2³¹.
    fn whole_double(x: Self::Double) -> Self::Int;

    /// The nearest number of single precision.
    fn single(x: Self::Double) -> Self::Float;
    fn to_double(x: Self::Int) -> Self::Double;

    fn greater_int(a: Self::Int, b: Self::Int) -> Self::Mask;
    fn shift_right(a: Self::Int, by: Self::Int) -> Self::Int;
    fn choose_int(mask: Self::Mask, a: Self::Int, b: Self::Int) -> Self::Int;
    /// The numbers that they are.
    fn to_float(x: Self::Int) -> Self::Float;
    /// The bits of each number, and the number of such bits.
    fn to_bits(x: Self::Float) -> Self::Int;
    fn from_bits(bits: Self::Int) -> Self::Float;

    /// The low halves of integers.
    fn shorts(first: Self::Int, second: Self::Int) -> Self::Short;
    /// Vector `n` of the `N` that these are of, all numbers from 0 on.
    fn wide<const N: usize>(all: &[Self::Short; PAIRS], n: usize) -> Self::Int;
    /// Where `x` is from the one end on to the other, of each vector; ends are in order.
    fn in_range(x: Self::Short, ends: [i16; 2]) -> [Self::Mask; 2];

    /// The numbers of a short table at the places of each, all of which it has.
    fn looked_up(table: &[i32; 2 * RAYS], places: Self::Int) -> Self::Int;
    /// The bytes at the places of each; 0 at others than are before the last three, of which there must be.
    fn bytes(all: &[u8], places: Self::Int) -> Self::Int;
    /// The entries of a table at the places of each, all of which it has.
    fn entries<const LEN: usize>(table: &[[f32; 4]; LEN], places: Self::Int) -> [Self::Float; 4];

    /// Four numbers of each, side by side.
    fn side_by_side(of: [Self::Float; 4]) -> [[f32; 4]; RAYS];

    /// Says that the few voxels of a packet from `corner` on, whose rows and planes are so far apart, will soon be read, if that can be said.
    fn ask_for_all<T>(corner: usize, strides: [usize; 2], stored: &[T]);
    /// Says that of the few voxels of a packet from `corner` on, whose rows and planes are so far apart, the `last` row of each plane and all of the
    /// `last` plane will soon be read, if that can be said.
    fn ask_for<T>(corner: usize, strides: [usize; 2], last: [usize; 2], stored: &[T]);
    /// Whether any of few numbers is at least that one.
    fn any_at_least(few: &Self::Few, least: i16) -> bool;
    /// The numbers of the few voxels of a packet from `corner` on, whose rows and planes are so far apart.
    fn few(corner: usize, strides: [usize; 2], numbers: &[i16]) -> Self::Few;
    /// Likewise the first three parts of vectors.
    fn few_vectors(corner: usize, strides: [usize; 2], vectors: &[[i16; 4]]) -> [Self::Few; 3];
    /// Where samples are that are so far from few voxels' first one along each axis, `low` and `parts` together, which wrap, in parts of
    /// [`PART_BITS`] bits.
    fn places(low: &[Self::Short; 3], parts: [i16; 3], vectors: usize) -> Places<Self>;
    /// The trilinear samples of few numbers from 0 on: interpolated along x, y and z, from `a` to `b` by `t` parts of 2¹⁵ to `a` and the nearest whole
    /// number to `(b − a)·t/2¹⁵`, the higher of two. Of the first of two `vectors`, or of both; of the other, any.
    fn sampled(few: &Self::Few, places: &Places<Self>, vectors: usize) -> Self::Short;
    /// Likewise of pairs on the edges along x of cells, those of either vector.
    fn sampled_apart(pairs: [&[Self::Int; 4]; 2], within: &[Self::Short; 3], vectors: usize) -> Self::Short;
    /// What the ends of the four edges along x weigh of each cell of vector `n` of `N`, side by side: of `t` parts of 2¹⁵ along x the ends are `−(2¹⁵ − t)` and `−t`, since 16 bits
    /// hold no positive 2¹⁵; of y and z, `yz = y·z/2¹⁵`, `z − yz`, `y − yz`, and what those leave of 2¹⁵ − 1. All products are such nearest numbers.
    fn weights<const N: usize>(within: &[[Self::Short; PAIRS]; 3], n: usize) -> [Self::Short; 4];
    /// The trilinear samples of the parts of few vectors, of vector `n` of `N` of samples, by such weights.
    fn weighed<const N: usize>(
        few: &[Self::Few; 3],
        cells: &[Self::Short; PAIRS],
        n: usize,
        weights: &[Self::Short; 4],
    ) -> [Self::Float; 3];
    /// Two numbers side by side on each of the four edges along x of each cell, the first in the low half; of cells beyond what is stored, any.
    fn apart_pairs(apart: &Apart<Self>, numbers: &[i16]) -> [Self::Int; 4];
    /// The trilinear samples of the first three parts of vectors, by what pairs on the four edges weigh, those that are `shown`; of others, any.
    fn apart_vectors(
        apart: &Apart<Self>,
        weights: &[Self::Short; 4],
        vectors: &[[i16; 4]],
        shown: Self::Mask,
    ) -> [Self::Float; 3];
}

/// What is done in some way, as a function of its own. All of it is to be compiled in place there: `#[inline(always)]`, and no closures around
/// operations.
pub trait Kernel<S: Simd> {
    /// Does it.
    fn run(self);
}

/// What an expression is for each of some, as an array. A closure would not do: what it does is compiled for any processor, unless the
/// compiler happens to put it in place.
macro_rules! each {
    ($n:ident of [$($of:expr),+] => $value:expr) => {
        [$({
            let $n = $of;
            $value
        }),+]
    };
}

pub(super) use each;

/// `a` or `b`, whichever is smaller.
#[inline(always)]
pub fn smaller<S: Simd>(a: S::Float, b: S::Float) -> S::Float {
    S::choose(S::greater(b, a), a, b)
}

/// `a` or `b`, whichever is larger.
#[inline(always)]
pub fn larger<S: Simd>(a: S::Float, b: S::Float) -> S::Float {
    S::choose(S::greater(a, b), a, b)
}
