//! At which planes the packets of a tile are in a box, all of them at once.

use super::boxes::CastBox;
use super::gaps::MARGIN;
use super::rays::{self, Rays};
use super::simd::{RAYS, Simd, each};

/// Packets along a tile's edge.
pub const PACKETS: usize = 4;

/// The columns and rows of a tile's packets.
const PLACES: [[f64; RAYS]; 2] = {
    let mut places = [[0.0; RAYS]; 2];
    let mut n = 0;
    while n < RAYS {
        places[0][n] = (n % PACKETS) as f64;
        places[1][n] = (n / PACKETS) as f64;
        n += 1;
    }
    places
};

/// Where a tile's packets are in a box.
pub struct Spans<S: Simd> {
    /// From where on rays of each may be in the box, and where that ends.
    pub any: [S::Int; 2],
    /// Likewise all of its rays are.
    pub all: [S::Int; 2],
    /// The low corner of each along each axis.
    pub low: [Corner<S>; 3],
}

/// The rays of the corners of packets along an axis, in double precision.
pub struct Corner<S: Simd> {
    /// Where it is at plane 0.
    pub origin: S::Double,
    /// How far it goes from plane to plane.
    pub step: S::Double,
}

impl<S: Simd> Corner<S> {
    /// Of those of the tile that begins at `first`: the ray of each packet, of `edge` pixels along each edge, that is the `last` in its
    /// row and column.
    #[inline(always)]
    fn new(rays: &Rays, axis: usize, first: [u32; 2], edge: f64, last: [bool; 2]) -> Self {
        let at = each!(a of [0, 1] => {
            let within = if last[a] { edge - 1.0 } else { 0.0 };
            S::double(f64::from(first[a]) + within) + S::doubles(PLACES[a]) * S::double(edge)
        });
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
}

/// Planes from one on, up to another.
struct Span<S: Simd> {
    begin: S::Double,
    end: S::Double,
}

impl<S: Simd> Span<S> {
    /// All of a frame.
    #[inline(always)]
    fn of(rays: &Rays) -> Self {
        Self {
            begin: S::double(0.0),
            end: S::double(f64::from(rays.planes)),
        }
    }

    /// Less than before: where some corners are above coordinate `low`, and others below `high`.
    #[inline(always)]
    fn within(&mut self, [above, below]: [&Corner<S>; 2], [low, high]: [f64; 2]) {
        let (planes, rises) = above.meets(low);
        self.begin = larger_where::<S>(rises, planes, self.begin);
        self.end = smaller_where::<S>(!rises, planes, self.end);
        let (planes, rises) = below.meets(high);
        self.begin = larger_where::<S>(!rises, planes, self.begin);
        self.end = smaller_where::<S>(rises, planes, self.end);
    }

    /// A plane as a whole number, one that is near enough to be counted.
    #[inline(always)]
    fn whole(plane: S::Double) -> S::Int {
        let counted = smaller_where::<S>(!S::none(), plane, S::double(LAST));
        S::whole_double(larger_where::<S>(!S::none(), counted, S::double(-LAST)))
    }
}

impl<S: Simd> Spans<S> {
    /// Of the packets of `edge` pixels along each edge of the tile that begins at pixel `first`.
    #[inline(always)]
    pub fn new(rays: &Rays, edge: usize, first: [u32; 2], cast_box: &CastBox) -> Self {
        let (edge, lowest) = (edge as f64, rays.lowest);
        let low = each!(axis of [0, 1, 2] => Corner::<S>::new(rays, axis, first, edge, lowest[axis]));
        let high =
            each!(axis of [0, 1, 2] => Corner::<S>::new(rays, axis, first, edge, lowest[axis].map(|last| !last)));
        let bounds = &cast_box.shown.bounds;
        let (mut any, mut all) = (Span::<S>::of(rays), Span::<S>::of(rays));
        for axis in 0..3 {
            let faces = [bounds.min[axis], bounds.max[axis]];
            // Some of its rays are in the box from where its highest place is above the low face and its lowest below the high one.
            any.within([&high[axis], &low[axis]], [faces[0] - MARGIN, faces[1] + MARGIN]);
            all.within([&low[axis], &high[axis]], [faces[0] + MARGIN, faces[1] - MARGIN]);
        }
        let last = S::int(rays.planes);
        let end = Span::<S>::whole(S::floor_double(any.end) + S::double(1.0));
        Self {
            any: [
                Span::<S>::whole(S::ceil_double(any.begin)),
                S::choose_int(S::greater_int(end, last), last, end),
            ],
            all: [
                Span::<S>::whole(S::ceil_double(all.begin)),
                Span::<S>::whole(S::floor_double(all.end) + S::double(1.0)),
            ],
            low,
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
