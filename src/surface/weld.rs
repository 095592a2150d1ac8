//! Vertices that fall together are one.
//!
//! *Theory.* Where a voxel has the isovalue itself, or so nearly that the vertex rounds to it, the vertices on all its crossed
//! edges lie on the voxel. vtkMarchingCubes merges points of equal coordinates as they come, and drops triangles of which two
//! corners became one.
//! *Practice.* Extraction notes each vertex that falls on a voxel; here those of one voxel are put together, the first of them
//! stays, and all later numbers close up. Without any nothing is done.

use rayon::prelude::*;

use super::mesh::Mesh;
use super::vertices::Hit;

/// Merges the vertices of `mesh` that `hits` says are on the same voxel.
pub(super) fn weld(mesh: &mut Mesh, mut hits: Vec<Hit>) {
    hits.par_sort_unstable();
    let merged: Vec<(u32, u32)> = hits
        .chunk_by(|a, b| a.voxel == b.voxel)
        .flat_map(|same| same[1..].iter().map(|hit| (hit.vertex, same[0].vertex)))
        .collect();
    drop(hits);
    if merged.is_empty() {
        return;
    }
    let number = new_numbers(mesh.positions.len(), &merged);
    let stays = stays(mesh.positions.len(), &merged);
    keep(&mut mesh.positions, &stays);
    keep(&mut mesh.normals, &stays);
    mesh.triangles.par_iter_mut().for_each(|t| *t = t.map(|v| number[v as usize]));
    mesh.triangles.retain(|[a, b, c]| a != b && b != c && c != a);
}

/// Which vertices are not merged into another.
fn stays(vertices: usize, merged: &[(u32, u32)]) -> Vec<bool> {
    let mut stays = vec![true; vertices];
    for (gone, _) in merged {
        stays[*gone as usize] = false;
    }
    stays
}

/// The number that each vertex has when those that are merged have closed up.
fn new_numbers(vertices: usize, merged: &[(u32, u32)]) -> Vec<u32> {
    let mut numbers: Vec<u32> = vec![0; vertices];
    for (gone, _) in merged {
        numbers[*gone as usize] = 1;
    }
    let mut gone_before = 0;
    for (n, number) in numbers.iter_mut().enumerate() {
        let gone = *number;
        *number = n as u32 - gone_before;
        gone_before += gone;
    }
    for (gone, into) in merged {
        numbers[*gone as usize] = numbers[*into as usize];
    }
    numbers
}

fn keep<T>(values: &mut Vec<T>, stays: &[bool]) {
    let mut stays = stays.iter();
    values.retain(|_| stays.next().is_some_and(|s| *s));
}
