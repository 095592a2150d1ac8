//! Whether a surface is closed: along each edge as many triangles run one way as the other.
//!
//! An edge has two triangles, or more where pieces touch along it.

use super::error::MeshError;
use super::read::TriangleMesh;

/// # Errors
/// If the surface ends somewhere, or neighbours face different sides.
pub fn check(mesh: &TriangleMesh) -> Result<(), MeshError> {
    let mut sides: Vec<([u32; 2], i64)> = mesh
        .triangles
        .iter()
        .flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]].map(run))
        .collect();
    sides.sort_unstable();
    let (mut open, mut turned) = (Vec::new(), Vec::new());
    for runs in sides.chunk_by(|one, other| one.0 == other.0) {
        let surplus: i64 = runs.iter().map(|(_, way)| way).sum();
        match surplus {
            0 => {}
            _ if runs.len() % 2 == 1 => open.push(runs[0].0),
            _ => turned.push(runs[0].0),
        }
    }
    let middle = |edge: &[u32; 2]| edge.map(|v| mesh.positions[v as usize]).iter().sum::<glam::DVec3>() / 2.0;
    if let Some(first) = open.first() {
        return Err(MeshError::Open {
            edges: open.len(),
            at: middle(first),
        });
    }
    turned.first().map_or(Ok(()), |first| {
        Err(MeshError::Orientation {
            edges: turned.len(),
            at: middle(first),
        })
    })
}

/// An edge by its vertices in their order, and which way it is run.
fn run([from, to]: [u32; 2]) -> ([u32; 2], i64) {
    if from < to { ([from, to], 1) } else { ([to, from], -1) }
}
