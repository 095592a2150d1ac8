//! Whether closed triangles enclose something, and from which side.

use glam::DVec3;
use rayon::prelude::*;

use super::TriangleSolid;
use super::error::MeshError;
use super::face::{self, Face};
use super::read::TriangleMesh;
use crate::math::Aabb;

/// The triangles with their planes.
pub fn faces(mesh: &TriangleMesh) -> Result<Vec<Face>, MeshError> {
    let face = |triangle: &[u32; 3]| {
        let corners = triangle.map(|corner| mesh.positions[corner as usize]);
        let at = corners.iter().sum::<DVec3>() / 3.0;
        Face::new(corners).ok_or(MeshError::NoArea { at })
    };
    mesh.triangles.iter().map(face).collect()
}

/// The faces of a closed surface, turned if they enclose a negative volume.
pub fn outwards(faces: Vec<Face>) -> Result<Vec<Face>, MeshError> {
    let bounds = faces.iter().fold(Aabb::EMPTY, |all, face| all.hull(&face.bounds()));
    let middle = bounds.center();
    let (mut volume, mut sizes) = (0.0, 0.0);
    for face in &faces {
        let [a, b, c] = face.corners.map(|corner| corner - middle);
        volume += a.dot(b.cross(c));
        sizes += a.length() * b.length() * c.length();
    }
    // The sum of n terms, each of a few roundings itself.
    let rounding = (faces.len() + 16) as f64 * f64::EPSILON * sizes;
    if volume.abs() <= rounding {
        return Err(MeshError::NoVolume);
    }
    if volume > 0.0 {
        return Ok(faces);
    }
    let turned = |face: Face| {
        let [a, b, c] = face.corners;
        Face::new([a, c, b])
    };
    Ok(faces.into_iter().filter_map(turned).collect())
}

/// Whether the surface winds once round what lies behind each face and not at all round what lies before it.
///
/// # Errors
/// If a piece is inside out, or is one more skin round another.
pub fn sides(solid: &TriangleSolid) -> Result<(), MeshError> {
    let wrong = |n: usize| {
        let middle = solid.faces[n].middle();
        // Before the face is ahead of it where the ray leaves by it, and behind it where the ray enters by it.
        let before = match solid.faces[n].crossing(middle) {
            1 => others(solid, n, middle),
            -1 => others(solid, n, middle) - 1,
            _ => 0,
        };
        (before != 0).then_some(MeshError::Sides { at: middle })
    };
    let found = (0..solid.faces.len()).into_par_iter().find_map_first(wrong);
    found.map_or(Ok(()), Err)
}

/// The crossings of the ray from `p` with all faces but the `own`.
fn others(solid: &TriangleSolid, own: usize, p: DVec3) -> i32 {
    let mut winding = 0;
    let meets = |bounds: &Aabb| face::ray_meets(p, bounds);
    solid.hierarchy.visit(meets, |n| {
        if n != own {
            winding += solid.faces[n].crossing_ahead(p);
        }
    });
    winding
}
