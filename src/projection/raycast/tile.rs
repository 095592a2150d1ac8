//! A tile of the frame, cast box by box.

use super::blend::{hides, under};
use super::boxes::CastBox;
use super::classify::{Classifier, Run};
use super::lanes::LANES;
use super::rays::{Rays, TILE, TILE_PIXELS, TileRays};
use super::sample::Places;
use super::voxels::CastTarget;
use crate::projection::composite::Blending;

/// All that tiles share.
pub struct Scene<'a> {
    pub target: &'a CastTarget,
    pub boxes: &'a [CastBox],
    pub rays: Rays<'a>,
    pub classifier: Classifier,
    pub blending: Blending,
    /// Columns and rows.
    pub size: [u32; 2],
    /// Millimetres of ray a millimetre of depth, of each pixel.
    pub paths: &'a (dyn Fn(u32, u32) -> f32 + Sync),
    /// The first plane of each pixel that a surface hides.
    pub stops: &'a (dyn Fn(u32, u32) -> i32 + Sync),
}

/// The pixels of a tile, row by row, those beyond the frame too.
pub struct Tile {
    /// What has been blended so far.
    pub pixels: [[f32; 4]; TILE_PIXELS],
    rays: TileRays,
    paths: [f32; TILE_PIXELS],
    /// The first plane of each pixel that is not sampled any more.
    ends: [i32; TILE_PIXELS],
}

impl Tile {
    /// The tile whose first pixel is `first`.
    pub fn cast(scene: &Scene, first: [u32; 2]) -> Self {
        let at = |n: usize| [first[0] + (n % TILE) as u32, first[1] + (n / TILE) as u32];
        let mut tile = Self {
            pixels: [[0.0; 4]; TILE_PIXELS],
            rays: TileRays::new(&scene.rays, first),
            paths: std::array::from_fn(|n| (scene.paths)(at(n)[0], at(n)[1])),
            ends: std::array::from_fn(|n| (scene.stops)(at(n)[0], at(n)[1])),
        };
        cast_boxes(&mut tile, scene, first);
        tile
    }

    /// Goes on with the points `begin..end` of a pixel's ray, which are in a box of `block`.
    #[inline(always)]
    fn march(&mut self, scene: &Scene, block: usize, pixel: usize, begin: i32, end: i32) {
        const STEP: i32 = LANES as i32;
        let block = &scene.target.blocks[block];
        let ray = self.rays.ray(pixel);
        let mut plane = begin - begin % STEP;
        while plane < end {
            let (first, last) = ((begin - plane).max(0), (end - plane).min(STEP));
            let run = Run {
                block,
                places: Places::new(block, &ray, plane, first as usize, last as usize),
                plane,
                path: self.paths[pixel],
            };
            if let Some(sources) = scene.classifier.sources(&run) {
                for source in &sources[first as usize..last as usize] {
                    under(scene.blending, &mut self.pixels[pixel], source);
                    if hides(scene.blending, &self.pixels[pixel]) {
                        self.ends[pixel] = 0;
                        return;
                    }
                }
            }
            plane += STEP;
        }
    }
}

#[multiversion::multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn cast_boxes(tile: &mut Tile, scene: &Scene, first: [u32; 2]) {
    for cast_box in scene.boxes {
        let [columns, rows] = [0, 1].map(|axis| {
            let range = &cast_box.pixels[axis];
            let within = |pixel: u32| pixel.saturating_sub(first[axis]).min(TILE as u32) as usize;
            within(range.start)..within(range.end)
        });
        if columns.is_empty() {
            continue;
        }
        for row in rows {
            let intervals = cast_box.template.row(&tile.rays, row);
            for column in columns.clone() {
                let pixel = row * TILE + column;
                let (begin, end) = (intervals.begin[column], intervals.end[column].min(tile.ends[pixel]));
                if begin < end {
                    tile.march(scene, cast_box.block, pixel, begin, end);
                }
            }
        }
    }
}
