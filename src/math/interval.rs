//! Closed intervals of values, for conservative ranges.

/// A closed interval `[lo, hi]` of `f32` values; empty when `lo > hi`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Smallest value.
    pub lo: f32,
    /// Largest value.
    pub hi: f32,
}

impl Interval {
    /// The interval that holds nothing.
    pub const EMPTY: Self = Self {
        lo: f32::INFINITY,
        hi: f32::NEG_INFINITY,
    };

    /// All values.
    pub const ALL: Self = Self {
        lo: f32::NEG_INFINITY,
        hi: f32::INFINITY,
    };

    /// The interval between two values, in either order.
    pub fn new(a: f32, b: f32) -> Self {
        Self {
            lo: a.min(b),
            hi: a.max(b),
        }
    }

    /// The interval of one value.
    pub const fn point(v: f32) -> Self {
        Self { lo: v, hi: v }
    }

    /// Whether no value lies in it.
    pub fn is_empty(self) -> bool {
        self.lo > self.hi
    }

    /// Whether it holds exactly one value.
    pub fn is_point(self) -> bool {
        self.lo == self.hi
    }

    /// `hi - lo`; negative when empty.
    pub fn width(self) -> f32 {
        self.hi - self.lo
    }

    /// Whether `v` lies in it.
    pub fn contains(self, v: f32) -> bool {
        self.lo <= v && v <= self.hi
    }

    /// Whether every value of `other` lies in it.
    pub fn encloses(self, other: Self) -> bool {
        other.is_empty() || (self.lo <= other.lo && other.hi <= self.hi)
    }

    /// The smallest interval that holds both.
    pub fn hull(self, other: Self) -> Self {
        Self {
            lo: self.lo.min(other.lo),
            hi: self.hi.max(other.hi),
        }
    }

    /// The values in both.
    pub fn intersect(self, other: Self) -> Self {
        Self {
            lo: self.lo.max(other.lo),
            hi: self.hi.min(other.hi),
        }
    }

    /// The hull of `f` at both ends: the exact image under a monotone `f`.
    pub fn map_monotone(self, f: impl Fn(f32) -> f32) -> Self {
        self.map_corners(Self::point(0.0), |v, _| f(v))
    }

    /// The hull of `f` at the four corners of `self × other`: the exact image when `f` is monotone in each argument
    /// (in either direction, which may depend on the other argument).
    pub fn map_corners(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        if self.is_empty() || other.is_empty() {
            return Self::EMPTY;
        }
        let corners = [
            f(self.lo, other.lo),
            f(self.lo, other.hi),
            f(self.hi, other.lo),
            f(self.hi, other.hi),
        ];
        // An indeterminate corner (0·∞, ∞−∞) says nothing, so nothing is known.
        if corners.iter().any(|c| c.is_nan()) {
            return Self::ALL;
        }
        corners.into_iter().map(Self::point).fold(Self::EMPTY, Self::hull)
    }

    /// Widened outwards by `ulps` units of rounding of its largest magnitude, so that it also holds what a short chain of
    /// rounded `f32` operations makes of its values.
    pub fn widen_ulps(self, ulps: f32) -> Self {
        if self.is_empty() {
            return self;
        }
        let slack = self.lo.abs().max(self.hi.abs()) * f32::EPSILON * ulps;
        Self {
            lo: self.lo - slack,
            hi: self.hi + slack,
        }
    }
}
