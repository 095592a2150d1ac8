//! A tile of the frame, cast box by box.

use std::marker::PhantomData;
use std::ops::Range;

use super::approach::{approach, first_voxels};
use super::boxes::CastBox;
use super::classify::Classifier;
use super::gaps::FARTHEST;
use super::kind::Kind;
use super::packet::{COUNT, March, Packets};
use super::pixels::Parts;
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

/// Casts the tiles of parts that no other thread has taken, and writes the pixels of squares that anything may cover.
pub type Cast = fn(&Scene, &Parts);

/// By the widest vectors that the processor has, in packets of `N`.
pub fn by_widest<K: Kind, const N: usize>(scene: &Scene, parts: &Parts) {
    #[cfg(target_arch = "x86_64")]
    if Avx512::is_there() {
        return Avx512::run(Tiles::<K, N>::new(scene, parts));
    }
    by_arrays::<K, N>(scene, parts);
}

/// By arrays, whatever vectors the processor has.
pub fn by_arrays<K: Kind, const N: usize>(scene: &Scene, parts: &Parts) {
    Portable::run(Tiles::<K, N>::new(scene, parts));
}

/// Tiles that are to be cast, in packets of `N` vectors. A thread has the same packets for all its tiles: there are 40 kB of them.
struct Tiles<'a, 'b, 'c, K: Kind, const N: usize> {
    scene: &'a Scene<'b>,
    parts: &'a Parts<'c>,
    kind: PhantomData<K>,
}

impl<S: Sampling, K: Kind, const N: usize> Kernel<S> for Tiles<'_, '_, '_, K, N> {
    #[inline(always)]
    fn run(self) {
        let mut packets = Packets::<S, N>::new();
        let mut template = Template::<S, K, N>::new(&self.scene.rays, 0);
        while let Some(mut pixels) = self.parts.take() {
            let [left, top] = pixels.first;
            for column in (left..pixels.end()).step_by(tile(N)) {
                packets.begin([column, top]);
                for cast_box in self.scene.boxes {
                    cast(self.scene, [column, top], cast_box, (&mut packets, &mut template));
                }
                packets.write(&mut pixels);
            }
        }
    }
}

impl<'a, 'b, 'c, K: Kind, const N: usize> Tiles<'a, 'b, 'c, K, N> {
    fn new(scene: &'a Scene<'b>, parts: &'a Parts<'c>) -> Self {
        Self {
            scene,
            parts,
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
    if S::bits(S::greater_int(spans.any[1], approached)) == 0 {
        return;
    }
    let first_voxel = S::int_array(first_voxels::<S>(voxels, &spans, approached));
    let mut next = S::int_array(approached);
    let ends = S::int_array(spans.any[1]);
    let [begin, end] = each!(of of [spans.all[0], spans.all[1]] => S::int_array(of));
    packets.turn();
    while let Some(nearest) = (0..COUNT).filter(|n| next[*n] < ends[*n]).map(|n| next[n]).min() {
        // All packets go on by a stretch before any goes on by the next: what they read stays in a processor's cache.
        let stretch_end = nearest - nearest % STRETCH + STRETCH;
        let mut left =
            S::bits(S::greater_int(spans.any[1], S::ints(next)) & S::greater_int(S::int(stretch_end), S::ints(next)));
        while left != 0 {
            let n = left.trailing_zeros() as usize;
            left &= left - 1;
            // What the packet after this one comes to first is on its way while this one goes on.
            if left != 0 {
                let after = left.trailing_zeros() as usize;
                S::ask_for_all(first_voxel[after] as usize, voxels.strides, voxels.weighted);
            }
            S::run(March {
                packet: packets.packet(scene, n, begin[n]..end[n]),
                scene,
                voxels,
                cast_box,
                template,
                next: &mut next[n],
                end: ends[n].min(stretch_end),
            });
        }
    }
}
