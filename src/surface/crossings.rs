//! Which edges that start in a slice are crossed, one bit each, and the numbers of the vertices on them (LC87 §5.1).
//!
//! *Theory.* Of a cell's twelve edges only three are new; the other nine were met in earlier cells, and so were the vertices
//! on them.
//! *Changes from the paper.* No vertex is looked up in earlier rows or slices. Vertices are numbered in the order of the edges
//! that are crossed, so an edge's vertex is its row's first one plus the number of crossed edges before it in the row: the
//! set bits below it. All slices can then be worked on at once.
//! *Practice.* A voxel of the isovalue itself takes the vertices of all its crossed edges together: it has a vertex of its own,
//! and they have none. Bits of many rows are combined at a time, in wide registers; that costs less than to find out where
//! nothing is crossed. Only rows before the first and after the last with a voxel inside are left out.

use std::ops::Range;

use super::bits::{SliceBits, clear_beyond};
use super::inside::InsideRows;

/// The kinds of vertices: on x, y and z edges, and others.
pub(super) const KINDS: usize = 4;

/// The kind of vertices that lie on voxels; those below it are the edges' axes.
pub(super) const ON_VOXELS: usize = 3;

/// The numbers of the first vertices of each kind that start in a row of voxels.
pub(super) type RowNumbers = [u32; KINDS];

/// The vertices that start in a slice: one bit for each voxel that an edge with a vertex starts from, or that is one itself.
pub(super) struct Crossings {
    /// For each kind, row after row.
    kinds: [Vec<u64>; KINDS],
    words_a_row: usize,
    /// All rows with any are among these.
    pub rows: Range<usize>,
    /// Of each row.
    pub numbers: Vec<RowNumbers>,
}

impl Crossings {
    /// Without any vertices, in a lattice of `dims`.
    pub fn new(dims: [usize; 3]) -> Self {
        let words_a_row = dims[0].div_ceil(64);
        Self {
            kinds: std::array::from_fn(|_| vec![0; words_a_row * dims[1]]),
            words_a_row,
            rows: 0..0,
            numbers: vec![[0; KINDS]; dims[1]],
        }
    }

    /// Finds those of slice `k`, without their numbers. No edge leads on from the last slice that is held.
    pub fn find(&mut self, rows: &InsideRows, k: usize) {
        let above = (k + 1).min(rows.slices.end - 1);
        let inside = rows.rows_inside(k, above);
        let found = inside.start.saturating_sub(1)..inside.end;
        for kind in &mut self.kinds {
            clear_beyond(kind, self.words_a_row, &self.rows, &found);
        }
        let row = self.words_a_row;
        let words = found.start * row..found.end * row;
        let (first, but_last) = (words.start, words.start..words.end.min((rows.dims[1] - 1) * row));
        let [x, y, z, on] = &mut self.kinds;
        let [from, from_on] = [rows.inside(k).skip(first), rows.on(k).skip(first)];
        let [to, to_on] = [rows.inside(above).skip(first), rows.on(above).skip(first)];
        across_x(from, from_on, &rows.starts()[first..], &mut x[words.clone()]);
        across([from, from.skip(row)], [from_on, from_on.skip(row)], &mut y[but_last]);
        across([from, to], [from_on, to_on], &mut z[words.clone()]);
        on[words.clone()].copy_from_slice(&from_on.0[..words.len()]);
        self.rows = found;
    }

    /// How many there are.
    pub fn count(&self) -> u64 {
        let words = self.rows.start * self.words_a_row..self.rows.end * self.words_a_row;
        self.kinds.iter().map(|bits| count_ones(&bits[words.clone()])).sum()
    }

    /// Numbers them from `first` on, row after row and kind after kind.
    pub fn number(&mut self, first: u32) {
        let rows = self.rows.clone();
        self.numbers[..rows.start].fill([first; KINDS]);
        let next = number(&self.kinds, self.words_a_row, rows.clone(), first, &mut self.numbers);
        self.numbers[rows.end..].fill([next; KINDS]);
    }

    /// The vertices of `kind` in word `w` of row `j`.
    #[inline(always)]
    pub fn word(&self, kind: usize, j: usize, w: usize) -> u64 {
        self.kinds[kind][j * self.words_a_row + w]
    }

    /// The vertices of `kind` in row `j`.
    #[inline(always)]
    pub fn row(&self, kind: usize, j: usize) -> &[u64] {
        &self.kinds[kind][j * self.words_a_row..][..self.words_a_row]
    }
}

/// The x edges with a vertex of their own that start from voxels of a slice.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn across_x(inside: SliceBits<'_>, on: SliceBits<'_>, starts: &[u64], out: &mut [u64]) {
    let words = out.len();
    let (inside, inside_after) = (&inside.0[..words], &inside.0[1..][..words]);
    let (on, on_after) = (&on.0[..words], &on.0[1..][..words]);
    let starts = &starts[..words];
    for n in 0..words {
        let next = inside[n] >> 1 | inside_after[n] << 63;
        let on_next = on[n] >> 1 | on_after[n] << 63;
        out[n] = (inside[n] ^ next) & starts[n] & !(on[n] | on_next);
    }
}

/// The edges with a vertex of their own from the voxels of some rows to those of as many others.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn across(inside: [SliceBits<'_>; 2], on: [SliceBits<'_>; 2], out: &mut [u64]) {
    let words = out.len();
    let (from, to) = (&inside[0].0[..words], &inside[1].0[..words]);
    let (on_from, on_to) = (&on[0].0[..words], &on[1].0[..words]);
    for n in 0..words {
        out[n] = (from[n] ^ to[n]) & !(on_from[n] | on_to[n]);
    }
}

#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl+avx512vpopcntdq", "x86_64+popcnt"))]
fn count_ones(bits: &[u64]) -> u64 {
    let mut count = 0;
    for word in bits {
        count += u64::from(word.count_ones());
    }
    count
}

/// Numbers those of some rows from `first` on, and returns the number after the last.
#[multiversion::multiversion(targets("x86_64+popcnt"))]
fn number(
    kinds: &[Vec<u64>; KINDS],
    words_a_row: usize,
    rows: Range<usize>,
    first: u32,
    numbers: &mut [RowNumbers],
) -> u32 {
    let mut next = first;
    for j in rows {
        for kind in 0..KINDS {
            numbers[j][kind] = next;
            for word in &kinds[kind][j * words_a_row..][..words_a_row] {
                // Wraps only where there is an error in the end.
                next = next.wrapping_add(word.count_ones());
            }
        }
    }
    next
}
