//! A tile of the frame, cast box by box.

use std::ops::Range;

use super::boxes::CastBox;
use super::classify::Classifier;
use super::hops::{Hops, PACKETS};
use super::packet::Packet;
use super::rays::Rays;
#[cfg(target_arch = "x86_64")]
use super::simd::Avx512;
use super::simd::{EDGE, Kernel, Portable, Simd};
use super::voxels::CastTarget;
use crate::projection::composite::Blending;

/// Pixels along a tile's edge.
pub const TILE: usize = PACKETS * EDGE;

/// Planes that a box is cast by at a time, all pixels of a tile: what they read stays in a processor's cache.
const SLAB: i32 = 32;

/// All that tiles share.
pub struct Scene<'a> {
    pub target: &'a CastTarget,
    pub boxes: &'a [CastBox<'a>],
    pub rays: Rays,
    pub classifier: Classifier,
    pub blending: Blending,
    /// Millimetres of ray a millimetre of depth, of each pixel; `None` where all are 1.
    pub paths: Option<&'a (dyn Fn([u32; 2]) -> f32 + Sync)>,
    /// The first plane of each pixel that a surface hides, if there are any.
    pub stops: Option<&'a (dyn Fn([u32; 2]) -> i32 + Sync)>,
}

/// Pixel `n` of the packet whose first pixel is `first`.
pub fn pixel([x, y]: [u32; 2], n: usize) -> [u32; 2] {
    [x + (n % EDGE) as u32, y + (n / EDGE) as u32]
}

/// What is called with rows of pixels, each from its first on.
pub type Rows<'a> = &'a mut dyn FnMut([u32; 2], &[[f32; 4]]);

/// Casts the tile that begins at a pixel, and hands on those rows of its pixels that anything may cover.
pub type Cast = fn(&Scene, [u32; 2], Rows);

/// By the widest vectors that the processor has.
pub fn by_widest(scene: &Scene, first: [u32; 2], rows: Rows) {
    #[cfg(target_arch = "x86_64")]
    if Avx512::is_there() {
        return Avx512::run(TileCast { scene, first, rows });
    }
    by_arrays(scene, first, rows);
}

/// By arrays, whatever vectors the processor has.
#[multiversion::multiversion(targets("x86_64+avx2"))]
pub fn by_arrays(scene: &Scene, first: [u32; 2], rows: Rows) {
    TileCast { scene, first, rows }.run::<Portable>();
}

/// A tile that is to be cast.
struct TileCast<'a, 'b> {
    scene: &'a Scene<'b>,
    first: [u32; 2],
    rows: Rows<'a>,
}

impl Kernel for TileCast<'_, '_> {
    #[inline(always)]
    fn run<S: Simd>(self) {
        let mut packets: Packets<S> = [const { None }; PACKETS * PACKETS];
        for cast_box in self.scene.boxes {
            cast_box_by(&mut packets, self.scene, self.first, cast_box);
        }
        for (at, packet) in packets.iter().enumerate() {
            let Some(packet) = packet else { continue };
            let pixels = S::side_by_side(packet.pixels);
            for (row, pixels) in pixels.chunks_exact(EDGE).enumerate() {
                (self.rows)(pixel(first_of(self.first, at), row * EDGE), pixels);
            }
        }
    }
}

/// The packets of a tile, row by row; those that nothing may cover are left out.
type Packets<S> = [Option<Packet<S>>; PACKETS * PACKETS];

/// The first pixel of a packet of the tile whose first pixel is `first`.
fn first_of([x, y]: [u32; 2], packet: usize) -> [u32; 2] {
    [
        x + (packet % PACKETS * EDGE) as u32,
        y + (packet / PACKETS * EDGE) as u32,
    ]
}

#[inline(always)]
fn cast_box_by<S: Simd>(packets: &mut Packets<S>, scene: &Scene, first: [u32; 2], cast_box: &CastBox) {
    let covers = |axis: usize| {
        let Range { start, end } = cast_box.pixels[axis];
        start < first[axis] + TILE as u32 && first[axis] < end
    };
    if !covers(0) || !covers(1) {
        return;
    }
    let block = &scene.target.blocks[cast_box.block];
    let mut hops = Hops::<S>::new(&scene.rays, first, block, cast_box);
    let mut entered = 0u16;
    loop {
        hops.hop(&cast_box.shown.gaps);
        let before_ends = hops.before_ends();
        let left = S::bits(before_ends);
        if left == 0 {
            return;
        }
        let (mut planes, ends) = (S::int_array(hops.planes), S::int_array(hops.ends));
        let nearest = S::least(S::choose_int(before_ends, hops.planes, S::int(i32::MAX)));
        let slab = nearest - nearest % SLAB + SLAB;
        for n in 0..PACKETS * PACKETS {
            if left >> n & 1 == 0 || planes[n] >= slab {
                continue;
            }
            let packet = match &mut packets[n] {
                Some(packet) => packet,
                none => none.insert(Packet::new(scene, first_of(first, n))),
            };
            if entered >> n & 1 == 0 {
                entered |= 1 << n;
                packet.enter(scene, cast_box);
            }
            planes[n] = packet.march(scene, block, planes[n]..slab.min(ends[n]));
        }
        hops.planes = S::ints(planes);
    }
}
