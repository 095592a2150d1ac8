//! Vertices that fall together are one.
//!
//! *Theory.* Where a voxel has nearly the isovalue, the vertices on its crossed edges may round to the voxel.
//! vtkMarchingCubes merges points of equal coordinates as they come, and drops triangles of which two corners became one.
//! *Practice.* Voxels of the isovalue itself have one vertex from the start (`inside`), unless the lattice has values that are
//! not finite. Of the others extraction notes each vertex that falls on a voxel. Here those of one voxel are put together:
//! the first of them stays, and the mesh's last vertices move to where the others were. That is rare, so only the triangles
//! of the slices where it happens are looked at.

use std::collections::{BTreeSet, HashMap};
use std::ops::Range;

use rayon::prelude::*;

use super::mesh::Mesh;
use super::vertices::Hit;

/// What [`weld`] knows of how a mesh was made of slices.
pub(super) struct Layout<'a> {
    pub voxels_a_slice: usize,
    /// For each slice and the end: the numbers of vertices and of triangles before it.
    pub before: &'a [[usize; 2]],
}

impl Layout<'_> {
    /// The triangles that may have vertex `v`: those on both sides of its slice.
    fn layers_of(&self, v: usize) -> Range<usize> {
        let slice = self.before.partition_point(|before| before[0] <= v) - 1;
        slice.saturating_sub(1)..slice + 1
    }

    fn triangles_of(&self, layer: usize) -> Range<usize> {
        self.before[layer][1]..self.before[layer + 1][1]
    }
}

/// A vertex that goes, and the one in its place.
#[derive(Clone, Copy)]
pub(super) struct Merged {
    pub gone: u32,
    pub into: u32,
}

/// Merges the vertices of `mesh` that `hits` says are on the same voxel. There is a list for each slice, whose hits are in
/// that slice or the next.
pub(super) fn weld(mesh: &mut Mesh, hits: &[Vec<Hit>], layout: &Layout<'_>) {
    let merged = merged(hits, layout.voxels_a_slice);
    if !merged.is_empty() {
        let renamed = close_up(mesh, &merged);
        rename(mesh, &renamed, layout);
    }
}

/// The vertices of `hits`, a list for each slice, that give way to others on the same voxel.
pub(super) fn merged(hits: &[Vec<Hit>], voxels_a_slice: usize) -> Vec<Merged> {
    (0..hits.len())
        .into_par_iter()
        .flat_map_iter(|k| merged_in_slice(hits, k, voxels_a_slice as u64))
        .collect()
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

/// Fills the places of the vertices that go with the last ones, and returns the new numbers of both.
fn close_up(mesh: &mut Mesh, merged: &[Merged]) -> HashMap<u32, u32> {
    let kept = mesh.positions.len() - merged.len();
    let gone: BTreeSet<u32> = merged.iter().map(|m| m.gone).collect();
    let last = (kept as u32..mesh.positions.len() as u32).filter(|v| !gone.contains(v));
    let mut renamed: HashMap<u32, u32> = HashMap::new();
    for (place, from) in gone.iter().zip(last) {
        let (place, from) = (*place as usize, from as usize);
        mesh.positions[place] = mesh.positions[from];
        mesh.normals[place] = mesh.normals[from];
        if !mesh.values.is_empty() {
            mesh.values[place] = mesh.values[from];
        }
        renamed.insert(from as u32, place as u32);
    }
    mesh.positions.truncate(kept);
    mesh.normals.truncate(kept);
    mesh.values.truncate(kept);
    for m in merged {
        let into = renamed.get(&m.into).copied().unwrap_or(m.into);
        renamed.insert(m.gone, into);
    }
    renamed
}

/// Gives the triangles their vertices' new numbers, and drops those that lose a corner.
fn rename(mesh: &mut Mesh, renamed: &HashMap<u32, u32>, layout: &Layout<'_>) {
    let layers: BTreeSet<usize> = renamed.keys().flat_map(|v| layout.layers_of(*v as usize)).collect();
    let number = |v: u32| renamed.get(&v).copied().unwrap_or(v);
    let is_renamed = Marks::new(renamed.keys().copied());
    let mut dropped = Vec::new();
    for n in layers.into_iter().flat_map(|layer| layout.triangles_of(layer)) {
        let triangle = &mut mesh.triangles[n];
        if triangle.iter().any(|v| is_renamed.has(*v)) {
            *triangle = triangle.map(number);
            let [a, b, c] = *triangle;
            if a == b || b == c || c == a {
                dropped.push(n);
            }
        }
    }
    // From the last on, so that what fills a gap is no gap itself.
    for n in dropped.into_iter().rev() {
        let last = mesh.triangles.len() - 1;
        mesh.triangles.swap(n, last);
        mesh.triangles.truncate(last);
    }
}

/// A quick answer to whether a number may be in a set: one bit for each remainder.
struct Marks(Vec<u64>);

impl Marks {
    const BITS: u32 = 1 << 16;

    fn new(numbers: impl Iterator<Item = u32>) -> Self {
        let mut words = vec![0; (Self::BITS / 64) as usize];
        for n in numbers {
            let bit = n % Self::BITS;
            words[(bit / 64) as usize] |= 1 << (bit % 64);
        }
        Self(words)
    }

    fn has(&self, n: u32) -> bool {
        let bit = n % Self::BITS;
        self.0[(bit / 64) as usize] >> (bit % 64) & 1 == 1
    }
}
