//! In arrays, which compilers turn into what vectors there are.

use std::ops::{Add, BitAnd, BitOr, Mul, Not, Sub};

use super::{Apart, EDGE, FEW, Kernel, Pairs, RAYS, Simd, Within};

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
    type Few = [i16; FEW];

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
    fn shift_left(a: Self::Int, by: Self::Int) -> Self::Int {
        a.with(by, |a, by| a << (by & 31))
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
    fn weights(second: Self::Int) -> Self::Int {
        second.map(|second| (second ^ 0x8000).wrapping_sub(second << 16))
    }

    #[inline(always)]
    fn weighed(pairs: Self::Int, weights: Self::Int) -> Self::Float {
        pairs.with(weights, |pair, weight| {
            let (first, second) = (pair << 16 >> 16, pair >> 16);
            (first * (weight << 16 >> 16) + second * (weight >> 16)) as f32
        })
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

    #[inline(always)]
    fn ask_for<T>(_: usize, _: [usize; 2], _: [usize; 2], _: &[T]) {}

    #[inline(always)]
    fn any_at_least(few: &Self::Few, least: i16) -> bool {
        few.iter().fold(false, |any, number| any | (*number >= least))
    }

    #[inline(always)]
    fn few(corner: usize, strides: [usize; 2], numbers: &[i16]) -> Self::Few {
        let mut few = [0; FEW];
        for (few, row) in few.chunks_exact_mut(EDGE).zip(rows(corner, strides, numbers)) {
            few.copy_from_slice(row);
        }
        few
    }

    #[inline(always)]
    fn few_vectors(corner: usize, strides: [usize; 2], vectors: &[[i16; 4]]) -> [Self::Few; 3] {
        let mut few = [[0; FEW]; 3];
        for (n, row) in rows(corner, strides, vectors).enumerate() {
            for (x, vector) in row.iter().enumerate() {
                for part in 0..3 {
                    few[part][EDGE * n + x] = vector[part];
                }
            }
        }
        few
    }

    #[inline(always)]
    fn take(few: &Self::Few, cells: Self::Int) -> Pairs<Self> {
        let mut pairs = [[0; RAYS]; 4];
        for (pair, by) in pairs.iter_mut().zip([0, EDGE, EDGE * EDGE, EDGE * EDGE + EDGE]) {
            for (pair, cell) in pair.iter_mut().zip(cells.0) {
                let number = |at: usize| i32::from(few[at % FEW] as u16);
                let at = cell as u16 as usize + by;
                *pair = number(at) | number(at + 1) << 16;
            }
        }
        pairs.map(Sixteen)
    }

    #[inline(always)]
    fn apart_pairs(apart: &Apart<Self>, numbers: &[i16]) -> Pairs<Self> {
        let mut pairs = [[0i32; RAYS]; 4];
        let edges = edges(apart.strides, numbers);
        let cells = edges[0].len();
        for n in 0..RAYS {
            let at = apart.voxels.0[n] as usize;
            // Every place is in the block. But for this way out of the loop compilers may fetch by vectors, which is slower.
            if at + 1 >= cells {
                break;
            }
            for (pair, edge) in pairs.iter_mut().zip(edges) {
                pair[n] = i32::from(edge[..cells][at] as u16) | i32::from(edge[..cells][at + 1]) << 16;
            }
        }
        pairs.map(Sixteen)
    }

    /// One after another.
    #[inline(always)]
    fn apart_vectors(
        apart: &Apart<Self>,
        within: &Within<Self>,
        vectors: &[[i16; 4]],
        shown: Mask,
    ) -> [Self::Float; 3] {
        let edges = edges(apart.strides, vectors);
        let mut all = [[0.0; 4]; RAYS];
        let mut left = Self::bits(shown);
        while left != 0 {
            let n = left.trailing_zeros() as usize % RAYS;
            let parts = within.parts.map(|part| part.0[n]);
            all[n] = vector(&edges, apart.voxels.0[n] as usize, within.weights.0[n], parts);
            left &= left - 1;
        }
        [0, 1, 2].map(|part| Sixteen(all.map(|vector| vector[part])))
    }
}

/// The trilinear sample of vectors on the [`edges`] of cells, in that whose low corner is voxel `at`, by the operations of
/// [`Within::between`].
#[inline(always)]
fn vector(edges: &[&[[i16; 4]]; 4], at: usize, weights: i32, [ty, tz]: [f32; 2]) -> [f32; 4] {
    let (first, second) = (weights << 16 >> 16, weights >> 16);
    let weights = [first, first, first, first, second, second, second, second];
    let edge = |edge: usize| -> [f32; 4] {
        // Two voxels side by side.
        let pair: Option<&[[i16; 4]; 2]> = edges[edge].get(at..).and_then(|rest| rest.first_chunk());
        let pair: [i16; 8] = bytemuck::cast(pair.copied().unwrap_or_default());
        let mut weighed = [0; 8];
        for c in 0..8 {
            weighed[c] = i32::from(pair[c]) * weights[c];
        }
        let mut edge = [0.0; 4];
        for c in 0..4 {
            edge[c] = (weighed[c] + weighed[c + 4]) as f32;
        }
        edge
    };
    let between = |a: [f32; 4], b: [f32; 4], t: f32| {
        let mut mixed = [0.0; 4];
        for c in 0..4 {
            mixed[c] = t.mul_add(b[c] - a[c], a[c]);
        }
        mixed
    };
    let near = between(edge(0), edge(1), ty);
    let far = between(edge(2), edge(3), ty);
    between(near, far, tz)
}

/// What is stored, from the first voxel on each of the four edges of a cell along x: an index in one is in all of them.
#[inline(always)]
fn edges<T>([row, plane]: [usize; 2], stored: &[T]) -> [&[T]; 4] {
    let cells = stored.len().saturating_sub(row + plane);
    [0, row, plane, row + plane].map(|by| stored.get(by..by + cells).unwrap_or_default())
}

/// The rows that few voxels are in, from the one at `corner` on.
#[inline(always)]
fn rows<T>(corner: usize, [y, z]: [usize; 2], stored: &[T]) -> impl Iterator<Item = &[T]> {
    let all = &stored[corner..][..(EDGE - 1) * (y + z) + EDGE];
    (0..EDGE * EDGE).map(move |n| &all[n % EDGE * y + n / EDGE * z..][..EDGE])
}
