//! How the corners, edges and faces of a cell are numbered (LC87 figure 4, by axes).
//!
//! Corner `c` is the upper one on axis `a` where bit `a` of `c` is set. Edge `4 * axis + u + 2 * v` runs along `axis`; `u` and `v`
//! are 1 where it lies at the upper end of the two other axes, in increasing order. Face `2 * axis + side` is the lower (0) or
//! upper (1) one across `axis`.

/// The corners of each face, counterclockwise seen from outside the cell.
pub(super) const FACES: [[u8; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];

/// The edges of each face: the one from each corner of [`FACES`] to the next.
pub(super) const FACE_EDGES: [[u8; 4]; 6] = [
    [8, 6, 10, 4],
    [5, 11, 7, 9],
    [0, 9, 2, 8],
    [10, 3, 11, 1],
    [4, 1, 5, 0],
    [2, 7, 3, 6],
];

/// The edge between two corners that differ in one axis.
pub(super) const fn edge_between(a: u8, b: u8) -> u8 {
    let axis = (a ^ b).trailing_zeros() as u8;
    let lower = a & b;
    let below = lower & ((1 << axis) - 1);
    let above = lower >> (axis + 1);
    4 * axis + (below | above << axis)
}

/// The lower and the upper corner of an edge.
pub(super) const fn edge_corners(edge: u8) -> [u8; 2] {
    let (axis, place) = (edge / 4, edge % 4);
    let below = place & ((1 << axis) - 1);
    let above = place >> axis;
    let lower = below | above << (axis + 1);
    [lower, lower | 1 << axis]
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
}
