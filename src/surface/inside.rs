//! Which voxels are inside, and which the surface goes through, one bit each (LC87 §4, step 3).
//!
//! *Theory.* A voxel is inside where its value is not below the isovalue.
//! *Changes from the paper.* The bits of a whole row are found at once. All that follows works on words of 64 of them: where
//! an edge is crossed its two ends differ, so crossings are an exclusive or of rows, and counting set bits numbers them.
//! *Practice.* The isovalue is turned into the smallest value of the voxels' own type that is inside, so that voxels are
//! compared as they are. Bits are held for a few slices only. Of the others no more is kept than the words through which
//! the surface goes ([`words`](super::words)), so that a second pass compares no voxels.

use std::ops::Range;

use super::bits::{SliceBits, SliceRows, hull, keep_equal};
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

/// The bits of some slices of a lattice.
pub(super) struct InsideRows {
    /// Those held. Of voxels that the surface goes through they have those of the isovalue itself with a neighbour outside: the
    /// vertices on all their crossed edges are one. None are known in slices whose neighbours are not held.
    held: Vec<SliceRows>,
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
            held: Vec::new(),
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
        let gone = (held.start - self.slices.start).min(self.slices.len());
        self.held.rotate_left(gone);
        self.slices = held;
        let [width, height, _] = self.dims;
        self.held
            .resize_with(self.slices.len(), || SliceRows::new([width, height]));
        for k in fresh..self.slices.end {
            let slice = &mut self.held[k - self.slices.start];
            slice.clear();
            if let Some(kept) = known.slice(k) {
                slice.restore(kept);
            } else if let Some(smallest_inside) = classifier.smallest_inside {
                slice.classify(classifier.slices.slice(k), smallest_inside);
            }
            if let Some(iso) = classifier.iso {
                self.find_ties(classifier.slices, iso, k, known);
            }
        }
    }

    /// Finds the voxels of the isovalue that have a vertex, in the slices whose neighbours are classified now that slice `last`
    /// is.
    fn find_ties<T: Voxel>(&mut self, slices: Slices<'_, T>, iso: T, last: usize, known: Known<'_>) {
        let first = if self.slices.start == 0 {
            0
        } else {
            self.slices.start + 1
        };
        let end = if last + 1 == self.dims[2] { last + 1 } else { last };
        let unknown = (first.max(self.settled)..end).filter(|k| known.slice(*k).is_none());
        unknown.for_each(|k| self.find_ties_of(slices, iso, k));
        self.settled = self.settled.max(end);
    }

    /// Finds the voxels of the isovalue that have a vertex in slice `k`.
    fn find_ties_of<T: Voxel>(&mut self, slices: Slices<'_, T>, iso: T, k: usize) {
        let here = &mut self.held[k - self.slices.start];
        let (rows, words) = (here.rows.clone(), here.words_of(&here.rows));
        let mut on = std::mem::take(&mut here.on);
        self.outer_voxels(k, &mut on[words.clone()]);
        let here = &mut self.held[k - self.slices.start];
        let bits = on[words].chunks_exact_mut(self.words_a_row);
        for (j, (row, sets)) in rows.clone().zip(bits.zip(&mut here.sets[rows])) {
            if row.iter().any(|word| *word != 0) {
                keep_equal(slices.row(j, k), iso, row);
                keep_with_finite_neighbours(slices, [j, k], row);
                sets.on = WordSets::some_of(row, self.dims[0]);
                here.has_on |= sets.on != 0;
            }
        }
        here.on = on;
    }

    /// Finds the voxels of slice `k` that are inside and have a neighbour outside, in the rows with any inside. Beyond the lattice
    /// its border goes on.
    fn outer_voxels(&mut self, k: usize, outer: &mut [u64]) {
        let mut changes = std::mem::take(&mut self.changes);
        let here = self.inside(k);
        let Range { start, end } = self.slice(k).rows;
        let (row, last) = (self.words_a_row, self.dims[1] - 1);
        let words = start * row..end * row;
        x_changes(
            here.skip(words.start),
            &self.starts[words.clone()],
            &mut changes[1..][words.clone()],
        );
        let below = self.inside(k.saturating_sub(1));
        let above = self.inside((k + 1).min(self.dims[2] - 1));
        // The first and the last row have a neighbour less.
        let (first, middle, last) = (start..end.min(1), start.max(1)..end.min(last), start.max(last)..end);
        for (rows, down, up) in [(first, 0, row), (middle, row, row), (last, row, 0)] {
            if rows.is_empty() {
                continue;
            }
            let first = rows.start * row;
            let round = [
                here.skip(first - down),
                here.skip(first + up),
                below.skip(first),
                above.skip(first),
            ];
            let outer = &mut outer[first - words.start..rows.end * row - words.start];
            outer_voxels(&changes[first..], here.skip(first), round, outer);
        }
        self.changes = changes;
    }

    /// Whether the surface goes through voxels of slice `k`, whose neighbours are held.
    pub fn has_on(&self, k: usize) -> bool {
        self.slice(k).has_on
    }

    /// What is to be kept of slice `k`.
    pub fn words_of(&self, k: usize) -> SliceWords {
        SliceWords::new(self.slice(k), self.dims[0])
    }

    /// All rows of slices `k` and `next` with a voxel inside are among these.
    pub fn rows_inside(&self, k: usize, next: usize) -> Range<usize> {
        hull(&self.slice(k).rows, &self.slice(next).rows)
    }

    #[inline(always)]
    fn slice(&self, k: usize) -> &SliceRows {
        &self.held[k - self.slices.start]
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
        SliceBits(&self.slice(k).inside)
    }

    /// The voxels of slice `k` that the surface goes through.
    #[inline(always)]
    pub fn on(&self, k: usize) -> SliceBits<'_> {
        SliceBits(&self.slice(k).on)
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

/// Clears the bits of the voxels of row `j` of slice `k` next to one that is not finite: the vertex on an edge to that is
/// elsewhere.
fn keep_with_finite_neighbours<T: Voxel>(slices: Slices<'_, T>, [j, k]: [usize; 2], bits: &mut [u64]) {
    if !T::TYPE.is_float() {
        return;
    }
    for (w, word) in bits.iter_mut().enumerate() {
        for i in SetBits(*word) {
            if !slices.has_finite_neighbours([w * 64 + i as usize, j, k]) {
                *word &= !(1 << i);
            }
        }
    }
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
    fn what_moves_holds_what_stays_does() {
        let dims = [70, 6, 40];
        // Slices and rows without voxels inside between others, and many voxels of the isovalue.
        let field = |n: usize| match [n / (70 * 6) % 7, n / 70 % 3] {
            [0 | 1, _] | [2, 0] => 0,
            [3, _] => 5 + n % 2,
            _ => (n * 37 + n * n) % 11,
        };
        let voxels: Vec<u16> = (0..70 * 6 * 40).map(|n| field(n) as u16).collect();
        let slices = Slices {
            voxels: &voxels,
            first_slice: 0,
            dims,
        };
        let classifier = Classifier::new(slices, 5.0, Ties::OneVertex);
        let all = InsideRows::of(&classifier, 0..40);
        let words: Vec<SliceWords> = (0..30).map(|k| all.words_of(k)).collect();
        for known in [&words[..0], &words] {
            let known = Known {
                first_slice: 0,
                slices: known,
            };
            let mut moved = InsideRows::new(dims);
            for held in [0..7, 3..11, 8..12, 20..33, 29..34, 33..40] {
                moved.move_to(&classifier, held.clone(), known);
                for k in held.clone() {
                    assert_eq!(moved.inside(k).0, all.inside(k).0, "{held:?}, slice {k}");
                }
                let settled = held.start + usize::from(held.start > 0)..held.end - usize::from(held.end < 40);
                for k in settled {
                    assert_eq!(moved.on(k).0, all.on(k).0, "{held:?}, slice {k}");
                    assert_eq!(moved.has_on(k), all.on(k).0.iter().any(|word| *word != 0));
                }
            }
        }
        assert!((0..40).any(|k| all.has_on(k)) && (0..40).any(|k| all.rows_inside(k, k).is_empty()));
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
}
