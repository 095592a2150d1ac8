//! Which voxels are inside, one bit each (LC87 §4, step 3).
//!
//! *Theory.* A voxel is inside where its value is not below the isovalue.
//! *Changes from the paper.* The bits of a whole row are found at once. All that follows works on words of 64 of them: where
//! an edge is crossed its two ends differ, so crossings are an exclusive or of rows, and counting set bits numbers them.
//! *Practice.* The isovalue is turned into the smallest value of the voxels' own type that is inside, so that voxels are
//! compared as they are.

use rayon::prelude::*;
use rayon::slice::ChunksMut;

use crate::volume::Voxel;

/// Rows of bits, bit `i % 64` of word `i / 64` for voxel `i` of a row; bits beyond a row's end are 0.
pub(super) struct InsideRows {
    words: Vec<u64>,
    words_a_row: usize,
}

impl InsideRows {
    /// `rows` rows of `width` voxels, none inside.
    pub fn new(width: usize, rows: usize) -> Self {
        let words_a_row = width.div_ceil(64);
        Self {
            words: vec![0; words_a_row * rows],
            words_a_row,
        }
    }

    /// The words of row `n`.
    pub fn row(&self, n: usize) -> &[u64] {
        &self.words[n * self.words_a_row..][..self.words_a_row]
    }

    /// The rows for writing, in runs of `rows` of them.
    pub fn runs_mut(&mut self, rows: usize) -> ChunksMut<'_, u64> {
        self.words.par_chunks_mut(self.words_a_row * rows)
    }
}

/// Fills `words` with the bits of the rows of `width` voxels that `voxels` holds.
#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512dq+avx512vl",
    "x86_64+avx2"
))]
pub(super) fn classify<T: Voxel>(voxels: &[T], width: usize, smallest_inside: T, words: &mut [u64]) {
    let rows = voxels.chunks_exact(width).zip(words.chunks_exact_mut(width.div_ceil(64)));
    for (row, words) in rows {
        for (chunk, word) in row.chunks(64).zip(words) {
            let mut inside = [0_u8; 64];
            match <&[T; 64]>::try_from(chunk) {
                // A loop of known length, which compilers turn into wide comparisons.
                Ok(whole) => {
                    for (bit, v) in inside.iter_mut().zip(whole) {
                        *bit = u8::from(*v >= smallest_inside);
                    }
                }
                Err(_) => {
                    for (bit, v) in inside.iter_mut().zip(chunk) {
                        *bit = u8::from(*v >= smallest_inside);
                    }
                }
            }
            *word = packed(&inside);
        }
    }
}

/// Bit `n` of the result is byte `n`, which is 0 or 1.
#[inline(always)]
fn packed(bytes: &[u8; 64]) -> u64 {
    // The product carries byte n of eight, at bit 8n, to bit 56 + n; the other sums stay below and do not carry.
    const GATHER: u64 = 0x0102_0408_1020_4080;
    let mut word = 0;
    for (n, eight) in bytes.as_chunks::<8>().0.iter().enumerate() {
        word |= (u64::from_le_bytes(*eight).wrapping_mul(GATHER) >> 56) << (8 * n);
    }
    word
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_comparisons() {
        for width in [1, 7, 63, 64, 65, 130] {
            let voxels: Vec<f32> = (0..3 * width).map(|n| ((n * 37 + n * n) % 11) as f32).collect();
            let mut rows = InsideRows::new(width, 3);
            rows.runs_mut(3).for_each(|words| classify(&voxels, width, 5.0, words));
            for (n, row) in voxels.chunks(width).enumerate() {
                let bit = |i: usize| rows.row(n).get(i / 64).is_some_and(|w| w >> (i % 64) & 1 == 1);
                for i in 0..width.div_ceil(64) * 64 {
                    assert_eq!(bit(i), row.get(i).is_some_and(|v| *v >= 5.0), "width {width}, row {n}, voxel {i}");
                }
            }
        }
    }

    #[test]
    fn not_a_number_is_outside() {
        let mut word = [0];
        classify(&[f64::NAN, 1.0, f64::INFINITY], 3, 1.0, &mut word);
        assert_eq!(word, [0b110]);
    }
}
