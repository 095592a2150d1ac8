//! Which of a mesh's triangles are triangles.

use std::borrow::Cow;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::mesh::Mesh;

/// The triangles of `mesh` that have [`corners`]: nearly always all of them, which one look at each list tells.
pub(super) fn triangles(mesh: &Mesh) -> Cow<'_, [[u32; 3]]> {
    let is_whole = |t: &[u32; 3]| {
        let [a, b, c] = *t;
        a != b && b != c && c != a && t.iter().all(|v| (*v as usize) < mesh.positions.len())
    };
    if mesh.positions.par_iter().all(is_finite) && mesh.triangles.par_iter().all(is_whole) {
        return Cow::Borrowed(&mesh.triangles);
    }
    let numbers = (0..mesh.triangles.len()).filter(|n| corners(mesh, *n).is_some());
    Cow::Owned(numbers.map(|n| mesh.triangles[n]).collect())
}

/// Whether a vertex at `position` is anywhere.
pub(super) fn is_finite(position: &[f32; 3]) -> bool {
    position.iter().all(|x| x.is_finite())
}

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
