//! Which voxels are inside, and which the surface goes through, one bit each (LC87 §4, step 3).
//!
//! *Theory.* A voxel is inside where its value is not below the isovalue.
//! *Changes from the paper.* The bits of a whole row are found at once. All that follows works on words of 64 of them: where
//! an edge is crossed its two ends differ, so crossings are an exclusive or of rows, and counting set bits numbers them.
//! *Practice.* The isovalue is turned into the smallest value of the voxels' own type that is inside, so that voxels are
//! compared as they are. Bits are held for a few slices only. Of the others no more is kept than the words through which
//! the surface goes ([`words`](super::words)), so that a second pass compares no voxels but those of the isovalue.

use std::ops::Range;

use super::cells::SetBits;
use super::slices::Slices;
use super::words::{Known, SliceWords, WordSets, existing};
use crate::volume::Voxel;

/// What becomes of vertices that lie on one voxel because it has the isovalue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ties {
    /// They are one from the start.
    OneVertex,
    /// They are several.
    Apart,
}

/// What tells voxels inside from others.
#[derive(Clone, Copy)]
pub(super) struct Classifier<'a, T> {
    pub slices: Slices<'a, T>,
    /// `None` where the voxels' type ends below the isovalue.
    smallest_inside: Option<T>,
    /// The isovalue, where voxels of it are to be found and their type has it.
    iso: Option<T>,
}

impl<'a, T: Voxel> Classifier<'a, T> {
    /// For the surface at `iso`.
    pub fn new(slices: Slices<'a, T>, iso: f64, ties: Ties) -> Self {
        let smallest_inside = T::not_below(iso);
        Self {
            slices,
            smallest_inside,
            iso: smallest_inside.filter(|v| ties == Ties::OneVertex && v.to_f64() == iso),
        }
    }
}

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

/// The bits of some slices of a lattice.
pub(super) struct InsideRows {
    inside: Vec<u64>,
    /// Voxels of the isovalue itself with a neighbour outside: the vertices on all their crossed edges are one. None are known
    /// in slices whose neighbours are not held.
    on: Vec<u64>,
    sets: Vec<WordSets>,
    /// The voxels of a slice that start an x edge.
    starts: Vec<u64>,
    /// Room for the voxels of a slice that differ from the next in x, behind a word of none.
    changes: Vec<u64>,
    /// The slices that are held.
    pub slices: Range<usize>,
    /// Voxels along each axis of the whole lattice.
    pub dims: [usize; 3],
    /// The end of the slices whose `on` is found.
    settled: usize,
    words_a_row: usize,
}

impl InsideRows {
    /// Holds no slices yet.
    pub fn new(dims: [usize; 3]) -> Self {
        let words_a_row = dims[0].div_ceil(64);
        let row = (0..words_a_row).map(|w| {
            if w * 64 + 1 < dims[0] {
                existing(dims[0] - 1, w)
            } else {
                0
            }
        });
        Self {
            inside: Vec::new(),
            on: Vec::new(),
            sets: Vec::new(),
            starts: row.cycle().take(words_a_row * dims[1]).collect(),
            changes: vec![0; words_a_row * dims[1] + 1],
            slices: 0..0,
            dims,
            settled: 0,
            words_a_row,
        }
    }

    /// The bits of `held` slices.
    pub fn of<T: Voxel>(classifier: &Classifier<'_, T>, held: Range<usize>) -> Self {
        let mut rows = Self::new(classifier.slices.dims);
        rows.move_to(classifier, held, Known::default());
        rows
    }

    /// Holds the slices `held`, which start and end in or after those held before; what is held already is kept. The bits of
    /// slices that are `known` are written down from there.
    pub fn move_to<T: Voxel>(&mut self, classifier: &Classifier<'_, T>, held: Range<usize>, known: Known<'_>) {
        let fresh = self.slices.end.max(held.start);
        self.drop_before(held.start);
        self.slices = held;
        let rows = self.dims[1] * self.slices.len();
        let words = self.words_a_row * rows + 1;
        self.inside.resize(words, 0);
        self.on.resize(words, 0);
        self.sets.resize(rows, WordSets::OUTSIDE);
        for k in fresh..self.slices.end {
            self.classify(classifier, k, known);
            if let Some(iso) = classifier.iso {
                self.find_ties(classifier.slices, iso, k);
            }
        }
    }

    fn drop_before(&mut self, k: usize) {
        let rows = self.dims[1] * (k - self.slices.start).min(self.slices.len());
        let words = self.words_a_row * rows;
        self.inside.drain(..words);
        self.on.drain(..words);
        self.sets.drain(..rows);
    }

    fn classify<T: Voxel>(&mut self, classifier: &Classifier<'_, T>, k: usize, known: Known<'_>) {
        let (first_row, ny, words) = (self.first_row(k), self.dims[1], self.words(k));
        let sets = &mut self.sets[first_row..][..ny];
        let Some(smallest_inside) = classifier.smallest_inside else {
            sets.fill(WordSets::OUTSIDE);
            return;
        };
        let (voxels, inside) = (classifier.slices.slice(k), &mut self.inside[words]);
        if let Some(known) = known.slice(k) {
            sets.copy_from_slice(&known.sets);
            known.restore(self.dims[0], inside);
        } else {
            classify(voxels, self.dims[0], smallest_inside, inside);
            for (row, sets) in inside.chunks_exact(self.words_a_row).zip(sets) {
                *sets = WordSets::of(row, self.dims[0]);
                sets.on = if classifier.iso.is_some() { sets.on } else { 0 };
            }
        }
    }

    /// Finds the voxels of the isovalue that have a vertex, in the slices whose neighbours are classified now that slice `last`
    /// is.
    fn find_ties<T: Voxel>(&mut self, slices: Slices<'_, T>, iso: T, last: usize) {
        let first = if self.slices.start == 0 {
            0
        } else {
            self.slices.start + 1
        };
        let end = if last + 1 == self.dims[2] { last + 1 } else { last };
        for k in first.max(self.settled)..end {
            let (first_row, words) = (self.first_row(k), self.words(k));
            let rows = first_row..first_row + self.dims[1];
            if self.sets[rows.clone()].iter().all(|sets| sets.on == 0) {
                continue;
            }
            let mut on = std::mem::take(&mut self.on);
            self.outer_voxels(k, &mut on[words.clone()]);
            let bits = on[words].chunks_exact_mut(self.words_a_row);
            for (j, (row, sets)) in bits.zip(&mut self.sets[rows]).enumerate() {
                if sets.on == 0 {
                    row.fill(0);
                } else if row.iter().any(|word| *word != 0) {
                    keep_equal(slices.row(j, k), iso, row);
                    keep_with_finite_neighbours(slices, [j, k], row);
                }
                sets.on = WordSets::of(row, self.dims[0]).on;
            }
            self.on = on;
        }
        self.settled = self.settled.max(end);
    }

    /// Finds the voxels of slice `k` that are inside and have a neighbour outside. Beyond the lattice its border goes on.
    fn outer_voxels(&mut self, k: usize, outer: &mut [u64]) {
        let mut changes = std::mem::take(&mut self.changes);
        let here = self.inside(k);
        x_changes(here, &self.starts, &mut changes[1..]);
        let below = self.inside(k.saturating_sub(1));
        let above = self.inside((k + 1).min(self.dims[2] - 1));
        let (row, end) = (self.words_a_row, outer.len());
        // The first and the last row have a neighbour less.
        for (words, down, up) in [(0..row, 0, row), (row..end - row, row, row), (end - row..end, row, 0)] {
            let first = words.start;
            let round = [
                here.skip(first - down),
                here.skip(first + up),
                below.skip(first),
                above.skip(first),
            ];
            outer_voxels(&changes[first..], here.skip(first), round, &mut outer[words]);
        }
        self.changes = changes;
    }

    /// Whether the surface may go through voxels of slice `k`, whose neighbours are held.
    pub fn has_on(&self, k: usize) -> bool {
        self.sets(k).iter().any(|sets| sets.on != 0)
    }

    /// What is known of the words of slice `k`.
    pub fn words_of(&self, k: usize) -> SliceWords {
        SliceWords::new(self.sets(k), self.dims[0], self.inside(k).0)
    }

    /// What is known of the rows of slice `k`.
    pub fn sets(&self, k: usize) -> &[WordSets] {
        &self.sets[self.first_row(k)..][..self.dims[1]]
    }

    fn words(&self, k: usize) -> Range<usize> {
        let row = self.first_row(k);
        self.words_a_row * row..self.words_a_row * (row + self.dims[1])
    }

    fn first_row(&self, k: usize) -> usize {
        self.dims[1] * (k - self.slices.start)
    }

    /// Words in a row of voxels.
    #[inline(always)]
    pub fn words_a_row(&self) -> usize {
        self.words_a_row
    }

    /// The voxels of a slice that start an x edge.
    #[inline(always)]
    pub fn starts(&self) -> &[u64] {
        &self.starts
    }

    /// The voxels inside of slice `k`.
    #[inline(always)]
    pub fn inside(&self, k: usize) -> SliceBits<'_> {
        let words = self.words(k);
        SliceBits(&self.inside[words.start..words.end + 1])
    }

    /// The voxels of slice `k` that the surface goes through.
    #[inline(always)]
    pub fn on(&self, k: usize) -> SliceBits<'_> {
        let words = self.words(k);
        SliceBits(&self.on[words.start..words.end + 1])
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

/// Finds the voxels of a slice that start an x edge and differ from its other end.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn x_changes(inside: SliceBits<'_>, starts: &[u64], changes: &mut [u64]) {
    let words = changes.len();
    let (inside, after, starts) = (&inside.0[..words], &inside.0[1..][..words], &starts[..words]);
    for n in 0..words {
        changes[n] = (inside[n] ^ (inside[n] >> 1 | after[n] << 63)) & starts[n];
    }
}

/// Finds the voxels of some rows that are inside and differ from a neighbour: in x by `changes`, which starts a word before
/// the rows, or in the rows and slices round these.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn outer_voxels(changes: &[u64], inside: SliceBits<'_>, round: [SliceBits<'_>; 4], outer: &mut [u64]) {
    let words = outer.len();
    let (before, changes) = (&changes[..words], &changes[1..][..words]);
    let inside = &inside.0[..words];
    let [a, b, c, d] = round.map(|bits| &bits.0[..words]);
    for n in 0..words {
        let in_x = changes[n] | changes[n] << 1 | before[n] >> 63;
        let across = (inside[n] ^ a[n]) | (inside[n] ^ b[n]) | (inside[n] ^ c[n]) | (inside[n] ^ d[n]);
        outer[n] = inside[n] & (in_x | across);
    }
}

/// Clears the bits of a row's voxels that are not `iso`.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn keep_equal<T: Voxel>(row: &[T], iso: T, bits: &mut [u64]) {
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

/// Clears the bits of the voxels of row `j` of slice `k` next to one that is not finite: the vertex on an edge to that is
/// elsewhere.
fn keep_with_finite_neighbours<T: Voxel>(slices: Slices<'_, T>, [j, k]: [usize; 2], bits: &mut [u64]) {
    for (w, word) in bits.iter_mut().enumerate() {
        for i in SetBits(*word) {
            if !slices.has_finite_neighbours([w * 64 + i as usize, j, k]) {
                *word &= !(1 << i);
            }
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
    fn bits_are_comparisons() {
        for width in [1, 7, 63, 64, 65, 130] {
            let voxels: Vec<f32> = (0..3 * width).map(|n| ((n * 37 + n * n) % 11) as f32).collect();
            let slices = Slices {
                voxels: &voxels,
                first_slice: 0,
                dims: [width, 3, 1],
            };
            let rows = InsideRows::of(&Classifier::new(slices, 5.0, Ties::OneVertex), 0..1);
            let words = width.div_ceil(64);
            for (n, row) in voxels.chunks(width).enumerate() {
                let bits = &rows.inside(0).0[n * words..][..words];
                let bit = |i: usize| bits.get(i / 64).is_some_and(|w| w >> (i % 64) & 1 == 1);
                for i in 0..width.div_ceil(64) * 64 {
                    assert_eq!(
                        bit(i),
                        row.get(i).is_some_and(|v| *v >= 5.0),
                        "width {width}, row {n}, voxel {i}"
                    );
                }
            }
        }
    }

    #[test]
    fn bits_come_back_from_what_is_kept() {
        // From rows of one word to rows of several words in a group.
        for width in [3, 64, 300, 2048, 2049, 4200] {
            let dims = [width, 4, 3];
            let field = |n: usize| match n / 300 % 3 {
                0 => 0,
                1 => 9,
                _ => (n * 37 + n * n) % 11,
            };
            let voxels: Vec<u16> = (0..12 * width).map(|n| field(n) as u16).collect();
            let slices = Slices {
                voxels: &voxels,
                first_slice: 0,
                dims,
            };
            let classifier = Classifier::new(slices, 5.0, Ties::OneVertex);
            let first = InsideRows::of(&classifier, 0..3);
            let words: Vec<SliceWords> = (0..3).map(|k| first.words_of(k)).collect();
            let known = Known {
                first_slice: 0,
                slices: &words,
            };
            let mut again = InsideRows::new(dims);
            again.move_to(&classifier, 0..3, known);
            for k in 0..3 {
                assert!(first.has_on(k) || width < 300, "width {width}, slice {k}");
                assert_eq!(again.inside(k).0, first.inside(k).0, "width {width}, slice {k}");
                assert_eq!(again.on(k).0, first.on(k).0, "width {width}, slice {k}");
            }
        }
    }

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
