//! Solids between two heights over a rectangle: wavy plates, and boxes with rounded edges.
//!
//! *Practice.* Densities are integrated over vertical lines ([`Lines`]), between the places where the heights have kinks.

use std::f64::consts::TAU;
use std::sync::LazyLock;

use glam::{DVec2, DVec3};

use super::filter::Support;
use super::lines::{Lines, stretches};
use crate::math::Aabb;
use crate::math::quadrature::GaussLegendre;

static LINES: LazyLock<GaussLegendre<12>> = LazyLock::new(GaussLegendre::new);
static MANY_LINES: LazyLock<GaussLegendre<32>> = LazyLock::new(GaussLegendre::new);

/// A plate about the origin whose upper face is wavy: at `(x, y)` it ends at `amplitude · cos(2πx/λ.x) · cos(2πy/λ.y)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waves {
    /// Extents along x and y, above 0.
    pub size: DVec2,
    /// How far its flat lower face lies below z = 0; above `amplitude`.
    pub depth: f64,
    /// How high the waves are, at least 0.
    pub amplitude: f64,
    /// Their lengths along x and y, above 0; infinite where there are none along that axis.
    pub wavelength: DVec2,
}

impl Waves {
    /// The height of the upper face.
    pub fn height(&self, at: DVec2) -> f64 {
        let phase = TAU * at / self.wavelength;
        self.amplitude * phase.x.cos() * phase.y.cos()
    }

    fn steepest(&self) -> f64 {
        (TAU * self.amplitude / self.wavelength).length()
    }

    fn bounds(&self) -> Aabb {
        let half = 0.5 * self.size;
        Aabb::new((-half).extend(-self.depth), half.extend(self.amplitude))
    }

    fn distance(&self, p: DVec3) -> f64 {
        let beside = (p.truncate().abs() - 0.5 * self.size).max_element();
        let above = (p.z - self.height(p.truncate())) / (1.0 + self.steepest().powi(2)).sqrt();
        beside.max(above).max(-self.depth - p.z)
    }
}

/// A box about the origin with rounded edges and corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoundedBox {
    /// Half its extents.
    pub half: DVec3,
    /// The radius of its edges, above 0 and at most the least of `half`.
    pub radius: f64,
}

impl RoundedBox {
    fn distance(&self, p: DVec3) -> f64 {
        let q = p.abs() - (self.half - self.radius);
        q.max(DVec3::ZERO).length() + q.max_element().min(0.0) - self.radius
    }

    /// Half the thickness at `at`, a point of the rectangle that the box covers.
    fn half_height(&self, at: DVec2) -> Option<f64> {
        let beyond = (at.abs() - (self.half.truncate() - self.radius)).max(DVec2::ZERO);
        let rest = self.radius * self.radius - beyond.length_squared();
        (rest >= 0.0).then(|| self.half.z - self.radius + rest.sqrt())
    }
}

/// A solid between two heights over a rectangle about the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Relief {
    /// A wavy plate.
    Waves(Waves),
    /// A box with rounded edges.
    RoundedBox(RoundedBox),
}

impl Relief {
    /// A box that holds it.
    pub fn bounds(&self) -> Aabb {
        match self {
            Self::Waves(waves) => waves.bounds(),
            Self::RoundedBox(rounded) => Aabb::new(-rounded.half, rounded.half),
        }
    }

    /// At most the distance to the surface, above 0 outside.
    pub fn distance(&self, p: DVec3) -> f64 {
        match self {
            Self::Waves(waves) => waves.distance(p),
            Self::RoundedBox(rounded) => rounded.distance(p),
        }
    }

    /// Where it begins and ends above and below `at`.
    fn interval(&self, at: DVec2) -> Option<(f64, f64)> {
        match self {
            Self::Waves(waves) => (at.abs().cmple(0.5 * waves.size).all()).then(|| (-waves.depth, waves.height(at))),
            Self::RoundedBox(rounded) => rounded.half_height(at).map(|half| (-half, half)),
        }
    }

    /// Where the thickness has kinks along x, and along y at `x`, rising.
    fn knots(&self, x: f64) -> [[f64; 4]; 2] {
        match self {
            Self::Waves(waves) => {
                let half = 0.5 * waves.size;
                [half.x, half.y].map(|half| [-half, -half, half, half])
            }
            Self::RoundedBox(RoundedBox { half, radius }) => {
                let flat = *half - *radius;
                let beyond = (x.abs() - flat.x).max(0.0);
                let rim = flat.y + (radius * radius - beyond * beyond).max(0.0).sqrt();
                [[-half.x, -flat.x, flat.x, half.x], [-rim, -flat.y, flat.y, rim]]
            }
        }
    }

    /// The density at `p`.
    pub fn density(&self, p: DVec3, support: &Support) -> f64 {
        let lines = Lines::new(p, support);
        // A stretched ball fills its square less evenly.
        let sum = if lines.is_ball {
            self.integrated(&lines, &LINES)
        } else {
            self.integrated(&lines, &MANY_LINES)
        };
        sum.clamp(0.0, 1.0)
    }

    /// The integral over lines, by `rule` along x and along y.
    fn integrated<const N: usize>(&self, lines: &Lines, rule: &GaussLegendre<N>) -> f64 {
        let (lo, hi) = (lines.middle() - lines.reach, lines.middle() + lines.reach);
        let mut sum = 0.0;
        for (from, to) in stretches(lo.x, hi.x, &self.knots(0.0)[0]) {
            for (x, weight) in rule.over(from, to) {
                for (from, to) in stretches(lo.y, hi.y, &self.knots(x)[1]) {
                    let along = |y: f64| {
                        let at = DVec2::new(x, y);
                        self.interval(at).map_or(0.0, |interval| lines.stretch(at, interval))
                    };
                    sum += weight * rule.integrate(from, to, along);
                }
            }
        }
        sum
    }
}
