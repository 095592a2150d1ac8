//! Which voxels are inside, one bit each (LC87 §4, step 3).
//!
//! *Theory.* A voxel is inside where its value is not below the isovalue.
//! *Changes from the paper.* The bits of a whole row are found at once. All that follows works on words of 64 of them: where
//! an edge is crossed its two ends differ, so crossings are an exclusive or of rows, and counting set bits numbers them.
//! *Practice.* The isovalue is turned into the smallest value of the voxels' own type that is inside, so that voxels are
//! compared as they are.

use rayon::prelude::*;

use super::slices::Slices;
use crate::volume::Voxel;

/// The bits of a lattice of voxels: bit `i % 64` of word `i / 64` for voxel `i` of a row; bits beyond a row's end are 0.
pub(super) struct InsideRows {
    words: Vec<u64>,
    /// Voxels along each axis.
    pub dims: [usize; 3],
}

impl InsideRows {
    /// The bits of all slices of a lattice.
    pub fn of<T: Voxel>(slices: Slices<'_, T>, smallest_inside: T) -> Self {
        let dims @ [nx, ny, nz] = slices.dims;
        let words_a_slice = nx.div_ceil(64) * ny;
        let mut words = vec![0; words_a_slice * nz];
        words
            .par_chunks_mut(words_a_slice)
            .enumerate()
            .for_each(|(k, words)| classify(slices.slice(k), nx, smallest_inside, words));
        Self { words, dims }
    }

    /// The words of row `j` of slice `k`.
    #[inline(always)]
    pub fn row(&self, j: usize, k: usize) -> &[u64] {
        let [nx, ny, _] = self.dims;
        let words = nx.div_ceil(64);
        &self.words[words * (j + ny * k)..][..words]
    }
}

/// Fills `words` with the bits of the rows of `width` voxels that `voxels` holds.
#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512dq+avx512vl",
    "x86_64+avx2"
))]
fn classify<T: Voxel>(voxels: &[T], width: usize, smallest_inside: T, words: &mut [u64]) {
    let rows = voxels.chunks_exact(width).zip(words.chunks_exact_mut(width.div_ceil(64)));
    for (row, words) in rows {
        let (whole, rest) = row.as_chunks::<64>();
        for (chunk, word) in whole.iter().zip(words.iter_mut()) {
            *word = word_of(chunk, smallest_inside);
        }
        if let Some(last) = words.get_mut(whole.len()) {
            *last = word_of(rest, smallest_inside);
        }
    }
}

/// The bits of at most 64 voxels. For 64 of them compilers turn this into wide comparisons.
#[inline(always)]
fn word_of<T: Voxel>(voxels: &[T], smallest_inside: T) -> u64 {
    let mut word = 0;
    for (n, v) in voxels.iter().enumerate() {
        word |= u64::from(*v >= smallest_inside) << n;
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
            let slices = Slices {
                voxels: &voxels,
                first_slice: 0,
                dims: [width, 3, 1],
            };
            let rows = InsideRows::of(slices, 5.0);
            for (n, row) in voxels.chunks(width).enumerate() {
                let bit = |i: usize| rows.row(n, 0).get(i / 64).is_some_and(|w| w >> (i % 64) & 1 == 1);
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
