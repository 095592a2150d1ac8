//! Sampling in registers of 512 bits.
//!
//! *Practice.* A cell's corners are not read one after another: the 4³ voxels that the cells of a bundle are among go into registers, row
//! by row, and each sample takes its own from there by permutations. What is read one by one goes into registers as an array: functions
//! that take sixteen arguments are not always compiled in place.

use std::arch::x86_64::*;

use super::super::{Apart, EDGE, PAIRS, PART_BITS, Places, RAYS, Sampling, Simd, each, normal};
use super::{Avx512, Float, Int};

#[derive(Clone, Copy)]
pub struct Short(__m512i);

/// The first two planes and the last two.
pub struct Few {
    low: __m512i,
    high: __m512i,
}

/// Words of the 4³ voxels from a cell's low corner to the next row, and to the next plane.
const ROW: i16 = EDGE as i16;
const PLANE: i16 = (EDGE * EDGE) as i16;

/// The even ones of 64 words.
static EVEN: [i16; 32] = {
    let mut words = [0; 32];
    let mut n = 0;
    while n < 32 {
        words[n] = 2 * n as i16;
        n += 1;
    }
    words
};

/// Each of 16 words twice.
static TWICE: [i16; 32] = {
    let mut words = [0; 32];
    let mut n = 0;
    while n < 32 {
        words[n] = n as i16 / 2;
        n += 1;
    }
    words
};

impl Sampling for Avx512 {
    type Short = Short;
    type Few = Few;

    operations! {
        fn shorts(first: Int, second: Int) -> Short {
            Short(every_second(first.0, 0, second.0))
        }
        fn in_range(x: Short, ends: [i16; 2]) -> [u16; 2] {
            {
                let from_first = _mm512_sub_epi16(x.0, _mm512_set1_epi16(ends[0]));
                let mask = _mm512_cmple_epu16_mask(from_first, _mm512_set1_epi16(ends[1].wrapping_sub(ends[0])));
                [mask as u16, (mask >> 16) as u16]
            }
        }
        fn places(low: &[Short; 3], parts: [i16; 3], _vectors: usize) -> Places<Self> {
            {
                let [x, y, z] = each!(axis of [0, 1, 2] => _mm512_add_epi16(low[axis].0, _mm512_set1_epi16(parts[axis])));
                // Two bits of each.
                let xy = or_bits(_mm512_srli_epi16::<PART_BITS>(x), _mm512_srli_epi16::<{ PART_BITS - 2 }>(y), 0b1100);
                Places {
                    cell: Short(or_bits(xy, _mm512_srli_epi16::<{ PART_BITS - 4 }>(z), 0b11_0000)),
                    within: each!(at of [x, y, z] => Short(_mm512_srli_epi16::<1>(_mm512_slli_epi16::<{ 16 - PART_BITS }>(at)))),
                }
            }
        }
        fn sampled(few: &Few, places: &Places<Self>, _vectors: usize) -> Short {
            between_all(
                each!(edge of [0, ROW, PLANE, PLANE + ROW] => {
                    each!(end of [edge, edge + 1] => take(few, _mm512_add_epi16(places.cell.0, _mm512_set1_epi16(end))))
                }),
                &places.within,
            )
        }
        fn sampled_apart(pairs: [&[Int; 4]; 2], within: &[Short; 3], _vectors: usize) -> Short {
            {
                let ends = each!(edge of [0, 1, 2, 3] => {
                    each!(first of [0, 1] => every_second(pairs[0][edge].0, first, pairs[1][edge].0))
                });
                between_all(ends, within)
            }
        }
    }

    #[inline(always)]
    fn wide<const N: usize>(all: &[Short; PAIRS], n: usize) -> Int {
        // SAFETY: the processor has AVX-512.
        Int(unsafe { _mm512_cvtepu16_epi32(nth::<N>(all, n)) })
    }

    #[inline(always)]
    fn weights<const N: usize>(within: &[[Short; PAIRS]; 3], n: usize) -> [Short; 4] {
        // SAFETY: the processor has AVX-512.
        unsafe {
            let [x, y, z] = each!(axis of [0, 1, 2] => twice::<N>(&within[axis], n));
            let signs = _mm512_xor_si512(x, _mm512_set1_epi32(0xffff_8000_u32 as i32));
            let ends = _mm512_add_epi16(signs, _mm512_set1_epi32(1 << 16));
            let yz = _mm512_mulhrs_epi16(y, z);
            let (y_alone, z_alone) = (_mm512_sub_epi16(y, yz), _mm512_sub_epi16(z, yz));
            let none = _mm512_sub_epi16(_mm512_sub_epi16(_mm512_set1_epi16(i16::MAX), y), z_alone);
            each!(of of [none, y_alone, z_alone, yz] => Short(_mm512_mulhrs_epi16(ends, of)))
        }
    }

    #[inline(always)]
    fn weighed<const N: usize>(few: &[Few; 3], cells: &[Short; PAIRS], n: usize, weights: &[Short; 4]) -> [Float; 3] {
        // SAFETY: the processor has AVX-512.
        unsafe {
            let ends = _mm512_add_epi16(twice::<N>(cells, n), _mm512_set1_epi32(1 << 16));
            let edges = each!(edge of [0, ROW, PLANE, PLANE + ROW] => _mm512_add_epi16(ends, _mm512_set1_epi16(edge)));
            each!(part of [0, 1, 2] => {
                sum_of_products(each!(edge of [0, 1, 2, 3] => take(&few[part], edges[edge])), weights)
            })
        }
    }

    #[inline(always)]
    fn ask_for_all<T>(corner: usize, [y, z]: [usize; 2], stored: &[T]) {
        let first = stored.as_ptr().wrapping_add(corner);
        for n in 0..EDGE * EDGE {
            ask_for_row(first.wrapping_add(n % EDGE * y + n / EDGE * z));
        }
    }

    #[inline(always)]
    fn ask_for<T>(corner: usize, [y, z]: [usize; 2], [last_y, last_z]: [usize; 2], stored: &[T]) {
        let first = stored.as_ptr().wrapping_add(corner);
        for n in 0..EDGE {
            ask_for_row(first.wrapping_add(last_y * y + n * z));
            ask_for_row(first.wrapping_add(n * y + last_z * z));
        }
    }

    #[inline(always)]
    fn any_at_least(few: &Few, least: i16) -> bool {
        // SAFETY: the processor has AVX-512.
        unsafe { _mm512_cmpge_epi16_mask(_mm512_max_epi16(few.low, few.high), _mm512_set1_epi16(least)) != 0 }
    }

    #[inline(always)]
    fn few(corner: usize, strides: [usize; 2], numbers: &[i16]) -> Few {
        let rows = rows(corner, strides, numbers);
        // SAFETY: each row is four numbers, eight bytes; the processor has AVX-512.
        unsafe {
            let row = |z: usize, y: usize| rows[4 * z + y].cast::<i64>().read_unaligned();
            let [low, high] = each!(z of [0, 2] => {
                std::mem::transmute::<[i64; 8], __m512i>([
                    row(z, 0),
                    row(z, 1),
                    row(z, 2),
                    row(z, 3),
                    row(z + 1, 0),
                    row(z + 1, 1),
                    row(z + 1, 2),
                    row(z + 1, 3),
                ])
            });
            Few { low, high }
        }
    }

    #[inline(always)]
    fn few_normals(corner: usize, strides: [usize; 2], normals: &[u32]) -> [Few; 3] {
        let rows = rows(corner, strides, normals);
        // SAFETY: each row is four normals, sixteen bytes; the processor has AVX-512.
        unsafe {
            let planes = each!(z of [0, 1, 2, 3] => {
                let [a, b, c, d] = each!(n of [4 * z, 4 * z + 1, 4 * z + 2, 4 * z + 3] => _mm_loadu_si128(rows[n].cast()));
                let ab = _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(a), b);
                let cd = _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(c), d);
                _mm512_inserti64x4::<1>(_mm512_castsi256_si512(ab), cd)
            });
            let [low, high] = each!(n of [0, 2] => {
                let [low, high] = each!(first of [0, 1] => every_second(planes[n], first, planes[n + 1]));
                normal_parts(high, low)
            });
            each!(part of [0, 1, 2] => Few { low: low[part], high: high[part] })
        }
    }

    #[inline(always)]
    fn apart_pairs(apart: &Apart<Self>, numbers: &[i16]) -> [Int; 4] {
        let (voxels, edges) = in_reach(apart, numbers);
        each!(edge of [edges[0], edges[1], edges[2], edges[3]] => {
            // SAFETY: two numbers, 32 bits, are there from each place on; the processor has AVX-512.
            unsafe {
                let pairs = each!(n of [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15] => {
                    edge.add(voxels[n] as usize).cast::<i32>().read_unaligned()
                });
                Int(std::mem::transmute::<[i32; RAYS], __m512i>(pairs))
            }
        })
    }

    #[inline(always)]
    fn apart_normals(apart: &Apart<Self>, weights: &[Short; 4], normals: &[u32], shown: u16) -> [Float; 3] {
        let shown = Apart {
            voxels: Self::choose_int(shown, apart.voxels, Self::int(0)),
            strides: apart.strides,
        };
        let (voxels, edges) = in_reach(&shown, normals);
        let pairs = each!(edge of [edges[0], edges[1], edges[2], edges[3]] => {
            // SAFETY: two normals, 64 bits, are there from each place on; the processor has AVX-512.
            unsafe {
                let [first, second] = each!(half of [0, 8] => {
                    let two = each!(n of [0, 1, 2, 3, 4, 5, 6, 7] => {
                        edge.add(voxels[half + n] as usize).cast::<i64>().read_unaligned()
                    });
                    std::mem::transmute::<[i64; 8], __m512i>(two)
                });
                let [low, high] = each!(word of [0, 1] => every_second(first, word, second));
                normal_parts(high, low)
            }
        });
        // SAFETY: the processor has AVX-512.
        each!(part of [0, 1, 2] => unsafe { sum_of_products(each!(edge of [0, 1, 2, 3] => pairs[edge][part]), weights) })
    }
}

/// Every second word of two registers, from the `first` of each on.
///
/// # Safety
/// The processor has AVX-512.
#[inline(always)]
unsafe fn every_second(a: __m512i, first: i16, b: __m512i) -> __m512i {
    // SAFETY: as above, and `EVEN` is a register long.
    unsafe {
        let words = _mm512_add_epi16(_mm512_loadu_si512(EVEN.as_ptr().cast()), _mm512_set1_epi16(first));
        _mm512_permutex2var_epi16(a, words, b)
    }
}

/// The parts of normals, of which these are the `high` and the `low` words: see [`normal::parts`].
///
/// # Safety
/// The processor has AVX-512.
#[inline(always)]
unsafe fn normal_parts(high: __m512i, low: __m512i) -> [__m512i; 3] {
    // SAFETY: as above.
    unsafe {
        let bits = _mm512_set1_epi16(normal::FIRST_BITS);
        let (above, below) = (
            _mm512_slli_epi16::<{ normal::SECOND }>(high),
            _mm512_srli_epi16::<{ 16 - normal::SECOND }>(low),
        );
        [
            _mm512_and_si512(high, bits),
            _mm512_and_si512(_mm512_or_si512(above, below), bits),
            _mm512_slli_epi16::<{ normal::THIRD }>(low),
        ]
    }
}

/// The words of vector `n` of the `N` that these are of; one alone is in a register.
///
/// # Safety
/// The processor has AVX-512.
#[inline(always)]
unsafe fn nth<const N: usize>(all: &[Short; PAIRS], n: usize) -> __m256i {
    // SAFETY: there are two of them in each; the processor has AVX.
    unsafe {
        if N == 1 {
            return _mm512_castsi512_si256(all[0].0);
        }
        _mm256_loadu_si256(all.as_ptr().cast::<__m256i>().add(n % (2 * PAIRS)))
    }
}

/// Likewise, each twice, side by side.
///
/// # Safety
/// The processor has AVX-512.
#[inline(always)]
unsafe fn twice<const N: usize>(all: &[Short; PAIRS], n: usize) -> __m512i {
    // SAFETY: as above, and `TWICE` is a register long.
    unsafe {
        _mm512_permutexvar_epi16(
            _mm512_loadu_si512(TWICE.as_ptr().cast()),
            _mm512_castsi256_si512(nth::<N>(all, n)),
        )
    }
}

/// `a`, and the bits of `b` that are in `mask`.
///
/// # Safety
/// The processor has AVX-512.
#[inline(always)]
unsafe fn or_bits(a: __m512i, b: __m512i, mask: i16) -> __m512i {
    // SAFETY: as above.
    unsafe { _mm512_or_si512(a, _mm512_and_si512(b, _mm512_set1_epi16(mask))) }
}

/// The numbers at such places among few.
///
/// # Safety
/// The processor has AVX-512.
#[inline(always)]
unsafe fn take(few: &Few, places: __m512i) -> __m512i {
    // SAFETY: as above; only as many bits of a place are looked at as there are numbers.
    unsafe { _mm512_permutex2var_epi16(few.low, places, few.high) }
}

/// What is interpolated between the ends of edges: see [`Simd::sampled`].
///
/// # Safety
/// The processor has AVX-512.
#[inline(always)]
unsafe fn between_all(edges: [[__m512i; 2]; 4], within: &[Short; 3]) -> Short {
    // SAFETY: as above.
    unsafe {
        let [a, b, c, d] = each!(edge of [0, 1, 2, 3] => between(edges[edge], within[0]));
        Short(between(
            [between([a, b], within[1]), between([c, d], within[1])],
            within[2],
        ))
    }
}

/// What is so many parts of 2¹⁵ of the way from one number to the other.
///
/// # Safety
/// The processor has AVX-512.
#[inline(always)]
unsafe fn between([a, b]: [__m512i; 2], way: Short) -> __m512i {
    // SAFETY: as above.
    unsafe { _mm512_add_epi16(a, _mm512_mulhrs_epi16(_mm512_sub_epi16(b, a), way.0)) }
}

/// The sums of some pairs' numbers times their weights.
///
/// # Safety
/// The processor has AVX-512.
#[inline(always)]
unsafe fn sum_of_products(pairs: [__m512i; 4], weights: &[Short; 4]) -> Float {
    // SAFETY: as above.
    unsafe {
        let [a, b, c, d] = each!(n of [0, 1, 2, 3] => _mm512_madd_epi16(pairs[n], weights[n].0));
        Float(_mm512_cvtepi32_ps(_mm512_add_epi32(
            _mm512_add_epi32(a, b),
            _mm512_add_epi32(c, d),
        )))
    }
}

/// Cells' voxels, and what is stored from the first voxel on each of a cell's four edges along x: from each voxel on each edge on there are
/// two.
#[inline(always)]
fn in_reach<T>(apart: &Apart<Avx512>, stored: &[T]) -> ([u32; RAYS], [*const T; 4]) {
    let [row, plane] = apart.strides;
    let last = stored.len().checked_sub(row + plane + 2).expect("a cell is stored");
    let last = last.min(i32::MAX as usize) as i32;
    // SAFETY: the processor has AVX-512, and a register is sixteen integers; each edge begins before the last cell.
    unsafe {
        let voxels = _mm512_min_epu32(apart.voxels.0, _mm512_set1_epi32(last));
        (
            std::mem::transmute::<__m512i, [u32; RAYS]>(voxels),
            each!(by of [0, row, plane, row + plane] => stored.as_ptr().add(by)),
        )
    }
}

/// The rows that few voxels are in, from the one at `corner` on.
#[inline(always)]
fn rows<T>(corner: usize, [y, z]: [usize; 2], stored: &[T]) -> [*const T; EDGE * EDGE] {
    let all = &stored[corner..][..(EDGE - 1) * (y + z) + EDGE];
    // SAFETY: the last of them ends where `all` does.
    each!(n of [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15] => unsafe { all.as_ptr().add(n % EDGE * y + n / EDGE * z) })
}

/// Says that what is stored there will soon be read.
#[inline(always)]
fn ask_for_row<T>(row: *const T) {
    // SAFETY: nothing is read, so any place can be asked for; the processor has SSE.
    unsafe { _mm_prefetch::<_MM_HINT_T0>(row.cast()) };
}
