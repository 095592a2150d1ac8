//! The rays of a square of pixels, cast through a box.

use std::ops::Range;

use super::blend::{self, Colours};
use super::boxes::CastBox;
use super::classify::Bundle;
use super::gaps::Gaps;
use super::rays::{Intervals, PacketRays};
use super::sample::{Places, Start};
use super::simd::{Mask, RAYS, Simd, each};
use super::tile::{Scene, pixel};
use super::voxels::CastBlock;

/// How far around a packet's places is asked whether anything shows, for their rounding, voxels.
pub const MARGIN: f32 = 0.01;

/// The rays of a square of pixels, those beyond the frame too.
pub struct Packet<S: Simd> {
    /// What has been blended so far.
    pub pixels: Colours<S>,
    rays: PacketRays<S>,
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
            rays: PacketRays::new(&scene.rays, first),
            paths: match scene.paths {
                Some(paths) => Some(S::floats(std::array::from_fn(|n| paths(pixel(first, n))))),
                None => None,
            },
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

    /// Turns to a box; the planes at which any ray is in it.
    #[inline(always)]
    pub fn enter(&mut self, cast_box: &CastBox) -> Range<i32> {
        let bounds = &cast_box.shown.bounds;
        let Intervals { begin, end } = self.rays.intervals(&bounds.min.to_array(), &bounds.max.to_array());
        let end = S::choose_int(S::greater_int(end, self.ends), self.ends, end);
        self.covered = Intervals { begin, end };
        self.planes()
    }

    /// The planes at which any ray is in the box.
    #[inline(always)]
    fn planes(&self) -> Range<i32> {
        let Intervals { begin, end } = self.covered;
        let covers = S::greater_int(end, begin);
        let first = S::least(S::choose_int(covers, begin, S::int(i32::MAX)));
        first..S::greatest(S::choose_int(covers, end, S::int(0)))
    }

    /// Goes on with those points in the box that are at `planes`.
    #[inline(always)]
    pub fn march(&mut self, scene: &Scene, cast_box: &CastBox, planes: Range<i32>) {
        let own = self.planes();
        let (mut plane, last) = (own.start.max(planes.start), own.end.min(planes.end));
        if plane >= last {
            return;
        }
        let block = &scene.target.blocks[cast_box.block];
        let reach = Reach::new(&self.rays, block, &scene.lowest, planes.start);
        let mut start: Option<Start<S>> = None;
        while plane < last {
            if let Some(planes) = reach.free_planes(&cast_box.shown.gaps, plane) {
                plane = plane.saturating_add(planes);
                continue;
            }
            let inside = S::greater_int(self.covered.end, S::int(plane)) & !S::greater_int(self.covered.begin, S::int(plane));
            if inside == 0 && S::greater_int(self.covered.end, S::int(plane)) == 0 {
                break;
            }
            let start = match &start {
                Some(start) if start.reaches(plane) => start,
                _ => start.insert(Start::new(block, &self.rays, plane)),
            };
            self.sample(scene, block, start, plane, inside);
            plane += 1;
        }
    }

    /// Goes on with the points at a plane, those `inside` the box.
    #[inline(always)]
    fn sample(&mut self, scene: &Scene, block: &CastBlock, start: &Start<S>, plane: i32, inside: Mask) {
        let hidden = blend::hidden::<S>(scene.blending, &self.pixels);
        let bundle = Bundle {
            block,
            places: Places::new(block, start, plane, inside, &scene.lowest),
            inside,
            hidden,
            plane,
            paths: self.paths,
        };
        let Some(sources) = scene.classifier.sources(&bundle) else {
            return;
        };
        blend::under::<S>(scene.blending, hidden, &mut self.pixels, &sources);
        let hidden = blend::hidden::<S>(scene.blending, &self.pixels);
        self.ends = S::choose_int(hidden, S::int(0), self.ends);
        self.covered.end = S::choose_int(hidden, S::int(0), self.covered.end);
    }
}

/// The lowest and the highest place of a packet along each axis, in stored voxels, as they go on from a plane.
struct Reach {
    plane: i32,
    low: [[f32; 2]; 3],
    high: [[f32; 2]; 3],
    /// Planes for a voxel of the way along the fastest axis.
    planes_per_voxel: f32,
}

impl Reach {
    /// From `plane` on, where ray `lowest` of each axis has the lowest place along it.
    #[inline(always)]
    fn new<S: Simd>(rays: &PacketRays<S>, block: &CastBlock, lowest: &[usize; 3], plane: i32) -> Self {
        let origin = each!(axis of [0, 1, 2] => S::double_array(rays.origin[axis]));
        let step = each!(axis of [0, 1, 2] => S::double_array(rays.step[axis]));
        let of = |axis: usize, ray: usize| {
            let step = step[axis][ray];
            let at = origin[axis][ray] + f64::from(plane) * step - f64::from(block.first[axis]);
            [at as f32, step as f32]
        };
        let low = [0, 1, 2].map(|axis| of(axis, lowest[axis]));
        let high = [0, 1, 2].map(|axis| of(axis, RAYS - 1 - lowest[axis]));
        let fastest = low.iter().chain(&high).fold(f32::MIN_POSITIVE, |most, [_, step]| most.max(step.abs()));
        Self {
            plane,
            low,
            high,
            planes_per_voxel: 1.0 / fastest,
        }
    }

    /// From `plane` on, at how many planes nothing shows; `None` if something may at once.
    #[inline(always)]
    fn free_planes(&self, gaps: &Gaps, plane: i32) -> Option<i32> {
        let planes = (plane - self.plane) as f32;
        let at = |[from, step]: [f32; 2], by: f32| from + planes * step + by;
        let free = gaps.free(self.low.map(|low| at(low, -MARGIN)), self.high.map(|high| at(high, MARGIN)))?;
        Some(1 + (free * self.planes_per_voxel) as i32)
    }
}
