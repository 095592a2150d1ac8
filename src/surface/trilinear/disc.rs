//! Discs: contours that bound a sheet of their own.

use super::interpolant::{crossing, sample, share_a_face};
use super::triangles::CellTriangles;

/// Steps towards the level set from a contour's centroid; each roughly squares the distance.
const STEPS: usize = 4;

/// Adds the triangles of the disc within a contour, given by its edges in order.
///
/// They fan out from a vertex of the contour if none of the chords lies in a face of the cell, where the neighbour could have the
/// same chord; otherwise from a vertex inside the cell.
pub(super) fn triangulate(values: &[f64; 8], contour: &[u8], out: &mut CellTriangles) {
    let n = contour.len();
    match (0..n).find(|&apex| has_free_chords(contour, apex)) {
        Some(apex) => (1..n - 1).for_each(|k| out.add([0, k, k + 1].map(|step| contour[(apex + step) % n]))),
        None => {
            let center = out.add_vertex(center(values, contour));
            (0..n).for_each(|k| out.add([contour[k], contour[(k + 1) % n], center]));
        }
    }
}

/// Whether no chord from a vertex of the contour lies in a face of the cell.
fn has_free_chords(contour: &[u8], apex: usize) -> bool {
    let n = contour.len();
    (2..n - 1).all(|k| !share_a_face(contour[apex], contour[(apex + k) % n]))
}

/// A point inside the cell, near the level set and amid a contour: from the centroid, Newton's steps along the gradient while they
/// come closer and stay inside.
fn center(values: &[f64; 8], contour: &[u8]) -> [f64; 3] {
    let mut at = centroid(values, contour);
    for _ in 0..STEPS {
        let (value, gradient) = sample(values, at);
        let square: f64 = gradient.iter().map(|g| g * g).sum();
        let next = [0, 1, 2].map(|axis| at[axis] - value * gradient[axis] / square);
        let is_inside = next.iter().all(|&x| 0.0 < x && x < 1.0);
        if !is_inside || sample(values, next).0.abs() >= value.abs() {
            break;
        }
        at = next;
    }
    at
}

fn centroid(values: &[f64; 8], contour: &[u8]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for &edge in contour {
        let at = crossing(values, edge);
        (0..3).for_each(|axis| sum[axis] += at[axis]);
    }
    sum.map(|x| x / contour.len() as f64)
}
