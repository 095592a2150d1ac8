//! A tile of the frame, cast box by box.

use std::marker::PhantomData;
use std::ops::Range;

use super::approach::{approach, first_voxels};
use super::boxes::CastBox;
use super::classify::Classifier;
use super::gaps::FARTHEST;
use super::kind::Kind;
use super::packet::{COUNT, March, Packets};
use super::pixels::Pixels;
use super::places::STRETCH;
use super::rays::Rays;
#[cfg(target_arch = "x86_64")]
use super::simd::Avx512;
use super::simd::{Kernel, Portable, Sampling, Simd, each};
use super::spans::{PACKETS, Spans};
use super::template::{Template, edge};
use super::voxels::CastTarget;
use crate::projection::composite::Blending;

/// Pixels along the edge of a tile of packets of `n` vectors.
pub const fn tile(n: usize) -> usize {
    PACKETS * edge(n)
}

/// All that tiles share.
pub struct Scene<'a> {
    pub target: &'a CastTarget,
    pub boxes: &'a [CastBox<'a>],
    pub rays: Rays,
    /// See [`hops`](super::gaps::hops).
    pub hops: [i32; FARTHEST as usize + 1],
    pub classifier: Classifier,
    pub blending: Blending,
    /// Millimetres of ray a millimetre of depth, of each pixel; `None` where all are 1.
    pub paths: Option<&'a (dyn Fn([u32; 2]) -> f32 + Sync)>,
    /// The first plane of each pixel that a surface hides, if there are any.
    pub stops: Option<&'a (dyn Fn([u32; 2]) -> i32 + Sync)>,
}

/// Casts the tiles that pixels are of, and writes those of squares that anything may cover.
pub type Cast = fn(&Scene, &mut Pixels);

/// By the widest vectors that the processor has, in packets of `N`.
pub fn by_widest<K: Kind, const N: usize>(scene: &Scene, pixels: &mut Pixels) {
    #[cfg(target_arch = "x86_64")]
    if Avx512::is_there() {
        return Avx512::run(Tiles::<K, N>::new(scene, pixels));
    }
    by_arrays::<K, N>(scene, pixels);
}

/// By arrays, whatever vectors the processor has.
pub fn by_arrays<K: Kind, const N: usize>(scene: &Scene, pixels: &mut Pixels) {
    Portable::run(Tiles::<K, N>::new(scene, pixels));
}

/// Tiles side by side that are to be cast, in packets of `N` vectors.
struct Tiles<'a, 'b, 'c, K: Kind, const N: usize> {
    scene: &'a Scene<'b>,
    pixels: &'a mut Pixels<'c>,
    kind: PhantomData<K>,
}

impl<S: Sampling, K: Kind, const N: usize> Kernel<S> for Tiles<'_, '_, '_, K, N> {
    #[inline(always)]
    fn run(self) {
        let mut packets = Packets::<S, N>::new();
        let mut template = Template::<S, K, N>::new(&self.scene.rays, 0);
        let [left, top] = self.pixels.first;
        for column in (left..self.pixels.end()).step_by(tile(N)) {
            packets.begin([column, top]);
            for cast_box in self.scene.boxes {
                cast(self.scene, [column, top], cast_box, (&mut packets, &mut template));
            }
            packets.write(self.pixels);
        }
    }
}

impl<'a, 'b, 'c, K: Kind, const N: usize> Tiles<'a, 'b, 'c, K, N> {
    fn new(scene: &'a Scene<'b>, pixels: &'a mut Pixels<'c>) -> Self {
        Self {
            scene,
            pixels,
            kind: PhantomData,
        }
    }
}

/// Casts the tile that begins at pixel `first` through a box, if that is seen there.
#[inline(always)]
fn cast<S: Sampling, K: Kind, const N: usize>(
    scene: &Scene,
    first: [u32; 2],
    cast_box: &CastBox,
    (packets, template): (&mut Packets<S, N>, &mut Template<S, K, N>),
) {
    let covers = |axis: usize| {
        let Range { start, end } = cast_box.pixels[axis];
        start < first[axis] + tile(N) as u32 && first[axis] < end
    };
    if !covers(0) || !covers(1) {
        return;
    }
    let voxels = &scene.target.blocks[cast_box.block].voxels();
    let spans = Spans::<S>::new(&scene.rays, edge(N), first, cast_box);
    let approached = approach::<S>(scene, cast_box, voxels, &spans);
    let first_voxel = S::int_array(first_voxels::<S>(voxels, &spans, approached));
    let mut next = S::int_array(approached);
    let ends = S::int_array(spans.any[1]);
    let [begin, end] = each!(of of [spans.all[0], spans.all[1]] => S::int_array(of));
    packets.turn();
    while let Some(nearest) = (0..COUNT).filter(|n| next[*n] < ends[*n]).map(|n| next[n]).min() {
        // All packets go on by a stretch before any goes on by the next: what they read stays in a processor's cache.
        let stretch_end = nearest - nearest % STRETCH + STRETCH;
        for n in 0..COUNT {
            let end_here = ends[n].min(stretch_end);
            if next[n] < end_here {
                // What the packet after this one comes to first is on its way while this one goes on.
                if let Some(after) = (n + 1..COUNT).find(|n| next[*n] < ends[*n]) {
                    S::ask_for_all(first_voxel[after] as usize, voxels.strides, voxels.weighted);
                }
                S::run(March {
                    packet: packets.packet(scene, n, begin[n]..end[n]),
                    scene,
                    voxels,
                    cast_box,
                    template,
                    next: &mut next[n],
                    end: end_here,
                });
            }
        }
    }
}
