//! Where the packets of a tile come to something that shows, all of them at once.
//!
//! *Practice.* A packet is its lowest and its highest place along each axis here, which move on from plane to plane as their rays do. Each
//! of the tile's packets goes as far as its [`Gaps`] are empty, by itself, until all are where something may show.

use super::boxes::CastBox;
use super::gaps::Gaps;
use super::rays::{self, Rays};
use super::simd::{EDGE, RAYS, Simd, each};
use super::voxels::CastBlock;

/// How far around a packet's places is asked whether anything shows, for their rounding, voxels.
pub const MARGIN: f32 = 0.01;

/// Packets along a tile's edge.
pub const PACKETS: usize = 4;

/// The columns and rows of the first pixels of a tile's packets.
pub const FIRST: [[f64; RAYS]; 2] = {
    let mut first = [[0.0; RAYS]; 2];
    let mut n = 0;
    while n < RAYS {
        first[0][n] = (n % PACKETS * EDGE) as f64;
        first[1][n] = (n / PACKETS * EDGE) as f64;
        n += 1;
    }
    first
};

/// The packets of a tile on their way through a box.
pub struct Hops<S: Simd> {
    /// The next plane of each.
    pub planes: S::Int,
    /// The first plane at which each is certainly behind the box.
    pub ends: S::Int,
    /// The plane that places are counted from.
    from: i32,
    /// The lowest place at that plane along each axis, in stored voxels, and how far it is to the next plane's.
    low: [[S::Float; 2]; 3],
    /// Likewise the highest.
    high: [[S::Float; 2]; 3],
    /// Planes for a voxel of the way along the fastest axis.
    planes_per_voxel: S::Float,
}

/// The rays of the corners of packets along an axis, in double precision.
struct Corner<S: Simd> {
    origin: S::Double,
    step: S::Double,
}

impl<S: Simd> Corner<S> {
    /// Of those of the tile that begins at `first`: ray `ray` of each packet.
    #[inline(always)]
    fn new(rays: &Rays, axis: usize, first: [u32; 2], ray: usize) -> Self {
        let within = [(ray % EDGE) as f64, (ray / EDGE) as f64];
        let at = each!(a of [0, 1] => S::double(f64::from(first[a]) + within[a]) + S::doubles(FIRST[a]));
        Self {
            origin: rays.origin.at::<S>(axis, at),
            step: rays.step.at::<S>(axis, at),
        }
    }

    /// How many planes on it is at coordinate `face`, and whether it rises.
    #[inline(always)]
    fn meets(&self, face: f64) -> (S::Double, S::Mask) {
        let inverse = rays::inverse::<S>(self.step);
        let planes = (S::double(face) - self.origin) * inverse;
        (planes, S::greater_double(inverse, S::double(0.0)))
    }

    /// From plane `from` on, among the stored voxels from `first` on.
    #[inline(always)]
    fn line(&self, from: i32, first: i32) -> [S::Float; 2] {
        let at = self.origin + S::double(f64::from(from)) * self.step;
        [S::single(at - S::double(f64::from(first))), S::single(self.step)]
    }
}

impl<S: Simd> Hops<S> {
    /// The packets of the tile that begins at pixel `first`, before they are in a box of `block`.
    #[inline(always)]
    pub fn new(rays: &Rays, first: [u32; 2], block: &CastBlock, cast_box: &CastBox) -> Self {
        let lowest = rays.lowest;
        let low = each!(axis of [0, 1, 2] => Corner::<S>::new(rays, axis, first, lowest[axis]));
        let high = each!(axis of [0, 1, 2] => Corner::<S>::new(rays, axis, first, RAYS - 1 - lowest[axis]));
        let bounds = &cast_box.shown.bounds;
        let margin = f64::from(MARGIN);
        let (mut begin, mut end) = (S::double(0.0), S::double(f64::from(rays.planes)));
        for axis in 0..3 {
            // It is in the box from where its highest place is above the low face and its lowest below the high one.
            let (above, rises) = high[axis].meets(bounds.min[axis] - margin);
            (begin, end) = (
                larger_where::<S>(rises, above, begin),
                smaller_where::<S>(!rises, above, end),
            );
            let (below, rises) = low[axis].meets(bounds.max[axis] + margin);
            (begin, end) = (
                larger_where::<S>(!rises, below, begin),
                smaller_where::<S>(rises, below, end),
            );
        }
        let one = S::double(1.0);
        let planes = S::whole_double(S::floor_double(smaller_where::<S>(!S::none(), begin, S::double(LAST))));
        let ends = S::whole_double(S::ceil_double(larger_where::<S>(!S::none(), end + one, S::double(0.0))));
        // Of those that meet the box: how far they go from there is little, whatever the lattice.
        let meet = S::greater_int(ends, planes);
        let from = S::least(S::choose_int(meet, planes, S::int(i32::MAX)));
        let low = each!(axis of [0, 1, 2] => low[axis].line(from, block.first[axis]));
        let high = each!(axis of [0, 1, 2] => high[axis].line(from, block.first[axis]));
        let mut fastest = S::float(f32::MIN_POSITIVE);
        for axis in 0..3 {
            for [_, step] in [low[axis], high[axis]] {
                fastest = super::simd::larger::<S>(fastest, S::absolute(step));
            }
        }
        Self {
            planes,
            ends,
            from,
            low,
            high,
            planes_per_voxel: S::divide(S::float(1.0), fastest),
        }
    }

    /// Which packets are not behind the box.
    #[inline(always)]
    pub fn before_ends(&self) -> S::Mask {
        S::greater_int(self.ends, self.planes)
    }

    /// Goes on with each packet to where something may show, or behind the box.
    #[inline(always)]
    pub fn hop(&mut self, gaps: &Gaps) {
        loop {
            let planes = S::to_float(self.planes - S::int(self.from));
            let low = each!(axis of [0, 1, 2] => self.low[axis][0] + planes * self.low[axis][1] - S::float(MARGIN));
            let high = each!(axis of [0, 1, 2] => self.high[axis][0] + planes * self.high[axis][1] + S::float(MARGIN));
            let (free, voxels) = gaps.free::<S>(&low, &high);
            let hops = free & self.before_ends();
            if S::bits(hops) == 0 {
                return;
            }
            let on = S::whole(S::floor(voxels * self.planes_per_voxel)) + S::int(1);
            self.planes = S::choose_int(hops, self.planes + on, self.planes);
        }
    }
}

/// Planes are counted no further.
const LAST: f64 = (1 << 30) as f64;

/// `a` or `b`, whichever is larger, where `mask` says, else `b`.
#[inline(always)]
fn larger_where<S: Simd>(mask: S::Mask, a: S::Double, b: S::Double) -> S::Double {
    S::choose_double(mask & S::greater_double(a, b), a, b)
}

/// `a` or `b`, whichever is smaller, where `mask` says, else `b`.
#[inline(always)]
fn smaller_where<S: Simd>(mask: S::Mask, a: S::Double, b: S::Double) -> S::Double {
    S::choose_double(mask & S::greater_double(b, a), a, b)
}
