//! Sixteen numbers side by side, those of the rays of a square of pixels.
//!
//! *Practice.* The ray caster is written once, for any [`Simd`]: [`Portable`] in arrays, which compilers turn into what vectors the
//! processor has, [`Avx512`] in registers of 512 bits. Each operation rounds as the other's does, so the bits of a frame are the same.

#[cfg(target_arch = "x86_64")]
mod avx512;
mod normal;
mod portable;
mod sampling;

use std::ops::{Add, BitAnd, BitOr, Mul, Not, Sub};

#[cfg(target_arch = "x86_64")]
pub use avx512::Avx512;
pub use normal::{ONE_NORMAL, packed};
pub use portable::Portable;
pub use sampling::{ALL_WEIGHTS, Apart, PAIRS, PART_BITS, Places, Sampling};

/// Pixels along an edge of a vector's square.
pub const EDGE: usize = 4;

/// Rays of a vector, row by row.
pub const RAYS: usize = EDGE * EDGE;

/// Voxels of a packet whose voxels are few: [`EDGE`] along each axis.
pub const FEW: usize = EDGE * EDGE * EDGE;

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

    /// The numbers of a short table at the places of each, all of which it has.
    fn looked_up(table: &[i32; 2 * RAYS], places: Self::Int) -> Self::Int;
    /// The bytes at the places of each; 0 at others than are before the last three, of which there must be.
    fn bytes(all: &[u8], places: Self::Int) -> Self::Int;
    /// The entries of a table at the places of each, all of which it has.
    fn entries<const LEN: usize>(table: &[[f32; 4]; LEN], places: Self::Int) -> [Self::Float; 4];

    /// Four numbers of each, side by side.
    fn side_by_side(of: [Self::Float; 4]) -> [[f32; 4]; RAYS];
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
