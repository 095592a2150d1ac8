//! Threads and coils: an outline screwed along the z axis.
//!
//! *Theory.* The outline stands in the half-plane beside the axis and rises by the pitch each turn (WK94, figure 4).
//! *Practice.* Lines along the axis meet each turn in one stretch, so densities are integrated over them; turns that overlap
//! count once. Away from the ends they come from a table (`screw`).

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::filter::Support;
use super::lines::Lines;
use super::profile::Profile;
use super::revolved::{beside_axis, over_rings};
use super::screw::Screw;
use crate::math::Aabb;

/// An outline screwed along z, right-handed, from the direction of x at z = 0 on.
#[derive(Clone, Debug, PartialEq)]
pub struct Thread {
    profile: Profile,
    pitch: f64,
    turns: f64,
    /// Distances from the axis between which lines along it change smoothly, rising.
    knots: Vec<f64>,
    /// Tables for the filters that it is sampled with.
    screws: Vec<Arc<Screw>>,
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
            screws: Vec::new(),
        }
    }

    /// The same with a table for samples by a filter of radius `reach`.
    pub fn tabulated(&self, reach: f64) -> Self {
        let mut thread = self.clone();
        thread.screws.extend(Screw::shared(&self.profile, self.pitch, reach));
        thread
    }

    /// A box that holds it.
    pub fn bounds(&self) -> Aabb {
        let (lo, hi) = self.profile.bounds();
        let rise = self.pitch * self.turns;
        Aabb::new(DVec3::new(-hi.x, -hi.x, lo.y), DVec3::new(hi.x, hi.x, hi.y + rise))
    }

    /// The turns that there are in a direction (in turns): from 0 to the last.
    fn turns_at(&self, start: f64) -> [f64; 2] {
        [0.0, (self.turns - start).floor()]
    }

    /// The stretches between the heights `lo` and `hi` of a line in direction `start` (in turns), where the outline goes from `bottom`
    /// to `top`, for the turns from `first` to `last`; merged and rising.
    fn stretches(
        &self,
        (bottom, top): (f64, f64),
        start: f64,
        [first, last]: [f64; 2],
        [lo, hi]: [f64; 2],
        mut each: impl FnMut((f64, f64)),
    ) {
        let from = ((lo - top) / self.pitch - start).ceil().max(first);
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
        let start = in_turns(flat.to_angle());
        if let Some(interval) = self.profile.interval(flat.length()) {
            self.stretches(interval, start, self.turns_at(start), [p.z; 2], |(lo, hi)| {
                inside |= lo <= p.z && p.z <= hi
            });
        }
        inside
    }

    /// At most the distance to the surface, above 0 outside.
    ///
    /// The outline's distance at a point's own direction changes, along any way through space, by at most
    /// √(1 + (pitch / 2πρ)²) of the way's length at distance ρ from the axis; within half the point's own distance from the axis
    /// that is taken at that half.
    pub fn distance(&self, p: DVec3) -> f64 {
        let flat = beside_axis(p);
        let start = in_turns(p.truncate().to_angle());
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
        let screw = self.screws.iter().find(|screw| screw.reach == support.reach);
        match screw.filter(|_| support.is_ball && self.sees_no_end(p, support.reach)) {
            Some(screw) => {
                let height = p.z - self.pitch * in_turns(p.truncate().to_angle());
                let endless = |_: f64| [f64::NEG_INFINITY, f64::INFINITY];
                screw.density(p.truncate().length(), height, |rho, z| {
                    self.integrated(DVec3::new(rho, 0.0, z), support, &[], endless)
                })
            }
            None => self.integrated(p, support, &self.cuts(p), |start| self.turns_at(start)),
        }
    }

    /// The density at `p` by integration over lines, with the turns that `turns_at` tells of a direction (in turns). Between the
    /// directions `cuts` (radians, rising) those do not change.
    fn integrated(&self, p: DVec3, support: &Support, cuts: &[f64], turns_at: impl Fn(f64) -> [f64; 2]) -> f64 {
        let lines = Lines::new(p, support);
        let heights = [p.z - support.reach, p.z + support.reach];
        let sum = over_rings(
            &lines,
            &self.knots,
            cuts,
            |rho| self.profile.interval(rho),
            |interval, angle, at| {
                let mut line = 0.0;
                let start = in_turns(angle);
                self.stretches(interval, start, turns_at(start), heights, |stretch| {
                    line += lines.stretch(at, stretch);
                });
                line
            },
        );
        sum.clamp(0.0, 1.0)
    }

    /// Whether a ball of radius `reach` about `p` would see nothing else if the thread went on without end.
    fn sees_no_end(&self, p: DVec3, reach: f64) -> bool {
        let rho = p.truncate().length();
        let start = in_turns(p.truncate().to_angle());
        // How far the ball is seen to both sides, in turns.
        let half = if reach < rho { (reach / rho).asin() / TAU } else { 0.5 };
        let crosses = |end: f64| {
            let apart = (start - end).rem_euclid(1.0);
            apart.min(1.0 - apart) <= half
        };
        // The last of the turns that are missing below, and the first above, in the directions that are seen.
        let below = if crosses(0.0) { 0.0 } else { start + half - 1.0 };
        let past = (start - half - self.turns).rem_euclid(1.0);
        let above = self.turns + if crosses(self.turns) { 0.0 } else { past };
        let (lo, hi) = self.profile.bounds();
        p.z - reach >= hi.y + self.pitch * below && p.z + reach <= lo.y + self.pitch * above
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

/// An angle (radians) in turns, from 0 to 1.
fn in_turns(angle: f64) -> f64 {
    angle.rem_euclid(TAU) / TAU
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Two cubics, of 2.3e-4 each (see [`Screw`]), the first of which the second's weights make up to 1.25 times as large; and two
    /// integrals by Gauss's rule, which differ by a tenth of that.
    const TABLE_ERROR: f64 = 6e-4;

    /// Numbers from 0 to 1 that fill space evenly.
    fn part(n: u32, step: f64) -> f64 {
        (f64::from(n) * step).fract()
    }

    fn outlines() -> [Thread; 3] {
        let corners = [
            (5.0, -1.8),
            (7.0, -1.8),
            (8.5, -0.4),
            (8.5, 0.4),
            (7.0, 1.8),
            (5.0, 1.8),
        ];
        let tooth = Profile::polygon(&corners.map(DVec2::from));
        [
            Thread::new(tooth.clone(), 4.0, 3.3),
            Thread::new(tooth, 7.0, 1.8),
            Thread::new(Profile::torus(2.5, 1.2), 5.0, 2.6),
        ]
    }

    #[test]
    fn a_table_has_the_densities_of_integrals() {
        let support = Support::ball(2.0);
        for plain in outlines() {
            let thread = plain.tabulated(support.reach);
            let bounds = thread.bounds().expand(DVec3::splat(support.reach));
            let (mut worst, mut by_table) = (0f64, 0);
            for n in 0..4000 {
                let part = DVec3::new(part(n, 0.819_172_513), part(n, 0.671_043_607), part(n, 0.549_700_478));
                let p = bounds.min + bounds.size() * part;
                by_table += u32::from(thread.sees_no_end(p, support.reach));
                worst = worst.max((thread.density(p, &support) - plain.density(p, &support)).abs());
            }
            assert!(worst < TABLE_ERROR, "{worst}");
            assert!(by_table > 800, "{by_table} places of 4000 by the table");
        }
    }

    #[test]
    fn threads_that_are_alike_share_a_table() {
        let [first, second, _] = outlines();
        let table = |thread: &Thread, reach: f64| Arc::clone(&thread.tabulated(reach).screws[0]);
        let one = table(&first, 2.0);
        assert!(Arc::ptr_eq(&one, &table(&first.clone(), 2.0)));
        assert!(!Arc::ptr_eq(&one, &table(&first, 2.5)));
        assert!(!Arc::ptr_eq(&one, &table(&second, 2.0)));
    }
}
