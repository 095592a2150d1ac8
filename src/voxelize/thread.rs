//! Threads and coils: an outline screwed along the z axis.
//!
//! *Theory.* The outline stands in the half-plane beside the axis and rises by the pitch each turn (WK94, figure 4).
//! *Practice.* Lines along the axis meet each turn in one stretch, so densities are integrated over them; turns that overlap
//! count once.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::filter::Support;
use super::lines::Lines;
use super::profile::Profile;
use super::revolved::{beside_axis, over_rings};
use crate::math::Aabb;

/// An outline screwed along z, right-handed, from the direction of x at z = 0 on.
#[derive(Clone, Debug, PartialEq)]
pub struct Thread {
    profile: Profile,
    pitch: f64,
    turns: f64,
    /// Distances from the axis between which lines along it change smoothly, rising.
    knots: Vec<f64>,
}

/// Distances from the axis at which a thread's thickness is compared with its pitch.
const THICKNESSES: usize = 64;

impl Thread {
    /// `profile` screwed so that it rises by `pitch` each turn, for a number of turns, both above 0.
    pub fn new(profile: Profile, pitch: f64, turns: f64) -> Self {
        let mut knots = profile.knots().to_vec();
        knots.extend(joints(&profile, pitch));
        knots.sort_by(f64::total_cmp);
        Self {
            profile,
            pitch,
            turns,
            knots,
        }
    }

    /// A box that holds it.
    pub fn bounds(&self) -> Aabb {
        let (lo, hi) = self.profile.bounds();
        let rise = self.pitch * self.turns;
        Aabb::new(DVec3::new(-hi.x, -hi.x, lo.y), DVec3::new(hi.x, hi.x, hi.y + rise))
    }

    /// The stretches of the line at distance `rho` and direction `angle` between the heights `lo` and `hi`, merged and rising.
    fn stretches(&self, rho: f64, angle: f64, lo: f64, hi: f64, mut each: impl FnMut((f64, f64))) {
        let Some((bottom, top)) = self.profile.interval(rho) else {
            return;
        };
        let start = angle.rem_euclid(TAU) / TAU;
        let last = (self.turns - start).floor();
        let from = ((lo - top) / self.pitch - start).ceil().max(0.0);
        let to = ((hi - bottom) / self.pitch - start).floor().min(last);
        let mut open: Option<(f64, f64)> = None;
        let mut turn = from;
        while turn <= to {
            let rise = self.pitch * (start + turn);
            let next = (bottom + rise, top + rise);
            open = match open {
                Some(before) if next.0 <= before.1 => Some((before.0, next.1)),
                Some(before) => {
                    each(before);
                    Some(next)
                }
                None => Some(next),
            };
            turn += 1.0;
        }
        open.into_iter().for_each(each);
    }

    /// Whether `p` is inside.
    pub fn contains(&self, p: DVec3) -> bool {
        let mut inside = false;
        let flat = p.truncate();
        self.stretches(flat.length(), flat.to_angle(), p.z, p.z, |(lo, hi)| {
            inside |= lo <= p.z && p.z <= hi
        });
        inside
    }

    /// At most the distance to the surface, above 0 outside.
    ///
    /// The outline's distance at a point's own direction changes, along any way through space, by at most
    /// √(1 + (pitch / 2πρ)²) of the way's length at distance ρ from the axis; within half the point's own distance from the axis
    /// that is taken at that half.
    pub fn distance(&self, p: DVec3) -> f64 {
        let flat = beside_axis(p);
        let start = p.truncate().to_angle().rem_euclid(TAU) / TAU;
        let turn = (p.z - self.middle_height()) / self.pitch - start;
        let last = (self.turns - start).floor();
        let nearest = [turn.floor() - 1.0, turn.floor(), turn.ceil(), turn.ceil() + 1.0]
            .map(|turn| {
                self.profile
                    .distance(flat - DVec2::Y * self.pitch * (start + turn.clamp(0.0, last.max(0.0))))
            })
            .into_iter()
            .fold(f64::INFINITY, f64::min);
        let half = 0.5 * flat.x;
        let slope = (1.0 + (self.pitch / (TAU * half)).powi(2)).sqrt();
        let safe = (nearest.abs() / slope).min(half).min(self.to_ends(flat, start));
        let box_distance = outside_cylinder(&self.bounds(), flat);
        if self.contains(p) {
            -safe
        } else {
            safe.max(box_distance)
        }
    }

    fn middle_height(&self) -> f64 {
        let (lo, hi) = self.profile.bounds();
        0.5 * (lo.y + hi.y)
    }

    /// The distance of a point in the direction `start` (in turns) to the planes in which the thread begins and ends.
    fn to_ends(&self, flat: DVec2, start: f64) -> f64 {
        let to = |end: f64| {
            let turned = (start - end).rem_euclid(1.0);
            let apart = turned.min(1.0 - turned) * TAU;
            flat.x * apart.min(0.5 * PI).sin()
        };
        to(0.0).min(to(self.turns))
    }

    /// The density at `p`.
    pub fn density(&self, p: DVec3, support: &Support) -> f64 {
        let lines = Lines::new(p, support);
        let (lo, hi) = (p.z - support.reach, p.z + support.reach);
        let sum = over_rings(&lines, &self.knots, &self.cuts(p), |rho, at| {
            let mut line = 0.0;
            self.stretches(rho, at.to_angle(), lo, hi, |stretch| line += lines.stretch(at, stretch));
            line
        });
        sum.clamp(0.0, 1.0)
    }

    /// The directions in which the thread begins and ends, in turns on both sides of the point's own direction, rising.
    fn cuts(&self, p: DVec3) -> [f64; 4] {
        let towards = p.truncate().to_angle();
        let near = |end: f64| {
            let below = towards - (towards - end * TAU).rem_euclid(TAU);
            [below, below + TAU]
        };
        let ([a, b], [c, d]) = (near(0.0), near(self.turns));
        let mut cuts = [a, b, c, d];
        cuts.sort_by(f64::total_cmp);
        cuts
    }
}

/// The distances from the axis at which a turn begins or ceases to meet the next one.
fn joints(profile: &Profile, pitch: f64) -> Vec<f64> {
    let (lo, hi) = profile.bounds();
    let place = |n: usize| lo.x + (hi.x - lo.x) * n as f64 / THICKNESSES as f64;
    let meets = |rho: f64| profile.interval(rho).is_some_and(|(bottom, top)| top - bottom >= pitch);
    let changes = (0..THICKNESSES)
        .map(|n| (place(n), place(n + 1)))
        .filter(|(a, b)| meets(*a) != meets(*b));
    changes.map(|(a, b)| halved(a, b, meets)).collect()
}

/// Where `holds` changes between `a` and `b`.
fn halved(mut a: f64, mut b: f64, holds: impl Fn(f64) -> bool) -> f64 {
    let at_a = holds(a);
    for _ in 0..40 {
        let middle = 0.5 * (a + b);
        if holds(middle) == at_a {
            a = middle;
        } else {
            b = middle;
        }
    }
    0.5 * (a + b)
}

/// The distance of a point beside the axis to the cylinder that `bounds` holds; 0 inside.
fn outside_cylinder(bounds: &Aabb, flat: DVec2) -> f64 {
    let radial = (flat.x - bounds.max.x).max(0.0);
    let axial = (bounds.min.z - flat.y).max(flat.y - bounds.max.z).max(0.0);
    radial.hypot(axial)
}
