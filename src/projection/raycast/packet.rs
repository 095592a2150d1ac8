//! The rays of a square of pixels, cast through a box.

use std::ops::Range;

use super::blend::{self, Colours};
use super::boxes::CastBox;
use super::classify::Bundle;
use super::rays::{Intervals, PacketRays};
use super::sample::{Places, Start};
use super::simd::Simd;
use super::tile::{Scene, pixel};
use super::voxels::CastBlock;

/// Planes in a row at which nothing shows, from which on it is asked how far that goes: to ask costs about as much.
const MISSES: u32 = 3;

/// The rays of a square of pixels, those beyond the frame too.
pub struct Packet<S: Simd> {
    /// What has been blended so far.
    pub pixels: Colours<S>,
    /// Its first pixel.
    first: [u32; 2],
    /// Millimetres of each ray a millimetre of depth, if not all are 1.
    paths: Option<S::Float>,
    /// The first plane of each pixel that is not sampled any more.
    ends: S::Int,
    /// The covered sampling points of the box that is being cast.
    covered: Intervals<S>,
}

impl<S: Simd> Packet<S> {
    /// The packet whose first pixel is `first`.
    #[inline(always)]
    pub fn new(scene: &Scene, first: [u32; 2]) -> Self {
        let nowhere = S::int(0);
        Self {
            pixels: [S::float(0.0); 4],
            first,
            paths: paths::<S>(scene, first),
            ends: match scene.stops {
                Some(stops) => S::ints(std::array::from_fn(|n| stops(pixel(first, n)))),
                None => S::int(scene.rays.planes),
            },
            covered: Intervals {
                begin: nowhere,
                end: nowhere,
            },
        }
    }

    /// Turns to a box.
    #[inline(always)]
    pub fn enter(&mut self, scene: &Scene, cast_box: &CastBox) {
        let bounds = &cast_box.shown.bounds;
        let Intervals { begin, end } =
            PacketRays::<S>::new(&scene.rays, self.first).intervals(&bounds.min.to_array(), &bounds.max.to_array());
        let end = S::choose_int(S::greater_int(end, self.ends), self.ends, end);
        self.covered = Intervals { begin, end };
    }

    /// Goes on with those points in the box that are at `planes`, until none at a plane shows; the next plane to go on with.
    #[inline(always)]
    pub fn march(&mut self, scene: &Scene, block: &CastBlock, planes: Range<i32>) -> i32 {
        let mut start: Option<Start<S>> = None;
        let mut misses = 0;
        for plane in planes.clone() {
            let before = S::greater_int(self.covered.end, S::int(plane));
            if S::bits(before) == 0 {
                return i32::MAX;
            }
            let inside = before & !S::greater_int(self.covered.begin, S::int(plane));
            let start = match &start {
                Some(start) if start.reaches(plane) => start,
                _ => start.insert(Start::new(block, &PacketRays::new(&scene.rays, self.first), plane)),
            };
            misses = if self.sample(scene, block, start, plane, inside) {
                0
            } else {
                misses + 1
            };
            if misses == MISSES {
                return plane + 1;
            }
        }
        planes.end
    }

    /// Goes on with the points at a plane, those `inside` the box; whether any shows.
    #[inline(always)]
    fn sample(&mut self, scene: &Scene, block: &CastBlock, start: &Start<S>, plane: i32, inside: S::Mask) -> bool {
        let hidden = blend::hidden::<S>(scene.blending, &self.pixels);
        let bundle = Bundle {
            block,
            places: Places::new(block, start, plane, inside, &scene.rays.lowest),
            inside,
            hidden,
            plane,
            paths: self.paths,
        };
        let Some(sources) = scene.classifier.sources(&bundle) else {
            return false;
        };
        blend::under::<S>(scene.blending, hidden, &mut self.pixels, &sources);
        let hidden = blend::hidden::<S>(scene.blending, &self.pixels);
        self.ends = S::choose_int(hidden, S::int(0), self.ends);
        self.covered.end = S::choose_int(hidden, S::int(0), self.covered.end);
        true
    }
}

/// See [`Scene::paths`].
#[inline(always)]
fn paths<S: Simd>(scene: &Scene, first: [u32; 2]) -> Option<S::Float> {
    let paths = scene.paths?;
    Some(S::floats(std::array::from_fn(|n| paths(pixel(first, n)))))
}
