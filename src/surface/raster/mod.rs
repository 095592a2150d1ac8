//! Opaque meshes drawn on the processor: what is nearest at each pixel's centre.
//!
//! *Theory.* In homogeneous coordinates of the frame each corner's weight is a linear function of the pixel, under perspective
//! too (Olano and Greer, Triangle scan conversion using 2D homogeneous coordinates, Graphics Hardware 1997). So nothing is clipped:
//! a point before the nearest depth that is drawn has a depth of its own, and is left out by that.
//! *Practice.* All is in double precision. A weight counts as not negative down to what rounding may make of 0, so every centre
//! within a triangle shows it: triangles that share an edge meet without gap, and where both show, the nearer one does. Parts of
//! a triangle beyond its edges are held to its edges, so no point is seen that is not the triangle's. Where a triangle is seen
//! from the side, as exactly as rounding lets one tell, it is not there. What is nearest is the same in any order: the less depth,
//! then the earlier triangle. Triangles go to the tiles that they may cover, tiles are the work of one thread each, and a pixel
//! is lit once, when it is known what it shows.

mod bins;
mod outline;
mod tile;

use rayon::prelude::*;

use self::bins::Bins;
use self::tile::{TILE, Tile};
use super::facet::Facet;
use super::{Mesh, MeshLook, SurfaceView};
use crate::image::{Frame, Rgba};
use crate::math::Aabb;
use crate::projection::raycast::require_size;
use crate::projection::{Camera, ProjectError, Settings};

/// What some meshes look like.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// What is nearest at each pixel, alpha 1; transparent where nothing is.
    pub frame: Frame,
    /// Its depth, millimetres, top row first; infinite where nothing is.
    pub depths_mm: Vec<f32>,
}

/// Draws `meshes`. Triangles with a vertex that is nowhere (not there, NaN or infinite) are left out.
///
/// # Errors
/// If the frame's size is impossible.
pub fn draw(view: &SurfaceView, meshes: &[(&Mesh, MeshLook)]) -> Result<Drawn, ProjectError> {
    require_size(view.camera.size)?;
    let [width, height] = view.camera.size;
    let bins = Bins::new(view, meshes);
    let mut drawn = Drawn {
        frame: Frame::transparent(width, height),
        depths_mm: vec![f32::INFINITY; width as usize * height as usize],
    };
    let band = TILE as usize * width as usize;
    let pixels = drawn.frame.pixels_mut().par_chunks_mut(band);
    let bands = pixels.zip(drawn.depths_mm.par_chunks_mut(band)).enumerate();
    bands.for_each(|(row, (pixels, depths_mm))| {
        let tiles = (0..width.div_ceil(TILE)).into_par_iter();
        let shaded: Vec<Vec<Seen>> = tiles
            .map(|column| shade(view, meshes, &Tile::new(view, meshes, &bins, [column, row as u32])))
            .collect();
        for (column, tile) in shaded.iter().enumerate() {
            put(tile, column * TILE as usize, width as usize, pixels, depths_mm);
        }
    });
    Ok(drawn)
}

/// Draws `meshes` alone: premultiplied, without background. The depth cue spans them.
///
/// # Errors
/// As [`draw`].
pub fn draw_alone(camera: &Camera, settings: &Settings, meshes: &[(&Mesh, MeshLook)]) -> Result<Frame, ProjectError> {
    let all = meshes.iter();
    let bounds = all.fold(Aabb::EMPTY, |all, (mesh, _)| all.hull(&bins::bounds(mesh)));
    Ok(draw(&SurfaceView::alone(camera, settings, &bounds), meshes)?.frame)
}

/// What a pixel of a tile shows.
type Seen = Option<(Rgba, f32)>;

/// The pixels of `tile`, lit.
fn shade(view: &SurfaceView, meshes: &[(&Mesh, MeshLook)], tile: &Tile) -> Vec<Seen> {
    let mut last = None;
    tile.pixels()
        .map(|nearest| {
            let nearest = nearest?;
            let facet = match last.take() {
                Some((owner, facet)) if owner == nearest.owner => facet,
                _ => {
                    let (mesh, look) = &meshes[nearest.owner.mesh as usize];
                    Facet::new(view, mesh, look, nearest.owner.triangle as usize)
                }
            };
            let [r, g, b] = facet
                .color(view, nearest.weights, nearest.depth_mm)
                .as_vec3()
                .to_array();
            last = Some((nearest.owner, facet));
            Some(([r, g, b, 1.0], nearest.depth_mm as f32))
        })
        .collect()
}

/// Puts a tile whose first column is `left` into a band of the frame, `width` pixels wide.
fn put(tile: &[Seen], left: usize, width: usize, pixels: &mut [Rgba], depths_mm: &mut [f32]) {
    let rows = pixels.chunks_exact_mut(width).zip(depths_mm.chunks_exact_mut(width));
    for ((pixels, depths_mm), tile) in rows.zip(tile.chunks_exact(TILE as usize)) {
        for (n, seen) in tile.iter().enumerate().take(width - left) {
            if let Some((color, depth_mm)) = *seen {
                pixels[left + n] = color;
                depths_mm[left + n] = depth_mm;
            }
        }
    }
}
