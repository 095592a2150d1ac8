//! In arrays, which compilers turn into what vectors there are.

use std::ops::{Add, BitAnd, BitOr, Mul, Not, Sub};

use super::{Kernel, RAYS, Simd};

mod sampling;

/// For any processor.
#[derive(Clone, Copy)]
pub struct Portable;

/// For what vectors the processor has.
#[multiversion::multiversion(targets("x86_64+avx2+fma"))]
fn run_there<K: Kernel<Portable>>(kernel: K) {
    kernel.run();
}

/// Sixteen of anything.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub struct Sixteen<T>([T; RAYS]);

impl<T: Copy> Sixteen<T> {
    /// What `f` makes of each.
    #[inline(always)]
    fn map<R: Copy + Default>(self, f: impl Fn(T) -> R) -> Sixteen<R> {
        let mut all = [R::default(); RAYS];
        for (one, of) in all.iter_mut().zip(self.0) {
            *one = f(of);
        }
        Sixteen(all)
    }

    /// What `f` makes of each with the other's.
    #[inline(always)]
    fn with<R: Copy + Default>(self, other: Self, f: impl Fn(T, T) -> R) -> Sixteen<R> {
        let mut all = [R::default(); RAYS];
        for (n, one) in all.iter_mut().enumerate() {
            *one = f(self.0[n], other.0[n]);
        }
        Sixteen(all)
    }

    /// Where `f` says so.
    #[inline(always)]
    fn which(self, other: Self, f: impl Fn(T, T) -> bool) -> Mask {
        self.with(other, |a, b| if f(a, b) { -1 } else { 0 })
    }

    #[inline(always)]
    fn choose(mask: Mask, a: Self, b: Self) -> Self {
        let mut all = b.0;
        for (n, one) in all.iter_mut().enumerate() {
            *one = if mask.0[n] != 0 { a.0[n] } else { b.0[n] };
        }
        Self(all)
    }
}

/// All bits of some, and none of others.
type Mask = Sixteen<i32>;

impl BitAnd for Mask {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        self.with(other, |a, b| a & b)
    }
}

impl BitOr for Mask {
    type Output = Self;

    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        self.with(other, |a, b| a | b)
    }
}

impl Not for Mask {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        self.map(|a| !a)
    }
}

macro_rules! arithmetic {
    ($number:ty, $add:expr, $sub:expr, $mul:expr) => {
        impl Add for Sixteen<$number> {
            type Output = Self;

            #[inline(always)]
            fn add(self, other: Self) -> Self {
                self.with(other, $add)
            }
        }

        impl Sub for Sixteen<$number> {
            type Output = Self;

            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                self.with(other, $sub)
            }
        }

        impl Mul for Sixteen<$number> {
            type Output = Self;

            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                self.with(other, $mul)
            }
        }
    };
}

arithmetic!(f32, |a, b| a + b, |a, b| a - b, |a, b| a * b);
arithmetic!(f64, |a, b| a + b, |a, b| a - b, |a, b| a * b);
arithmetic!(i32, i32::wrapping_add, i32::wrapping_sub, i32::wrapping_mul);

impl Simd for Portable {
    type Float = Sixteen<f32>;
    type Double = Sixteen<f64>;
    type Mask = Mask;
    type Int = Sixteen<i32>;

    fn run(kernel: impl Kernel<Self>) {
        run_there(kernel);
    }

    #[inline(always)]
    fn none() -> Mask {
        Sixteen([0; RAYS])
    }

    #[inline(always)]
    fn bits(mask: Mask) -> u16 {
        let mut bits = 0;
        for n in 0..RAYS {
            bits |= (mask.0[n] & 1 << n) as u16;
        }
        bits
    }

    #[inline(always)]
    fn float(x: f32) -> Self::Float {
        Sixteen([x; RAYS])
    }

    #[inline(always)]
    fn floats(x: [f32; RAYS]) -> Self::Float {
        Sixteen(x)
    }

    #[inline(always)]
    fn double(x: f64) -> Self::Double {
        Sixteen([x; RAYS])
    }

    #[inline(always)]
    fn doubles(x: [f64; RAYS]) -> Self::Double {
        Sixteen(x)
    }

    #[inline(always)]
    fn int(x: i32) -> Self::Int {
        Sixteen([x; RAYS])
    }

    #[inline(always)]
    fn ints(x: [i32; RAYS]) -> Self::Int {
        Sixteen(x)
    }

    #[inline(always)]
    fn int_array(x: Self::Int) -> [i32; RAYS] {
        x.0
    }

    #[inline(always)]
    fn mul_add(a: Self::Float, b: Self::Float, c: Self::Float) -> Self::Float {
        let mut all = [0.0; RAYS];
        for (n, one) in all.iter_mut().enumerate() {
            *one = a.0[n].mul_add(b.0[n], c.0[n]);
        }
        Sixteen(all)
    }

    #[inline(always)]
    fn divide(a: Self::Float, b: Self::Float) -> Self::Float {
        a.with(b, |a, b| a / b)
    }

    #[inline(always)]
    fn root(x: Self::Float) -> Self::Float {
        x.map(f32::sqrt)
    }

    #[inline(always)]
    fn absolute(x: Self::Float) -> Self::Float {
        x.map(f32::abs)
    }

    #[inline(always)]
    fn greater(a: Self::Float, b: Self::Float) -> Mask {
        a.which(b, |a, b| a > b)
    }

    #[inline(always)]
    fn choose(mask: Mask, a: Self::Float, b: Self::Float) -> Self::Float {
        Sixteen::choose(mask, a, b)
    }

    /// Vectors have no conversion that saturates as `as` does.
    #[inline(always)]
    fn whole(x: Self::Float) -> Self::Int {
        const FIRST: f32 = 1.5 * (1 << 23) as f32;
        x.map(|x| ((x + FIRST).to_bits() as i32).wrapping_sub(FIRST.to_bits() as i32))
    }

    #[inline(always)]
    fn inverse(x: Self::Double) -> Self::Double {
        x.map(f64::recip)
    }

    #[inline(always)]
    fn floor_double(x: Self::Double) -> Self::Double {
        x.map(f64::floor)
    }

    #[inline(always)]
    fn ceil_double(x: Self::Double) -> Self::Double {
        x.map(f64::ceil)
    }

    #[inline(always)]
    fn greater_double(a: Self::Double, b: Self::Double) -> Mask {
        a.which(b, |a, b| a > b)
    }

    #[inline(always)]
    fn choose_double(mask: Mask, a: Self::Double, b: Self::Double) -> Self::Double {
        Sixteen::choose(mask, a, b)
    }

    #[inline(always)]
    fn whole_double(x: Self::Double) -> Self::Int {
        const FIRST: f64 = 1.5 * (1u64 << 52) as f64;
        x.map(|x| (x + FIRST).to_bits() as i32)
    }

    #[inline(always)]
    fn single(x: Self::Double) -> Self::Float {
        x.map(|x| x as f32)
    }

    #[inline(always)]
    fn to_double(x: Self::Int) -> Self::Double {
        x.map(f64::from)
    }

    #[inline(always)]
    fn greater_int(a: Self::Int, b: Self::Int) -> Mask {
        a.which(b, |a, b| a > b)
    }

    #[inline(always)]
    fn shift_right(a: Self::Int, by: Self::Int) -> Self::Int {
        a.with(by, |a, by| ((a as u32) >> (by & 31)) as i32)
    }

    #[inline(always)]
    fn choose_int(mask: Mask, a: Self::Int, b: Self::Int) -> Self::Int {
        Sixteen::choose(mask, a, b)
    }

    #[inline(always)]
    fn to_float(x: Self::Int) -> Self::Float {
        x.map(|x| x as f32)
    }

    #[inline(always)]
    fn to_bits(x: Self::Float) -> Self::Int {
        x.map(|x| x.to_bits() as i32)
    }

    #[inline(always)]
    fn from_bits(bits: Self::Int) -> Self::Float {
        bits.map(|bits| f32::from_bits(bits as u32))
    }

    #[inline(always)]
    fn looked_up(table: &[i32; 2 * RAYS], places: Self::Int) -> Self::Int {
        places.map(|place| table[place as usize % (2 * RAYS)])
    }

    #[inline(always)]
    fn bytes(all: &[u8], places: Self::Int) -> Self::Int {
        let all = &all[..all.len().checked_sub(3).expect("three more bytes")];
        places.map(|place| all.get(place as u32 as usize).map_or(0, |byte| i32::from(*byte)))
    }

    #[inline(always)]
    fn entries<const LEN: usize>(table: &[[f32; 4]; LEN], places: Self::Int) -> [Self::Float; 4] {
        let mut entries = [[0.0; RAYS]; 4];
        for (n, place) in places.0.into_iter().enumerate() {
            let entry = table[place as usize];
            (entries[0][n], entries[1][n]) = (entry[0], entry[1]);
            (entries[2][n], entries[3][n]) = (entry[2], entry[3]);
        }
        entries.map(Sixteen)
    }

    #[inline(always)]
    fn side_by_side([a, b, c, d]: [Self::Float; 4]) -> [[f32; 4]; RAYS] {
        std::array::from_fn(|n| [a.0[n], b.0[n], c.0[n], d.0[n]])
    }
}
