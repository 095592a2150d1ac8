//! φ⁻¹ at a point, by Newton's iteration.

use glam::{DMat3, DVec3};

use super::spline::Spline;

/// A point and the Jacobian of φ there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Preimage {
    /// Where it was, millimetres.
    pub at: DVec3,
    /// φ's Jacobian at `at`, or within what the last step moved of it.
    pub jacobian: DMat3,
}

/// Steps of Newton's iteration, and halvings of one of them. It takes three or four; many more happen only where φ folds.
const STEPS: usize = 40;
const HALVINGS: usize = 12;

/// Before the last step the point is off by less than this part of the landmarks' spread. The step leaves the square of it,
/// times how φ bends.
const NEARLY: f64 = 1e-7;

impl Spline {
    /// The point that goes to `target`; `None` if none is found, as may be where the map folds.
    pub fn inverse(&self, target: DVec3) -> Option<DVec3> {
        self.invert_afresh(target).ok().map(|found| found.at)
    }

    /// [`Self::invert`] from no place nearby.
    pub(super) fn invert_afresh(&self, target: DVec3) -> Result<Preimage, DVec3> {
        // Where the movement, as it is here, would have come from.
        let guess = target - (self.point(target) - target);
        self.invert(target, guess).or_else(|_| self.invert(target, target))
    }

    /// The point that goes to `target`, sought from `start`; `Err` has where the search came to a stop.
    pub(super) fn invert(&self, target: DVec3, start: DVec3) -> Result<Preimage, DVec3> {
        let nearly = NEARLY * self.scale;
        let mut at = start;
        let (mut value, mut jacobian) = self.point_and_jacobian(at);
        for _ in 0..STEPS {
            let miss = target - value;
            let step = jacobian.inverse() * miss;
            if !step.is_finite() {
                return Err(at);
            }
            if miss.length() <= nearly {
                let at = at + step;
                return Ok(Preimage { at, jacobian });
            }
            let mut part = 1.0;
            let next = loop {
                let next = at + part * step;
                let found = self.point_and_jacobian(next);
                if (target - found.0).length() < miss.length() * (1.0 - 0.25 * part) {
                    break Some((next, found));
                }
                part *= 0.5;
                if part < 0.5f64.powi(HALVINGS as i32) {
                    break None;
                }
            };
            let Some((next, found)) = next else {
                return Err(at);
            };
            at = next;
            (value, jacobian) = found;
        }
        Err(at)
    }
}
