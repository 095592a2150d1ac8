//! A tile of the frame, cast box by box.

use std::ops::Range;

use super::boxes::CastBox;
use super::classify::Classifier;
use super::gaps::FARTHEST;
use super::packet::{March, Packet, first_of as vector_of};
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

/// Pixel `n` of the vector whose first pixel is `first`.
pub fn pixel([x, y]: [u32; 2], n: usize) -> [u32; 2] {
    [x + (n % EDGE) as u32, y + (n / EDGE) as u32]
}

/// What is called with rows of pixels, each from its first on.
pub type Rows<'a> = &'a mut dyn FnMut([u32; 2], &[[f32; 4]]);

/// Casts the tile that begins at a pixel, and hands on those rows of its pixels that anything may cover.
pub type Cast = fn(&Scene, [u32; 2], Rows);

/// By the widest vectors that the processor has, in packets of `N`.
pub fn by_widest<const N: usize>(scene: &Scene, first: [u32; 2], rows: Rows) {
    #[cfg(target_arch = "x86_64")]
    if Avx512::is_there() {
        return Avx512::run(TileCast::<N> { scene, first, rows });
    }
    by_arrays::<N>(scene, first, rows);
}

/// By arrays, whatever vectors the processor has.
pub fn by_arrays<const N: usize>(scene: &Scene, first: [u32; 2], rows: Rows) {
    Portable::run(TileCast::<N> { scene, first, rows });
}

/// A tile that is to be cast, in packets of `N` vectors.
struct TileCast<'a, 'b, const N: usize> {
    scene: &'a Scene<'b>,
    first: [u32; 2],
    rows: Rows<'a>,
}

impl<S: Simd, const N: usize> Kernel<S> for TileCast<'_, '_, N> {
    #[inline(always)]
    fn run(self) {
        let mut packets: Packets<S, N> = [const { None }; PACKETS * PACKETS];
        let mut template = Template::new(&self.scene.rays, 0);
        for cast_box in self.scene.boxes {
            self.cast(&mut packets, &mut template, cast_box);
        }
        for (at, packet) in packets.iter().enumerate() {
            let Some(packet) = packet else { continue };
            for n in 0..N {
                let first = vector_of::<N>(self.packet(at), n);
                let pixels = S::side_by_side(packet.pixels[n]);
                for (row, pixels) in pixels.chunks_exact(EDGE).enumerate() {
                    (self.rows)(pixel(first, row * EDGE), pixels);
                }
            }
        }
    }
}

/// The packets of a tile, row by row; those that nothing may cover are left out.
type Packets<S, const N: usize> = [Option<Packet<S, N>>; PACKETS * PACKETS];

impl<const N: usize> TileCast<'_, '_, N> {
    /// The first pixel of a packet.
    #[inline(always)]
    fn packet(&self, packet: usize) -> [u32; 2] {
        let [x, y] = self.first;
        [
            x + (packet % PACKETS * edge(N)) as u32,
            y + (packet / PACKETS * edge(N)) as u32,
        ]
    }

    #[inline(always)]
    fn cast<S: Simd>(&self, packets: &mut Packets<S, N>, template: &mut Template<S, N>, cast_box: &CastBox) {
        let (scene, first) = (self.scene, self.first);
        let covers = |axis: usize| {
            let Range { start, end } = cast_box.pixels[axis];
            start < first[axis] + tile(N) as u32 && first[axis] < end
        };
        if !covers(0) || !covers(1) {
            return;
        }
        let block = &scene.target.blocks[cast_box.block];
        let spans = Spans::<S>::new(&scene.rays, edge(N), first, cast_box);
        let [mut next, ends] = each!(of of [spans.any[0], spans.any[1]] => S::int_array(of));
        let [begin, end] = each!(of of [spans.all[0], spans.all[1]] => S::int_array(of));
        let mut entered = 0u16;
        while let Some(nearest) = (0..RAYS).filter(|n| next[*n] < ends[*n]).map(|n| next[n]).min() {
            // All packets go on by a stretch before any goes on by the next: what they read stays in a processor's cache.
            let stretch_end = nearest - nearest % STRETCH + STRETCH;
            for n in 0..PACKETS * PACKETS {
                if next[n] >= ends[n].min(stretch_end) {
                    continue;
                }
                let packet = match &mut packets[n] {
                    Some(packet) => packet,
                    none => none.insert(Packet::new(scene, self.packet(n))),
                };
                if entered >> n & 1 == 0 {
                    entered |= 1 << n;
                    packet.enter(begin[n]..end[n]);
                }
                S::run(March {
                    packet,
                    scene,
                    block,
                    cast_box,
                    template,
                    next: &mut next[n],
                    end: ends[n].min(stretch_end),
                });
            }
        }
    }
}
