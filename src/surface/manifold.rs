//! Rows of cells in the topology of the trilinear interpolant: what [`cells`](super::cells) does by cases, by values.
//!
//! *Practice.* Vertices on edges are numbered as there. A cell may have others within it, numbered row after row; so each
//! cell with a surface is triangulated twice, to count and to write.

use glam::{DVec2, DVec3};

use super::cells::{IN_CELLS, Numbering, RowCount, RowPlan, RowsRound, SetBits};
use super::inside::InsideRows;
use super::slices::Slices;
use super::trilinear::triangulate;
use super::vertices::{Level, VertexSink};
use crate::volume::Voxel;

/// Counts what each row of slice `k` makes.
pub(super) fn count<T: Voxel>(slices: Slices<'_, T>, rows: &InsideRows, iso: f64, k: usize, counts: &mut [RowCount]) {
    let has_layer = k + 1 < rows.slices.end;
    for (j, count) in counts.iter_mut().enumerate() {
        let round = RowsRound::new(rows, j, k);
        *count = RowCount::default();
        for w in 0..round.words() {
            for axis in 0..3 {
                count.vertices[axis] += round.vertices(w, axis).count_ones();
            }
            if has_layer && j + 1 < rows.dims[1] {
                for i in SetBits(round.active(w)) {
                    let surface = triangulate(&values(slices, [w * 64 + i as usize, j, k], iso));
                    count.vertices[IN_CELLS] += surface.interior().len() as u32;
                    count.triangles += surface.triangles().len() as u32;
                }
            }
        }
    }
}

/// Writes the triangles of the cells between slices `k` and `k + 1`, and the vertices within the cells.
pub(super) fn connect<T: Voxel>(
    slices: Slices<'_, T>,
    rows: &InsideRows,
    level: &Level,
    k: usize,
    plan: [&[RowPlan]; 2],
    sink: &mut VertexSink<'_>,
    triangles: &mut [[u32; 3]],
) {
    let mut places = triangles.iter_mut();
    let [lower, upper] = plan;
    for j in (0..rows.dims[1] - 1).filter(|j| lower[*j].triangles) {
        let round = RowsRound::new(rows, j, k);
        let mut first = [lower[j].first, lower[j + 1].first, upper[j].first, upper[j + 1].first];
        for w in 0..round.words() {
            let numbering = Numbering::new(&round, w);
            for i in SetBits(round.active(w)) {
                let cell = [w * 64 + i as usize, j, k];
                let values = values(slices, cell, level.iso());
                let surface = triangulate(&values);
                let on_edges = numbering.on_edges(&first, i);
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
            numbering.step_over(&mut first);
        }
    }
}

/// The values at a cell's corners, less the isovalue.
fn values<T: Voxel>(slices: Slices<'_, T>, [i, j, k]: [usize; 3], iso: f64) -> [f64; 8] {
    std::array::from_fn(|c| slices.value([i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)]) - iso)
}

/// Adds the vertex at `place` within a cell; its normal is the interpolant's.
fn push(sink: &mut VertexSink<'_>, level: &Level, cell: [usize; 3], values: &[f64; 8], place: DVec3) {
    let index = DVec3::from_array(cell.map(|n| n as f64)) + place;
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
