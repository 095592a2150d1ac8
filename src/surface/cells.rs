//! Cells: which of them the surface runs through, their cases, and which vertices their triangles have (LC87 §4, step 4).
//!
//! *Practice.* Where a cell's edges end on voxels of the isovalue, their vertices are those voxels' ([`ties`](super::ties)).

use std::ops::Range;

use super::bits::{SliceBits, clear_beyond};
use super::cases::{CASES, Case, MAX_TRIANGLES};
use super::crossings::Crossings;
use super::inside::InsideRows;
use super::numbering::{Numbering, OwnVertices, SLOTS, STEPS, Vertices};
use super::ties::{COUNTS, TIED_CASES, way};

/// The cells between two slices, one bit each, row after row as of voxels.
#[derive(Default)]
pub(super) struct Cells {
    /// Those with corners both inside and outside.
    pub active: Vec<u64>,
    /// All rows with any are among these.
    rows: Range<usize>,
}

impl Cells {
    /// Finds those between slices `k` and `k + 1`.
    pub fn find(&mut self, rows: &InsideRows, k: usize) {
        let row = rows.words_a_row();
        let height = rows.dims[1] - 1;
        let inside = rows.rows_inside(k, k + 1);
        let found = inside.start.saturating_sub(1)..inside.end.min(height);
        self.active.resize(row * height, 0);
        clear_beyond(&mut self.active, row, &self.rows, &found);
        let first = found.start * row;
        let [lower, upper] = [rows.inside(k).skip(first), rows.inside(k + 1).skip(first)];
        find_mixed(
            [lower, lower.skip(row), upper, upper.skip(row)],
            &rows.starts()[first..],
            &mut self.active[first..found.end * row],
        );
        self.rows = found;
    }
}

/// The cells with corners both inside and outside, of the four rows of voxels round each row of them.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn find_mixed(rows: [SliceBits<'_>; 4], starts: &[u64], mixed: &mut [u64]) {
    let words = mixed.len();
    let [a, b, c, d] = rows.map(|bits| &bits.0[..words]);
    let [a1, b1, c1, d1] = rows.map(|bits| &bits.0[1..][..words]);
    let starts = &starts[..words];
    for n in 0..words {
        let (any, all) = (a[n] | b[n] | c[n] | d[n], a[n] & b[n] & c[n] & d[n]);
        let (any_after, all_after) = (a1[n] | b1[n] | c1[n] | d1[n], a1[n] & b1[n] & c1[n] & d1[n]);
        let (any_next, all_next) = (any >> 1 | any_after << 63, all >> 1 | all_after << 63);
        mixed[n] = (any | any_next) & !(all & all_next) & starts[n];
    }
}

/// 64 cells of a row: the corners that are inside, and those that the surface goes through.
pub(super) struct CellWord {
    pub inside: Corners,
    pub on: Corners,
    /// The cells there are.
    pub cells: u64,
}

impl CellWord {
    /// Word `w` of row `j` between slices `k` and `k + 1`.
    #[inline(always)]
    pub fn new(rows: &InsideRows, [w, j, k]: [usize; 3]) -> Self {
        Self {
            inside: Corners::inside(rows, [w, j, k]),
            on: Corners::on(rows, [w, j, k]),
            cells: rows.starts()[j * rows.words_a_row() + w],
        }
    }
}

/// One bit for the voxels at the lower and the upper x of 64 cells of a row, of each of four rows.
pub(super) struct Corners {
    here: [u64; 4],
    next: [u64; 4],
}

impl Corners {
    /// The corners that are inside, of word `w` of row `j` between slices `k` and `k + 1`.
    #[inline(always)]
    fn inside(rows: &InsideRows, [w, j, k]: [usize; 3]) -> Self {
        let (row, first) = (rows.words_a_row(), j * rows.words_a_row() + w);
        Self::new([rows.inside(k), rows.inside(k + 1)], [first, first + row])
    }

    /// The corners that the surface goes through.
    #[inline(always)]
    fn on(rows: &InsideRows, [w, j, k]: [usize; 3]) -> Self {
        let (row, first) = (rows.words_a_row(), j * rows.words_a_row() + w);
        Self::new([rows.on(k), rows.on(k + 1)], [first, first + row])
    }

    /// Of the words `row` and `next_row` of two slices. Their last cell may have corners of the next row, if it is none.
    #[inline(always)]
    fn new([lower, upper]: [SliceBits<'_>; 2], [row, next_row]: [usize; 2]) -> Self {
        let (mut here, mut next) = ([0; 4], [0; 4]);
        for (n, (slice, w)) in [(lower, row), (lower, next_row), (upper, row), (upper, next_row)]
            .into_iter()
            .enumerate()
        {
            here[n] = slice.0[w];
            next[n] = here[n] >> 1 | slice.0[w + 1] << 63;
        }
        Self { here, next }
    }

    /// The cells with a corner that is set.
    #[inline(always)]
    pub fn any(&self) -> u64 {
        let ([a, b, c, d], [e, f, g, h]) = (self.here, self.next);
        a | b | c | d | e | f | g | h
    }

    /// The cells whose corners are all set.
    #[inline(always)]
    pub fn all(&self) -> u64 {
        let ([a, b, c, d], [e, f, g, h]) = (self.here, self.next);
        a & b & c & d & e & f & g & h
    }

    /// The eight corners of cell `i`.
    #[inline(always)]
    pub fn of_cell(&self, i: u32) -> usize {
        let mut corners = 0;
        for row in 0..4 {
            // The corners of a row are next to each other but in the last cell of a word.
            let pair = if i < 63 {
                self.here[row] >> i & 3
            } else {
                self.here[row] >> 63 | (self.next[row] >> 63) << 1
            };
            corners |= pair << (2 * row);
        }
        corners as usize
    }
}

/// The positions of the set bits of a word, from the lowest.
pub(super) struct SetBits(pub u64);

impl Iterator for SetBits {
    type Item = u32;

    #[inline(always)]
    fn next(&mut self) -> Option<u32> {
        let lowest = self.0.trailing_zeros();
        self.0 &= self.0.wrapping_sub(1);
        (lowest < 64).then_some(lowest)
    }
}

/// How many triangles the `cells` between slices `k` and `k + 1` have.
#[multiversion::multiversion(targets("x86_64+avx2+popcnt+bmi1+bmi2"))]
pub(super) fn count(rows: &InsideRows, k: usize, cells: &Cells) -> u64 {
    let words_a_row = rows.words_a_row();
    let mut count = 0;
    for j in cells.rows.clone() {
        for w in 0..words_a_row {
            let active = cells.active[j * words_a_row + w];
            if active == 0 {
                continue;
            }
            let inside = Corners::inside(rows, [w, j, k]);
            let on = Corners::on(rows, [w, j, k]);
            for i in SetBits(active) {
                count += u64::from(COUNTS[way(inside.of_cell(i), on.of_cell(i))]);
            }
        }
    }
    count
}

/// Writes the triangles of the `cells` between slices `k` and `k + 1`, whose vertices are `crossings`.
#[multiversion::multiversion(targets("x86_64+avx2+popcnt+bmi1+bmi2"))]
pub(super) fn connect(
    rows: &InsideRows,
    k: usize,
    crossings: [&Crossings; 2],
    cells: &Cells,
    triangles: &mut [[u32; 3]],
) {
    let words_a_row = rows.words_a_row();
    let has_ties = rows.has_on(k) || rows.has_on(k + 1);
    let mut rest = triangles;
    for j in cells.rows.clone() {
        let first = j * words_a_row;
        if cells.active[first..][..words_a_row].iter().all(|word| *word == 0) {
            continue;
        }
        let mut numbering = Numbering::new(crossings, j);
        for w in 0..words_a_row {
            let active = cells.active[first + w];
            if active == 0 {
                if has_ties {
                    numbering.end_word(&OwnVertices::of(crossings, j, w));
                }
                continue;
            }
            let inside = Corners::inside(rows, [w, j, k]);
            if !has_ties {
                for i in SetBits(active) {
                    let case = inside.of_cell(i);
                    numbering.step_over_cell(&STEPS[case]);
                    let written = write(rest, &SLOT_CASES[case], &numbering.vertices);
                    rest = &mut rest[written..];
                }
                continue;
            }
            let on = Corners::on(rows, [w, j, k]);
            let own = OwnVertices::of(crossings, j, w);
            for i in SetBits(active) {
                numbering.step_over_tied(&own, i);
                let case = &TIED_CASES[way(inside.of_cell(i), on.of_cell(i))];
                let written = write(rest, case, &numbering.vertices);
                rest = &mut rest[written..];
            }
            numbering.end_word(&own);
        }
    }
}

/// [`CASES`], with the slots of edges in place of edges.
static SLOT_CASES: [Case; 256] = {
    let mut cases = CASES;
    let mut n = 0;
    while n < 256 * MAX_TRIANGLES * 3 {
        let edge = &mut cases[n / (3 * MAX_TRIANGLES)].triangles[n / 3 % MAX_TRIANGLES][n % 3];
        *edge = SLOTS[*edge as usize];
        n += 1;
    }
    cases
};

/// Writes the triangles of a case, and returns how many there are.
#[inline(always)]
fn write(room: &mut [[u32; 3]], case: &Case, vertices: &Vertices) -> usize {
    let count = usize::from(case.count);
    let corner = |slot: u8| vertices[usize::from(slot) % vertices.len()];
    // What is too much is overwritten by the next cell: that is faster than a loop of unknown length.
    if let Some(room) = room.first_chunk_mut::<MAX_TRIANGLES>() {
        *room = case.triangles.map(|slots| slots.map(corner));
    } else {
        for (triangle, slots) in room[..count].iter_mut().zip(case.triangles) {
            *triangle = slots.map(corner);
        }
    }
    count
}
