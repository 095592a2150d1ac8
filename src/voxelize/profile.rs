//! Outlines in the half-plane beside an axis: what solids of revolution and threads are made of.
//!
//! *Theory.* A point of the half-plane is (ρ, z): its distance from the axis, and its place along it. An outline is a closed
//! chain of straight lines and arcs, counter-clockwise, of which the axis itself may be a part that is not written.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

/// One part of an outline, with the solid to its left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Piece {
    /// A straight line.
    Line {
        /// Where it begins.
        from: DVec2,
        /// Where it ends.
        to: DVec2,
        /// The direction from there to there.
        along: DVec2,
        /// How long it is.
        length: f64,
    },
    /// An arc that bulges outwards.
    Arc {
        /// Its middle.
        center: DVec2,
        /// Its radius, above 0.
        radius: f64,
        /// The direction in which it begins, radians from ρ towards z.
        from: f64,
        /// How far it goes on from there, at most a full turn.
        sweep: f64,
        /// The direction of its middle.
        middle: DVec2,
        /// The cosine of the angle from there to its ends; -1 for a full circle.
        cosine: f64,
    },
}

/// How far, as a part of a piece, its ends may be missed: a line along the axis must meet the pieces that end there.
const ROUNDING: f64 = 1e-12;

/// The point of a piece nearest to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Where it is.
    pub point: DVec2,
    /// The outward unit normal there, of the piece and not of its end.
    pub normal: DVec2,
    /// The curvatures of the surface that the piece makes when it is turned about the axis, along the piece and round the
    /// axis, above 0 where the solid bulges. Round the axis it may be infinite.
    pub curvatures: [f64; 2],
}

impl Piece {
    /// The line between two points.
    pub fn line(from: DVec2, to: DVec2) -> Self {
        let (along, length) = ((to - from).normalize_or_zero(), (to - from).length());
        Self::Line {
            from,
            to,
            along,
            length,
        }
    }

    /// An arc about `center` that bulges outwards: from the direction `from` on for `sweep`, radians.
    pub fn arc(center: DVec2, radius: f64, from: f64, sweep: f64) -> Self {
        let full = sweep >= TAU;
        Self::Arc {
            center,
            radius,
            from,
            sweep,
            middle: DVec2::from_angle(from + 0.5 * sweep),
            cosine: if full { -1.0 } else { (0.5 * sweep).cos() - ROUNDING },
        }
    }

    /// The point nearest to `p`.
    pub fn nearest(&self, p: DVec2) -> Nearest {
        match *self {
            Self::Line {
                from, along, length, ..
            } => {
                let point = from + along * (p - from).dot(along).clamp(0.0, length);
                let normal = -along.perp();
                let round = if normal.x == 0.0 { 0.0 } else { normal.x / point.x };
                let curvatures = [0.0, round];
                Nearest {
                    point,
                    normal,
                    curvatures,
                }
            }
            Self::Arc { center, radius, .. } => {
                let normal = self.nearest_direction(p - center);
                let point = center + normal * radius;
                // An arc about a point of the axis turns into a sphere.
                let round = if center.x == 0.0 {
                    1.0 / radius
                } else {
                    normal.x / point.x
                };
                let curvatures = [1.0 / radius, round];
                Nearest {
                    point,
                    normal,
                    curvatures,
                }
            }
        }
    }

    /// The outward unit normal nearest to `p`.
    pub fn normal_at(&self, p: DVec2) -> DVec2 {
        match *self {
            Self::Line { along, .. } => -along.perp(),
            Self::Arc { center, .. } => self.nearest_direction(p - center),
        }
    }

    /// The squared distance to `p`.
    pub fn distance_squared(&self, p: DVec2) -> f64 {
        match *self {
            Self::Line {
                from, along, length, ..
            } => {
                let offset = p - from;
                let t = offset.dot(along).clamp(0.0, length);
                (offset - along * t).length_squared()
            }
            Self::Arc { center, radius, .. } => {
                let nearest = center + self.nearest_direction(p - center) * radius;
                nearest.distance_squared(p)
            }
        }
    }

    /// How far `p` lies on the outer side of a line and of what continues it; 0 for an arc.
    fn ahead(&self, p: DVec2) -> f64 {
        match *self {
            Self::Line { from, along, .. } => (p - from).perp_dot(along),
            Self::Arc { .. } => 0.0,
        }
    }

    /// The direction on an arc nearest to that of `towards`.
    fn nearest_direction(&self, towards: DVec2) -> DVec2 {
        let Self::Arc {
            from,
            sweep,
            middle,
            cosine,
            ..
        } = *self
        else {
            return DVec2::ZERO;
        };
        let direction = towards.try_normalize().unwrap_or(middle);
        if direction.dot(middle) >= cosine {
            direction
        } else if middle.perp_dot(direction) >= 0.0 {
            DVec2::from_angle(from + sweep)
        } else {
            DVec2::from_angle(from)
        }
    }

    /// Where it begins and where it ends; the same for a full circle.
    pub fn ends(&self) -> [DVec2; 2] {
        match *self {
            Self::Line { from, to, .. } => [from, to],
            Self::Arc {
                center,
                radius,
                from,
                sweep,
                ..
            } => [from, from + sweep].map(|angle| center + DVec2::from_angle(angle) * radius),
        }
    }

    fn is_full(&self) -> bool {
        matches!(self, Self::Arc { sweep, .. } if *sweep >= TAU)
    }

    /// Whether the surface goes on smoothly across the axis at `end`, an end of the piece.
    fn is_smooth_on_axis(&self, end: DVec2) -> bool {
        match *self {
            Self::Line { from, to, .. } => end.x == 0.0 && from.y == to.y,
            // An angle of a quarter turn has a cosine that is not quite 0.
            Self::Arc { center, radius, .. } => center.x == 0.0 && end.x.abs() <= 1e-12 * radius,
        }
    }

    /// Its ends, and where it is farthest from the axis and nearest to it.
    fn knots(&self) -> impl Iterator<Item = DVec2> {
        let (points, len) = match *self {
            Self::Line { from, to, .. } => ([from, to, from, to], 2),
            Self::Arc {
                center,
                radius,
                from,
                sweep,
                ..
            } => {
                let at = |angle: f64| center + DVec2::from_angle(angle) * radius;
                let holds = |angle: f64| (angle - from).rem_euclid(TAU) <= sweep;
                let extreme = |angle: f64| if holds(angle) { at(angle) } else { at(from) };
                ([at(from), at(from + sweep), extreme(0.0), extreme(PI)], 4)
            }
        };
        points.into_iter().take(len)
    }

    /// The smallest and the largest z at distance `rho` from the axis.
    fn heights(&self, rho: f64) -> Option<(f64, f64)> {
        match *self {
            Self::Line { from, to, .. } => {
                let t = (rho - from.x) / (to.x - from.x);
                let z = from.y + t * (to.y - from.y);
                (-ROUNDING..=1.0 + ROUNDING).contains(&t).then_some((z, z))
            }
            Self::Arc {
                center,
                radius,
                middle,
                cosine,
                ..
            } => {
                let x = (rho - center.x) / radius;
                let half = (1.0 - x * x).max(0.0).sqrt();
                let on_arc = |y: &f64| x.abs() <= 1.0 && DVec2::new(x, *y).dot(middle) >= cosine;
                let mut z = [-half, half].into_iter().filter(on_arc).map(|y| center.y + y * radius);
                let first = z.next()?;
                Some((first, z.next().unwrap_or(first)))
            }
        }
    }
}

/// A closed outline that each line along the axis meets in one stretch at most.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    pieces: Vec<Piece>,
    /// Where pieces meet, or end on the axis in a point.
    corners: Vec<DVec2>,
    /// Distances from the axis at which the solid's thickness has a kink, rising.
    knots: Vec<f64>,
    /// Whether the solid is what lies behind all its sides, which are straight.
    is_convex_polygon: bool,
}

impl Profile {
    /// The profile of at least one piece, in order.
    pub fn new(pieces: Vec<Piece>) -> Self {
        let mut knots: Vec<f64> = pieces.iter().flat_map(Piece::knots).map(|p| p.x).collect();
        knots.sort_by(f64::total_cmp);
        knots.dedup();
        let corners = pieces.iter().filter(|piece| !piece.is_full()).flat_map(|piece| {
            let ends = piece.ends().into_iter();
            ends.filter(|end| !piece.is_smooth_on_axis(*end))
        });
        let corners = corners.collect();
        let ends = || pieces.iter().flat_map(|piece| piece.ends());
        let straight = |piece: &Piece| matches!(piece, Piece::Line { .. });
        let convex = |piece: &Piece| ends().all(|end| piece.ahead(end) <= 1e-9 * (1.0 + end.length()));
        let is_convex_polygon = pieces.iter().all(|piece| straight(piece) && convex(piece));
        Self {
            pieces,
            corners,
            knots,
            is_convex_polygon,
        }
    }

    /// The profile round which these corners lie, counter-clockwise; sides along the axis are left out.
    pub fn polygon(corners: &[DVec2]) -> Self {
        let next = |n: usize| corners[(n + 1) % corners.len()];
        let sides = corners.iter().enumerate().map(|(n, &from)| (from, next(n)));
        let off_axis = sides.filter(|(from, to)| from.x > 0.0 || to.x > 0.0);
        Self::new(off_axis.map(|(from, to)| Piece::line(from, to)).collect())
    }

    /// Its parts.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Whether the solid is what lies behind all sides, which are straight.
    pub fn is_convex_polygon(&self) -> bool {
        self.is_convex_polygon
    }

    /// The one side of a convex polygon whose line a ball of radius `reach` about `p` meets; it meets no corner off the axis.
    pub fn only_side(&self, p: DVec2, reach: f64) -> Option<&Piece> {
        let mut met = self.pieces.iter().filter(|piece| piece.ahead(p) > -reach);
        let first = met.next().filter(|_| self.is_convex_polygon)?;
        met.next().is_none().then_some(first)
    }

    /// Places where pieces meet or end in a point, each as often as pieces end there.
    pub fn corners(&self) -> &[DVec2] {
        &self.corners
    }

    /// Distances from the axis between which the thickness is smooth, rising.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// The least and the greatest (ρ, z).
    pub fn bounds(&self) -> (DVec2, DVec2) {
        let mut bounds = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for piece in &self.pieces {
            let (lo, hi) = match *piece {
                Piece::Line { from, to, .. } => (from.min(to), from.max(to)),
                Piece::Arc { center, radius, .. } => (center - radius, center + radius),
            };
            bounds = (bounds.0.min(lo), bounds.1.max(hi));
        }
        (bounds.0.max(DVec2::new(0.0, f64::NEG_INFINITY)), bounds.1)
    }

    /// Distances from the axis at which a straight side passes height `z`: steep ones are thin there.
    pub fn crossings(&self, z: f64) -> impl Iterator<Item = f64> + '_ {
        self.pieces.iter().filter_map(move |piece| match *piece {
            Piece::Line { from, to, .. } => {
                let t = (z - from.y) / (to.y - from.y);
                (0.0 < t && t < 1.0).then_some(from.x + t * (to.x - from.x))
            }
            Piece::Arc { .. } => None,
        })
    }

    /// Where the solid begins and ends along z at distance `rho` from the axis.
    pub fn interval(&self, rho: f64) -> Option<(f64, f64)> {
        let heights = self.pieces.iter().filter_map(|piece| piece.heights(rho));
        heights.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// Whether `p` is inside.
    pub fn contains(&self, p: DVec2) -> bool {
        self.interval(p.x).is_some_and(|(lo, hi)| lo <= p.y && p.y <= hi)
    }

    /// At most the distance to the outline, above 0 outside; beyond the corners of straight outlines it is less.
    pub fn distance(&self, p: DVec2) -> f64 {
        let mut distance = [0.0];
        self.distances(&[p.x], &[p.y], &mut distance);
        distance[0]
    }

    /// [`Self::distance`] for many points (`rho`, `z`) at once.
    pub fn distances(&self, rho: &[f64], z: &[f64], distances: &mut [f64]) {
        if !self.is_convex_polygon {
            for ((distance, x), y) in distances.iter_mut().zip(rho).zip(z) {
                *distance = self.distance_to_outline(DVec2::new(*x, *y));
            }
            return;
        }
        distances.fill(f64::NEG_INFINITY);
        for piece in &self.pieces {
            for ((distance, x), y) in distances.iter_mut().zip(rho).zip(z) {
                *distance = distance.max(piece.ahead(DVec2::new(*x, *y)));
            }
        }
    }

    fn distance_to_outline(&self, p: DVec2) -> f64 {
        let squares = self.pieces.iter().map(|piece| piece.distance_squared(p));
        let distance = squares.fold(f64::INFINITY, f64::min).sqrt();
        if self.contains(p) { -distance } else { distance }
    }
}

/// Profiles of the primitives, in millimetres.
impl Profile {
    /// A cylinder about the origin.
    pub fn cylinder(radius: f64, height: f64) -> Self {
        Self::frustum(radius, radius, height)
    }

    /// A cone's frustum about the origin, from radius `bottom` below to `top` above; either may be 0, not both.
    pub fn frustum(bottom: f64, top: f64, height: f64) -> Self {
        let (low, high) = (-0.5 * height, 0.5 * height);
        let corners = [(0.0, low), (bottom, low), (top, high), (0.0, high)].map(DVec2::from);
        let mut kept: Vec<DVec2> = corners.to_vec();
        kept.dedup();
        Self::polygon(&kept)
    }

    /// A torus about the origin: a tube of radius `tube` on a circle of radius `ring`, which is larger.
    pub fn torus(ring: f64, tube: f64) -> Self {
        Self::new(vec![Piece::arc(DVec2::new(ring, 0.0), tube, 0.0, TAU)])
    }

    /// A capsule about the origin: all within `radius` of a stretch of z that is `length` long.
    pub fn capsule(radius: f64, length: f64) -> Self {
        let half = 0.5 * length;
        let cap = |z: f64, from: f64| Piece::arc(DVec2::new(0.0, z), radius, from, 0.5 * PI);
        let side = Piece::line(DVec2::new(radius, -half), DVec2::new(radius, half));
        Self::new(vec![cap(-half, -0.5 * PI), side, cap(half, 0.0)])
    }

    /// What is left when the outline moves inwards by `by`, above 0; `None` if that is nothing.
    ///
    /// Convex polygons, and outlines whose pieces meet without a corner.
    pub fn inset(&self, by: f64) -> Option<Self> {
        let straight = self.pieces.iter().all(|piece| matches!(piece, Piece::Line { .. }));
        if straight {
            self.inset_polygon(by)
        } else {
            self.inset_smooth(by)
        }
    }

    fn inset_smooth(&self, by: f64) -> Option<Self> {
        let moved = |piece: &Piece| match *piece {
            Piece::Line { from, to, along, .. } => {
                let inwards = along.perp() * by;
                let line = Piece::line(from + inwards, to + inwards);
                (line.ends()[0].x > 0.0).then_some(line)
            }
            Piece::Arc {
                center,
                radius,
                from,
                sweep,
                ..
            } => (by < radius).then(|| Piece::arc(center, radius - by, from, sweep)),
        };
        self.pieces.iter().map(moved).collect::<Option<Vec<_>>>().map(Self::new)
    }

    /// The corners of what lies behind all sides, moved inwards, and beside the axis.
    fn inset_polygon(&self, by: f64) -> Option<Self> {
        let axis = (DVec2::NEG_X, 0.0);
        let sides = self.pieces.iter().map(|piece| {
            let normal = piece.nearest(piece.ends()[0]).normal;
            (normal, normal.dot(piece.ends()[0]) - by)
        });
        let sides: Vec<(DVec2, f64)> = sides.chain([axis]).collect();
        let tolerance = 1e-9 * self.bounds().1.abs().max_element();
        let mut corners: Vec<DVec2> = Vec::new();
        for (n, a) in sides.iter().enumerate() {
            for b in &sides[n + 1..] {
                let det = a.0.perp_dot(b.0);
                let at = DVec2::new(a.1 * b.0.y - b.1 * a.0.y, a.0.x * b.1 - b.0.x * a.1) / det;
                let behind = sides.iter().all(|side| side.0.dot(at) <= side.1 + tolerance);
                if det.abs() > 1e-9 && behind && corners.iter().all(|c| c.distance(at) > tolerance) {
                    corners.push(at.max(DVec2::new(0.0, f64::NEG_INFINITY)));
                }
            }
        }
        let middle = corners.iter().sum::<DVec2>() / corners.len().max(1) as f64;
        corners.sort_by(|p, q| (*p - middle).to_angle().total_cmp(&(*q - middle).to_angle()));
        (corners.len() >= 3).then(|| Self::polygon(&corners))
    }
}
