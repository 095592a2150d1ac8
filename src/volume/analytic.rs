//! Closed-form fields: value, gradient and range known exactly, the truths that sampled volumes are tested against.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::field::{Field, Sample, SampleRange};
use crate::math::{Aabb, Interval};

/// A function of space in closed form, in world millimetres.
pub trait ClosedForm: Send + Sync {
    /// Its value at `p`.
    fn value(&self, p: DVec3) -> f64;

    /// Its gradient at `p`, per millimetre.
    fn gradient(&self, p: DVec3) -> DVec3;

    /// Numbers below and above all its values in the finite box `region`.
    fn range(&self, region: &Aabb) -> Span;
}

/// A closed-form function as a field: covered inside a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Analytic<F> {
    /// The function.
    pub form: F,
    /// Where the field is; finite.
    pub bounds: Aabb,
}

impl<F: ClosedForm> Field for Analytic<F> {
    fn bounds(&self) -> Aabb {
        self.bounds
    }

    fn sample(&self, p: DVec3) -> Sample {
        match self.bounds.contains(p) {
            true => Sample::solid(self.form.value(p) as f32),
            false => Sample::EMPTY,
        }
    }

    /// The function's gradient inside the box, 0 outside.
    fn gradient(&self, p: DVec3) -> DVec3 {
        match self.bounds.contains(p) {
            true => self.form.gradient(p),
            false => DVec3::ZERO,
        }
    }

    fn range(&self, region: &Aabb) -> SampleRange {
        let inside = region.intersect(&self.bounds);
        if inside.is_empty() {
            return SampleRange::EMPTY;
        }
        let covered = if inside == *region { 1.0 } else { 0.0 };
        SampleRange {
            value: self.form.range(&inside).rounded(),
            coverage: Interval::new(covered, 1.0),
        }
    }
}

/// A closed interval of `f64`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Lower end.
    pub lo: f64,
    /// Upper end.
    pub hi: f64,
}

impl Span {
    /// From the smallest to the largest of `values`.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let none = Self {
            lo: f64::INFINITY,
            hi: f64::NEG_INFINITY,
        };
        values.into_iter().fold(none, |span, v| Self {
            lo: span.lo.min(v),
            hi: span.hi.max(v),
        })
    }

    /// The image under a monotone function.
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self::of([f(self.lo), f(self.hi)])
    }

    fn times(self, other: Self) -> Self {
        let [a, b] = [self, other];
        Self::of([a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi])
    }

    /// The image under the cosine: that of the ends, and ±1 where a multiple of π of that parity lies between.
    fn cos(self) -> Self {
        let holds = |phase: f64| ((self.lo - phase) / TAU).ceil() * TAU + phase <= self.hi;
        let ends = self.map(f64::cos);
        Self {
            lo: if holds(PI) { -1.0 } else { ends.lo },
            hi: if holds(0.0) { 1.0 } else { ends.hi },
        }
    }

    /// As `f32`, with room for the rounding of `f64` arithmetic and of the conversion: the former is some 1e-15 of the
    /// magnitudes involved, far below the half ulp (6e-8) of the latter; two ulps hold both unless terms cancel to less
    /// than a part in 1e7 of their size, for which values this small against 1 are given 1e-12.
    fn rounded(self) -> Interval {
        let wide = Interval::new((self.lo - 1e-12) as f32, (self.hi + 1e-12) as f32);
        match self.lo == self.hi {
            true => Interval::point(self.lo as f32),
            false => wide.widen_ulps(2.0),
        }
    }
}

/// The same value everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constant(pub f64);

impl ClosedForm for Constant {
    fn value(&self, _: DVec3) -> f64 {
        self.0
    }

    fn gradient(&self, _: DVec3) -> DVec3 {
        DVec3::ZERO
    }

    fn range(&self, _: &Aabb) -> Span {
        Span::of([self.0])
    }
}

/// A linear ramp: `slope · p + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    /// The gradient, per millimetre.
    pub slope: DVec3,
    /// The value at the origin.
    pub offset: f64,
}

impl ClosedForm for Ramp {
    fn value(&self, p: DVec3) -> f64 {
        self.slope.dot(p) + self.offset
    }

    fn gradient(&self, _: DVec3) -> DVec3 {
        self.slope
    }

    fn range(&self, region: &Aabb) -> Span {
        Span::of(region.corners().map(|p| self.value(p)))
    }
}

/// A ball whose value falls with the distance from its centre by 1 a millimetre, and is 0 on its surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Its middle.
    pub center: DVec3,
    /// The distance at which the value is 0, millimetres.
    pub radius: f64,
}

impl ClosedForm for Ball {
    fn value(&self, p: DVec3) -> f64 {
        self.radius - p.distance(self.center)
    }

    /// 0 at the centre, where there is none.
    fn gradient(&self, p: DVec3) -> DVec3 {
        (self.center - p).normalize_or_zero()
    }

    fn range(&self, region: &Aabb) -> Span {
        let nearest = self.center.clamp(region.min, region.max);
        Span::of(region.corners().into_iter().chain([nearest]).map(|p| self.value(p)))
    }
}

/// The test signal of Marschner and Lobb (An evaluation of reconstruction filters for volume rendering, VIS'94, §5), with
/// α = 0.25 and f_M = 6, made for the box [-1, 1]³ and defined everywhere.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MarschnerLobb;

impl MarschnerLobb {
    /// The box that the signal is made for.
    pub const BOUNDS: Aabb = Aabb::new(DVec3::NEG_ONE, DVec3::ONE);

    const ALPHA: f64 = 0.25;
    const FREQUENCY: f64 = 6.0;

    /// `(1 − sin(πz/2) + α(1 + ρ)) / (2(1 + α))` of `sin(πz/2)` and of the radial part `ρ = cos(2π f_M cos(πr/2))`.
    fn join(sine: f64, rho: f64) -> f64 {
        (1.0 - sine + Self::ALPHA * (1.0 + rho)) / (2.0 * (1.0 + Self::ALPHA))
    }
}

impl ClosedForm for MarschnerLobb {
    fn value(&self, p: DVec3) -> f64 {
        let radius = p.truncate().length();
        let rho = (TAU * Self::FREQUENCY * (PI / 2.0 * radius).cos()).cos();
        Self::join((PI / 2.0 * p.z).sin(), rho)
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        let radius = p.truncate().length();
        let (sin, cos) = (PI / 2.0 * radius).sin_cos();
        let slope = (TAU * Self::FREQUENCY * cos).sin() * PI * PI * Self::FREQUENCY * sin;
        let radial = p.truncate().try_normalize().unwrap_or(DVec2::ZERO) * slope * Self::ALPHA;
        let along_z = -PI / 2.0 * (PI / 2.0 * p.z).cos();
        radial.extend(along_z) / (2.0 * (1.0 + Self::ALPHA))
    }

    fn range(&self, region: &Aabb) -> Span {
        let (lo, hi) = (region.min.truncate(), region.max.truncate());
        let nearest = DVec2::ZERO.clamp(lo, hi);
        let radius = Span {
            lo: nearest.length(),
            hi: lo.abs().max(hi.abs()).length(),
        };
        let cosine = radius.map(|r| PI / 2.0 * r).cos();
        let rho = cosine.map(|c| TAU * Self::FREQUENCY * c).cos();
        // sin a = cos(a − π/2)
        let z = Span::of([region.min.z, region.max.z]);
        let sine = z.map(|z| PI / 2.0 * z - PI / 2.0).cos();
        Span::of([Self::join(sine.hi, rho.lo), Self::join(sine.lo, rho.hi)])
    }
}

/// A product of three linear functions of one coordinate each: `∏ (slope·p + offset)`. Trilinear interpolation is exact on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trilinear {
    /// The factors' slopes, per millimetre.
    pub slope: DVec3,
    /// The factors at the origin.
    pub offset: DVec3,
}

impl ClosedForm for Trilinear {
    fn value(&self, p: DVec3) -> f64 {
        (self.slope * p + self.offset).element_product()
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        let f = self.slope * p + self.offset;
        self.slope * DVec3::new(f.y * f.z, f.x * f.z, f.x * f.y)
    }

    fn range(&self, region: &Aabb) -> Span {
        let [lo, hi] = [region.min, region.max].map(|p| (self.slope * p + self.offset).to_array());
        let factor = |a: usize| Span::of([lo[a], hi[a]]);
        factor(0).times(factor(1)).times(factor(2))
    }
}
