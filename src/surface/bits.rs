//! The bits of a slice's voxels, 64 a word (LC87 §4, step 3).
//!
//! *Practice.* A slice knows which of its rows have a voxel inside, so that no others need be looked at.

use std::ops::Range;

use super::words::{SliceWords, WordSets};
use crate::volume::Voxel;

/// One bit for each voxel of a slice, row after row: bit `i % 64` of word `i / 64` for voxel `i` of a row; bits beyond a row's
/// end are 0. There is one more word, of any bits.
#[derive(Clone, Copy)]
pub(super) struct SliceBits<'a>(pub &'a [u64]);

impl<'a> SliceBits<'a> {
    /// All but the first `words`.
    #[inline(always)]
    pub fn skip(self, words: usize) -> Self {
        Self(&self.0[words..])
    }
}

/// The bits of a slice, of rows of `width` voxels.
pub(super) struct SliceRows {
    width: usize,
    /// Of the voxels inside, and one more word.
    pub inside: Vec<u64>,
    /// Of the voxels that the surface goes through, and one more word.
    pub on: Vec<u64>,
    /// Whether `on` has any.
    pub has_on: bool,
    /// What is known of each row.
    pub sets: Vec<WordSets>,
    /// All rows with a voxel inside are among these.
    pub rows: Range<usize>,
}

impl SliceRows {
    /// A slice of `height` rows whose voxels are all outside.
    pub fn new([width, height]: [usize; 2]) -> Self {
        let words = width.div_ceil(64) * height + 1;
        Self {
            width,
            inside: vec![0; words],
            on: vec![0; words],
            has_on: false,
            sets: vec![WordSets::OUTSIDE; height],
            rows: 0..0,
        }
    }

    /// Takes all voxels outside.
    pub fn clear(&mut self) {
        let words = self.words_of(&self.rows);
        self.inside[words.clone()].fill(0);
        if self.has_on {
            self.on[words].fill(0);
        }
        self.has_on = false;
        self.sets[self.rows.clone()].fill(WordSets::OUTSIDE);
        self.rows = 0..0;
    }

    /// Compares the slice's `voxels`, when it is clear. Of none is it known that the surface goes through it.
    pub fn classify<T: Voxel>(&mut self, voxels: &[T], smallest_inside: T) {
        classify(voxels, self.width, smallest_inside, &mut self.inside);
        let rows = self.inside.chunks_exact(self.width.div_ceil(64));
        for (row, sets) in rows.zip(&mut self.sets) {
            *sets = WordSets::of(row, self.width);
        }
        let has_inside = |sets: &WordSets| *sets != WordSets::OUTSIDE;
        let first = self.sets.iter().position(has_inside).unwrap_or(0);
        let end = self.sets.iter().rposition(has_inside).map_or(0, |last| last + 1);
        self.rows = first..end;
    }

    /// Takes the bits from `kept`, when it is clear.
    pub fn restore(&mut self, kept: &SliceWords) {
        self.rows = kept.rows();
        self.sets[self.rows.clone()].copy_from_slice(&kept.sets);
        self.has_on = kept.has_on();
        let words = self.words_of(&self.rows);
        kept.restore(self.width, &mut self.inside[words.clone()], &mut self.on[words]);
    }

    /// The words of some rows.
    pub fn words_of(&self, rows: &Range<usize>) -> Range<usize> {
        let row = self.width.div_ceil(64);
        rows.start * row..rows.end * row
    }
}

/// The rows of two ranges, and those between them.
pub(super) fn hull(a: &Range<usize>, b: &Range<usize>) -> Range<usize> {
    match (a.is_empty(), b.is_empty()) {
        (true, _) => b.clone(),
        (_, true) => a.clone(),
        _ => a.start.min(b.start)..a.end.max(b.end),
    }
}

/// Clears the rows of `bits` in `before` that are not in `now`.
pub(super) fn clear_beyond(bits: &mut [u64], words_a_row: usize, before: &Range<usize>, now: &Range<usize>) {
    let below = before.start..before.end.min(now.start);
    let above = before.start.max(now.end)..before.end;
    for rows in [below, above].into_iter().filter(|rows| !rows.is_empty()) {
        bits[rows.start * words_a_row..rows.end * words_a_row].fill(0);
    }
}

/// Fills `inside` with the bits of the rows of `width` voxels that `voxels` holds.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn classify<T: Voxel>(voxels: &[T], width: usize, smallest_inside: T, inside: &mut [u64]) {
    let rows = inside.chunks_exact_mut(width.div_ceil(64));
    for (row, inside) in voxels.chunks_exact(width).zip(rows) {
        let (whole, rest) = row.as_chunks::<64>();
        for (chunk, word) in whole.iter().zip(inside.iter_mut()) {
            *word = not_below(chunk, smallest_inside);
        }
        if let Some(last) = inside.get_mut(whole.len()) {
            *last = not_below(rest, smallest_inside);
        }
    }
}

/// Clears the bits of a row's voxels that are not `iso`.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn keep_equal<T: Voxel>(row: &[T], iso: T, bits: &mut [u64]) {
    for (w, word) in bits.iter_mut().enumerate() {
        if *word != 0 {
            let chunk = &row[w * 64..row.len().min(w * 64 + 64)];
            *word &= match chunk.as_array::<64>() {
                Some(chunk) => equal(chunk, iso),
                None => equal(chunk, iso),
            };
        }
    }
}

// Of at most 64 voxels each. For 64 of them compilers turn these into wide comparisons.

#[inline(always)]
fn not_below<T: Voxel>(voxels: &[T], smallest_inside: T) -> u64 {
    let mut word = 0;
    for (n, v) in voxels.iter().enumerate() {
        word |= u64::from(*v >= smallest_inside) << n;
    }
    word
}

#[inline(always)]
fn equal<T: Voxel>(voxels: &[T], value: T) -> u64 {
    let mut word = 0;
    for (n, v) in voxels.iter().enumerate() {
        word |= u64::from(*v == value) << n;
    }
    word
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn not_a_number_is_outside() {
        let mut inside = [0];
        let voxels = [f64::NAN, 1.0, f64::INFINITY];
        classify(&voxels, 3, 1.0, &mut inside);
        assert_eq!(inside, [0b110]);
        let mut equal = [0b111];
        keep_equal(&voxels, 1.0, &mut equal);
        assert_eq!(equal, [0b010]);
    }
}
