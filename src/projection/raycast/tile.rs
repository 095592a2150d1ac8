//! A tile of the frame, cast box by box.

use std::ops::Range;

use super::blend::{Pixels, hides, under};
use super::boxes::CastBox;
use super::bundle::{RAYS, SAMPLES, STEPS};
use super::classify::{Bundle, Classifier};
use super::rays::{Rays, TILE, TILE_PIXELS, TileRays};
use super::sample::Places;
use super::voxels::CastTarget;
use crate::projection::composite::Blending;

/// Planes that a box is cast by at a time, all pixels of a tile: what they read stays in a processor's cache.
const SLAB: i32 = 32;

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

    /// Goes on with those points of the rays of `pixel` and its neighbours that are in a box of `block`.
    #[inline(always)]
    fn march(&mut self, scene: &Scene, block: usize, pixel: usize, points: &Points) {
        const STEP: i32 = STEPS as i32;
        let block = &scene.target.blocks[block];
        let paths = std::array::from_fn(|r| self.paths[pixel + r]);
        let mut pixels: Pixels = std::array::from_fn(|r| self.pixels[pixel + r]);
        let (first, last) = points.planes();
        let mut plane = first - first % STEP;
        while plane < last {
            let inside = points.inside(plane);
            let bundle = Bundle {
                block,
                places: Places::new(block, &self.rays, pixel, plane, &inside),
                inside,
                plane,
                paths,
            };
            if let Some(sources) = scene.classifier.sources(&bundle, &pixels) {
                under(scene.blending, &mut pixels, &sources);
                if pixels.iter().all(|pixel| hides(scene.blending, pixel)) {
                    break;
                }
            }
            plane += STEP;
        }
        for (r, blended) in pixels.into_iter().enumerate() {
            self.pixels[pixel + r] = blended;
            if hides(scene.blending, &blended) {
                self.ends[pixel + r] = 0;
            }
        }
    }
}

/// The covered sampling points of the rays of a bundle.
struct Points {
    begin: [i32; RAYS],
    end: [i32; RAYS],
}

impl Points {
    /// The first plane of any, and the first one behind all.
    #[inline(always)]
    fn planes(&self) -> (i32, i32) {
        let (mut first, mut last) = (i32::MAX, 0);
        for r in 0..RAYS {
            if self.begin[r] < self.end[r] {
                first = first.min(self.begin[r]);
                last = last.max(self.end[r]);
            }
        }
        (first, last)
    }

    /// Which samples of the bundle that begins at `plane` they are.
    #[inline(always)]
    fn inside(&self, plane: i32) -> [bool; SAMPLES] {
        let mut inside = [false; SAMPLES];
        for s in 0..STEPS {
            for r in 0..RAYS {
                let plane = plane + s as i32;
                inside[s * RAYS + r] = self.begin[r] <= plane && plane < self.end[r];
            }
        }
        inside
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
        if columns.is_empty() || rows.is_empty() {
            continue;
        }
        let covered = Covered::new(tile, cast_box, columns, rows);
        let mut slab = covered.planes.start - covered.planes.start % SLAB;
        while slab < covered.planes.end {
            for pixel in covered.bundles() {
                let points = Points {
                    begin: std::array::from_fn(|r| covered.begin[pixel + r].max(slab)),
                    end: std::array::from_fn(|r| covered.end[pixel + r].min(tile.ends[pixel + r]).min(slab + SLAB)),
                };
                tile.march(scene, cast_box.block, pixel, &points);
            }
            slab += SLAB;
        }
    }
}

/// The covered sampling points of a tile's pixels in one box.
struct Covered {
    columns: Range<usize>,
    rows: Range<usize>,
    begin: [i32; TILE_PIXELS],
    end: [i32; TILE_PIXELS],
    /// All of them.
    planes: Range<i32>,
}

impl Covered {
    #[inline(always)]
    fn new(tile: &Tile, cast_box: &CastBox, columns: Range<usize>, rows: Range<usize>) -> Self {
        let (mut begin, mut end) = ([0; TILE_PIXELS], [0; TILE_PIXELS]);
        let (mut nearest, mut farthest) = (i32::MAX, 0);
        for row in rows.clone() {
            let intervals = cast_box.template.row(&tile.rays, row);
            for column in columns.clone() {
                let pixel = row * TILE + column;
                let range = [intervals.begin[column], intervals.end[column].min(tile.ends[pixel])];
                [begin[pixel], end[pixel]] = range;
                if range[0] < range[1] {
                    nearest = nearest.min(range[0]);
                    farthest = farthest.max(range[1]);
                }
            }
        }
        Self {
            columns,
            rows,
            begin,
            end,
            planes: nearest..farthest,
        }
    }

    /// The first pixel of each bundle.
    #[inline(always)]
    fn bundles(&self) -> impl Iterator<Item = usize> + use<> {
        let columns = self.columns.start / RAYS * RAYS..self.columns.end;
        let pixels = move |row: usize| columns.clone().step_by(RAYS).map(move |column| row * TILE + column);
        self.rows.clone().flat_map(pixels)
    }
}
