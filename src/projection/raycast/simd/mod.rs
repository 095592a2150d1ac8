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

/// The weight that is stored for 1. All weights are negative: 16 bits hold no positive number as large.
pub const ONE_WEIGHT: f32 = -32768.0;

/// Two stored numbers side by side on each of the four edges along x of each sample's cell, the first in the low half.
pub type Pairs<S> = [<S as Simd>::Int; 4];

/// Cells of a bundle that are anywhere.
#[derive(Clone, Copy)]
pub struct Apart<S: Simd> {
    /// The stored voxel at each cell's low corner.
    pub voxels: S::Int,
    /// How far rows and planes of stored voxels are apart.
    pub strides: [usize; 2],
}

/// How far samples are in their cells.
#[derive(Clone, Copy)]
pub struct Within<S: Simd> {
    /// What the low and the high side weigh along x.
    pub weights: S::Int,
    /// Parts of the way along y and z.
    pub parts: [S::Float; 2],
}

impl<S: Simd> Within<S> {
    /// What is sampled of the weighed pairs on the four edges of cells along x, in parts of [`ONE_WEIGHT`] as they are.
    #[inline(always)]
    pub fn between(&self, [a, b, c, d]: [S::Float; 4]) -> S::Float {
        let [ty, tz] = self.parts;
        let (near, far) = (between::<S>(a, b, ty), between::<S>(c, d, ty));
        between::<S>(near, far, tz)
    }
}

/// What is `t` of the way from `a` to `b`.
#[inline(always)]
fn between<S: Simd>(a: S::Float, b: S::Float, t: S::Float) -> S::Float {
    S::mul_add(t, b - a, a)
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
    fn shift_left(a: Self::Int, by: Self::Int) -> Self::Int;
    fn choose_int(mask: Self::Mask, a: Self::Int, b: Self::Int) -> Self::Int;
    /// The numbers that they are.
    fn to_float(x: Self::Int) -> Self::Float;
    /// The bits of each number, and the number of such bits.
    fn to_bits(x: Self::Float) -> Self::Int;
    fn from_bits(bits: Self::Int) -> Self::Float;
    /// What two numbers weigh of which the second weighs so many parts of 2¹⁵: in parts of [`ONE_WEIGHT`], the first one's in the low half.
    fn weights(second: Self::Int) -> Self::Int;
    /// The sum of a pair's numbers times their weights.
    fn weighed(pairs: Self::Int, weights: Self::Int) -> Self::Float;

    /// The numbers of a short table at the places of each, all of which it has.
    fn looked_up(table: &[i32; 2 * RAYS], places: Self::Int) -> Self::Int;
    /// The bytes at the places of each; 0 at others than are before the last three, of which there must be.
    fn bytes(all: &[u8], places: Self::Int) -> Self::Int;
    /// The entries of a table at the places of each, all of which it has.
    fn entries<const LEN: usize>(table: &[[f32; 4]; LEN], places: Self::Int) -> [Self::Float; 4];

    /// Four numbers of each, side by side.
    fn side_by_side(of: [Self::Float; 4]) -> [[f32; 4]; RAYS];

    /// Says that of the few voxels of a packet from `corner` on, whose rows and planes are so far apart, the `last` row of each plane and all of the
    /// `last` plane will soon be read, if that can be said.
    fn ask_for<T>(corner: usize, strides: [usize; 2], last: [usize; 2], stored: &[T]);
    /// Whether any of few numbers is at least that one.
    fn any_at_least(few: &Self::Few, least: i16) -> bool;
    /// The numbers of the few voxels of a packet from `corner` on, whose rows and planes are so far apart.
    fn few(corner: usize, strides: [usize; 2], numbers: &[i16]) -> Self::Few;
    /// Likewise the first three parts of vectors.
    fn few_vectors(corner: usize, strides: [usize; 2], vectors: &[[i16; 4]]) -> [Self::Few; 3];
    /// The numbers round samples, whose cells say which of the few is at their low corner, x fastest, in the low half, and which is next to it along x in
    /// the high one; of other cells, any.
    fn take(few: &Self::Few, cells: Self::Int) -> Pairs<Self>;
    /// The numbers round samples; of cells beyond what is stored, any.
    fn apart_pairs(apart: &Apart<Self>, numbers: &[i16]) -> Pairs<Self>;
    /// The trilinear samples of the first three parts of vectors, in parts of [`ONE_WEIGHT`], those that are `shown`; of others, any.
    fn apart_vectors(
        apart: &Apart<Self>,
        within: &Within<Self>,
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
