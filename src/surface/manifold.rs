//! Rows of cells in the topology of the trilinear interpolant: what [`cells`](super::cells) does by cases, by values.
//!
//! *Practice.* Vertices on edges are numbered as there. A cell may have others within it, numbered row after row; so each
//! cell with a surface is triangulated twice, to count and to write.

use glam::{DVec2, DVec3};

use super::cells::SetBits;
use super::crossings::Crossings;
use super::numbering::{Numbering, OwnVertices};
use super::slices::Slices;
use super::trilinear::triangulate;
use super::vertices::{Level, VertexSink};
use crate::volume::Voxel;

/// The cells between slices `k` and `k + 1`.
pub(super) struct Layer<'a, T> {
    pub slices: Slices<'a, T>,
    pub k: usize,
    /// Those with a surface, row after row, one bit each.
    pub active: &'a [u64],
}

impl<T: Voxel> Layer<'_, T> {
    /// How many vertices there are within the cells, and how many triangles.
    pub fn count(&self, iso: f64) -> [u64; 2] {
        let [mut vertices, mut triangles] = [0; 2];
        for n in 0..self.active.len() {
            for (_, cell) in self.cells(n) {
                let surface = triangulate(&values(self.slices, cell, iso));
                vertices += surface.interior().len() as u64;
                triangles += surface.triangles().len() as u64;
            }
        }
        [vertices, triangles]
    }

    /// Writes the triangles, and the vertices within the cells.
    pub fn connect(
        &self,
        crossings: [&Crossings; 2],
        level: &Level,
        sink: &mut VertexSink<'_>,
        triangles: &mut [[u32; 3]],
    ) {
        let mut places = triangles.iter_mut();
        let words = self.words_a_row();
        for j in 0..self.slices.dims[1] - 1 {
            let mut numbering = Numbering::new(crossings, j);
            for w in 0..words {
                let own = OwnVertices::of(crossings, j, w);
                for (i, cell) in self.cells(j * words + w) {
                    let values = values(self.slices, cell, level.iso());
                    let surface = triangulate(&values);
                    let on_edges = numbering.next_cell(&own, i);
                    let within = sink.first + sink.written as u32;
                    let vertex = |v: u8| match on_edges.get(usize::from(v)) {
                        Some(vertex) => *vertex,
                        None => within + u32::from(v - 12),
                    };
                    for (corners, place) in surface.triangles().iter().zip(places.by_ref()) {
                        *place = corners.map(vertex);
                    }
                    for place in surface.interior() {
                        push(sink, level, cell, &values, DVec3::from_array(*place));
                    }
                }
            }
        }
    }

    fn words_a_row(&self) -> usize {
        self.slices.dims[0].div_ceil(64)
    }

    /// The cells with a surface in word `n`: by place in the word, and in the lattice.
    fn cells(&self, n: usize) -> impl Iterator<Item = (u32, [usize; 3])> {
        let (j, w) = (n / self.words_a_row(), n % self.words_a_row());
        let k = self.k;
        SetBits(self.active[n]).map(move |i| (i, [w * 64 + i as usize, j, k]))
    }
}

/// The values at a cell's corners, less the isovalue.
fn values<T: Voxel>(slices: Slices<'_, T>, [i, j, k]: [usize; 3], iso: f64) -> [f64; 8] {
    std::array::from_fn(|c| slices.value([i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)]) - iso)
}

/// Adds the vertex at `place` within a cell; its normal is the interpolant's.
fn push(sink: &mut VertexSink<'_>, level: &Level, cell: [usize; 3], values: &[f64; 8], place: DVec3) {
    let index = DVec3::from_array(level.index(cell)) + place;
    sink.positions[sink.written] = level.position(index.as_vec3().to_array());
    sink.normals[sink.written] = level.normal(gradient(values, place));
    sink.written += 1;
}

/// The gradient of the trilinear interpolant at a place of the unit cell.
fn gradient(values: &[f64; 8], p: DVec3) -> DVec3 {
    let along = |axis: usize| {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let at = DVec2::new(p[u], p[v]);
        let difference = |a: usize, b: usize| {
            let lower = a << u | b << v;
            values[lower | 1 << axis] - values[lower]
        };
        let edge = |b: usize| difference(0, b) + at.x * (difference(1, b) - difference(0, b));
        edge(0) + at.y * (edge(1) - edge(0))
    };
    DVec3::new(along(0), along(1), along(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gradient_is_that_of_a_trilinear_function() {
        let f = |x: f64, y: f64, z: f64| 1.0 + 2.0 * x - 3.0 * y + 0.5 * z + x * y - 4.0 * y * z + 7.0 * x * y * z;
        let values = std::array::from_fn(|c| f((c & 1) as f64, (c >> 1 & 1) as f64, (c >> 2) as f64));
        let (x, y, z) = (0.25, 0.5, 0.75);
        let expected = DVec3::new(
            2.0 + y + 7.0 * y * z,
            -3.0 + x - 4.0 * z + 7.0 * x * z,
            0.5 - 4.0 * y + 7.0 * x * y,
        );
        // All numbers are sums of few powers of two: exact.
        assert_eq!(gradient(&values, DVec3::new(x, y, z)), expected);
    }
}
