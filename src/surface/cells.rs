//! Rows of cells: their cases, how many vertices and triangles they make, and which vertices the triangles have
//! (LC87 §4, step 4, and the coherence of §5.1).
//!
//! *Theory.* Of a cell's twelve edges only three are new; the other nine were met in earlier cells, and so were the vertices
//! on them.
//! *Changes from the paper.* No vertex is looked up in earlier rows or slices. Vertices are numbered in the order of the edges
//! that are crossed, so an edge's vertex is its row's first one plus the number of crossed edges before it in the row: the
//! set bits below it. All rows can then be worked on at once.

use super::cases::CASES;

/// How many vertices there are on the x, y and z edges that start in a row of voxels, and triangles in the row of cells there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct RowCount {
    pub edges: [u32; 3],
    pub triangles: u32,
}

/// The vertex number of the first crossed x, y and z edge that starts in a row of voxels.
pub(super) type RowFirst = [u32; 3];

/// The bits of the four rows of voxels round a row of cells: bit 0 of an index is the upper one in y, bit 1 in z.
///
/// A row of voxels at the lattice's upper border has no row of cells; the missing rows are the border's own once more, so
/// that no edge towards them is crossed.
#[derive(Clone, Copy)]
pub(super) struct RowsRound<'a> {
    pub rows: [&'a [u64]; 4],
    /// Voxels in a row.
    pub width: usize,
}

impl RowsRound<'_> {
    /// The part of all rows in word `w`.
    #[inline(always)]
    fn word(&self, w: usize) -> CellWord {
        let here = self.rows.map(|row| row[w]);
        let next = self.rows.map(|row| row[w] >> 1 | row.get(w + 1).map_or(0, |above| above << 63));
        // The last voxel of a row starts neither a cell nor an x edge.
        let starts = self.width - 1 - (w * 64).min(self.width - 1);
        let cells = if starts >= 64 { u64::MAX } else { (1 << starts) - 1 };
        CellWord { here, next, cells }
    }

    /// The crossed x, y and z edges that start in word `w` of the first row.
    #[inline(always)]
    pub fn crossed(&self, w: usize) -> [u64; 3] {
        let word = self.word(w);
        let [row, up, above, _] = word.here;
        [word.crossed_x(0), row ^ up, row ^ above]
    }
}

/// 64 cells of a row: for each of four rows, whether the voxels at a cell's lower and upper x are inside.
struct CellWord {
    here: [u64; 4],
    next: [u64; 4],
    cells: u64,
}

impl CellWord {
    #[inline(always)]
    fn crossed_x(&self, row: usize) -> u64 {
        (self.here[row] ^ self.next[row]) & self.cells
    }

    /// The cells with corners both inside and outside.
    #[inline(always)]
    fn active(&self) -> u64 {
        let [a, b, c, d] = self.here;
        let [e, f, g, h] = self.next;
        (a | b | c | d | e | f | g | h) & !(a & b & c & d & e & f & g & h) & self.cells
    }

    /// The case of cell `i`.
    #[inline(always)]
    fn case(&self, i: u32) -> usize {
        let mut case = 0;
        for row in 0..4 {
            case |= (self.here[row] >> i & 1) << (2 * row) | (self.next[row] >> i & 1) << (2 * row + 1);
        }
        case as usize
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

/// Counts what a row makes.
#[multiversion::multiversion(targets("x86_64+avx2+popcnt+bmi1+bmi2"))]
pub(super) fn count(round: RowsRound<'_>) -> RowCount {
    let mut count = RowCount::default();
    for w in 0..round.rows[0].len() {
        let crossed = round.crossed(w);
        for axis in 0..3 {
            count.edges[axis] += crossed[axis].count_ones();
        }
        let word = round.word(w);
        for i in SetBits(word.active()) {
            count.triangles += u32::from(CASES[word.case(i)].count);
        }
    }
    count
}

/// Writes the triangles of a row of cells to the front of `triangles`, and returns how many; `first` belongs to the four rows.
#[multiversion::multiversion(targets("x86_64+avx2+popcnt+bmi1+bmi2"))]
pub(super) fn connect(round: RowsRound<'_>, mut first: [RowFirst; 4], triangles: &mut [[u32; 3]]) -> usize {
    let mut written = 0;
    for w in 0..round.rows[0].len() {
        let word = round.word(w);
        let crossings = Crossings::new(&word);
        for i in SetBits(word.active()) {
            let vertices = crossings.vertices(&first, i);
            let case = &CASES[word.case(i)];
            let made = &case.triangles[..usize::from(case.count)];
            for (out, edges) in triangles[written..].iter_mut().zip(made) {
                *out = edges.map(|e| vertices[usize::from(e)]);
            }
            written += made.len();
        }
        crossings.step_over(&mut first);
    }
    written
}

/// The crossed edges round 64 cells of a row: x edges of all four rows, y edges of the lower and the upper slice, z edges of
/// the lower and the upper row.
struct Crossings {
    x: [u64; 4],
    y: [u64; 2],
    z: [u64; 2],
}

impl Crossings {
    #[inline(always)]
    fn new(word: &CellWord) -> Self {
        let [row, up, above, both] = word.here;
        Self {
            x: [word.crossed_x(0), word.crossed_x(1), word.crossed_x(2), word.crossed_x(3)],
            y: [row ^ up, above ^ both],
            z: [row ^ above, up ^ both],
        }
    }

    /// The vertex on each of the twelve edges of cell `i`; a meaningless number where the edge is not crossed.
    #[inline(always)]
    fn vertices(&self, first: &[RowFirst; 4], i: u32) -> [u32; 12] {
        let before = (1 << i) - 1;
        // Edges at the cell's upper x are one further in their row.
        let through = before | 1 << i;
        let number = |first: u32, crossed: u64, below: u64| first + (crossed & below).count_ones();
        [
            number(first[0][0], self.x[0], before),
            number(first[1][0], self.x[1], before),
            number(first[2][0], self.x[2], before),
            number(first[3][0], self.x[3], before),
            number(first[0][1], self.y[0], before),
            number(first[0][1], self.y[0], through),
            number(first[2][1], self.y[1], before),
            number(first[2][1], self.y[1], through),
            number(first[0][2], self.z[0], before),
            number(first[0][2], self.z[0], through),
            number(first[1][2], self.z[1], before),
            number(first[1][2], self.z[1], through),
        ]
    }

    /// Moves `first` to the next word.
    #[inline(always)]
    fn step_over(&self, first: &mut [RowFirst; 4]) {
        for (first, crossed) in first.iter_mut().zip(self.x) {
            first[0] += crossed.count_ones();
        }
        first[0][1] += self.y[0].count_ones();
        first[2][1] += self.y[1].count_ones();
        first[0][2] += self.z[0].count_ones();
        first[1][2] += self.z[1].count_ones();
    }
}
