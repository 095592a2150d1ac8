//! Which of a mesh's triangles are triangles.

use glam::{DVec3, Vec3};

use super::mesh::Mesh;

/// The corners of triangle `n` (below `triangles.len()`), millimetres; `None` if it has a vertex twice, one that is not finite,
/// as beside a voxel of NaN, or one that is not there.
pub(super) fn corners(mesh: &Mesh, n: usize) -> Option<[DVec3; 3]> {
    let [a, b, c] = mesh.triangles[n];
    let is_triangle = a != b && b != c && c != a;
    let place = |v: u32| mesh.positions.get(v as usize).map(|p| Vec3::from(*p).as_dvec3());
    let corners = [place(a)?, place(b)?, place(c)?];
    (is_triangle && corners.iter().all(|p| p.is_finite())).then_some(corners)
}

/// Twice the triangle's area, along its normal.
pub(super) fn double_area([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}
