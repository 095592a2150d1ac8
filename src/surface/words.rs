//! What is kept of the bits of slices that were looked at, so that no voxel is compared twice.
//!
//! *Practice.* Rows before the first and after the last with a voxel inside take nothing, and words whose bits are alike no more
//! than the row does: twelve bytes, however long it is. Each word through which the surface goes takes eight. That is small beside the volume, and what grows with the surface is small beside the mesh.

use std::ops::Range;

use super::bits::SliceRows;
use super::cells::SetBits;

/// What is known of a row's words: a bit for each, or for each group of `2^n` of them where a row has more than 32.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct WordSets {
    /// All voxels are inside.
    pub full: u32,
    /// Some voxels are inside and some are not. Words in neither set are all outside.
    pub mixed: u32,
    /// The surface goes through voxels.
    pub on: u32,
}

impl WordSets {
    /// All voxels are outside.
    pub const OUTSIDE: Self = Self {
        full: 0,
        mixed: 0,
        on: 0,
    };

    /// How the words of a row of `width` voxels are grouped: by `2^shift`.
    pub fn shift(width: usize) -> u32 {
        width.div_ceil(64).div_ceil(32).next_power_of_two().trailing_zeros()
    }

    /// Those of a row of `width` voxels, of which `row` are inside; the surface goes through none.
    pub fn of(row: &[u64], width: usize) -> Self {
        if row.iter().fold(0, |any, word| any | word) == 0 {
            return Self::OUTSIDE;
        }
        let shift = Self::shift(width);
        let (mut some_outside, mut some_inside) = (0, 0);
        for (w, word) in row.iter().enumerate() {
            some_outside |= u32::from(*word != existing(width, w)) << (w >> shift);
            some_inside |= u32::from(*word != 0) << (w >> shift);
        }
        Self {
            full: some_inside & !some_outside,
            mixed: some_inside & some_outside,
            on: 0,
        }
    }

    /// The set of a row's words that have a bit.
    pub fn some_of(row: &[u64], width: usize) -> u32 {
        let shift = Self::shift(width);
        let words = row.iter().enumerate();
        words.fold(0, |set, (w, word)| set | u32::from(*word != 0) << (w >> shift))
    }
}

/// The bits of the voxels that word `w` of a row of `width` has.
#[inline(always)]
pub(super) fn existing(width: usize, w: usize) -> u64 {
    let left = width - w * 64;
    if left >= 64 { u64::MAX } else { (1 << left) - 1 }
}

/// What is kept of a slice's bits: all of them, in few words.
#[derive(Clone, Default)]
pub(super) struct SliceWords {
    /// The first row with a voxel inside.
    first_row: usize,
    /// Of each row from that to the last one.
    pub sets: Vec<WordSets>,
    /// The words of all mixed groups.
    mixed: Vec<u64>,
    /// The words of all groups with voxels that the surface goes through.
    on: Vec<u64>,
}

impl SliceWords {
    /// Those of `slice`, of rows of `width` voxels.
    pub fn new(slice: &SliceRows, width: usize) -> Self {
        let sets = &slice.sets[slice.rows.clone()];
        let words = slice.words_of(&slice.rows);
        let gather = |bits: &[u64], set: fn(&WordSets) -> u32| {
            let shift = WordSets::shift(width);
            let groups: u32 = sets.iter().map(|sets| set(sets).count_ones()).sum();
            let mut kept = Vec::with_capacity((groups as usize) << shift);
            for (row, sets) in bits.chunks_exact(width.div_ceil(64)).zip(sets) {
                groups_of(set(sets), row.len(), shift).for_each(|words| kept.extend_from_slice(&row[words]));
            }
            kept
        };
        Self {
            first_row: slice.rows.start,
            sets: sets.to_vec(),
            mixed: gather(&slice.inside[words.clone()], |sets| sets.mixed),
            on: gather(&slice.on[words], |sets| sets.on),
        }
    }

    /// The rows that are kept.
    pub fn rows(&self) -> Range<usize> {
        self.first_row..self.first_row + self.sets.len()
    }

    /// Whether the surface goes through voxels.
    pub fn has_on(&self) -> bool {
        !self.on.is_empty()
    }

    /// Writes the bits of these rows, of `width` voxels, to where there are none.
    pub fn restore(&self, width: usize, inside: &mut [u64], on: &mut [u64]) {
        let (row, shift) = (width.div_ceil(64), WordSets::shift(width));
        let (mut mixed, mut kept_on) = (&self.mixed[..], &self.on[..]);
        let rows = inside.chunks_exact_mut(row).zip(on.chunks_exact_mut(row));
        for ((inside, on), sets) in rows.zip(&self.sets) {
            for words in groups_of(sets.full, row, shift) {
                words.for_each(|w| inside[w] = existing(width, w));
            }
            groups_of(sets.mixed, row, shift).for_each(|words| take_into(&mut inside[words], &mut mixed));
            groups_of(sets.on, row, shift).for_each(|words| take_into(&mut on[words], &mut kept_on));
        }
    }
}

/// The words of each group of a set, of a row of `words`.
fn groups_of(set: u32, words: usize, shift: u32) -> impl Iterator<Item = Range<usize>> {
    SetBits(u64::from(set)).map(move |group| {
        let first = (group as usize) << shift;
        first..words.min(first + (1 << shift))
    })
}

/// Moves the first words of `rest` to `words`.
fn take_into(words: &mut [u64], rest: &mut &[u64]) {
    let (first, more) = rest.split_at(words.len());
    words.copy_from_slice(first);
    *rest = more;
}

/// What is known of some slices.
#[derive(Clone, Copy, Default)]
pub(super) struct Known<'a> {
    pub first_slice: usize,
    pub slices: &'a [SliceWords],
}

impl<'a> Known<'a> {
    /// Slice `k`, if it is known.
    pub fn slice(&self, k: usize) -> Option<&'a SliceWords> {
        self.slices.get(k.checked_sub(self.first_slice)?)
    }
}
