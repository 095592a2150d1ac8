//! Rows of cells: their cases, how many vertices and triangles they make, and which vertices the triangles have
//! (LC87 §4, step 4, and the coherence of §5.1).
//!
//! *Theory.* Of a cell's twelve edges only three are new; the other nine were met in earlier cells, and so were the vertices
//! on them.
//! *Changes from the paper.* No vertex is looked up in earlier rows or slices. Vertices are numbered in the order of the edges
//! that are crossed, so an edge's vertex is its row's first one plus the number of crossed edges before it in the row: the
//! set bits below it. All rows can then be worked on at once.

use super::cases::CASES;
use super::inside::InsideRows;

/// How many vertices there are on the x, y and z edges that start in a row of voxels, and triangles in the row of cells there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct RowCount {
    pub edges: [u32; 3],
    pub triangles: u32,
}

/// Where a row's vertices are, and whether it has any work.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RowPlan {
    /// The numbers of the vertices on the first crossed x, y and z edge that starts in the row.
    pub first: [u32; 3],
    /// Whether any x, y or z edge is crossed.
    pub crossed: [bool; 3],
    /// Whether any cell has triangles.
    pub triangles: bool,
}

/// The bits of the four rows of voxels round a row of cells: bit 0 of an index is the upper one in y, bit 1 in z.
///
/// A row of voxels at the lattice's upper border has no row of cells; the missing rows are the border's own once more, so
/// that no edge towards them is crossed.
#[derive(Clone, Copy)]
pub(super) struct RowsRound<'a> {
    rows: [&'a [u64]; 4],
    /// Voxels in a row.
    width: usize,
}

impl<'a> RowsRound<'a> {
    /// The rows round row `j` of slice `k`.
    #[inline(always)]
    pub fn new(rows: &'a InsideRows, j: usize, k: usize) -> Self {
        let [width, ny, nz] = rows.dims;
        let (up, above) = ((j + 1).min(ny - 1), (k + 1).min(nz - 1));
        Self {
            rows: [rows.row(j, k), rows.row(up, k), rows.row(j, above), rows.row(up, above)],
            width,
        }
    }

    /// Words in a row.
    #[inline(always)]
    pub fn words(&self) -> usize {
        self.rows[0].len()
    }

    /// The part of all rows in word `w`.
    #[inline(always)]
    fn word(&self, w: usize) -> CellWord {
        let (mut here, mut next) = ([0; 4], [0; 4]);
        for (n, row) in self.rows.iter().enumerate() {
            here[n] = row[w];
            next[n] = row[w] >> 1;
            if w + 1 < row.len() {
                next[n] |= row[w + 1] << 63;
            }
        }
        // The last voxel of a row starts neither a cell nor an x edge.
        let starts = self.width - 1 - (w * 64).min(self.width - 1);
        let cells = if starts >= 64 { u64::MAX } else { (1 << starts) - 1 };
        CellWord { here, next, cells }
    }

    /// The crossed edges along `axis` that start in word `w` of the first row.
    #[inline(always)]
    pub fn crossed(&self, w: usize, axis: usize) -> u64 {
        match axis {
            0 => self.word(w).crossed_x(0),
            _ => self.rows[0][w] ^ self.rows[axis][w],
        }
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

/// Counts what each row of slice `k` makes.
#[multiversion::multiversion(targets("x86_64+avx2+popcnt+bmi1+bmi2"))]
pub(super) fn count(rows: &InsideRows, k: usize, counts: &mut [RowCount]) {
    let [_, ny, nz] = rows.dims;
    for (j, count) in counts.iter_mut().enumerate() {
        let round = RowsRound::new(rows, j, k);
        *count = RowCount::default();
        for w in 0..round.words() {
            for axis in 0..3 {
                count.edges[axis] += round.crossed(w, axis).count_ones();
            }
            if j + 1 < ny && k + 1 < nz {
                let word = round.word(w);
                for i in SetBits(word.active()) {
                    count.triangles += u32::from(CASES[word.case(i)].count);
                }
            }
        }
    }
}

/// Writes the triangles of the cells between slices `k` and `k + 1`; `plan` is for each row of those two slices.
#[multiversion::multiversion(targets("x86_64+avx2+popcnt+bmi1+bmi2"))]
pub(super) fn connect(rows: &InsideRows, k: usize, plan: [&[RowPlan]; 2], triangles: &mut [[u32; 3]]) {
    let mut places = triangles.iter_mut();
    for j in (0..rows.dims[1] - 1).filter(|j| plan[0][*j].triangles) {
        let round = RowsRound::new(rows, j, k);
        let [lower, upper] = plan;
        let mut first = [lower[j].first, lower[j + 1].first, upper[j].first, upper[j + 1].first];
        for w in 0..round.words() {
            let word = round.word(w);
            let crossings = Crossings::new(&word);
            for i in SetBits(word.active()) {
                let vertices = crossings.vertices(&first, i);
                let case = &CASES[word.case(i)];
                for edges in &case.triangles[..usize::from(case.count)] {
                    if let Some(triangle) = places.next() {
                        for v in 0..3 {
                            triangle[v] = vertices[usize::from(edges[v])];
                        }
                    }
                }
            }
            crossings.step_over(&mut first);
        }
    }
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
    fn vertices(&self, first: &[[u32; 3]; 4], i: u32) -> [u32; 12] {
        let before = (1 << i) - 1;
        // Edges at the cell's upper x are one further in their row.
        let through = before | 1 << i;
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
    fn step_over(&self, first: &mut [[u32; 3]; 4]) {
        for n in 0..4 {
            first[n][0] += self.x[n].count_ones();
        }
        first[0][1] += self.y[0].count_ones();
        first[2][1] += self.y[1].count_ones();
        first[0][2] += self.z[0].count_ones();
        first[1][2] += self.z[1].count_ones();
    }
}

/// The number of the vertex on an edge: `first`, and one more for each crossed edge before it.
#[inline(always)]
fn number(first: u32, crossed: u64, before: u64) -> u32 {
    first + (crossed & before).count_ones()
}
