//! The rays of a square of pixels, cast through a box.

use std::ops::Range;

use super::blend::{self, Colours};
use super::boxes::CastBox;
use super::classify::{Classifier, Samples};
use super::kind::Kind;
use super::pixels::Pixels;
use super::places::{Line, Way};
use super::rays::{Intervals, PacketRays};
use super::sample::{Bundle, Normals, Numbers};
use super::simd::{EDGE, Kernel, RAYS, Sampling, each};
use super::spans::PACKETS;
use super::template::{Template, edge, side, voxel};
use super::tile::Scene;
use super::voxels::Voxels;
use crate::projection::composite::Blending;

/// The packets of a tile, row by row, each in `N` vectors: the rays of squares of pixels, those beyond the frame too.
///
/// What all frames need lies together, what only some do apart from it.
pub struct Packets<S: Sampling, const N: usize> {
    /// The tile's first pixel.
    first: [u32; 2],
    /// A bit for each that has met a box.
    begun: u16,
    /// See [`Packet`].
    lines: [Line; COUNT],
    pixels: [[Colours<S>; N]; COUNT],
    open: [[S::Mask; N]; COUNT],
    paths: [Option<[S::Float; N]>; COUNT],
    stops: [Option<[S::Int; N]>; COUNT],
    /// Of those that are cut by the box; of others, of whatever box there was before.
    covered: [[Intervals<S>; N]; COUNT],
    /// Whether each is known to be cut.
    is_cut: [bool; COUNT],
}

/// Packets of a tile.
pub const COUNT: usize = PACKETS * PACKETS;

/// One of the packets of a tile, and a box that is being cast.
pub struct Packet<'a, S: Sampling, const N: usize> {
    /// Its first pixel.
    first: [u32; 2],
    line: &'a Line,
    /// What has been blended so far.
    pixels: &'a mut [Colours<S>; N],
    /// The pixels that do not hide yet what is behind.
    open: &'a mut [S::Mask; N],
    /// Millimetres of each ray a millimetre of depth, if not all are 1.
    paths: &'a Option<[S::Float; N]>,
    /// The first plane of each pixel that a surface hides, if there are any.
    stops: &'a Option<[S::Int; N]>,
    /// The covered sampling points of the box, once they have been asked for.
    covered: &'a mut [Intervals<S>; N],
    /// Whether they have been.
    is_cut: &'a mut bool,
    /// Planes at which all rays are in the box.
    whole: Range<i32>,
}

/// The first pixel of vector `n` of the packet of `N` that begins at `first`.
#[inline(always)]
fn first_of<const N: usize>([x, y]: [u32; 2], n: usize) -> [u32; 2] {
    [x + (n % side(N) * EDGE) as u32, y + (n / side(N) * EDGE) as u32]
}

impl<S: Sampling, const N: usize> Packets<S, N> {
    /// Those of no tile.
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            first: [0; 2],
            begun: 0,
            lines: [Line::default(); COUNT],
            pixels: [[[S::float(0.0); 4]; N]; COUNT],
            open: [[S::none(); N]; COUNT],
            paths: [const { None }; COUNT],
            stops: [const { None }; COUNT],
            covered: [[Intervals::none(); N]; COUNT],
            is_cut: [false; COUNT],
        }
    }

    /// Turns to the tile that begins at pixel `first`; none has met a box.
    #[inline(always)]
    pub fn begin(&mut self, first: [u32; 2]) {
        self.first = first;
        self.begun = 0;
    }

    /// Turns to another box.
    #[inline(always)]
    pub fn turn(&mut self) {
        self.is_cut = [false; COUNT];
    }

    /// The nth, all of its rays in the box at planes `whole`.
    #[inline(always)]
    pub fn packet(&mut self, scene: &Scene, n: usize, whole: Range<i32>) -> Packet<'_, S, N> {
        let first = self.first_of(n);
        if self.begun >> n & 1 == 0 {
            self.begun |= 1 << n;
            self.lines[n] = Line::new(scene.rays.low::<N>(first));
            self.pixels[n] = [[S::float(0.0); 4]; N];
            self.open[n] = [!S::none(); N];
            if let Some(paths) = scene.paths {
                self.paths[n] = Some(of_pixels(first, |pixel| S::floats(each_ray(pixel, paths))));
            }
            if let Some(stops) = scene.stops {
                self.stops[n] = Some(of_pixels(first, |pixel| S::ints(each_ray(pixel, stops))));
            }
        }
        Packet {
            first,
            line: &self.lines[n],
            pixels: &mut self.pixels[n],
            open: &mut self.open[n],
            paths: &self.paths[n],
            stops: &self.stops[n],
            covered: &mut self.covered[n],
            is_cut: &mut self.is_cut[n],
            whole,
        }
    }

    /// The first pixel of the nth.
    #[inline(always)]
    fn first_of(&self, n: usize) -> [u32; 2] {
        let [x, y] = self.first;
        [x + (n % PACKETS * edge(N)) as u32, y + (n / PACKETS * edge(N)) as u32]
    }

    /// Writes the pixels of those that have met a box.
    #[inline(always)]
    pub fn write(&self, to: &mut Pixels) {
        for n in (0..COUNT).filter(|n| self.begun >> n & 1 == 1) {
            for (vector, pixels) in self.pixels[n].iter().enumerate() {
                to.write(first_of::<N>(self.first_of(n), vector), &S::side_by_side(*pixels));
            }
        }
    }
}

impl<S: Sampling, const N: usize> Packet<'_, S, N> {
    /// Which points at a plane are in the box, and seen; `None` if none is, nor any behind them.
    #[inline(always)]
    fn inside(&mut self, scene: &Scene, cast_box: &CastBox, plane: i32) -> Option<[S::Mask; N]> {
        let plane_of_each = S::int(plane);
        let (mut inside, mut left) = (*self.open, 0);
        if let Some(stops) = self.stops {
            for n in 0..N {
                inside[n] = inside[n] & S::greater_int(stops[n], plane_of_each);
            }
        }
        if self.whole.contains(&plane) {
            for inside in &inside {
                left |= S::bits(*inside);
            }
        } else {
            if !*self.is_cut {
                *self.is_cut = true;
                S::run(Cover {
                    scene,
                    first: self.first,
                    cast_box,
                    covered: self.covered,
                });
            }
            for (inside, covered) in inside.iter_mut().zip(&*self.covered) {
                let before_end = *inside & S::greater_int(covered.end, plane_of_each);
                left |= S::bits(before_end);
                *inside = before_end & !S::greater_int(covered.begin, plane_of_each);
            }
        }
        (left != 0).then_some(inside)
    }
}

/// A packet on its way through a box: those points in it that are at planes of one [stretch](super::places) where something may show.
pub struct March<'a, 'b, S: Sampling, K: Kind, const N: usize> {
    pub packet: Packet<'a, S, N>,
    pub scene: &'a Scene<'b>,
    pub voxels: &'a Voxels<'a>,
    pub cast_box: &'a CastBox<'b>,
    pub template: &'a mut Template<S, K, N>,
    /// The first plane; when it is done, the next one to go on with.
    pub next: &'a mut i32,
    /// The first plane that is not asked for.
    pub end: i32,
}

impl<S: Sampling, K: Kind, const N: usize> Kernel<S> for March<'_, '_, S, K, N> {
    #[inline(always)]
    fn run(mut self) {
        let mut plane = *self.next;
        let mut way = Way::new(self.packet.line, plane, &self.voxels.first);
        let mut shows = false;
        while plane < self.end {
            // Behind what shows, most often something shows.
            if !shows {
                let free = self.cast_box.shown.gaps.free(&way.at);
                if free > 0 {
                    let planes = self.scene.hops[usize::from(free)];
                    plane += planes;
                    way.go_on(planes);
                    continue;
                }
            }
            self.template.turn_to(&self.scene.rays, plane);
            let moved = self.template.moved(self.voxels, &way.at);
            way.go_on(1);
            if moved.is_few::<K>() {
                // What comes next is on its way while this is worked out.
                ask_for::<S>(self.voxels, &way);
            }
            let Some(inside) = self.packet.inside(self.scene, self.cast_box, plane) else {
                plane = i32::MAX;
                break;
            };
            let weighted = Numbers::new::<K>(self.voxels, &moved, self.voxels.weighted);
            shows = false;
            if self.scene.classifier.any_may_show::<S, K>(&weighted) {
                let bundle = Bundle::new(
                    (self.voxels, weighted),
                    (self.template, moved),
                    (plane, inside),
                    self.packet.paths,
                );
                if let Some(samples) = self.scene.classifier.samples(&bundle) {
                    let blending = if K::PLAIN { Blending::Over } else { self.scene.blending };
                    blend(
                        self.packet.pixels,
                        self.packet.open,
                        (&self.scene.classifier, blending),
                        &bundle,
                        &samples,
                    );
                    shows = true;
                }
            }
            plane += 1;
        }
        *self.next = plane;
    }
}

/// Says that few voxels round a packet will soon be read: those that it comes to next, as most of the others have been.
#[inline(always)]
fn ask_for<S: Sampling>(voxels: &Voxels, way: &Way) {
    let last = way.last();
    let first = voxels.index(voxel(&way.at)) as usize;
    S::ask_for(first, voxels.strides, last, voxels.weighted);
    if !voxels.normals.is_empty() {
        S::ask_for(first, voxels.strides, last, voxels.normals);
    }
}

/// Goes on with the samples of a bundle.
#[inline(always)]
fn blend<S: Sampling, K: Kind, const N: usize>(
    pixels: &mut [Colours<S>; N],
    open: &mut [S::Mask; N],
    (classifier, blending): (&Classifier, Blending),
    bundle: &Bundle<S, K, N>,
    samples: &Samples<S, N>,
) {
    let mut normals = Normals::of(bundle.voxels);
    // Each by itself, not in a loop: that it showed at the plane before tells the processor most of whether it does here.
    each!(n of [0, 1, 2, 3] => if n < N && samples.any >> n & 1 == 1
        && let Some(sources) = classifier.sources(bundle, n, samples, &mut normals)
    {
        blend::under::<S>(blending, &mut pixels[n], &sources);
        open[n] = open[n] & !blend::hidden::<S>(blending, &pixels[n]);
    });
}

/// The covered sampling points of a box, asked for by itself: few packets are cut.
struct Cover<'a, 'b, S: Sampling, const N: usize> {
    scene: &'a Scene<'b>,
    first: [u32; 2],
    cast_box: &'a CastBox<'b>,
    covered: &'a mut [Intervals<S>; N],
}

impl<S: Sampling, const N: usize> Kernel<S> for Cover<'_, '_, S, N> {
    #[inline(always)]
    fn run(self) {
        let bounds = &self.cast_box.shown.bounds;
        let [low, high] = [bounds.min.to_array(), bounds.max.to_array()];
        for (n, intervals) in self.covered.iter_mut().enumerate() {
            *intervals = PacketRays::<S>::new(&self.scene.rays, first_of::<N>(self.first, n)).intervals(&low, &high);
        }
    }
}

/// What `f` makes of the first pixel of each vector of a packet.
#[inline(always)]
fn of_pixels<T: Copy, const N: usize>(first: [u32; 2], f: impl Fn([u32; 2]) -> T) -> [T; N] {
    let mut all = [f(first); N];
    for (n, of) in all.iter_mut().enumerate().skip(1) {
        *of = f(first_of::<N>(first, n));
    }
    all
}

/// What `f` makes of each pixel of the vector that begins at `first`.
#[inline(always)]
fn each_ray<T>(first: [u32; 2], f: &dyn Fn([u32; 2]) -> T) -> [T; RAYS] {
    std::array::from_fn(|ray| f([first[0] + (ray % EDGE) as u32, first[1] + (ray / EDGE) as u32]))
}
