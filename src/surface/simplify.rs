//! Fewer triangles for nearly the same surface.
//!
//! *Theory.* Edges are collapsed one after another, that with the smallest error first; a vertex's error is the mean squared
//! distance from the planes of the triangles that were merged into it (Garland and Heckbert, *Surface simplification using
//! quadric error metrics*, SIGGRAPH 1997).
//! *Practice.* The work is meshoptimizer's. An edge is collapsed to one of its ends, so the vertices that stay are the mesh's
//! own, with all that belongs to them. Parts are simplified one by one and borders stay as they are, so that what fitted
//! together before still does.

use meshopt::{SimplifyOptions, VertexDataAdapter};

use super::mesh::{Mesh, Part};
use super::subset;

/// When [`simplify`] is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SimplifyGoal {
    /// With no more triangles than this, if borders and topology allow it.
    Triangles(usize),
    /// When the next collapse would have an error of more than this, millimetres.
    ErrorMm(f32),
}

/// A mesh of fewer triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct Simplified {
    /// The mesh.
    pub mesh: Mesh,
    /// The largest error of a collapse, millimetres: a root mean square over merged triangles, of which single points can be
    /// some times as far from the new surface.
    pub error_mm: f32,
}

/// Merges triangles of `mesh` until `goal` is met. Edges of one triangle stay, and so do vertices between parts; each part gives
/// in proportion to its triangles. Triangles that have a vertex twice, one that is not finite or one that is not there go.
pub fn simplify(mesh: &Mesh, goal: SimplifyGoal) -> Simplified {
    let mesh = subset::select(mesh, |_| true);
    let parts = match mesh.parts.is_empty() {
        true => vec![whole(&mesh)],
        false => mesh.parts.clone(),
    };
    let is_locked = between_parts(&mesh, &parts);
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    let mut simplified: Vec<Part> = Vec::new();
    let mut error_mm = 0.0_f32;
    for part in parts {
        let first = triangles.len();
        let (found, error) = simplify_part(&mesh, &part, &is_locked, goal);
        triangles.extend(found);
        error_mm = error_mm.max(error);
        simplified.push(Part {
            triangles: first..triangles.len(),
            ..part
        });
    }
    // A mesh without parts has none after.
    simplified.truncate(mesh.parts.len());
    Simplified {
        mesh: subset::with_triangles(&mesh, triangles, simplified),
        error_mm,
    }
}

fn whole(mesh: &Mesh) -> Part {
    Part {
        label: 0,
        iso: None,
        triangles: 0..mesh.triangles.len(),
    }
}

/// For each vertex whether triangles of more than one part have it.
fn between_parts(mesh: &Mesh, parts: &[Part]) -> Vec<bool> {
    let mut owner = vec![None; mesh.positions.len()];
    let mut is_shared = vec![false; mesh.positions.len()];
    for (n, part) in parts.iter().enumerate() {
        for v in triangles_of(mesh, part).as_flattened() {
            let v = *v as usize;
            is_shared[v] |= owner[v].is_some_and(|other| other != n);
            owner[v] = Some(n);
        }
    }
    is_shared
}

fn triangles_of<'a>(mesh: &'a Mesh, part: &Part) -> &'a [[u32; 3]] {
    mesh.triangles.get(part.triangles.clone()).unwrap_or_default()
}

/// A part's triangles after simplification, and the largest error.
fn simplify_part(mesh: &Mesh, part: &Part, is_locked: &[bool], goal: SimplifyGoal) -> (Vec<[u32; 3]>, f32) {
    let triangles = triangles_of(mesh, part);
    let positions = VertexDataAdapter::new(bytemuck::cast_slice(&mesh.positions), size_of::<[f32; 3]>(), 0);
    let Some(positions) = positions.ok().filter(|_| !triangles.is_empty()) else {
        return (Vec::new(), 0.0);
    };
    let (target, error_limit) = match goal {
        SimplifyGoal::Triangles(n) => (share(n, triangles.len(), mesh.triangles.len()), f32::MAX),
        // The larger of NaN and 0 is 0.
        SimplifyGoal::ErrorMm(limit) => (0, limit.max(0.0)),
    };
    let mut error = 0.0;
    let options = SimplifyOptions::LockBorder | SimplifyOptions::ErrorAbsolute | SimplifyOptions::Sparse;
    let found = meshopt::simplify_with_locks(
        triangles.as_flattened(),
        &positions,
        is_locked,
        3 * target,
        error_limit,
        options,
        Some(&mut error),
    );
    (found.as_chunks::<3>().0.to_vec(), error)
}

/// The part of `target` that `part` is of `all`, rounded down; no more than `part`.
fn share(target: usize, part: usize, all: usize) -> usize {
    let share = target as u128 * part as u128 / all as u128;
    share.min(part as u128) as usize
}
