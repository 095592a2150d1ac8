//! Marching cubes that is topologically correct.

mod cell;
mod contour;
mod disc;
mod section;
mod tube;

use std::sync::LazyLock;

use contour::Contours;
use tube::Tube;

/// Most triangles in a cell: a tube's three for each vertex of its contours... 
const MAX_TRIANGLES: usize = 24;
/// Most vertices inside a cell: a tube's six and a disc's.
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
    const EMPTY: Self = Self {
        triangles: [[0; 3]; MAX_TRIANGLES],
        triangle_count: 0,
        interior: [[0.0; 3]; MAX_INTERIOR],
        interior_count: 0,
    };

    /// Three vertices a triangle: below 12 the one on that edge of the cell, from 12 on those of [`interior`](Self::interior).
    pub fn triangles(&self) -> &[[u8; 3]] {
        &self.triangles[..self.triangle_count as usize]
    }

    /// The vertices inside the cell, in the unit cell.
    pub fn interior(&self) -> &[[f64; 3]] {
        &self.interior[..self.interior_count as usize]
    }

    fn add(&mut self, triangle: [u8; 3]) {
        self.triangles[self.triangle_count as usize] = triangle;
        self.triangle_count += 1;
    }

    /// Adds a vertex inside the cell; returns its number among the cell's.
    fn add_vertex(&mut self, at: [f64; 3]) -> u8 {
        self.interior[self.interior_count as usize] = at;
        self.interior_count += 1;
        11 + self.interior_count
    }
}

/// The level set of the trilinear interpolant of eight corner values, at zero.
pub fn triangulate(values: &[f64; 8]) -> CellTriangles {
    match PLAIN[cell::signs(values) as usize] {
        Some(plain) => plain,
        None => resolve(values),
    }
}

static PLAIN: LazyLock<[Option<CellTriangles>; 256]> = LazyLock::new(|| std::array::from_fn(plain));

/// The triangles of all cells with these signs, if the signs alone decide.
fn plain(signs: usize) -> Option<CellTriangles> {
    let values = std::array::from_fn(|c| if signs >> c & 1 == 1 { 1.0 } else { -1.0 });
    let ambiguous = cell::FACES
        .iter()
        .any(|face| contour::alternate(face.map(|c| signs >> c & 1 == 1)));
    let single = Contours::trace(&values).firsts().len() <= 1;
    (!ambiguous && single).then(|| resolve(&values))
}

fn resolve(values: &[f64; 8]) -> CellTriangles {
    let mut out = CellTriangles::EMPTY;
    let contours = Contours::trace(values);
    let tube = if contours.firsts().len() > 1 { Tube::find(values, &contours) } else { None };
    if let Some(tube) = &tube {
        tube.triangulate(&contours, &mut out);
    }
    for &first in contours.firsts() {
        if tube.as_ref().is_none_or(|tube| !tube.bounds(contours.label[first as usize])) {
            let mut order = [0; 12];
            let mut n = 0;
            for edge in contours.walk(first) {
                order[n] = edge;
                n += 1;
            }
            disc::triangulate(values, &order[..n], &mut out);
        }
    }
    out
}
