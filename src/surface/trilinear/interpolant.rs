//! The trilinear interpolant of a cell's values.

use crate::surface::cell::{FACE_EDGES, edge_corners};

/// One bit for each of the two faces that meet in each edge.
const FACES_OF_EDGE: [u8; 12] = {
    let mut faces = [0; 12];
    let mut k = 0;
    while k < 24 {
        faces[FACE_EDGES[k / 4][k % 4] as usize] |= 1 << (k / 4);
        k += 1;
    }
    faces
};

/// Whether a value counts as inside: zero lies infinitesimally above the surface.
pub(super) fn is_inside(value: f64) -> bool {
    value >= 0.0
}

/// One bit a corner, set where it is inside.
pub(super) fn signs(values: &[f64; 8]) -> u8 {
    (0..8).fold(0, |signs, c| signs | u8::from(is_inside(values[c])) << c)
}

/// Whether two edges lie on a common face, so that a chord between their vertices would lie in it.
pub(super) fn share_a_face(a: u8, b: u8) -> bool {
    FACES_OF_EDGE[a as usize] & FACES_OF_EDGE[b as usize] != 0
}

/// Where the interpolant is zero on an edge whose ends differ in sign, in the unit cell.
pub(super) fn crossing(values: &[f64; 8], edge: u8) -> [f64; 3] {
    let [lower, upper] = edge_corners(edge);
    let (a, b) = (values[lower as usize], values[upper as usize]);
    let mut at = [0, 1, 2].map(|axis| f64::from(lower >> axis & 1));
    at[edge as usize / 4] = a / (a - b);
    at
}

/// The interpolant and its gradient at a point of the unit cell.
pub(in crate::surface) fn sample(values: &[f64; 8], at: [f64; 3]) -> (f64, [f64; 3]) {
    let mut value = 0.0;
    let mut gradient = [0.0; 3];
    for (corner, &v) in values.iter().enumerate() {
        let upper = |axis: usize| corner >> axis & 1 == 1;
        let weight = [0, 1, 2].map(|axis| if upper(axis) { at[axis] } else { 1.0 - at[axis] });
        let slope = [0, 1, 2].map(|axis| if upper(axis) { v } else { -v });
        value += v * weight[0] * weight[1] * weight[2];
        for axis in 0..3 {
            gradient[axis] += slope[axis] * weight[(axis + 1) % 3] * weight[(axis + 2) % 3];
        }
    }
    (value, gradient)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gradient_is_the_slope_of_the_interpolant() {
        let values = [3.0, -1.0, 4.0, 1.0, -5.0, 9.0, 2.0, -6.0];
        let at = [0.25, 0.5, 0.75];
        for axis in 0..3 {
            // The interpolant is linear along an axis; all numbers are exact in binary.
            let mut ahead = at;
            ahead[axis] += 0.125;
            let slope = (sample(&values, ahead).0 - sample(&values, at).0) / 0.125;
            assert_eq!(slope, sample(&values, at).1[axis], "axis {axis}");
        }
    }
}
