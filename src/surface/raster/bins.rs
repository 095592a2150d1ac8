//! Which triangles each tile of the frame may show.
//!
//! *Practice.* Triangles are taken in chunks, all threads at once. A chunk sorts its triangles by tile, each into up to four; those
//! that reach over more are few, and every tile looks at them. So a chunk's memory is bounded, whatever it holds.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::outline::reach;
use super::tile::TILE;
use crate::math::Aabb;
use crate::surface::facet::places;
use crate::surface::{Mesh, MeshLook, SurfaceView};

/// Triangles that are sorted together.
const CHUNK: usize = 1 << 14;

/// The most tiles that a triangle is sorted into.
const FEW_TILES: usize = 4;

/// A triangle and the pixels that may show it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Entry {
    /// Its number in its mesh.
    pub triangle: u32,
    columns: [u16; 2],
    rows: [u16; 2],
}

/// The triangles of some meshes that may be seen.
pub(super) struct Bins {
    chunks: Vec<Chunk>,
    /// Tiles in a row.
    columns: u32,
}

/// Some triangles of one mesh.
struct Chunk {
    mesh: u32,
    /// Where the triangles of each tile begin, and where the last ones end.
    starts: Vec<u32>,
    sorted: Vec<Entry>,
    /// Those of no tile.
    wide: Vec<Entry>,
}

impl Entry {
    fn new(triangle: u32, [columns, rows]: [Range<u16>; 2]) -> Self {
        Self {
            triangle,
            columns: [columns.start, columns.end],
            rows: [rows.start, rows.end],
        }
    }

    /// Its pixels in a part of the frame: columns and rows.
    pub fn within(&self, part: &[Range<u32>; 2]) -> [Range<u32>; 2] {
        let [columns, rows] = [self.columns, self.rows].map(|range| range.map(u32::from));
        [
            columns[0].max(part[0].start)..columns[1].min(part[0].end),
            rows[0].max(part[1].start)..rows[1].min(part[1].end),
        ]
    }

    /// The columns and rows of its tiles.
    fn tiles(&self) -> [Range<u32>; 2] {
        [self.columns, self.rows].map(|[first, end]| u32::from(first) / TILE..u32::from(end).div_ceil(TILE))
    }
}

impl Bins {
    /// Of all `meshes`.
    pub fn new(view: &SurfaceView, meshes: &[(&Mesh, MeshLook)]) -> Self {
        let [columns, rows] = view.camera.size.map(|size| size.div_ceil(TILE));
        let chunks: Vec<(u32, Range<usize>)> = (0..)
            .zip(meshes)
            .flat_map(|(n, (mesh, _))| chunks(mesh.triangles.len()).map(move |range| (n, range)))
            .collect();
        let chunks = chunks.into_par_iter().map(|(n, triangles)| {
            let (mesh, _) = meshes[n as usize];
            Chunk::new(n, entries(view, mesh, triangles), [columns, rows])
        });
        Self {
            chunks: chunks.collect(),
            columns,
        }
    }

    /// The triangles, each with the number of its mesh, that may be seen in the tile of this column and row.
    pub fn of(&self, [column, row]: [u32; 2]) -> impl Iterator<Item = (u32, &Entry)> {
        let tile = (row * self.columns + column) as usize;
        self.chunks.iter().flat_map(move |chunk| {
            let sorted = &chunk.sorted[chunk.starts[tile] as usize..chunk.starts[tile + 1] as usize];
            sorted.iter().chain(&chunk.wide).map(|entry| (chunk.mesh, entry))
        })
    }
}

impl Chunk {
    fn new(mesh: u32, entries: Vec<Entry>, [columns, rows]: [u32; 2]) -> Self {
        let (few, wide): (Vec<Entry>, Vec<Entry>) = entries
            .into_iter()
            .partition(|entry| entry.tiles().map(|range| range.len()).iter().product::<usize>() <= FEW_TILES);
        let tiles = move |entry: &Entry| {
            let [across, down] = entry.tiles();
            down.flat_map(move |row| across.clone().map(move |column| (row * columns + column) as usize))
        };
        let mut starts = vec![0; (columns * rows) as usize + 1];
        few.iter().flat_map(tiles).for_each(|tile| starts[tile + 1] += 1);
        for tile in 1..starts.len() {
            starts[tile] += starts[tile - 1];
        }
        let mut next = starts.clone();
        let mut sorted = vec![Entry::default(); starts[starts.len() - 1] as usize];
        for entry in &few {
            for tile in tiles(entry) {
                sorted[next[tile] as usize] = *entry;
                next[tile] += 1;
            }
        }
        Self {
            mesh,
            starts,
            sorted,
            wide,
        }
    }
}

fn chunks(triangles: usize) -> impl Iterator<Item = Range<usize>> {
    (0..triangles)
        .step_by(CHUNK)
        .map(move |first| first..triangles.min(first + CHUNK))
}

/// Those of some triangles that may be seen.
fn entries(view: &SurfaceView, mesh: &Mesh, triangles: Range<usize>) -> Vec<Entry> {
    let entry = |n: usize| {
        let reach = reach(view.camera, &places(view, mesh, n))?;
        Some(Entry::new(n as u32, reach))
    };
    triangles.filter(|&n| is_somewhere(mesh, n)).filter_map(entry).collect()
}

/// Whether all corners of triangle `n` are there, and finite.
fn is_somewhere(mesh: &Mesh, n: usize) -> bool {
    let corner = |v: u32| mesh.positions.get(v as usize);
    let is_finite = |v: u32| corner(v).is_some_and(|place| place.iter().all(|c| c.is_finite()));
    mesh.triangles[n].into_iter().all(is_finite)
}

/// The world box of the triangles of `mesh` that are somewhere.
pub(super) fn bounds(mesh: &Mesh) -> Aabb {
    let triangles = 0..mesh.triangles.len();
    let corners = triangles
        .filter(|&n| is_somewhere(mesh, n))
        .flat_map(|n| mesh.corners(n));
    Aabb::of_points(corners.map(|corner| DVec3::from_array(corner.map(f64::from))))
}
