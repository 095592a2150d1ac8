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

/// A vertex that goes, and the one in its place.
#[derive(Clone, Copy)]
struct Merged {
    gone: u32,
    into: u32,
}

/// Merges the vertices of `mesh` that `hits` says are on the same voxel. There is a list for each slice, of `voxels_a_slice`,
/// whose hits are in that slice or the next.
pub(super) fn weld(mesh: &mut Mesh, hits: &[Vec<Hit>], voxels_a_slice: usize) {
    let merged: Vec<Merged> = (0..hits.len())
        .into_par_iter()
        .flat_map_iter(|k| merged_in_slice(hits, k, voxels_a_slice as u64))
        .collect();
    if merged.is_empty() {
        return;
    }
    let mut gone = vec![false; mesh.positions.len()];
    for vertex in &merged {
        gone[vertex.gone as usize] = true;
    }
    let number = new_numbers(&gone, &merged);
    retain(&mut mesh.positions, |n, _| !gone[n]);
    retain(&mut mesh.normals, |n, _| !gone[n]);
    mesh.triangles.par_iter_mut().for_each(|t| *t = t.map(|v| number[v as usize]));
    retain(&mut mesh.triangles, |_, [a, b, c]| a != b && b != c && c != a);
}

/// The vertices that are merged at the voxels of slice `k`.
fn merged_in_slice(hits: &[Vec<Hit>], k: usize, voxels_a_slice: u64) -> Vec<Merged> {
    let voxels = k as u64 * voxels_a_slice..(k as u64 + 1) * voxels_a_slice;
    let lists = hits[k.saturating_sub(1)..=k].iter().flatten();
    let mut here: Vec<Hit> = lists.filter(|hit| voxels.contains(&hit.voxel)).copied().collect();
    here.sort_unstable();
    here.chunk_by(|a, b| a.voxel == b.voxel)
        .flat_map(|same| {
            same[1..].iter().map(|hit| Merged {
                gone: hit.vertex,
                into: same[0].vertex,
            })
        })
        .collect()
}

/// The number that each vertex has when those that go have made room.
fn new_numbers(gone: &[bool], merged: &[Merged]) -> Vec<u32> {
    let mut stayed = 0;
    let mut numbers: Vec<u32> = Vec::with_capacity(gone.len());
    numbers.extend(gone.iter().map(|gone| {
        let number = stayed;
        stayed += u32::from(!gone);
        number
    }));
    for vertex in merged {
        numbers[vertex.gone as usize] = numbers[vertex.into as usize];
    }
    numbers
}

/// Values that are looked at together.
const CHUNK: usize = 1 << 14;

/// `Vec::retain` by place and value: chunks are closed up in parallel, and then moved together.
fn retain<T: Copy + Send>(values: &mut Vec<T>, stays: impl Fn(usize, &T) -> bool + Sync) {
    let kept: Vec<usize> = values
        .par_chunks_mut(CHUNK)
        .enumerate()
        .map(|(c, chunk)| {
            let mut kept = 0;
            for n in 0..chunk.len() {
                let value = chunk[n];
                chunk[kept] = value;
                kept += usize::from(stays(c * CHUNK + n, &value));
            }
            kept
        })
        .collect();
    let mut end = 0;
    for (c, kept) in kept.into_iter().enumerate() {
        values.copy_within(c * CHUNK..c * CHUNK + kept, end);
        end += kept;
    }
    values.truncate(end);
}
