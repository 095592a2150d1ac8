//! Where rays meet the surfaces of solids.
//!
//! *Theory.* A ray is sampled, and the classifier's opacities accumulate along it; the surface is where they say. Rays near a silhouette
//! accumulate something, so silhouettes are smooth.
//! *Changes from the paper.* Opacities of the samples of one surface are accumulated as its solid's own min/max family does, by the
//! largest, since A ∪ A = A. Products would grow with the number of samples, and would make a grazing ray opaque before it is at the
//! surface, where the paper finds its largest errors. The surface is where density is ½; how much of a surface a ray meets follows from
//! the largest density on its way through: nothing up to ¼, half at ½, all from ¾ on. So with a filter of two voxels a silhouette is
//! about one voxel wide, in its right place. The rest of the ray goes straight on.
//! *Practice.* Samples are half a voxel apart; between two the surface is found by secants, and the top of a grazing ray's density by a
//! parabola. Normals take many samples, and are made of what is seen alone. From within a solid everything is the same with one less the density. A ray that begins in a soft surface is
//! leaving it for as long as density falls.

use std::ops::Range;

use glam::DVec3;

use super::object::Probe;
use super::ray::Ray;
use super::voxels::{Quest, SURFACE};

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// Where, millimetres along the ray.
    pub at_mm: f64,
    /// Where what the surface does not stop of the ray has left it.
    pub end_mm: f64,
    /// How much of the ray meets it, above 0.
    pub opacity: f64,
    /// Whether it is where the ray enters (0) or leaves (1) the object's box, cut off by a face of that.
    face: Option<usize>,
}

impl Meeting {
    /// Whether all of the ray meets the surface.
    pub fn is_full(&self) -> bool {
        self.opacity >= 1.0
    }

    /// The normal, of length 1, out of the solid of `probe`, which `ray` has met here: that of the box's face, else against the
    /// gradient of the data, on the side to which density falls.
    pub fn normal(&self, probe: &Probe, ray: &Ray) -> DVec3 {
        if let Some(side) = self.face {
            return probe.face_normal(side);
        }
        let [data, density] = probe.surface_gradients(ray.at(self.at_mm));
        let outwards = if data.dot(density) >= 0.0 { -data } else { data };
        outwards.normalize_or(-ray.direction)
    }
}

/// The density of the surface.
const LEVEL: f64 = 0.5;

/// Ripples of density that are lower than this are no surface of their own.
const RIPPLE: f64 = 0.05;

/// How near to the level a surface is found.
const CLOSE: f64 = 1e-4;

/// How much of a surface a ray meets whose density has risen to `density`.
pub fn opacity(density: f64) -> f64 {
    ((density - SURFACE[0]) / (SURFACE[1] - SURFACE[0])).clamp(0.0, 1.0)
}

/// The first surface of the object of `probe` that its ray meets from `from_mm` on and before `until_mm`; `within` says whether it is
/// inside of the object there.
pub fn next(probe: &mut Probe, within: bool, from_mm: f64, until_mm: f64) -> Option<Meeting> {
    let stretch = probe.stretch();
    let begin = from_mm.max(stretch.enter);
    if begin >= stretch.leave || begin >= until_mm {
        return None;
    }
    let mut search = Search::new(from_mm < stretch.enter);
    match rise(probe, &mut search, within, begin..stretch.leave, until_mm) {
        Some(found) => Some(meeting(probe, within, &found)),
        None if within && stretch.leave < until_mm => Some(Meeting {
            at_mm: stretch.leave,
            end_mm: stretch.leave,
            opacity: 1.0,
            face: Some(1),
        }),
        None => None,
    }
}

/// Goes along a ray in the box until it has met something; heights are densities, or from within one less those.
fn rise(probe: &mut Probe, search: &mut Search, within: bool, mm: Range<f64>, until_mm: f64) -> Option<Met> {
    let quest = if within { Quest::Exit } else { Quest::Entrance };
    let step = probe.half_voxel();
    let mut at = mm.start;
    while at < mm.end && !(at >= until_mm && search.is_quiet()) {
        let region = probe.region(at, quest);
        let end = region.end.min(mm.end);
        if !region.worthwhile {
            if let found @ Some(_) = search.feed(Point { mm: at, height: 0.0 }) {
                return found;
            }
            at = end;
        }
        while at < end {
            let height = height(probe, within, at);
            if let found @ Some(_) = search.feed(Point { mm: at, height }) {
                return found;
            }
            at += step;
        }
    }
    let last = Point {
        mm: mm.end,
        height: 0.0,
    };
    if at >= mm.end { search.feed(last) } else { None }
}

fn height(probe: &mut Probe, within: bool, mm: f64) -> f64 {
    let density = probe.density(mm);
    if within { 1.0 - density } else { density }
}

/// Where the surface is that was found, exactly.
fn meeting(probe: &mut Probe, within: bool, met: &Met) -> Meeting {
    let at_mm = match met.crossing {
        Some([low, high]) if low < high => crossing(low, high, |mm| height(probe, within, mm) - LEVEL),
        Some([at, _]) => at,
        None => met.crest.mm,
    };
    let on_face = met.crossing == Some([at_mm; 2]) && at_mm == probe.stretch().enter;
    Meeting {
        at_mm,
        end_mm: met.end_mm,
        opacity: opacity(met.crest.height),
        face: on_face.then_some(0),
    }
}

/// Where `f` is 0 between two places, below it at the first and above it at the second (regula falsi; Dowell and Jarratt 1971).
fn crossing(low: f64, high: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    let (mut low, mut high) = ((low, f(low)), (high, f(high)));
    let mut at = high.0;
    for _ in 0..16 {
        if low.1 >= 0.0 || high.1 <= 0.0 {
            break;
        }
        at = low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1);
        let value = f(at);
        if value.abs() < CLOSE {
            break;
        }
        if value < 0.0 {
            low = (at, value);
            high.1 *= 0.5;
        } else {
            high = (at, value);
            low.1 *= 0.5;
        }
    }
    at
}

/// A sample on a ray.
#[derive(Clone, Copy, Debug)]
struct Point {
    mm: f64,
    height: f64,
}

/// What a search has met.
#[derive(Debug)]
struct Met {
    /// The places before and behind which height passes ½; `None` where it does not.
    crossing: Option<[f64; 2]>,
    /// Where height is largest, as far as that matters.
    crest: Point,
    end_mm: f64,
}

/// What the samples along a ray have shown so far.
struct Search {
    /// While the ray leaves the soft surface that it began in: the least height.
    leaving: Option<f64>,
    crossing: Option<[f64; 2]>,
    crest: Point,
    /// The last two samples.
    before: [Option<Point>; 2],
}

impl Search {
    /// Of a ray that comes from outside of the box, or begins somewhere in it.
    fn new(outside: bool) -> Self {
        Self {
            leaving: (!outside).then_some(f64::INFINITY),
            crossing: None,
            crest: Point { mm: 0.0, height: 0.0 },
            before: [None; 2],
        }
    }

    /// Whether no surface has begun.
    fn is_quiet(&self) -> bool {
        self.crossing.is_none() && self.crest.height < SURFACE[0]
    }

    /// The next sample; what it shows that the ray has met.
    fn feed(&mut self, point: Point) -> Option<Met> {
        let top = self.top(point);
        let [_, before] = self.before;
        self.before = [before, Some(point)];
        if let Some(lowest) = &mut self.leaving {
            *lowest = lowest.min(point.height);
            if point.height >= SURFACE[0] && point.height <= *lowest + RIPPLE {
                return None;
            }
            self.leaving = None;
            self.crest = point;
        }
        if top.height > self.crest.height {
            self.crest = top;
        }
        if self.crossing.is_none() && point.height >= LEVEL {
            self.crossing = Some([before.unwrap_or(point).mm, point.mm]);
        }
        let over = match self.crossing {
            Some(_) => self.crest.height >= SURFACE[1] || point.height < LEVEL,
            None => !self.is_quiet() && (point.height < SURFACE[0] || point.height < self.crest.height - RIPPLE),
        };
        if over {
            return Some(Met {
                crossing: self.crossing,
                crest: self.crest,
                end_mm: point.mm,
            });
        }
        if self.is_quiet() {
            self.crest = point;
        }
        None
    }

    /// The highest point about the last sample, now that `next` is known: the top of the parabola through three samples of one
    /// distance, else the sample.
    fn top(&self, next: Point) -> Point {
        let [Some(a), Some(b)] = self.before else {
            return next;
        };
        let [before, behind] = [b.mm - a.mm, next.mm - b.mm];
        let is_top = a.height <= b.height && next.height < b.height;
        if !is_top || (before - behind).abs() > 1e-6 * behind {
            return next;
        }
        let bend = 2.0 * b.height - a.height - next.height;
        let slope = next.height - a.height;
        Point {
            mm: b.mm + 0.5 * behind * slope / bend,
            height: b.height + slope * slope / (8.0 * bend),
        }
    }
}
