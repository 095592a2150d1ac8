//! The arithmetic of one node: value maps and Boolean combination (design §3).

use super::{BooleanOp, Family, ValueMap, ValueRule};
use crate::math::Interval;
use crate::volume::{Sample, SampleRange};

impl ValueMap {
    /// The mapped value.
    pub fn apply(&self, v: f32) -> f32 {
        match self {
            Self::Linear { scale, offset } => scale * v + offset,
            Self::Quadratic { a, b, c } => (a * v + b) * v + c,
            Self::Table(points) => interpolate(points, v),
        }
    }

    /// A conservative image of `range`.
    pub fn range(&self, range: Interval) -> Interval {
        if range.is_empty() {
            return range;
        }
        match self {
            Self::Linear { .. } => range.map_monotone(|v| self.apply(v)),
            Self::Quadratic { a, b, c } => {
                // Horner's scheme in interval arithmetic: each step rounds monotonically, so the image holds.
                let scaled = range.map_corners(Interval::point(*a), |v, a| a * v);
                let slope = scaled.map_monotone(|s| s + b);
                let product = slope.map_corners(range, |s, v| s * v);
                product.map_monotone(|p| p + c)
            }
            Self::Table(points) => {
                // A point inside an interpolated stretch may round past its ends by two operations' worth.
                let ends = Interval::new(self.apply(range.lo), self.apply(range.hi));
                let image = points
                    .iter()
                    .filter(|p| range.contains(p.0))
                    .fold(ends, |image, p| image.hull(Interval::point(p.1)));
                if image.is_point() { image } else { image.widen_ulps(4.0) }
            }
        }
    }
}

impl ValueMap {
    /// The map of a sample: an absent one stays absent.
    #[inline]
    pub fn sample(&self, s: Sample) -> Sample {
        if s.coverage > 0.0 {
            Sample {
                value: self.apply(s.value),
                ..s
            }
        } else {
            Sample::EMPTY
        }
    }
}

fn interpolate(points: &[(f32, f32)], v: f32) -> f32 {
    let after = points.partition_point(|p| p.0 <= v);
    match (after.checked_sub(1).map(|i| points[i]), points.get(after)) {
        (Some(a), Some(b)) => a.1 + (v - a.0) / (b.0 - a.0) * (b.1 - a.1),
        (Some(end), None) | (None, Some(&end)) => end.1,
        (None, None) => v,
    }
}

impl Family {
    fn or(self, c1: f32, c2: f32) -> f32 {
        match self {
            Self::MinMax => c1.max(c2),
            // c₁+c₂−c₁c₂, written so that an absent operand leaves the other's bits, and so that the order does not matter.
            Self::Product => {
                let (more, less) = (c1.max(c2), c1.min(c2));
                more + less * (1.0 - more)
            }
        }
    }

    fn and(self, c1: f32, c2: f32) -> f32 {
        match self {
            Self::MinMax => c1.min(c2),
            Self::Product => c1 * c2,
        }
    }
}

/// A Boolean operation with its value rule and coverage family: a binary node without its operands.
#[derive(Clone, Debug, PartialEq)]
pub struct Operator {
    /// The set operation.
    pub op: BooleanOp,
    /// The value where both operands are.
    pub rule: ValueRule,
    /// How coverages combine.
    pub family: Family,
}

impl Operator {
    /// The combination of two samples.
    ///
    /// Where one operand is absent the other's value is taken as it is, so a path that leaves the absent operand out gives
    /// the same bits.
    #[inline]
    pub fn apply(&self, first: Sample, second: Sample) -> Sample {
        let coverage = self.coverage(first.coverage, second.coverage);
        if coverage <= 0.0 {
            return Sample::EMPTY;
        }
        let value = match self.op {
            BooleanOp::Union => self.region_value(first, second),
            BooleanOp::Intersection => self.rule.apply(first.value, second.value),
            BooleanOp::Subtraction => first.value,
            BooleanOp::SubtractionWithRule => self.overlaid_value(first, second),
        };
        Sample { value, coverage }
    }

    pub(super) fn coverage(&self, c1: f32, c2: f32) -> f32 {
        match self.op {
            BooleanOp::Union => self.family.or(c1, c2),
            BooleanOp::Intersection => self.family.and(c1, c2),
            BooleanOp::Subtraction => self.family.and(c1, 1.0 - c2),
            BooleanOp::SubtractionWithRule => c1,
        }
    }

    /// v₁, v₂ and u weighted by how much of the point lies in the first only, the second only, and both.
    fn region_value(&self, first: Sample, second: Sample) -> f32 {
        let (c1, c2) = (first.coverage, second.coverage);
        if c1 <= 0.0 {
            return second.value;
        }
        if c2 <= 0.0 {
            return first.value;
        }
        let u = self.rule.apply(first.value, second.value);
        let alone = [(1.0 - c2) * c1, (1.0 - c1) * c2];
        weighted([(alone[0], first.value), (alone[1], second.value)], (c1 * c2, u))
    }

    /// v₁ where the second is absent, u where it is present.
    fn overlaid_value(&self, first: Sample, second: Sample) -> f32 {
        let c2 = second.coverage;
        if c2 <= 0.0 {
            return first.value;
        }
        let u = self.rule.apply(first.value, second.value);
        weighted([(1.0 - c2, first.value), (0.0, second.value)], (c2, u))
    }

    /// A conservative range of the combination.
    pub fn range(&self, first: &SampleRange, second: &SampleRange) -> SampleRange {
        let coverage = self.coverage_range(first.coverage, second.coverage);
        if coverage.hi <= 0.0 {
            return SampleRange::EMPTY;
        }
        SampleRange {
            value: self.value_range(first, second),
            coverage,
        }
    }

    fn coverage_range(&self, c1: Interval, c2: Interval) -> Interval {
        let corners = c1.map_corners(c2, |a, b| self.coverage(a, b));
        match self.family {
            Family::MinMax => corners,
            // Three roundings, which need not be monotone together.
            Family::Product if corners.is_point() => corners,
            Family::Product => corners.widen_ulps(4.0).intersect(Interval::new(0.0, 1.0)),
        }
    }

    fn value_range(&self, first: &SampleRange, second: &SampleRange) -> Interval {
        let both = self.rule.range(first.value, second.value);
        let hull = match self.op {
            BooleanOp::Intersection => return both,
            BooleanOp::Subtraction => return first.value,
            BooleanOp::SubtractionWithRule => possible(first, second).0.hull(both),
            BooleanOp::Union => {
                let (alone, second_alone) = possible(first, second);
                alone.hull(second_alone).hull(both)
            }
        };
        // Soft regions mix these values: three weights and products, four sums and a quotient, each rounded.
        let soft = |r: &SampleRange| r.coverage.hi < 1.0 || (r.coverage.lo > 0.0 && r.coverage.lo < 1.0);
        let crisp = |r: &SampleRange| r.coverage.is_point() && !soft(r);
        if hull.is_point() || (crisp(first) && crisp(second)) {
            hull
        } else {
            hull.widen_ulps(8.0)
        }
    }
}

/// The mean of the values of three regions by their weights, of which one at least is above 0. What weighs nothing has no part in
/// it, and values that are one number stay that number. Exchanging the first two changes no bit.
pub(super) fn weighted(alone: [(f32, f32); 2], both: (f32, f32)) -> f32 {
    let [first, second] = alone;
    let one = [first, second, both].into_iter().filter(|part| part.0 > 0.0);
    let mut values = one.map(|part| part.1);
    let value = values.next().unwrap_or(both.1);
    if values.all(|other| other == value) {
        return value;
    }
    let part = |(weight, value): (f32, f32)| if weight > 0.0 { weight * value } else { 0.0 };
    let mean = (part(first) + part(second) + part(both)) / (first.0 + second.0 + both.0);
    // Weights too small for their products to be precise must not lead beyond the values.
    let ends = [first, second, both].into_iter().filter(|part| part.0 > 0.0);
    let hull = ends.fold(Interval::EMPTY, |hull, part| hull.hull(Interval::point(part.1)));
    if mean < hull.lo {
        hull.lo
    } else if mean > hull.hi {
        hull.hi
    } else {
        mean
    }
}

/// The values that each operand can show where the other is not full.
fn possible(first: &SampleRange, second: &SampleRange) -> (Interval, Interval) {
    let alone = |a: &SampleRange, b: &SampleRange| {
        if b.coverage.lo >= 1.0 { Interval::EMPTY } else { a.value }
    };
    (alone(first, second), alone(second, first))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn operator() -> impl Strategy<Value = Operator> {
        let op = prop_oneof![
            Just(BooleanOp::Union),
            Just(BooleanOp::Intersection),
            Just(BooleanOp::Subtraction),
            Just(BooleanOp::SubtractionWithRule)
        ];
        let rule = prop_oneof![
            Just(ValueRule::First),
            Just(ValueRule::Second),
            Just(ValueRule::Max),
            Just(ValueRule::Min),
            Just(ValueRule::Sum),
            Just(ValueRule::Difference),
            Just(ValueRule::Product),
            Just(ValueRule::Average),
            (0.0f32..=1.0).prop_map(ValueRule::Blend),
        ];
        let family = prop_oneof![Just(Family::MinMax), Just(Family::Product)];
        (op, rule, family).prop_map(|(op, rule, family)| Operator { op, rule, family })
    }

    fn coverage() -> impl Strategy<Value = f32> {
        prop_oneof![Just(0.0f32), Just(1.0f32), 0.0f32..=1.0]
    }

    fn sample() -> impl Strategy<Value = Sample> {
        (-100.0f32..100.0, coverage()).prop_map(|(value, coverage)| {
            if coverage == 0.0 {
                Sample::EMPTY
            } else {
                Sample { value, coverage }
            }
        })
    }

    fn hull(a: Sample, b: Sample) -> SampleRange {
        let value = |s: Sample| {
            if s.coverage > 0.0 {
                Interval::point(s.value)
            } else {
                Interval::EMPTY
            }
        };
        SampleRange {
            value: value(a).hull(value(b)),
            coverage: Interval::new(a.coverage, b.coverage),
        }
    }

    proptest! {
        #[test]
        fn the_range_holds_every_combination(op in operator(), a in [sample(), sample()], b in [sample(), sample()]) {
            let range = op.range(&hull(a[0], a[1]), &hull(b[0], b[1]));
            for x in a {
                for y in b {
                    let s = op.apply(x, y);
                    prop_assert!(range.contains(s), "{op:?} {x:?} {y:?} = {s:?} not in {range:?}");
                }
            }
        }

        #[test]
        fn an_absent_operand_changes_no_bit(op in operator(), s in sample()) {
            let with_empty = op.apply(s, Sample::EMPTY);
            match op.op {
                BooleanOp::Intersection => prop_assert_eq!(with_empty, Sample::EMPTY),
                _ => prop_assert_eq!(with_empty, s),
            }
        }

        #[test]
        fn crisp_union_follows_the_paper(v1 in -9.0f32..9.0, v2 in -9.0f32..9.0) {
            let op = Operator { op: BooleanOp::Union, rule: ValueRule::Average, family: Family::MinMax };
            prop_assert_eq!(op.apply(Sample::solid(v1), Sample::EMPTY).value, v1);
            prop_assert_eq!(op.apply(Sample::EMPTY, Sample::solid(v2)).value, v2);
            prop_assert_eq!(op.apply(Sample::solid(v1), Sample::solid(v2)).value, 0.5 * v1 + 0.5 * v2);
        }

        #[test]
        fn map_ranges_hold(lo in -50.0f32..50.0, w in 0.0f32..40.0, t in 0.0f32..=1.0, a in -2.0f32..2.0, b in -2.0f32..2.0) {
            let range = Interval::new(lo, lo + w);
            let v = (lo + t * w).clamp(range.lo, range.hi);
            for map in [
                ValueMap::Linear { scale: a, offset: b },
                ValueMap::Quadratic { a, b, c: 3.0 },
                ValueMap::Table([(-20.0, a), (0.0, b), (7.0, 30.0)].into()),
            ] {
                let image = map.range(range);
                prop_assert!(image.contains(map.apply(v)), "{map:?} at {v} is {} not in {image:?}", map.apply(v));
            }
        }
    }
}
