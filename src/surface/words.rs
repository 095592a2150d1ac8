//! What is known of rows of voxels once they were looked at: which words of their bits need another look.
//!
//! *Practice.* Twelve bytes a row, however long it is, so that it is small beside any volume.

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

/// What is known of the rows of some slices.
#[derive(Clone, Copy, Default)]
pub(super) struct Known<'a> {
    pub first_slice: usize,
    /// For each row, slice after slice.
    pub sets: &'a [WordSets],
}

impl<'a> Known<'a> {
    /// The rows of slice `k`, if they are known.
    pub fn slice(&self, k: usize, ny: usize) -> Option<&'a [WordSets]> {
        let start = k.checked_sub(self.first_slice)? * ny;
        self.sets.get(start..start + ny)
    }
}
