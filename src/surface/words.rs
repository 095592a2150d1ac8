//! What is kept of the bits of slices that were looked at, so that no voxel is compared twice.
//!
//! *Practice.* Words whose bits are alike take none: twelve bytes a row, however long it is, and eight for each word through which
//! the surface goes. That is small beside the volume, and what grows with the surface is small beside the mesh.

/// What is known of a row's words: a bit for each, or for each group of `2^n` of them where a row has more than 32.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct WordSets {
    /// All voxels are inside.
    pub full: u32,
    /// Some voxels are inside and some are not. Words in neither set are all outside.
    pub mixed: u32,
    /// The surface may go through voxels.
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

    /// Those of a row of `width` voxels, of which `row` are inside; the surface may go through any of these.
    pub fn of(row: &[u64], width: usize) -> Self {
        let shift = Self::shift(width);
        let (mut some_outside, mut some_inside) = (0, 0);
        for (w, word) in row.iter().enumerate() {
            some_outside |= u32::from(*word != existing(width, w)) << (w >> shift);
            some_inside |= u32::from(*word != 0) << (w >> shift);
        }
        Self {
            full: some_inside & !some_outside,
            mixed: some_inside & some_outside,
            on: some_inside,
        }
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
    /// Of each row.
    pub sets: Vec<WordSets>,
    /// The words of all mixed groups.
    mixed: Vec<u64>,
}

impl SliceWords {
    /// Those of rows of `width` voxels, of which `inside` has the bits and `sets` are known.
    pub fn new(sets: &[WordSets], width: usize, inside: &[u64]) -> Self {
        let shift = WordSets::shift(width);
        let groups: u32 = sets.iter().map(|sets| sets.mixed.count_ones()).sum();
        let mut mixed = Vec::with_capacity((groups as usize) << shift);
        let rows = inside.chunks_exact(width.div_ceil(64)).zip(sets);
        for (row, sets) in rows.filter(|(_, sets)| sets.mixed != 0) {
            let is_mixed = |w: usize| sets.mixed >> (w >> shift) & 1 == 1;
            mixed.extend(
                row.iter()
                    .enumerate()
                    .filter(|(w, _)| is_mixed(*w))
                    .map(|(_, word)| word),
            );
        }
        Self {
            sets: sets.to_vec(),
            mixed,
        }
    }

    /// Writes the bits of rows of `width` voxels to `inside`.
    pub fn restore(&self, width: usize, inside: &mut [u64]) {
        let shift = WordSets::shift(width);
        let mut mixed = self.mixed.iter();
        for (row, sets) in inside.chunks_exact_mut(width.div_ceil(64)).zip(&self.sets) {
            for (w, word) in row.iter_mut().enumerate() {
                let is_in = |set: u32| set >> (w >> shift) & 1 == 1;
                *word = if is_in(sets.mixed) {
                    mixed.next().copied().unwrap_or(0)
                } else if is_in(sets.full) {
                    existing(width, w)
                } else {
                    0
                };
            }
        }
    }
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
