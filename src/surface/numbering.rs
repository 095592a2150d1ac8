//! The numbers of the vertices round a cell, from one cell of a row to the next (LC87 §5.1).
//!
//! *Theory.* Vertices on edges of one direction are numbered along the row, and a row of cells has eight rows of such edges.
//! *Practice.* Where a cell ends an edge's number is one higher if the edge had a vertex. That is known from the cell's case, so
//! a step over a cell adds a row of a table to eight numbers. Cells without a surface have no vertices to step over.

use super::cell::edge_corners;
use super::crossings::{Crossings, ON_VOXELS};

/// The places round a cell where vertices can be: its twelve edges, then its eight corners.
pub(super) const PLACES: usize = 20;

/// The edges with a vertex of their own that a row of cells goes along: x edges of its four rows of voxels, y edges of the lower
/// and the upper slice, z edges of the lower and the upper row.
const TRACKS: usize = 8;

/// The vertices round a cell: on each track the one at the cell's lower x, and then on each the next one. Of tracks in y and z
/// that is the one at the cell's upper x, if it has both. Then those on the cell's corners, and no others.
pub(super) type Vertices = [u32; 4 * TRACKS];

/// Where the vertices on corners start among [`Vertices`].
const ON_CORNERS: usize = 2 * TRACKS;

/// Where the vertex in each place is among [`Vertices`].
pub(super) const SLOTS: [u8; PLACES] = [0, 1, 2, 3, 4, 12, 5, 13, 6, 14, 7, 15, 16, 17, 18, 19, 20, 21, 22, 23];

/// For each case, how many vertices the cell has on each track that the next cell has no more.
pub(super) static STEPS: [[u8; TRACKS]; 256] = {
    let mut steps = [[0; TRACKS]; 256];
    let mut n = 0;
    while n < 256 * TRACKS {
        let (case, track) = (n / TRACKS, n % TRACKS);
        let mut edge = 0;
        while SLOTS[edge] as usize != track {
            edge += 1;
        }
        let [a, b] = edge_corners(edge as u8);
        steps[case][track] = (case >> a ^ case >> b) as u8 & 1;
        n += 1;
    }
    steps
};

/// Which edges and voxels round 64 cells of a row have a vertex of their own.
pub(super) struct OwnVertices {
    /// On each track.
    edges: [u64; TRACKS],
    /// On voxels of all four rows.
    on: [u64; 4],
}

impl OwnVertices {
    /// Round word `w` of row `j`, of the crossings that start in the lower and in the upper slice.
    #[inline(always)]
    pub fn of([lower, upper]: [&Crossings; 2], j: usize, w: usize) -> Self {
        let own = |slice: &Crossings, kind, j| slice.word(kind, j, w);
        Self {
            edges: [
                own(lower, 0, j),
                own(lower, 0, j + 1),
                own(upper, 0, j),
                own(upper, 0, j + 1),
                own(lower, 1, j),
                own(upper, 1, j),
                own(lower, 2, j),
                own(lower, 2, j + 1),
            ],
            on: [
                own(lower, ON_VOXELS, j),
                own(lower, ON_VOXELS, j + 1),
                own(upper, ON_VOXELS, j),
                own(upper, ON_VOXELS, j + 1),
            ],
        }
    }

    /// How many vertices cell `i` has on each track that the next cell has no more.
    #[inline(always)]
    fn step(&self, i: u32) -> [u8; TRACKS] {
        self.edges.map(|edges| (edges >> i & 1) as u8)
    }
}

/// The numbers of the vertices round the cells of a row, from one cell with a surface to the next.
#[derive(Clone)]
pub(super) struct Numbering {
    /// Those round the cell that was stepped over last; the second half is the first half of the cell that comes next.
    pub vertices: Vertices,
    /// The first vertex on voxels of each row, of the word.
    on: [u32; 4],
}

impl Numbering {
    /// Before the first cell of row `j`, of the crossings that start in the lower and in the upper slice.
    #[inline(always)]
    pub fn new([lower, upper]: [&Crossings; 2], j: usize) -> Self {
        let (lower, upper) = (&lower.numbers, &upper.numbers);
        let rows = [lower[j], lower[j + 1], upper[j], upper[j + 1]];
        let [a, b, c, d] = rows;
        let mut vertices = [0; 4 * TRACKS];
        vertices[TRACKS..ON_CORNERS].copy_from_slice(&[a[0], b[0], c[0], d[0], a[1], c[1], a[2], b[2]]);
        Self {
            vertices,
            on: rows.map(|row| row[ON_VOXELS]),
        }
    }

    /// Takes a step over a cell.
    #[inline(always)]
    pub fn step_over_cell(&mut self, step: &[u8; TRACKS]) {
        for n in 0..TRACKS {
            self.vertices[n] = self.vertices[TRACKS + n];
        }
        for (next, step) in self.vertices[TRACKS..ON_CORNERS].iter_mut().zip(step) {
            *next += u32::from(*step);
        }
    }

    /// Takes a step over cell `i`, some of whose corners may have a vertex. All cells with a surface are stepped over in their
    /// order.
    #[inline(always)]
    pub fn step_over_tied(&mut self, own: &OwnVertices, i: u32) {
        self.step_over_cell(&own.step(i));
        for row in 0..4 {
            let at_lower_x = self.on[row] + (own.on[row] & ((1 << i) - 1)).count_ones();
            self.vertices[ON_CORNERS + 2 * row] = at_lower_x;
            self.vertices[ON_CORNERS + 2 * row + 1] = at_lower_x + (own.on[row] >> i & 1) as u32;
        }
    }

    /// The vertex on each of the twelve edges of cell `i`, a meaningless number where the edge has none of its own; and steps
    /// over the cell. All cells with a surface are stepped over in their order.
    #[inline(always)]
    pub fn next_cell(&mut self, own: &OwnVertices, i: u32) -> [u32; 12] {
        self.step_over_cell(&own.step(i));
        std::array::from_fn(|edge| self.vertices[usize::from(SLOTS[edge])])
    }

    /// The vertex in each place round the cell that was stepped over last; a meaningless number where there is none.
    fn places(&self) -> [u32; PLACES] {
        SLOTS.map(|slot| self.vertices[usize::from(slot)])
    }

    /// The vertex in each place round any cell `i` of a word before its first is stepped over; a meaningless number where there
    /// is none.
    pub fn in_places(&self, own: &OwnVertices, i: u32) -> [u32; PLACES] {
        let mut there = self.clone();
        let before = (1 << i) - 1;
        for (next, edges) in there.vertices[TRACKS..ON_CORNERS].iter_mut().zip(own.edges) {
            *next += (edges & before).count_ones();
        }
        there.step_over_tied(own, i);
        there.places()
    }

    /// Steps over the vertices on voxels of a word whose cells have been stepped over.
    #[inline(always)]
    pub fn end_word(&mut self, own: &OwnVertices) {
        for (next, on) in self.on.iter_mut().zip(own.on) {
            *next += on.count_ones();
        }
    }

    /// Steps over a word none of whose cells has been stepped over.
    pub fn step_over(&mut self, own: &OwnVertices) {
        for (next, edges) in self.vertices[TRACKS..ON_CORNERS].iter_mut().zip(own.edges) {
            *next += edges.count_ones();
        }
        self.end_word(own);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::surface::cells::{Cells, SetBits};
    use crate::surface::inside::{Classifier, InsideRows, Ties};
    use crate::surface::slices::Slices;

    proptest! {
        /// Stepping over the cells of a row and counting the set bits before one are two ways to the same numbers.
        #[test]
        fn steps_count_what_is_before(voxels in prop::collection::vec(0_u8..4, 2 * 2 * 150)) {
            let dims = [150, 2, 2];
            let slices = Slices { voxels: &voxels, first_slice: 0, dims };
            let rows = InsideRows::of(&Classifier::new(slices, 2.0, Ties::OneVertex), 0..2);
            let mut first = 0;
            let crossings = [0, 1].map(|k| {
                let mut crossings = Crossings::new(dims);
                crossings.find(&rows, k);
                crossings.number(first);
                first += crossings.count() as u32;
                crossings
            });
            let mut cells = Cells::default();
            cells.find(&rows, 0);
            let mut stepped = Numbering::new(crossings.each_ref(), 0);
            let mut counted = stepped.clone();
            for (w, active) in cells.active.iter().enumerate() {
                let own = OwnVertices::of(crossings.each_ref(), 0, w);
                for i in SetBits(*active) {
                    stepped.step_over_tied(&own, i);
                    prop_assert_eq!(stepped.places(), counted.in_places(&own, i), "word {}, cell {}", w, i);
                }
                stepped.end_word(&own);
                counted.step_over(&own);
            }
        }
    }
}
