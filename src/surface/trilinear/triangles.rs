//! What a cell's triangulation is handed over in, without allocation.

/// Most triangles in a cell: a tube has one for each of at most twelve edges and six at each end; discs have less.
const MAX_TRIANGLES: usize = 24;
/// Most vertices inside a cell: a tube's six, and one for a disc.
const MAX_INTERIOR: usize = 7;

/// The triangles of one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellTriangles {
    triangles: [[u8; 3]; MAX_TRIANGLES],
    triangle_count: u8,
    interior: [[f64; 3]; MAX_INTERIOR],
    interior_count: u8,
}

impl CellTriangles {
    pub(super) const EMPTY: Self = Self {
        triangles: [[0; 3]; MAX_TRIANGLES],
        triangle_count: 0,
        interior: [[0.0; 3]; MAX_INTERIOR],
        interior_count: 0,
    };

    /// Three vertices a triangle, counterclockwise seen from lower values: `n` below 12 is the vertex on edge `n` of the cell, and
    /// `12 + k` is `interior()[k]`.
    pub fn triangles(&self) -> &[[u8; 3]] {
        &self.triangles[..self.triangle_count as usize]
    }

    /// Where the vertices inside the cell are, 0 to 1 along each axis.
    pub fn interior(&self) -> &[[f64; 3]] {
        &self.interior[..self.interior_count as usize]
    }

    pub(super) fn add(&mut self, triangle: [u8; 3]) {
        self.triangles[self.triangle_count as usize] = triangle;
        self.triangle_count += 1;
    }

    /// Adds a vertex inside the cell; returns its number in triangles.
    pub(super) fn add_vertex(&mut self, at: [f64; 3]) -> u8 {
        self.interior[self.interior_count as usize] = at;
        self.interior_count += 1;
        11 + self.interior_count
    }
}
