//! Frames of several passes, each of one sample a pixel.
//!
//! *Practice.* A pass is traced in tiles side by side, and a pixel's samples are added up in the order of passes: a frame is the same bits on
//! any number of threads. A frame can be looked at after any pass.

use rayon::prelude::*;

use super::ray::Ray;
use super::sampling::Stream;
use super::tracer::{Bounds, Tracer};
use super::world::World;
use crate::image::Frame;
use crate::projection::{Camera, ProjectError};

/// The longest side of a frame, pixels.
const LONGEST_SIDE: u32 = 1 << 15;

/// Edge of a tile, pixels.
const TILE: u32 = 16;

/// What a frame is traced with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// Samples of each pixel; the first is in its middle.
    pub samples: u32,
    /// What random numbers depend on.
    pub seed: u64,
    /// How far rays are followed.
    pub bounds: Bounds,
}

impl Sampling {
    /// The most samples.
    pub const MAX_SAMPLES: u32 = 1 << 16;
}

impl Default for Sampling {
    fn default() -> Self {
        Self {
            samples: 1,
            seed: 0,
            bounds: Bounds::default(),
        }
    }
}

/// A frame that gets better with each pass.
pub struct Progressive<'a> {
    world: &'a World,
    camera: &'a Camera,
    sampling: Sampling,
    sums: Vec<[f64; 4]>,
    passes: u32,
}

impl<'a> Progressive<'a> {
    /// Nothing traced yet of a frame of `camera`.
    ///
    /// # Errors
    /// If the frame's size is impossible.
    pub fn new(world: &'a World, camera: &'a Camera, sampling: Sampling) -> Result<Self, ProjectError> {
        let [width, height] = camera.size;
        if [width, height].iter().any(|side| !(1..=LONGEST_SIDE).contains(side)) {
            let limit = LONGEST_SIDE;
            return Err(ProjectError::FrameSize { width, height, limit });
        }
        Ok(Self {
            world,
            camera,
            sampling,
            sums: vec![[0.0; 4]; width as usize * height as usize],
            passes: 0,
        })
    }

    /// Traces one more sample of each pixel, and tells `done` of pixels as they are traced.
    pub fn pass(&mut self, done: &(dyn Fn(u64) + Sync)) {
        let [width, height] = self.camera.size;
        let columns = width.div_ceil(TILE);
        let tiles = (0..columns * height.div_ceil(TILE)).into_par_iter();
        let traced: Vec<Tile> = tiles
            .map(|n| {
                let tile = self.tile([n % columns * TILE, n / columns * TILE]);
                done(tile.lights.len() as u64);
                tile
            })
            .collect();
        for tile in traced {
            let rows = tile.lights.chunks_exact(tile.width as usize);
            for (y, row) in rows.enumerate() {
                let first = (tile.first[1] as usize + y) * width as usize + tile.first[0] as usize;
                for (sum, light) in self.sums[first..].iter_mut().zip(row) {
                    *sum = [0, 1, 2, 3].map(|c| sum[c] + light[c]);
                }
            }
        }
        self.passes += 1;
    }

    /// The mean of the passes so far.
    pub fn frame(&self) -> Frame {
        let [width, height] = self.camera.size;
        let mut frame = Frame::transparent(width, height);
        let part = 1.0 / f64::from(self.passes.max(1));
        for (pixel, sum) in frame.pixels_mut().iter_mut().zip(&self.sums) {
            *pixel = sum.map(|c| (c * part) as f32);
        }
        frame
    }

    fn tile(&self, first: [u32; 2]) -> Tile {
        let [width, height] = [0, 1].map(|axis| TILE.min(self.camera.size[axis] - first[axis]));
        let nearest_mm = self.world.nearest_mm(self.camera);
        let pixel = |n: u32| self.sample([first[0] + n % width, first[1] + n / width], nearest_mm);
        Tile {
            first,
            width,
            lights: (0..width * height).map(pixel).collect(),
        }
    }

    /// This pass's sample of a pixel.
    fn sample(&self, pixel: [u32; 2], nearest_mm: f64) -> [f64; 4] {
        let mut stream = Stream::new(self.sampling.seed, pixel, self.passes);
        let within = stream.in_pixel();
        let at = [0, 1].map(|axis| f64::from(pixel[axis]) + within[axis]);
        let ray = Ray::of_pixel(self.camera, at, nearest_mm);
        let mut tracer = Tracer {
            world: self.world,
            bounds: self.sampling.bounds,
            phase: stream.in_pixel()[0],
            stream,
        };
        tracer.primary(&ray)
    }
}

/// A part of a pass.
struct Tile {
    first: [u32; 2],
    width: u32,
    lights: Vec<[f64; 4]>,
}

/// The frame of `camera` after all of its passes; `done` is told of each sample of a pixel as it is traced.
///
/// # Errors
/// If the frame's size is impossible.
pub fn draw(
    world: &World,
    camera: &Camera,
    sampling: Sampling,
    done: &(dyn Fn(u64) + Sync),
) -> Result<Frame, ProjectError> {
    let mut progressive = Progressive::new(world, camera, sampling)?;
    for _ in 0..sampling.samples.max(1) {
        progressive.pass(done);
    }
    Ok(progressive.frame())
}
