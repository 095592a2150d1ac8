//! Rows of cells: their cases, how many vertices and triangles they make, and which vertices the triangles have
//! (LC87 §4, step 4, and the coherence of §5.1).
//!
//! *Theory.* Of a cell's twelve edges only three are new; the other nine were met in earlier cells, and so were the vertices
//! on them.
//! *Changes from the paper.* No vertex is looked up in earlier rows or slices. Vertices are numbered in the order of the edges
//! that are crossed, so an edge's vertex is its row's first one plus the number of crossed edges before it in the row: the
//! set bits below it. All rows can then be worked on at once.
//! *Practice.* A voxel of the isovalue itself takes the vertices of all its crossed edges together: it has a vertex of its own,
//! and they have none. A triangle of which two corners became one is left out, as vtkMarchingCubes does.

use super::cases::{CASES, Case};
use super::cell::CORNER_EDGES;
use super::inside::InsideRows;

/// The kinds of vertices: on x, y and z edges, and others.
pub(super) const KINDS: usize = 4;

/// The kind of vertices that lie on voxels; those below it are the edges' axes.
pub(super) const ON_VOXELS: usize = 3;

/// The kind of vertices that lie within cells, in the trilinear topology, which has none on voxels.
pub(super) const IN_CELLS: usize = 3;

/// How many vertices of each kind start in a row of voxels, and triangles in the row of cells there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct RowCount {
    pub vertices: [u32; KINDS],
    pub triangles: u32,
}

/// Where a row's vertices are, and whether it has any work.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RowPlan {
    /// The number of the row's first vertex of each kind.
    pub first: [u32; KINDS],
    /// Whether there is any vertex of each kind.
    pub any: [bool; KINDS],
    /// Whether there is any triangle.
    pub triangles: bool,
}

/// The bits of the four rows of voxels round a row of cells: bit 0 of an index is the upper one in y, bit 1 in z.
///
/// A row of voxels at the upper border of the lattice, or of the slices held, has no row of cells; the missing rows are the
/// border's own once more, so that no edge towards them is crossed.
#[derive(Clone, Copy)]
pub(super) struct RowsRound<'a> {
    inside: [&'a [u64]; 4],
    /// Empty where the surface goes through no voxel.
    on: [&'a [u64]; 4],
    /// Voxels in a row.
    width: usize,
}

impl<'a> RowsRound<'a> {
    /// The rows round row `j` of slice `k`.
    #[inline(always)]
    pub fn new(rows: &'a InsideRows, j: usize, k: usize) -> Self {
        let [width, ny, _] = rows.dims;
        let (up, above) = ((j + 1).min(ny - 1), (k + 1).min(rows.slices.end - 1));
        Self {
            inside: [rows.row(j, k), rows.row(up, k), rows.row(j, above), rows.row(up, above)],
            on: [rows.on(j, k), rows.on(up, k), rows.on(j, above), rows.on(up, above)],
            width,
        }
    }

    /// Words in a row.
    #[inline(always)]
    pub fn words(&self) -> usize {
        self.inside[0].len()
    }

    /// The part of all rows in word `w`.
    #[inline(always)]
    pub fn word(&self, w: usize) -> CellWord {
        // The last voxel of a row starts neither a cell nor an x edge.
        let starts = self.width - 1 - (w * 64).min(self.width - 1);
        CellWord {
            inside: Corners::new(&self.inside, w),
            on: Corners::new(&self.on, w),
            cells: if starts >= 64 { u64::MAX } else { (1 << starts) - 1 },
        }
    }

    /// The cells with corners both inside and outside in word `w`.
    #[inline(always)]
    pub fn active(&self, w: usize) -> u64 {
        self.word(w).active()
    }

    /// The vertices of `kind` in word `w` of the first row.
    #[inline(always)]
    pub fn vertices(&self, w: usize, kind: usize) -> u64 {
        let word = self.word(w);
        match kind {
            0 => word.own_x(0),
            1 | 2 => word.own_across(0, kind),
            _ => word.on.here[0],
        }
    }
}

/// One bit for the voxels at the lower and the upper x of 64 cells of a row, of each of four rows.
pub(super) struct Corners {
    here: [u64; 4],
    next: [u64; 4],
}

impl Corners {
    #[inline(always)]
    fn new(rows: &[&[u64]; 4], w: usize) -> Self {
        let (mut here, mut next) = ([0; 4], [0; 4]);
        for n in 0..4 {
            if w < rows[n].len() {
                here[n] = rows[n][w];
                next[n] = here[n] >> 1;
            }
            if w + 1 < rows[n].len() {
                next[n] |= rows[n][w + 1] << 63;
            }
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
            corners |= (self.here[row] >> i & 1) << (2 * row) | (self.next[row] >> i & 1) << (2 * row + 1);
        }
        corners as usize
    }
}

/// 64 cells of a row.
pub(super) struct CellWord {
    pub inside: Corners,
    pub on: Corners,
    /// The cells there are.
    pub cells: u64,
}

impl CellWord {
    /// The x edges of a row with a vertex of their own.
    #[inline(always)]
    fn own_x(&self, row: usize) -> u64 {
        (self.inside.here[row] ^ self.inside.next[row]) & self.cells & !(self.on.here[row] | self.on.next[row])
    }

    /// The edges from one row to another with a vertex of their own.
    #[inline(always)]
    fn own_across(&self, from: usize, to: usize) -> u64 {
        (self.inside.here[from] ^ self.inside.here[to]) & !(self.on.here[from] | self.on.here[to])
    }

    /// Whether all voxels are inside or all outside, and the surface goes through none: there are no vertices and no
    /// triangles.
    #[inline(always)]
    fn is_plain(&self) -> bool {
        self.inside.any() == self.inside.all() && self.on.any() == 0
    }

    /// The cells with corners both inside and outside.
    #[inline(always)]
    fn active(&self) -> u64 {
        self.inside.any() & !self.inside.all() & self.cells
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
    for (j, count) in counts.iter_mut().enumerate() {
        let round = RowsRound::new(rows, j, k);
        let has_cells = j + 1 < rows.dims[1] && k + 1 < rows.slices.end;
        *count = RowCount::default();
        for w in 0..round.words() {
            let word = round.word(w);
            if word.is_plain() {
                continue;
            }
            count.vertices[0] += word.own_x(0).count_ones();
            count.vertices[1] += word.own_across(0, 1).count_ones();
            count.vertices[2] += word.own_across(0, 2).count_ones();
            count.vertices[ON_VOXELS] += word.on.here[0].count_ones();
            if has_cells {
                count.triangles += triangles(&word);
            }
        }
    }
}

/// How many triangles the cells of a word make.
#[inline(always)]
fn triangles(word: &CellWord) -> u32 {
    let mut count = 0;
    let active = word.active();
    let through = word.on.any();
    for i in SetBits(active & !through) {
        count += u32::from(CASES[word.inside.of_cell(i)].count);
    }
    for i in SetBits(active & through) {
        count += triangles_through(&CASES[word.inside.of_cell(i)], word.on.of_cell(i));
    }
    count
}

/// How many triangles a case makes where the surface goes through the corners `on`.
#[inline(always)]
fn triangles_through(case: &Case, on: usize) -> u32 {
    let mut vertices = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];
    for corner in SetBits(on as u64) {
        for e in CORNER_EDGES[corner as usize] {
            vertices[usize::from(e)] = 12 + corner;
        }
    }
    let mut count = 0;
    for edges in &case.triangles[..usize::from(case.count)] {
        count += u32::from(is_whole(corners(edges, &vertices)));
    }
    count
}

/// The vertices of a triangle whose vertices lie on `edges`.
#[inline(always)]
pub(super) fn corners(edges: &[u8; 3], vertices: &[u32; 12]) -> [u32; 3] {
    let [a, b, c] = *edges;
    [
        vertices[usize::from(a)],
        vertices[usize::from(b)],
        vertices[usize::from(c)],
    ]
}

/// Whether no two corners are one.
#[inline(always)]
pub(super) fn is_whole<V: PartialEq>([a, b, c]: [V; 3]) -> bool {
    a != b && b != c && c != a
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
            if word.is_plain() {
                continue;
            }
            let numbering = Numbering::of(&word);
            let through = word.on.any();
            for i in SetBits(word.active()) {
                let case = &CASES[word.inside.of_cell(i)];
                let mut vertices = numbering.on_edges(&first, i);
                if through >> i & 1 == 1 {
                    numbering.move_to_corners(&first, i, word.on.of_cell(i), &mut vertices);
                }
                for edges in &case.triangles[..usize::from(case.count)] {
                    let triangle = corners(edges, &vertices);
                    if is_whole(triangle)
                        && let Some(place) = places.next()
                    {
                        *place = triangle;
                    }
                }
            }
            numbering.step_over(&mut first);
        }
    }
}

/// The vertices round 64 cells of a row: on x edges of all four rows, on y edges of the lower and the upper slice, on z edges
/// of the lower and the upper row, and on voxels of all four rows.
pub(super) struct Numbering {
    x: [u64; 4],
    y: [u64; 2],
    z: [u64; 2],
    on: [u64; 4],
}

impl Numbering {
    /// The vertices in word `w`.
    pub fn new(round: &RowsRound<'_>, w: usize) -> Self {
        Self::of(&round.word(w))
    }

    #[inline(always)]
    pub fn of(word: &CellWord) -> Self {
        Self {
            x: [word.own_x(0), word.own_x(1), word.own_x(2), word.own_x(3)],
            y: [word.own_across(0, 1), word.own_across(2, 3)],
            z: [word.own_across(0, 2), word.own_across(1, 3)],
            on: word.on.here,
        }
    }

    /// The vertex on each of the twelve edges of cell `i`; a meaningless number where the edge has none of its own.
    #[inline(always)]
    pub fn on_edges(&self, first: &[[u32; KINDS]; 4], i: u32) -> [u32; 12] {
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

    /// Puts the vertices of those corners of cell `i` that are `on` in place of the vertices on their edges.
    #[inline(always)]
    pub fn move_to_corners(&self, first: &[[u32; KINDS]; 4], i: u32, on: usize, vertices: &mut [u32; 12]) {
        for corner in SetBits(on as u64) {
            let vertex = self.on_corner(first, i, corner);
            for e in CORNER_EDGES[corner as usize] {
                vertices[usize::from(e)] = vertex;
            }
        }
    }

    /// The vertex on a corner of cell `i`; a meaningless number where it is not one.
    #[inline(always)]
    pub fn on_corner(&self, first: &[[u32; KINDS]; 4], i: u32, corner: u32) -> u32 {
        let row = (corner / 2) as usize;
        let below = ((1 << i) - 1) | u64::from(corner % 2) << i;
        number(first[row][ON_VOXELS], self.on[row], below)
    }

    /// Moves `first` to the next word.
    #[inline(always)]
    pub fn step_over(&self, first: &mut [[u32; KINDS]; 4]) {
        for (first, (x, on)) in first.iter_mut().zip(self.x.iter().zip(&self.on)) {
            first[0] += x.count_ones();
            first[ON_VOXELS] += on.count_ones();
        }
        first[0][1] += self.y[0].count_ones();
        first[2][1] += self.y[1].count_ones();
        first[0][2] += self.z[0].count_ones();
        first[1][2] += self.z[1].count_ones();
    }
}

/// The number of a vertex: `first`, and one more for each before it in the row.
#[inline(always)]
fn number(first: u32, vertices: u64, before: u64) -> u32 {
    first + (vertices & before).count_ones()
}
