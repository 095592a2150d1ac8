//! A tile of the frame, cast box by box.

use std::marker::PhantomData;
use std::ops::Range;

use super::approach::approach;
use super::boxes::CastBox;
use super::classify::Classifier;
use super::gaps::FARTHEST;
use super::kind::Kind;
use super::packet::{COUNT, March, Packets};
use super::places::STRETCH;
use super::rays::Rays;
#[cfg(target_arch = "x86_64")]
use super::simd::Avx512;
use super::simd::{EDGE, Kernel, Portable, RAYS, Simd, each};
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

/// Pixels of a frame, those of a few tiles side by side.
pub struct Pixels<'a> {
    /// The first of them.
    pub first: [u32; 2],
    /// All, row by row: as many rows as a tile has, but at the lower edge of the frame.
    pub rows: Vec<&'a mut [[f32; 4]]>,
}

/// Casts the tile that begins at a pixel, and writes those squares of its pixels that anything may cover.
pub type Cast = fn(&Scene, [u32; 2], &mut Pixels);

impl Pixels<'_> {
    /// Writes what of a square of pixels is among them.
    #[inline(always)]
    pub fn write(&mut self, first: [u32; 2], square: &[[f32; 4]; RAYS]) {
        let [column, row] = [0, 1].map(|axis| (first[axis] - self.first[axis]) as usize);
        let rows = self.rows.iter_mut().skip(row);
        for (row, pixels) in rows.zip(square.as_chunks::<EDGE>().0) {
            match row.get_mut(column..column + EDGE) {
                Some(whole) => whole.copy_from_slice(pixels),
                None => write_some(row.get_mut(column..).unwrap_or_default(), pixels),
            }
        }
    }
}

/// Writes what of a row of pixels there is room for.
#[cold]
#[inline(never)]
fn write_some(row: &mut [[f32; 4]], pixels: &[[f32; 4]; EDGE]) {
    row.copy_from_slice(&pixels[..row.len()]);
}

/// By the widest vectors that the processor has, in packets of `N`.
pub fn by_widest<K: Kind, const N: usize>(scene: &Scene, first: [u32; 2], pixels: &mut Pixels) {
    #[cfg(target_arch = "x86_64")]
    if Avx512::is_there() {
        return Avx512::run(TileCast::<K, N>::new(scene, first, pixels));
    }
    by_arrays::<K, N>(scene, first, pixels);
}

/// By arrays, whatever vectors the processor has.
pub fn by_arrays<K: Kind, const N: usize>(scene: &Scene, first: [u32; 2], pixels: &mut Pixels) {
    Portable::run(TileCast::<K, N>::new(scene, first, pixels));
}

/// A tile that is to be cast, in packets of `N` vectors.
struct TileCast<'a, 'b, 'c, K: Kind, const N: usize> {
    scene: &'a Scene<'b>,
    first: [u32; 2],
    pixels: &'a mut Pixels<'c>,
    kind: PhantomData<K>,
}

impl<S: Simd, K: Kind, const N: usize> Kernel<S> for TileCast<'_, '_, '_, K, N> {
    #[inline(always)]
    fn run(self) {
        let mut packets = Packets::<S, N>::new(self.first);
        let mut template = Template::new(&self.scene.rays, 0);
        for cast_box in self.scene.boxes {
            self.cast(&mut packets, &mut template, cast_box);
        }
        packets.write(self.pixels);
    }
}

impl<'a, 'b, 'c, K: Kind, const N: usize> TileCast<'a, 'b, 'c, K, N> {
    fn new(scene: &'a Scene<'b>, first: [u32; 2], pixels: &'a mut Pixels<'c>) -> Self {
        Self {
            scene,
            first,
            pixels,
            kind: PhantomData,
        }
    }

    #[inline(always)]
    fn cast<S: Simd>(&self, packets: &mut Packets<S, N>, template: &mut Template<S, K, N>, cast_box: &CastBox) {
        let (scene, first) = (self.scene, self.first);
        let covers = |axis: usize| {
            let Range { start, end } = cast_box.pixels[axis];
            start < first[axis] + tile(N) as u32 && first[axis] < end
        };
        if !covers(0) || !covers(1) {
            return;
        }
        let voxels = &scene.target.blocks[cast_box.block].voxels();
        let spans = Spans::<S>::new(&scene.rays, edge(N), first, cast_box);
        let mut next = S::int_array(approach::<S>(scene, cast_box, voxels, &spans));
        let ends = S::int_array(spans.any[1]);
        let [begin, end] = each!(of of [spans.all[0], spans.all[1]] => S::int_array(of));
        packets.turn();
        while let Some(nearest) = (0..COUNT).filter(|n| next[*n] < ends[*n]).map(|n| next[n]).min() {
            // All packets go on by a stretch before any goes on by the next: what they read stays in a processor's cache.
            let stretch_end = nearest - nearest % STRETCH + STRETCH;
            for n in 0..COUNT {
                let end_here = ends[n].min(stretch_end);
                if next[n] < end_here {
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
}
