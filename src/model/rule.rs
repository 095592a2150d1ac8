//! Value rules: what `u(v₁, v₂)` is, and what it can be (VCSG §2.3).

use super::{Kind, ValueRule};
use crate::math::Interval;

impl ValueRule {
    /// `u(v₁, v₂)`.
    #[inline]
    pub fn apply(&self, v1: f32, v2: f32) -> f32 {
        match self {
            Self::First => v1,
            Self::Second => v2,
            Self::Max => v1.max(v2),
            Self::Min => v1.min(v2),
            Self::Sum => v1 + v2,
            Self::Difference => v1 - v2,
            Self::Product => v1 * v2,
            Self::Average => 0.5 * v1 + 0.5 * v2,
            Self::Blend(t) => t * v1 + (1.0 - t) * v2,
            Self::AlgebraicSum => (v1 + v2) - v1 * v2,
            Self::AbsoluteDifference => (v1 - v2).abs(),
            Self::Quotient => v1 / v2,
            Self::Table(lut) => lut.at(v1, v2),
            Self::Over | Self::Plus | Self::In | Self::Out | Self::Atop | Self::Xor => self.blend([v1], [v2])[0],
        }
    }

    /// Whether `u(v₁, v₂)` is `u(v₂, v₁)`, bit for bit.
    pub fn is_symmetric(&self) -> bool {
        matches!(
            self,
            Self::Max
                | Self::Min
                | Self::Sum
                | Self::Product
                | Self::Average
                | Self::AlgebraicSum
                | Self::AbsoluteDifference
        )
    }

    /// Whether the rule combines samples of a kind.
    pub fn is_for(&self, kind: Kind) -> bool {
        let of_colors = matches!(
            self,
            Self::Over | Self::Plus | Self::In | Self::Out | Self::Atop | Self::Xor
        );
        match self {
            Self::First | Self::Second => true,
            _ => of_colors == (kind == Kind::Color),
        }
    }

    /// A conservative image of two ranges. Most rules are monotone in each argument, so that corners tell it exactly.
    pub fn range(&self, r1: Interval, r2: Interval) -> Interval {
        let corners = r1.map_corners(r2, |a, b| self.apply(a, b));
        // Corners may round alike where what lies between them does not.
        let is_exact = r1.is_point() && r2.is_point();
        match self {
            Self::Table(lut) => lut.range(r1, r2),
            Self::AbsoluteDifference if !r1.intersect(r2).is_empty() => corners.hull(Interval::point(0.0)),
            Self::Quotient if r2.contains(0.0) && !r1.is_empty() => Interval::ALL,
            Self::AlgebraicSum if !is_exact => widened_by_terms(corners, r1, r2),
            Self::Over | Self::In | Self::Out | Self::Atop | Self::Xor if !is_exact => {
                widened_by_terms(corners, r1, r2)
            }
            _ => corners,
        }
    }
}

/// A range of v₁ + v₂ − v₁·v₂, whose three roundings are of its terms and need not be monotone together.
fn widened_by_terms(range: Interval, r1: Interval, r2: Interval) -> Interval {
    let size = |r: Interval| r.lo.abs().max(r.hi.abs());
    let terms = size(r1) + size(r2) + size(r1) * size(r2);
    let slack = terms * (2.0 * f32::EPSILON);
    let (lo, hi) = (range.lo - slack, range.hi + slack);
    // Of endless terms nothing is known.
    if lo.is_nan() || hi.is_nan() {
        return Interval::ALL;
    }
    Interval { lo, hi }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn unequal_rules() -> Vec<ValueRule> {
        vec![
            ValueRule::Sum,
            ValueRule::Difference,
            ValueRule::AlgebraicSum,
            ValueRule::AbsoluteDifference,
            ValueRule::Quotient,
            ValueRule::Average,
        ]
    }

    proptest! {
        #[test]
        fn images_of_ranges_hold(
            rule in prop::sample::select(unequal_rules()),
            at in [-9.0f32..9.0, -9.0f32..9.0],
            by in [0.0f32..6.0, 0.0f32..6.0],
            part in [0.0f32..=1.0, 0.0f32..=1.0],
        ) {
            let range = |n: usize| Interval::new(at[n], at[n] + by[n]);
            let inside = |n: usize| (at[n] + part[n] * by[n]).clamp(range(n).lo, range(n).hi);
            let (value, image) = (rule.apply(inside(0), inside(1)), rule.range(range(0), range(1)));
            prop_assert!(image.contains(value), "{rule:?} gives {value}, not in {image:?}");
        }
    }

    #[test]
    fn a_quotient_is_bounded_away_from_zero_alone() {
        let over = |lo, hi| ValueRule::Quotient.range(Interval::new(1.0, 4.0), Interval::new(lo, hi));
        assert_eq!(over(2.0, 4.0), Interval::new(0.25, 2.0));
        assert_eq!(over(-1.0, 4.0), Interval::ALL);
    }

    #[test]
    fn densities_unite_as_fuzzy_sets() {
        assert_eq!(ValueRule::AlgebraicSum.apply(0.5, 0.5), 0.75);
        assert_eq!(ValueRule::AlgebraicSum.apply(1.0, 0.25), 1.0);
    }
}
