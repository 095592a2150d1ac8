//! A tile of the frame: what is nearest at each of its pixels.

use std::ops::Range;

use glam::DVec2;

use super::bins::Bins;
use super::outline::Outline;
use crate::surface::facet::places;
use crate::surface::{Mesh, MeshLook, SurfaceView};

/// Pixels along a tile's edge.
pub(super) const TILE: u32 = 32;

/// A triangle of one of the meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Owner {
    /// The mesh's number.
    pub mesh: u32,
    /// The triangle's, in it.
    pub triangle: u32,
}

/// What a pixel shows.
#[derive(Clone, Copy)]
pub(super) struct Nearest {
    /// Whose point it is.
    pub owner: Owner,
    /// The parts that its corners have in it.
    pub weights: [f64; 3],
    /// How deep it is.
    pub depth_mm: f64,
}

/// The pixels of a tile.
pub(super) struct Tile {
    /// Row by row, those beyond the frame too.
    nearest: Vec<Option<Nearest>>,
}

impl Tile {
    /// The tile of this column and row of tiles.
    pub fn new(view: &SurfaceView, meshes: &[(&Mesh, MeshLook)], bins: &Bins, at: [u32; 2]) -> Self {
        let mut tile = Self {
            nearest: vec![None; (TILE * TILE) as usize],
        };
        let part = [0, 1].map(|axis| TILE * at[axis]..(TILE * (at[axis] + 1)).min(view.camera.size[axis]));
        for (mesh, entry) in bins.of(at) {
            let pixels = entry.within(&part);
            if pixels.iter().all(|range| !range.is_empty()) {
                let owner = Owner {
                    mesh,
                    triangle: entry.triangle,
                };
                tile.add(view, meshes[mesh as usize].0, owner, &pixels);
            }
        }
        tile
    }

    /// Its pixels, row by row.
    pub fn pixels(&self) -> impl Iterator<Item = Option<Nearest>> {
        self.nearest.iter().copied()
    }

    /// Adds a triangle of `mesh`, as far as some pixels show it.
    fn add(&mut self, view: &SurfaceView, mesh: &Mesh, owner: Owner, [columns, rows]: &[Range<u32>; 2]) {
        let outline = Outline::new(view.camera, &places(view, mesh, owner.triangle as usize));
        let near_mm = view.camera.near_mm();
        let middle = 0.5 * DVec2::from(view.camera.size.map(f64::from));
        for row in rows.clone() {
            for column in columns.clone() {
                let centre = DVec2::new(f64::from(column), f64::from(row)) + 0.5;
                let Some(point) = outline.at(centre - middle) else {
                    continue;
                };
                let there = &mut self.nearest[(row % TILE * TILE + column % TILE) as usize];
                let is_first = there.is_none_or(|there| {
                    point.depth_mm < there.depth_mm || point.depth_mm == there.depth_mm && owner < there.owner
                });
                if point.depth_mm >= near_mm && is_first {
                    *there = Some(Nearest {
                        owner,
                        weights: point.weights,
                        depth_mm: point.depth_mm,
                    });
                }
            }
        }
    }
}
