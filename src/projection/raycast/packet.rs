//! The rays of a square of pixels, cast through a box.

use std::ops::Range;

use super::blend::{self, Colours};
use super::boxes::CastBox;
use super::classify::Samples;
use super::places::Stretch;
use super::rays::{Intervals, PacketRays};
use super::sample::{BlockVectors, Bundle};
use super::simd::{EDGE, Kernel, Simd};
use super::template::{Template, side};
use super::tile::{Scene, pixel};
use super::voxels::CastBlock;

/// The rays of a square of pixels, those beyond the frame too, in `N` vectors.
pub struct Packet<S: Simd, const N: usize> {
    /// What has been blended so far.
    pub pixels: [Colours<S>; N],
    /// Its first pixel.
    first: [u32; 2],
    /// Its low corner at plane 0 along each axis, in lattice coordinates, and the way from plane to plane.
    low: [[f64; 2]; 3],
    /// Millimetres of each ray a millimetre of depth, if not all are 1.
    paths: Option<[S::Float; N]>,
    /// The pixels that do not hide yet what is behind.
    open: [S::Mask; N],
    /// The first plane of each pixel that a surface hides, if there are any.
    stops: Option<[S::Int; N]>,
    /// Planes at which all rays are in the box that is being cast.
    whole: Range<i32>,
    /// The covered sampling points of that box, if they have been asked for.
    covered: Option<[Intervals<S>; N]>,
}

/// The first pixel of vector `n` of the packet of `N` that begins at `first`.
pub fn first_of<const N: usize>([x, y]: [u32; 2], n: usize) -> [u32; 2] {
    [x + (n % side(N) * EDGE) as u32, y + (n / side(N) * EDGE) as u32]
}

impl<S: Simd, const N: usize> Packet<S, N> {
    /// The packet whose first pixel is `first`.
    #[inline(always)]
    pub fn new(scene: &Scene, first: [u32; 2]) -> Self {
        Self {
            pixels: [[S::float(0.0); 4]; N],
            first,
            low: scene.rays.low::<N>(first),
            paths: paths::<S, N>(scene, first),
            open: [!S::none(); N],
            stops: stops::<S, N>(scene, first),
            whole: 0..0,
            covered: None,
        }
    }

    /// Turns to a box that all its rays are in at planes `whole`.
    #[inline(always)]
    pub fn enter(&mut self, whole: Range<i32>) {
        self.whole = whole;
        self.covered = None;
    }

    /// Which points at a plane are in the box, and seen; `None` if none is, nor any behind them.
    #[inline(always)]
    fn inside(&mut self, scene: &Scene, cast_box: &CastBox, plane: i32) -> Option<[S::Mask; N]> {
        let plane_of_each = S::int(plane);
        let (mut inside, mut left) = (self.open, 0);
        if let Some(stops) = &self.stops {
            for n in 0..N {
                inside[n] = inside[n] & S::greater_int(stops[n], plane_of_each);
            }
        }
        if self.whole.contains(&plane) {
            for inside in &inside {
                left |= S::bits(*inside);
            }
        } else {
            let covered = match &self.covered {
                Some(covered) => covered,
                None => self.covered.insert(covered::<S, N>(scene, self.first, cast_box)),
            };
            for n in 0..N {
                let before_end = inside[n] & S::greater_int(covered[n].end, plane_of_each);
                left |= S::bits(before_end);
                inside[n] = before_end & !S::greater_int(covered[n].begin, plane_of_each);
            }
        }
        (left != 0).then_some(inside)
    }
}

/// A packet on its way through a box: those points in it that are at planes of one [stretch](super::places) where something may show.
pub struct March<'a, 'b, S: Simd, const N: usize> {
    pub packet: &'a mut Packet<S, N>,
    pub scene: &'a Scene<'b>,
    pub block: &'a CastBlock,
    pub cast_box: &'a CastBox<'b>,
    pub template: &'a mut Template<S, N>,
    /// The first plane; when it is done, the next one to go on with.
    pub next: &'a mut i32,
    /// The first plane that is not asked for.
    pub end: i32,
}

impl<S: Simd, const N: usize> Kernel<S> for March<'_, '_, S, N> {
    #[inline(always)]
    fn run(self) {
        let mut plane = *self.next;
        let stretch = Stretch::new(&self.packet.low, plane);
        let mut shows = false;
        while plane < self.end {
            let low = stretch.at(plane);
            // Behind what shows, most often something shows.
            if !shows {
                let free = self.cast_box.shown.gaps.free(&low);
                if free > 0 {
                    plane += self.scene.hops[usize::from(free)];
                    continue;
                }
            }
            self.template.turn_to(&self.scene.rays, plane);
            let moved = self.template.moved(self.block, &low);
            // What comes next is on its way while this is worked out.
            let next = self.template.moved(self.block, &stretch.at(plane + 1));
            next.ask_for::<S>(self.block);
            let Some(inside) = self.packet.inside(self.scene, self.cast_box, plane) else {
                plane = i32::MAX;
                break;
            };
            let bundle = Bundle::new(self.block, self.template, moved, plane, inside, &self.packet.paths);
            shows = match self.scene.classifier.samples(&bundle) {
                Some(samples) => {
                    blend(
                        &mut self.packet.pixels,
                        &mut self.packet.open,
                        self.scene,
                        &bundle,
                        &samples,
                    );
                    true
                }
                None => false,
            };
            plane += 1;
        }
        *self.next = plane;
    }
}

/// Goes on with the samples of a bundle.
#[inline(always)]
fn blend<S: Simd, const N: usize>(
    pixels: &mut [Colours<S>; N],
    open: &mut [S::Mask; N],
    scene: &Scene,
    bundle: &Bundle<S, N>,
    samples: &Samples<S, N>,
) {
    let mut vectors = BlockVectors::of(bundle.block);
    for n in 0..N {
        if let Some(sources) = scene.classifier.sources(bundle, n, samples, &mut vectors) {
            blend::under::<S>(scene.blending, &mut pixels[n], &sources);
            open[n] = open[n] & !blend::hidden::<S>(scene.blending, &pixels[n]);
        }
    }
}

/// The covered sampling points of a box.
#[inline(always)]
fn covered<S: Simd, const N: usize>(scene: &Scene, first: [u32; 2], cast_box: &CastBox) -> [Intervals<S>; N] {
    let bounds = &cast_box.shown.bounds;
    let [low, high] = [bounds.min.to_array(), bounds.max.to_array()];
    let mut all = [Intervals {
        begin: S::int(0),
        end: S::int(0),
    }; N];
    for (n, intervals) in all.iter_mut().enumerate() {
        *intervals = PacketRays::<S>::new(&scene.rays, first_of::<N>(first, n)).intervals(&low, &high);
    }
    all
}

/// See [`Scene::paths`].
#[inline(always)]
fn paths<S: Simd, const N: usize>(scene: &Scene, first: [u32; 2]) -> Option<[S::Float; N]> {
    let paths = scene.paths?;
    let mut all = [S::float(1.0); N];
    for (n, of) in all.iter_mut().enumerate() {
        *of = S::floats(std::array::from_fn(|ray| paths(pixel(first_of::<N>(first, n), ray))));
    }
    Some(all)
}

/// See [`Scene::stops`].
#[inline(always)]
fn stops<S: Simd, const N: usize>(scene: &Scene, first: [u32; 2]) -> Option<[S::Int; N]> {
    let stops = scene.stops?;
    let mut all = [S::int(0); N];
    for (n, of) in all.iter_mut().enumerate() {
        *of = S::ints(std::array::from_fn(|ray| stops(pixel(first_of::<N>(first, n), ray))));
    }
    Some(all)
}
