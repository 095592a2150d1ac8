//! The cell: how its corners, edges and faces are numbered, and the trilinear interpolant of its values.
//!
//! Corner `c` is the upper one in x, y, z where its bits 0, 1, 2 are set. Edge `4 * axis + u + 2 * v` runs along `axis`; `u` and
//! `v` are 1 where it lies at the upper end of the two other axes, in increasing order. Face `2 * axis + side` is the lower
//! (0) or upper (1) one across `axis`.

/// The corners of each face, counterclockwise seen from outside the cell.
pub(super) const FACES: [[u8; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];

/// Whether a value counts as inside: zero lies infinitesimally above the surface.
pub(super) fn is_inside(value: f64) -> bool {
    value >= 0.0
}

/// One bit a corner, set where it is inside.
pub(super) fn signs(values: &[f64; 8]) -> u8 {
    (0..8).fold(0, |signs, c| signs | u8::from(is_inside(values[c])) << c)
}

/// The edge between two corners that differ in one axis.
pub(super) fn edge_between(a: u8, b: u8) -> u8 {
    let axis = (a ^ b).trailing_zeros() as u8;
    let lower = a & b;
    let below = lower & ((1 << axis) - 1);
    let above = lower >> (axis + 1);
    4 * axis + (below | above << axis)
}

/// The lower and the upper corner of an edge.
pub(super) fn edge_corners(edge: u8) -> [u8; 2] {
    let (axis, place) = (edge / 4, edge % 4);
    let below = place & ((1 << axis) - 1);
    let above = place >> axis;
    let lower = below | above << (axis + 1);
    [lower, lower | 1 << axis]
}

/// Whether two edges lie on a common face, so that a chord between their vertices would lie in it.
pub(super) fn share_a_face(a: u8, b: u8) -> bool {
    faces_of(a) & faces_of(b) != 0
}

/// One bit for each of the two faces that meet in an edge.
fn faces_of(edge: u8) -> u8 {
    let lower = edge_corners(edge)[0];
    let sides = (0..3).filter(|&axis| axis != edge / 4);
    sides.fold(0, |faces, axis| faces | 1 << (2 * axis + (lower >> axis & 1)))
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
pub(super) fn sample(values: &[f64; 8], at: [f64; 3]) -> (f64, [f64; 3]) {
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
