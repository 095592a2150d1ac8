//! Interval arithmetic in double precision.
//!
//! *Practice.* An operation in `f64` is off by at most 2⁻⁵³ of its result, and a bound is the outcome of some hundred of
//! them; each span is widened by 2⁻⁴⁰ of its size where it is made ([`Span::rounded`]), which holds them all and is far
//! below the 2⁻²³ of the device's own arithmetic.

/// A closed interval `[lo, hi]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Lower end.
    pub lo: f64,
    /// Upper end.
    pub hi: f64,
}

impl Span {
    /// The interval that holds nothing, from which hulls begin.
    pub const EMPTY: Self = Self {
        lo: f64::INFINITY,
        hi: f64::NEG_INFINITY,
    };

    /// Any number.
    pub const ALL: Self = Self {
        lo: f64::NEG_INFINITY,
        hi: f64::INFINITY,
    };

    /// Only 0.
    pub const ZERO: Self = Self::point(0.0);

    /// Only 1.
    pub const ONE: Self = Self::point(1.0);

    /// From `lo` to `hi`.
    pub const fn new(lo: f64, hi: f64) -> Self {
        Self { lo, hi }
    }

    /// Only `v`.
    pub const fn point(v: f64) -> Self {
        Self { lo: v, hi: v }
    }

    /// Everything within `by` of `v`.
    pub fn around(v: f64, by: f64) -> Self {
        Self::new(v - by, v + by)
    }

    /// `hi − lo`.
    pub fn width(self) -> f64 {
        self.hi - self.lo
    }

    /// The largest magnitude.
    pub fn magnitude(self) -> f64 {
        self.lo.abs().max(self.hi.abs())
    }

    /// The smallest interval that holds both.
    #[must_use]
    pub fn hull(self, other: Self) -> Self {
        Self::new(self.lo.min(other.lo), self.hi.max(other.hi))
    }

    /// With `v` in it.
    #[must_use]
    pub fn with(self, v: f64) -> Self {
        Self::new(self.lo.min(v), self.hi.max(v))
    }

    /// Moved outwards by `by` at both ends.
    #[must_use]
    pub fn widened(self, by: f64) -> Self {
        Self::new(self.lo - by, self.hi + by)
    }

    /// Widened by `part` of its magnitude.
    #[must_use]
    pub fn relaxed(self, part: f64) -> Self {
        self.widened(part * self.magnitude())
    }

    /// Widened for the rounding of this module's own arithmetic.
    #[must_use]
    pub fn rounded(self) -> Self {
        self.relaxed(ROUNDING)
    }

    /// The image under a rising function.
    #[must_use]
    pub fn rising(self, f: impl Fn(f64) -> f64) -> Self {
        Self::new(f(self.lo), f(self.hi))
    }

    /// The values that are not below 0; 0 if all are.
    #[must_use]
    pub fn not_negative(self) -> Self {
        self.rising(|v| v.max(0.0))
    }

    /// The image under the absolute value.
    #[must_use]
    pub fn abs(self) -> Self {
        let crosses = self.lo < 0.0 && self.hi > 0.0;
        let least = self.lo.abs().min(self.hi.abs());
        Self::new(if crosses { 0.0 } else { least }, self.magnitude())
    }

    /// The image under the square.
    #[must_use]
    pub fn squared(self) -> Self {
        self.abs().rising(|v| v * v)
    }

    /// Times a number.
    #[must_use]
    pub fn scaled(self, by: f64) -> Self {
        let (a, b) = (self.lo * by, self.hi * by);
        Self::new(a.min(b), a.max(b))
    }

    /// The larger of a number from each.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self::new(self.lo.max(other.lo), self.hi.max(other.hi))
    }
}

/// See the module head.
const ROUNDING: f64 = 1.0 / (1u64 << 40) as f64;

impl std::ops::Add for Span {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::new(self.lo + other.lo, self.hi + other.hi)
    }
}

impl std::ops::Sub for Span {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self::new(self.lo - other.hi, self.hi - other.lo)
    }
}

impl std::ops::Mul for Span {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let products = [
            self.lo * other.lo,
            self.lo * other.hi,
            self.hi * other.lo,
            self.hi * other.hi,
        ];
        products.into_iter().fold(Self::EMPTY, Self::with)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn span_and_member() -> impl Strategy<Value = (Span, f64)> {
        (-2.0f64..2.0, 0.0f64..2.0, 0.0f64..=1.0).prop_map(|(lo, width, t)| (Span::new(lo, lo + width), lo + t * width))
    }

    fn holds(span: Span, v: f64) -> bool {
        let span = span.rounded().widened(1e-15);
        span.lo <= v && v <= span.hi
    }

    proptest! {
        #[test]
        fn results_hold_the_results_of_members((a, x) in span_and_member(), (b, y) in span_and_member()) {
            prop_assert!(holds(a + b, x + y));
            prop_assert!(holds(a - b, x - y));
            prop_assert!(holds(a * b, x * y));
            prop_assert!(holds(a.abs(), x.abs()));
            prop_assert!(holds(a.squared(), x * x));
            prop_assert!(holds(a.scaled(-1.5), x * -1.5));
            prop_assert!(holds(a.max(b), x.max(y)));
            prop_assert!(holds(a.not_negative(), x.max(0.0)));
        }
    }
}
