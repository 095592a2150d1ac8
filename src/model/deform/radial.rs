//! Radial basis functions of a distance r (mm), with their derivatives as the splines' sums need them.
//!
//! *Theory.* With d the vector from a landmark, the gradient of U(|d|) is `g d` with g = U′/r, and its second derivative
//! `g 1 + h d dᵀ` with h = g′/r. The third, along one unit vector at the angle θ to d, is `3 g′ c(1 − c²) + U‴ c³` with
//! c = cos θ; along one vector is where a symmetric form is largest.

/// What a radial function is at a distance.
#[derive(Clone, Copy)]
pub(super) struct Terms {
    /// The function.
    pub u: f64,
    /// Its derivative over the distance.
    pub g: f64,
    /// That one's derivative over the distance.
    pub h: f64,
}

/// A radial function.
pub(super) trait Radial: Copy {
    /// Whether the gradient jumps at the landmark.
    const HAS_KINK: bool;

    /// How far from the landmark it is not 0, millimetres.
    fn reach(self) -> f64;

    /// At the distance `r`.
    fn terms(self, r: f64) -> Terms;

    /// The most that the third derivative can be at distances of `r` and more.
    fn third(self, r: f64) -> f64;
}

/// r: the thin plate's function in three dimensions (VTK's basis R).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ThinPlate;

impl Radial for ThinPlate {
    const HAS_KINK: bool = true;

    fn reach(self) -> f64 {
        f64::INFINITY
    }

    #[inline(always)]
    fn terms(self, r: f64) -> Terms {
        // At the landmark itself, where the gradient jumps, its mean.
        let g = if r > 0.0 { 1.0 / r } else { 0.0 };
        Terms { u: r, g, h: -g * g * g }
    }

    /// 3 c(1 − c²)/r² is largest at c² = 1/3.
    #[inline(always)]
    fn third(self, r: f64) -> f64 {
        1.1548 / (r * r)
    }
}

/// (1 − q)⁴ (4q + 1) with q = r / support, and 0 beyond (Wendland 1995): twice differentiable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Compact {
    /// One over the support, 1/mm.
    pub per_support: f64,
}

impl Radial for Compact {
    const HAS_KINK: bool = false;

    fn reach(self) -> f64 {
        1.0 / self.per_support
    }

    #[inline(always)]
    fn terms(self, r: f64) -> Terms {
        let k = self.per_support;
        let q = r * k;
        let t = if q < 1.0 { 1.0 - q } else { 0.0 };
        let per_r = if r > 0.0 { 1.0 / r } else { 0.0 };
        Terms {
            u: (t * t) * (t * t) * (4.0 * q + 1.0),
            g: -20.0 * k * k * (t * t * t),
            h: 60.0 * k * k * k * (t * t) * per_r,
        }
    }

    /// g′ = 60 k³ t² and U‴ = 120 k³ t (1 − 2q), where |1 − 2q| ≤ 1: at most 120 k³ t (1.5 t c(1 − c²) + c³), and the bracket is at
    /// most 1 for t ≤ 1.
    #[inline(always)]
    fn third(self, r: f64) -> f64 {
        let k = self.per_support;
        let q = r * k;
        let t = if q < 1.0 { 1.0 - q } else { 0.0 };
        120.0 * k * k * k * (if t < 1.0 { t } else { 1.0 })
    }
}
