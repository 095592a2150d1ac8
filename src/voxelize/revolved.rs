//! Solids of revolution: an outline turned about the z axis.
//!
//! *Theory.* WK94 classifies a voxel by the feature it is nearest to: a side, an edge, an apex. In the half-plane beside the axis
//! the features are the outline's pieces and their corners.
//! *Changes from the paper.* Near one piece the density is that of a surface with the piece's curvature and that of the circle
//! it is turned on ([`curved`]). Near a corner of two straight pieces it is that of a wedge ([`facet::wedge`]) between the planes
//! that have the pieces' densities, which accounts for the bend of the rim. Near the tip of a cone a table has it (`apex`).
//! Anything else (a solid of the filter's size, a stretched pose) is integrated over lines along the axis ([`Lines`]).

use std::f64::consts::PI;
use std::sync::LazyLock;

use glam::{DVec2, DVec3};

use super::apex;
use super::curved::{self, MAX_CURVATURE};
use super::facet;
use super::filter::{self, Support};
use super::lines::{Lines, stretches};
use super::profile::{Nearest, Piece, Profile};
use crate::math::quadrature::GaussLegendre;

static RADII: LazyLock<GaussLegendre<7>> = LazyLock::new(GaussLegendre::new);
static ANGLES: LazyLock<GaussLegendre<12>> = LazyLock::new(GaussLegendre::new);
static MANY_RADII: LazyLock<GaussLegendre<16>> = LazyLock::new(GaussLegendre::new);
static MANY_ANGLES: LazyLock<GaussLegendre<32>> = LazyLock::new(GaussLegendre::new);
static BALL_ANGLES: LazyLock<GaussLegendre<4>> = LazyLock::new(GaussLegendre::new);

/// The density at `p` of `profile` turned about the z axis, where [`Profile::distance`] is `distance` radii of the filter.
pub fn density(profile: &Profile, p: DVec3, distance: f64, support: &Support) -> f64 {
    if !support.is_ball {
        return integrated(profile, p, support);
    }
    let flat = beside_axis(p);
    let radius = support.reach;
    let known = match profile.only_side(flat, radius) {
        Some(side) => straight_side(side.normal_at(flat), flat, distance, radius),
        None => near_feature(profile, flat, radius),
    };
    known.unwrap_or_else(|| integrated_in_ball(profile, flat, radius))
}

/// The distance of `p` from the axis, and its place along it.
pub fn beside_axis(p: DVec3) -> DVec2 {
    DVec2::new(p.truncate().length(), p.z)
}

/// The density where the filter's ball sees nothing, one piece that bends little, or one rim; `None` elsewhere.
fn near_feature(profile: &Profile, p: DVec2, radius: f64) -> Option<f64> {
    let mut near = profile
        .pieces()
        .iter()
        .filter(|piece| piece.distance_squared(p) < radius * radius);
    let (first, second, more) = (near.next(), near.next(), near.next());
    let is_near = |corner: &&DVec2| corner.distance_squared(p) < radius * radius;
    let mut corners = profile.corners().iter().filter(is_near);
    match (first, second, more) {
        (None, ..) => Some(f64::from(u8::from(profile.distance(p) <= 0.0))),
        (Some(only), None, _) if corners.next().is_none() => side(&only.nearest(p), p, radius),
        (Some(first), Some(second), None) => {
            let Some(&corner) = corners.next() else {
                return between([first, second], profile, p, radius);
            };
            // A corner is there once for each of its pieces.
            let alone = corners.all(|other| *other == corner);
            alone.then(|| rim([first, second], corner, p, radius))?
        }
        _ => None,
    }
}

/// The density near one piece and none of its corners.
fn side(nearest: &Nearest, p: DVec2, radius: f64) -> Option<f64> {
    let distance = (p - nearest.point).dot(nearest.normal) / radius;
    Some(curved::density(distance, bend(nearest, p, radius)?))
}

/// The density between two sides of a convex outline that do not meet in the ball: each takes away what lies beyond it.
fn between(pieces: [&Piece; 2], profile: &Profile, p: DVec2, radius: f64) -> Option<f64> {
    let [first, second] = pieces.map(|piece| side(&piece.nearest(p), p, radius));
    let density = first? + second? - 1.0;
    profile.is_convex_polygon().then_some(density.max(0.0))
}

/// The density near a straight side with this normal and nothing else: of a cone's side, or near its tip or axis.
fn straight_side(normal: DVec2, p: DVec2, distance: f64, radius: f64) -> Option<f64> {
    let on_side = p.x - distance * radius * normal.x;
    let round = match normal.x {
        0.0 => 0.0,
        _ => radius * normal.x / on_side,
    };
    if round == 0.0 || (round.abs() <= MAX_CURVATURE && p.x >= radius) {
        return Some(curved::density(distance, [0.0, round]));
    }
    let (sine, cosine) = (normal.y.abs(), normal.x);
    apex::density(distance, on_side / (sine * radius), sine / cosine)
}

/// A rim bends at most this much for its density to be that of a wedge, in units of the filter's radius. At a sixth random
/// cones and cylinders are within 0.005 of their convolution; at a half they were up to 0.018 off.
const MAX_RIM_CURVATURE: f64 = 1.0 / 6.0;

/// The density near the convex corner of two straight pieces.
fn rim(pieces: [&Piece; 2], corner: DVec2, p: DVec2, radius: f64) -> Option<f64> {
    if radius > MAX_RIM_CURVATURE * corner.x {
        return None;
    }
    let [Piece::Line { to, along, .. }, Piece::Line { along: other, .. }] = pieces else {
        return None;
    };
    // Counter-clockwise, an outline turns left at a convex corner.
    let turn = along.perp_dot(*other);
    if (*to == corner) != (turn > 0.0) {
        return None;
    }
    let mut planes = [(0.0, DVec2::ZERO); 2];
    for (plane, piece) in planes.iter_mut().zip(pieces) {
        let at_corner = piece.nearest(corner);
        let distance = (p - corner).dot(at_corner.normal) / radius;
        let bent = curved::density(distance, bend(&at_corner, p, radius)?);
        *plane = (filter::half_space_distance(bent, distance), at_corner.normal);
    }
    let [(first, first_normal), (second, second_normal)] = planes;
    Some(facet::wedge(first, second, first_normal.dot(second_normal)))
}

/// Both curvatures in units of the filter's radius, if they are small enough and the ball sees one side of the axis only.
fn bend(at: &Nearest, p: DVec2, radius: f64) -> Option<[f64; 2]> {
    let curvatures = at.curvatures.map(|c| c * radius);
    let flat_round_axis = at.curvatures[1] == 0.0 || at.curvatures[0] == at.curvatures[1];
    let small = curvatures.iter().all(|c| c.abs() <= MAX_CURVATURE);
    (small && (flat_round_axis || p.x >= radius)).then_some(curvatures)
}

/// The density by integration over lines along the axis, in a ball: what a ring sees is alike on both sides of the plane
/// through the sample and the axis.
pub(super) fn integrated_in_ball(profile: &Profile, p: DVec2, radius: f64) -> f64 {
    let distance = p.x / radius;
    let mut sum = 0.0;
    for (from, to) in stretches((p.x - radius).max(0.0), p.x + radius, &knots(profile, p.y, radius)) {
        for (rho, w_rho) in RADII.over(from, to) {
            let Some((lo, hi)) = profile.interval(rho) else {
                continue;
            };
            let [lo, hi] = [lo, hi].map(|z| (z - p.y) / radius);
            if lo >= 1.0 || hi <= -1.0 {
                continue;
            }
            let rho = rho / radius;
            let chord = |angle: f64| {
                let squared = distance * distance + rho * rho - 2.0 * distance * rho * angle.cos();
                filter::chord(squared.max(0.0).sqrt(), lo, hi)
            };
            let arc = 2.0 * BALL_ANGLES.integrate(0.0, half_angle(distance, rho, 1.0), chord);
            sum += w_rho / radius * rho * arc;
        }
    }
    sum.clamp(0.0, 1.0)
}

/// Distances from the axis between which the part of `profile` within `reach` of the height `z` is smooth, rising.
fn knots(profile: &Profile, z: f64, reach: f64) -> Vec<f64> {
    let crossings = [z - reach, z + reach].into_iter().flat_map(|z| profile.crossings(z));
    let mut knots: Vec<f64> = profile.knots().iter().copied().chain(crossings).collect();
    knots.sort_by(f64::total_cmp);
    knots
}

/// The density by integration over lines along the axis.
pub fn integrated(profile: &Profile, p: DVec3, support: &Support) -> f64 {
    let lines = Lines::new(p, support);
    let knots = knots(profile, p.z, support.reach);
    let sum = over_rings(
        &lines,
        &knots,
        &[],
        |rho| profile.interval(rho),
        |interval, _, at| lines.stretch(at, interval),
    );
    sum.clamp(0.0, 1.0)
}

/// The integral of `f`, given the solid's `interval` of heights at a distance from the axis, a direction (radians) and the point there, over the
/// lines of `lines`, in rings about the axis: smooth between the distances `knots` and the directions `cuts`, each rising.
pub(super) fn over_rings(
    lines: &Lines,
    knots: &[f64],
    cuts: &[f64],
    interval: impl Fn(f64) -> Option<(f64, f64)>,
    f: impl Fn((f64, f64), f64, DVec2) -> f64,
) -> f64 {
    if lines.is_ball {
        rings(&RADII, &ANGLES, lines, knots, cuts, interval, f)
    } else {
        // A stretched ball fills its rings less evenly, and is the rarer case.
        rings(&MANY_RADII, &MANY_ANGLES, lines, knots, cuts, interval, f)
    }
}

/// [`over_rings`] by these rules.
fn rings<const R: usize, const A: usize>(
    radii: &GaussLegendre<R>,
    angles: &GaussLegendre<A>,
    lines: &Lines,
    knots: &[f64],
    cuts: &[f64],
    interval: impl Fn(f64) -> Option<(f64, f64)>,
    f: impl Fn((f64, f64), f64, DVec2) -> f64,
) -> f64 {
    let (distance, reach) = (lines.middle().length(), lines.reach);
    let towards = lines.middle().to_angle();
    let mut sum = 0.0;
    for (from, to) in stretches((distance - reach).max(0.0), distance + reach, knots) {
        for (rho, weight) in radii.over(from, to) {
            let Some(interval) = interval(rho) else {
                continue;
            };
            let half = half_angle(distance, rho, reach);
            let at = |angle: f64| f(interval, angle, DVec2::from_angle(angle) * rho);
            let arcs = stretches(towards - half, towards + half, cuts);
            let ring: f64 = arcs.map(|(from, to)| angles.integrate(from, to, at)).sum();
            sum += weight * rho * ring;
        }
    }
    sum
}

/// Half the angle under which a circle of radius `reach`, `distance` from the axis, is seen at distance `rho`.
fn half_angle(distance: f64, rho: f64, reach: f64) -> f64 {
    let cosine = (distance * distance + rho * rho - reach * reach) / (2.0 * distance * rho);
    if cosine.is_nan() {
        PI
    } else {
        cosine.clamp(-1.0, 1.0).acos()
    }
}
