//! Vertices that lie at one place are one: a format like STL has none that triangles share.

use std::collections::HashMap;

use glam::DVec3;

use super::error::MeshError;
use super::read::TriangleMesh;

/// The largest coordinate: squares of areas stay below the largest number.
pub const LIMIT: f64 = 1e75;

/// The most triangles; a hierarchy counts them in 32 bits.
pub const MAX_TRIANGLES: usize = 1 << 26;

/// The mesh with one vertex a place, without those that no triangle has, and without triangles that have a vertex twice.
pub fn welded(mesh: &TriangleMesh) -> Result<TriangleMesh, MeshError> {
    check(mesh)?;
    let mut known: HashMap<[u64; 3], u32> = HashMap::with_capacity(mesh.positions.len());
    let mut welded = TriangleMesh::default();
    for triangle in &mesh.triangles {
        let corners = triangle.map(|corner| {
            // Without the sign of zeros.
            let position = mesh.positions[corner as usize] + 0.0;
            *known
                .entry(position.to_array().map(f64::to_bits))
                .or_insert_with(|| push(&mut welded.positions, position))
        });
        let [a, b, c] = corners;
        if a != b && b != c && c != a {
            welded.triangles.push(corners);
        }
    }
    if welded.triangles.is_empty() {
        return Err(MeshError::Empty);
    }
    Ok(welded)
}

fn push(positions: &mut Vec<DVec3>, position: DVec3) -> u32 {
    positions.push(position);
    positions.len() as u32 - 1
}

fn check(mesh: &TriangleMesh) -> Result<(), MeshError> {
    let (vertices, found) = (mesh.positions.len(), mesh.triangles.len());
    if found > MAX_TRIANGLES {
        return Err(MeshError::TooMany {
            found,
            limit: MAX_TRIANGLES,
        });
    }
    let is_bad = |p: &DVec3| !p.abs().cmple(DVec3::splat(LIMIT)).all();
    if let Some(vertex) = mesh.positions.iter().position(is_bad) {
        return Err(MeshError::NotFinite { vertex, limit: LIMIT });
    }
    let is_outside = |corner: &u32| *corner as usize >= vertices;
    let bad = |(triangle, corners): (usize, &[u32; 3])| {
        let vertex = *corners.iter().find(|corner| is_outside(corner))?;
        Some(MeshError::Index {
            triangle,
            vertex,
            vertices,
        })
    };
    mesh.triangles.iter().enumerate().find_map(bad).map_or(Ok(()), Err)
}
