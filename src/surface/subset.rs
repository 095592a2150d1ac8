//! Some of a mesh's triangles, with what belongs to them.

use super::mesh::{Mesh, Part};
use super::sound;

/// The triangles of `mesh` whose numbers `keep` admits, if they are triangles ([`sound::corners`]), in their order.
pub(super) fn select(mesh: &Mesh, keep: impl Fn(usize) -> bool) -> Mesh {
    let kept: Vec<usize> = (0..mesh.triangles.len())
        .filter(|n| keep(*n) && sound::corners(mesh, *n).is_some())
        .collect();
    let before = |n: usize| kept.partition_point(|k| *k < n);
    let parts = mesh.parts.iter().map(|part| Part {
        triangles: before(part.triangles.start)..before(part.triangles.end),
        ..part.clone()
    });
    let triangles = kept.iter().map(|n| mesh.triangles[*n]).collect();
    with_triangles(mesh, triangles, parts.collect())
}

/// `mesh` with other triangles of its vertices; those that no triangle has are left out, the others keep their order.
pub(super) fn with_triangles(mesh: &Mesh, mut triangles: Vec<[u32; 3]>, parts: Vec<Part>) -> Mesh {
    let mut number = vec![0_u32; mesh.positions.len()];
    for v in triangles.iter().flatten() {
        number[*v as usize] = 1;
    }
    let used: Vec<usize> = (0..number.len()).filter(|v| number[*v] == 1).collect();
    for (n, v) in used.iter().enumerate() {
        number[*v] = n as u32;
    }
    for triangle in &mut triangles {
        *triangle = triangle.map(|v| number[v as usize]);
    }
    Mesh {
        positions: of(&mesh.positions, &used).into(),
        normals: of(&mesh.normals, &used).into(),
        values: of(&mesh.values, &used),
        colors: of(&mesh.colors, &used),
        triangles: triangles.into(),
        parts,
    }
}

/// An attribute of the vertices `used`; none of an attribute that is not there.
fn of<T: Copy>(attribute: &[T], used: &[usize]) -> Vec<T> {
    used.iter().filter_map(|v| attribute.get(*v).copied()).collect()
}
