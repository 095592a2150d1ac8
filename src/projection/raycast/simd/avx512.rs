//! In registers of 512 bits.

use std::arch::asm;
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Mul, Sub};

use super::{Kernel, RAYS, Simd, each};

/// For processors with AVX-512 F, BW and VL. Nothing of it may be called but what [`Avx512::run`] does.
#[derive(Clone, Copy)]
pub struct Avx512;

impl Avx512 {
    /// Whether the processor has it.
    pub fn is_there() -> bool {
        is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512vl")
    }
}

#[target_feature(enable = "avx512f,avx512bw,avx512vl")]
#[inline(never)]
fn run_there(kernel: impl Kernel<Avx512>) {
    kernel.run();
}

#[derive(Clone, Copy)]
pub struct Float(__m512);

#[derive(Clone, Copy)]
pub struct Double(__m512d, __m512d);

#[derive(Clone, Copy)]
pub struct Int(__m512i);

macro_rules! operator {
    ($number:ident, $operator:ident, $f:ident, |$a:ident, $b:ident| $of:expr) => {
        impl $operator for $number {
            type Output = Self;

            #[inline(always)]
            fn $f(self, other: Self) -> Self {
                let ($a, $b) = (self, other);
                // SAFETY: these numbers are made only where the processor has AVX-512: see [`Avx512`].
                unsafe { $of }
            }
        }
    };
}

operator!(Float, Add, add, |a, b| Float(_mm512_add_ps(a.0, b.0)));
operator!(Float, Sub, sub, |a, b| Float(_mm512_sub_ps(a.0, b.0)));
operator!(Float, Mul, mul, |a, b| Float(_mm512_mul_ps(a.0, b.0)));
operator!(Double, Add, add, |a, b| Double(
    _mm512_add_pd(a.0, b.0),
    _mm512_add_pd(a.1, b.1)
));
operator!(Double, Sub, sub, |a, b| Double(
    _mm512_sub_pd(a.0, b.0),
    _mm512_sub_pd(a.1, b.1)
));
operator!(Double, Mul, mul, |a, b| Double(
    _mm512_mul_pd(a.0, b.0),
    _mm512_mul_pd(a.1, b.1)
));
operator!(Int, Add, add, |a, b| Int(_mm512_add_epi32(a.0, b.0)));
operator!(Int, Sub, sub, |a, b| Int(_mm512_sub_epi32(a.0, b.0)));
operator!(Int, Mul, mul, |a, b| Int(_mm512_mullo_epi32(a.0, b.0)));
operator!(Int, BitAnd, bitand, |a, b| Int(_mm512_and_si512(a.0, b.0)));
operator!(Int, BitOr, bitor, |a, b| Int(_mm512_or_si512(a.0, b.0)));

/// Methods of [`Simd`] that are operations of the processor.
macro_rules! operations {
    ($(fn $name:ident($($argument:ident: $of:ty),*) -> $result:ty { $body:expr })*) => {$(
        #[inline(always)]
        fn $name($($argument: $of),*) -> $result {
            // SAFETY: called only where the processor has AVX-512 (see [`Avx512`]); nothing is read or written but the arguments.
            unsafe { $body }
        }
    )*};
}

const DOWN: i32 = _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC;
const UP: i32 = _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC;

mod sampling;

impl Simd for Avx512 {
    type Float = Float;
    type Double = Double;
    type Mask = u16;
    type Int = Int;

    fn run(kernel: impl Kernel<Self>) {
        assert!(Self::is_there(), "the processor has no AVX-512");
        // SAFETY: it has.
        unsafe { run_there(kernel) }
    }

    #[inline(always)]
    fn none() -> u16 {
        0
    }

    #[inline(always)]
    fn bits(mask: u16) -> u16 {
        mask
    }

    operations! {
        fn float(x: f32) -> Float { Float(_mm512_set1_ps(x)) }
        fn floats(x: [f32; RAYS]) -> Float { Float(std::mem::transmute::<[f32; RAYS], __m512>(x)) }
        fn double(x: f64) -> Double { Double(_mm512_set1_pd(x), _mm512_set1_pd(x)) }
        fn doubles(x: [f64; RAYS]) -> Double {
            {
                let [a, b] = std::mem::transmute::<[f64; RAYS], [__m512d; 2]>(x);
                Double(a, b)
            }
        }
        fn int(x: i32) -> Int { Int(_mm512_set1_epi32(x)) }
        fn ints(x: [i32; RAYS]) -> Int { Int(std::mem::transmute::<[i32; RAYS], __m512i>(x)) }
        fn int_array(x: Int) -> [i32; RAYS] { std::mem::transmute::<__m512i, [i32; RAYS]>(x.0) }

        fn mul_add(a: Float, b: Float, c: Float) -> Float { Float(_mm512_fmadd_ps(a.0, b.0, c.0)) }
        fn divide(a: Float, b: Float) -> Float { Float(_mm512_div_ps(a.0, b.0)) }
        fn root(x: Float) -> Float { Float(_mm512_sqrt_ps(x.0)) }
        fn absolute(x: Float) -> Float { Float(_mm512_abs_ps(x.0)) }
        fn greater(a: Float, b: Float) -> u16 { _mm512_cmp_ps_mask::<_CMP_GT_OQ>(a.0, b.0) }
        fn choose(mask: u16, a: Float, b: Float) -> Float { Float(_mm512_mask_blend_ps(mask, b.0, a.0)) }
        fn whole(x: Float) -> Int { Int(_mm512_cvtps_epi32(x.0)) }

        fn inverse(x: Double) -> Double {
            {
                let one = _mm512_set1_pd(1.0);
                Double(_mm512_div_pd(one, x.0), _mm512_div_pd(one, x.1))
            }
        }
        fn floor_double(x: Double) -> Double {
            Double(_mm512_roundscale_pd::<DOWN>(x.0), _mm512_roundscale_pd::<DOWN>(x.1))
        }
        fn ceil_double(x: Double) -> Double {
            Double(_mm512_roundscale_pd::<UP>(x.0), _mm512_roundscale_pd::<UP>(x.1))
        }
        fn greater_double(a: Double, b: Double) -> u16 {
            u16::from(_mm512_cmp_pd_mask::<_CMP_GT_OQ>(a.0, b.0))
                | u16::from(_mm512_cmp_pd_mask::<_CMP_GT_OQ>(a.1, b.1)) << 8
        }
        fn choose_double(mask: u16, a: Double, b: Double) -> Double {
            Double(
                _mm512_mask_blend_pd(mask as u8, b.0, a.0),
                _mm512_mask_blend_pd((mask >> 8) as u8, b.1, a.1),
            )
        }
        fn whole_double(x: Double) -> Int {
            Int(_mm512_inserti64x4::<1>(_mm512_castsi256_si512(_mm512_cvtpd_epi32(x.0)), _mm512_cvtpd_epi32(x.1)))
        }

        fn single(x: Double) -> Float {
            Float(_mm512_castsi512_ps(_mm512_inserti64x4::<1>(
                _mm512_castsi256_si512(_mm256_castps_si256(_mm512_cvtpd_ps(x.0))),
                _mm256_castps_si256(_mm512_cvtpd_ps(x.1))
            )))
        }
        fn to_double(x: Int) -> Double {
            Double(
                _mm512_cvtepi32_pd(_mm512_castsi512_si256(x.0)),
                _mm512_cvtepi32_pd(_mm512_extracti64x4_epi64::<1>(x.0)),
            )
        }

        fn greater_int(a: Int, b: Int) -> u16 { _mm512_cmpgt_epi32_mask(a.0, b.0) }
        fn shift_right(a: Int, by: Int) -> Int { Int(_mm512_srlv_epi32(a.0, by.0)) }
        fn choose_int(mask: u16, a: Int, b: Int) -> Int { Int(_mm512_mask_blend_epi32(mask, b.0, a.0)) }
        fn to_bits(x: Float) -> Int { Int(_mm512_castps_si512(x.0)) }
        fn from_bits(bits: Int) -> Float { Float(_mm512_castsi512_ps(bits.0)) }
        fn to_float(x: Int) -> Float { Float(_mm512_cvtepi32_ps(x.0)) }

    }

    #[inline(always)]
    fn looked_up(table: &[i32; 2 * RAYS], places: Int) -> Int {
        // SAFETY: the table is two registers, and only so many bits of a place are looked at; the processor has AVX-512.
        unsafe {
            let [low, high] = each!(from of [0, RAYS] => _mm512_loadu_si512(table.as_ptr().add(from).cast()));
            Int(_mm512_permutex2var_epi32(low, places.0, high))
        }
    }

    #[inline(always)]
    fn bytes(all: &[u8], places: Int) -> Int {
        let end = all
            .len()
            .checked_sub(3)
            .expect("three more bytes")
            .min(i32::MAX as usize) as i32;
        // SAFETY: four bytes are there from any place on that is less than `end`; the processor has AVX-512.
        unsafe {
            let there = _mm512_cmplt_epu32_mask(places.0, _mm512_set1_epi32(end));
            let fours = _mm512_mask_i32gather_epi32::<1>(_mm512_setzero_si512(), there, places.0, all.as_ptr().cast());
            Int(_mm512_and_si512(fours, _mm512_set1_epi32(0xff)))
        }
    }

    /// Four entries a register, one in each quarter, and then four by four transposed.
    #[inline(always)]
    fn entries<const LEN: usize>(table: &[[f32; 4]; LEN], places: Int) -> [Float; 4] {
        assert!((1..1 << 16).contains(&LEN), "{LEN} entries");
        // SAFETY: no place is behind the last entry, which are four numbers each; the processor has AVX-512.
        unsafe {
            let places = _mm512_min_epu32(places.0, _mm512_set1_epi32(LEN as i32 - 1));
            let places = one_by_one(_mm512_cvtepi32_epi16(places));
            let at = |n: usize| _mm_loadu_ps(table.as_ptr().cast::<f32>().add(4 * places[n] as usize));
            let [a, b, c, d] = each!(n of [0, 1, 2, 3] => {
                let a = _mm512_castps128_ps512(at(n));
                let b = _mm512_insertf32x4::<1>(a, at(n + 4));
                let c = _mm512_insertf32x4::<2>(b, at(n + 8));
                _mm512_insertf32x4::<3>(c, at(n + 12))
            });
            let [a, b, c, d] = transposed([a, b, c, d]);
            [Float(a), Float(b), Float(c), Float(d)]
        }
    }

    #[inline(always)]
    fn side_by_side([a, b, c, d]: [Float; 4]) -> [[f32; 4]; RAYS] {
        // SAFETY: the processor has AVX-512; sixteen times four numbers are as many as four times sixteen.
        unsafe {
            // Of each four of sixteen one, in each.
            let [a, b, c, d] = transposed([a.0, b.0, c.0, d.0]);
            let (low, high) = (_mm512_shuffle_f32x4::<0x44>(a, b), _mm512_shuffle_f32x4::<0x44>(c, d));
            let (rest_low, rest_high) = (_mm512_shuffle_f32x4::<0xee>(a, b), _mm512_shuffle_f32x4::<0xee>(c, d));
            std::mem::transmute::<[__m512; 4], [[f32; 4]; RAYS]>([
                _mm512_shuffle_f32x4::<0x88>(low, high),
                _mm512_shuffle_f32x4::<0xdd>(low, high),
                _mm512_shuffle_f32x4::<0x88>(rest_low, rest_high),
                _mm512_shuffle_f32x4::<0xdd>(rest_low, rest_high),
            ])
        }
    }
}

/// Numbers of 16 bits, to be used one by one. They are taken out of the register four at a time: compilers would do so with each, by two operations
/// of vectors, of which there are more than enough. Read from memory they are late: it waits for the whole register to be there.
///
/// # Safety
/// The processor has AVX-512.
#[inline(always)]
unsafe fn one_by_one(numbers: __m256i) -> [u16; RAYS] {
    // SAFETY: a register is four times four numbers.
    let fours = unsafe { std::mem::transmute::<__m256i, [u64; 4]>(numbers) };
    let [a, b, c, d] = each!(n of [0, 1, 2, 3] => {
        let mut four = fours[n];
        // SAFETY: it does nothing, which the compiler is not told.
        unsafe { asm!("/* {four} */", four = inout(reg) four, options(pure, nomem, nostack, preserves_flags)) };
        each!(by of [0, 16, 32, 48] => (four >> by) as u16)
    });
    // SAFETY: four times four numbers are sixteen.
    unsafe { std::mem::transmute::<[[u16; 4]; 4], [u16; RAYS]>([a, b, c, d]) }
}

/// The numbers of each quarter of four registers, transposed.
///
/// # Safety
/// The processor has AVX-512.
#[inline(always)]
unsafe fn transposed([a, b, c, d]: [__m512; 4]) -> [__m512; 4] {
    // SAFETY: as above.
    unsafe {
        let (ab, cd) = (_mm512_unpacklo_ps(a, b), _mm512_unpacklo_ps(c, d));
        let (ef, gh) = (_mm512_unpackhi_ps(a, b), _mm512_unpackhi_ps(c, d));
        [
            _mm512_shuffle_ps::<0x44>(ab, cd),
            _mm512_shuffle_ps::<0xee>(ab, cd),
            _mm512_shuffle_ps::<0x44>(ef, gh),
            _mm512_shuffle_ps::<0xee>(ef, gh),
        ]
    }
}
