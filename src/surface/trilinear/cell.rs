//! The cell: how its corners, edges and faces are numbered, and the trilinear interpolant of its values.
//!
//! Corner `c` is the upper one in x, y, z where its bits 0, 1, 2 are set. Edge `4 * axis + u + 2 * v` runs along `axis`; `u` and
//! `v` are 1 where it lies at the upper end of the two other axes, in increasing order. Face `2 * axis + side` is the lower
//! (0) or upper (1) one across `axis`.

/// The corners of each face, counterclockwise seen from outside the cell.
pub(in crate::surface) const FACES: [[u8; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];

/// The edges of each face: the one from each corner of [`FACES`] to the next.
pub(in crate::surface) const FACE_EDGES: [[u8; 4]; 6] = [
    [8, 6, 10, 4],
    [5, 11, 7, 9],
    [0, 9, 2, 8],
    [10, 3, 11, 1],
    [4, 1, 5, 0],
    [2, 7, 3, 6],
];

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

/// The edge between two corners that differ in one axis.
pub(in crate::surface) fn edge_between(a: u8, b: u8) -> u8 {
    let axis = (a ^ b).trailing_zeros() as u8;
    let lower = a & b;
    let below = lower & ((1 << axis) - 1);
    let above = lower >> (axis + 1);
    4 * axis + (below | above << axis)
}

/// The lower and the upper corner of an edge.
pub(in crate::surface) fn edge_corners(edge: u8) -> [u8; 2] {
    let (axis, place) = (edge / 4, edge % 4);
    let below = place & ((1 << axis) - 1);
    let above = place >> axis;
    let lower = below | above << (axis + 1);
    [lower, lower | 1 << axis]
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
    fn faces_and_edges_are_numbered_as_documented() {
        for (face, (corners, edges)) in FACES.iter().zip(FACE_EDGES).enumerate() {
            let (axis, side) = (face / 2, face as u8 % 2);
            assert!(corners.iter().all(|c| c >> axis & 1 == side), "face {face}");
            for k in 0..4 {
                let [a, b] = [corners[k], corners[(k + 1) % 4]];
                assert_eq!(edges[k], edge_between(a, b), "face {face}");
                assert_eq!(edge_corners(edges[k]), [a.min(b), a.max(b)], "face {face}");
            }
        }
        assert_eq!(edge_between(1, 3), 4 + 1);
        assert_eq!(edge_between(4, 5), 2);
        assert_eq!(edge_between(2, 6), 8 + 2);
    }

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
