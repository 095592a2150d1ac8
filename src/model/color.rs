//! Colours: samples that are classified before they are combined, and how two of them are (VCSG §2.3).
//!
//! *Theory.* For volumes of colours the function u is an operator of image compositing \[PD84\]: over, plus, in, out, atop, xor.
//! *Changes from the paper.* A colour has a coverage like a value, and the set operations say where it is; the operators act where
//! both are. The opacity that they act on is that over one unit length, the shortest which the scene's transfer functions
//! state, so that what a model is does not depend on how finely it is sampled.
//! *Practice.* A colour is premultiplied, and its opacity takes a value's place: whatever is asked about values, ranges of blocks,
//! gradients and surfaces among it, is answered for opacities.

use std::sync::Arc;

use super::combine::weighted;
use super::{BooleanOp, Operator, TransferFunction, Tree, ValueRule};
use crate::math::Interval;
use crate::volume::Sample;

/// A colour at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorSample {
    /// The opacity over one unit length as value, and the coverage.
    pub sample: Sample,
    /// Display-referred red, green and blue times the opacity: none is above it.
    pub rgb: [f32; 3],
}

impl ColorSample {
    /// Nothing is there.
    pub const EMPTY: Self = Self::of_value(Sample::EMPTY);

    /// A value, without colour.
    pub const fn of_value(sample: Sample) -> Self {
        Self { sample, rgb: [0.0; 3] }
    }

    /// Colour times coverage: what is filtered.
    pub fn premultiplied_rgb(&self) -> [f32; 3] {
        self.rgb.map(|c| c * self.sample.coverage)
    }

    fn rgba(&self) -> [f32; 4] {
        let [r, g, b] = self.rgb;
        [r, g, b, self.sample.value]
    }
}

/// Makes colours of values.
#[derive(Clone, Debug, PartialEq)]
pub struct Classifier {
    pub(super) transfer: Arc<TransferFunction>,
    /// The unit length of the tree's colours over that of the function.
    pub(super) units: f64,
}

impl Classifier {
    /// The classifier by `transfer` for a tree whose opacities hold for `unit_mm`.
    pub fn new(transfer: Arc<TransferFunction>, unit_mm: f64) -> Self {
        Self {
            units: unit_mm / transfer.unit_mm(),
            transfer,
        }
    }

    /// The colour of a sample; an absent one has none.
    pub fn apply(&self, s: Sample) -> ColorSample {
        if s.coverage <= 0.0 {
            return ColorSample::EMPTY;
        }
        let (rgb, opacity) = self.transfer.evaluate(s.value);
        // What overflow made no number shows nothing.
        let value = if s.value.is_nan() { 0.0 } else { self.over_unit(opacity) };
        ColorSample {
            sample: Sample { value, ..s },
            // Linear interpolation of colours up to 1 may round beyond.
            rgb: rgb.map(|c| c.clamp(0.0, 1.0) * value),
        }
    }

    fn over_unit(&self, opacity: f32) -> f32 {
        let opacity = opacity.clamp(0.0, 1.0);
        if self.units == 1.0 {
            return opacity;
        }
        (1.0 - (1.0 - f64::from(opacity)).powf(self.units)) as f32
    }

    /// The opacities of values in `range`: they rise and fall between control points alone.
    pub fn range(&self, range: Interval) -> Interval {
        if range.is_empty() {
            return range;
        }
        let opacity = |value: f32| self.over_unit(self.transfer.evaluate(value).1);
        let points = self.transfer.points().iter();
        let inner = points
            .filter(|p| range.contains(p.value))
            .map(|p| self.over_unit(p.opacity));
        let ends = Interval::new(opacity(range.lo), opacity(range.hi));
        let mut hull = inner.map(Interval::point).fold(ends, Interval::hull);
        if !(range.lo.is_finite() && range.hi.is_finite()) {
            // Values that overflow may be no numbers.
            hull = hull.hull(Interval::point(0.0));
        }
        // A step between two points of one value is one of them; a difference, a product and a sum round between others, and a
        // power in double precision once more.
        if hull.is_point() {
            hull
        } else {
            hull.widen_ulps(4.0).intersect(Interval::new(0.0, 1.0))
        }
    }
}

impl Tree {
    /// Classifier `index` of a [`Step::Classify`](super::Step::Classify).
    pub fn classifier(&self, index: u32) -> &Classifier {
        &self.classifiers.parts()[index as usize]
    }

    /// The length that the opacities of a tree of colours hold for, millimetres; `None` for a tree of values.
    pub fn color_unit_mm(&self) -> Option<f64> {
        self.color_unit_mm
    }

    /// Whether samples are colours.
    pub fn has_colors(&self) -> bool {
        self.color_unit_mm.is_some()
    }
}

impl ValueRule {
    /// How much of the first and of the second colour shows where both are, for their opacities (Porter and Duff 1984).
    fn shares(&self, a1: f32, a2: f32) -> [f32; 2] {
        match self {
            Self::Over => [1.0, 1.0 - a1],
            Self::Plus => [1.0, 1.0],
            Self::In => [a2, 0.0],
            Self::Out => [1.0 - a2, 0.0],
            Self::Atop => [a2, 1.0 - a1],
            Self::Xor => [1.0 - a2, 1.0 - a1],
            Self::Second => [0.0, 1.0],
            // Rules of values are not for colours (see `ValueRule::is_for`); the first is as good as any.
            _ => [1.0, 0.0],
        }
    }

    /// u of two premultiplied colours whose last channel is the opacity.
    pub(super) fn blend<const N: usize>(&self, first: [f32; N], second: [f32; N]) -> [f32; N] {
        let [f1, f2] = self.shares(first[N - 1], second[N - 1]);
        std::array::from_fn(|c| (f1 * first[c] + f2 * second[c]).min(1.0))
    }
}

impl Operator {
    /// The combination of two colours: as of values, channel by channel.
    pub fn blend(&self, first: &ColorSample, second: &ColorSample) -> ColorSample {
        let (c1, c2) = (first.sample.coverage, second.sample.coverage);
        let coverage = self.coverage(c1, c2);
        if coverage <= 0.0 {
            return ColorSample::EMPTY;
        }
        let [r, g, b, opacity] = self.colour(first, second);
        ColorSample {
            sample: Sample {
                value: opacity,
                coverage,
            },
            rgb: [r, g, b].map(|c| c.min(opacity)),
        }
    }

    fn colour(&self, first: &ColorSample, second: &ColorSample) -> [f32; 4] {
        let (c1, c2) = (first.sample.coverage, second.sample.coverage);
        let (one, other) = (first.rgba(), second.rgba());
        let alone = match self.op {
            BooleanOp::Subtraction => return one,
            BooleanOp::Intersection => return self.rule.blend(one, other),
            _ if c2 <= 0.0 => return one,
            BooleanOp::Union if c1 <= 0.0 => return other,
            BooleanOp::Union => [(1.0 - c2) * c1, (1.0 - c1) * c2],
            BooleanOp::SubtractionWithRule => [1.0 - c2, 0.0],
        };
        let both = if self.op == BooleanOp::Union { c1 * c2 } else { c2 };
        let u = self.rule.blend(one, other);
        std::array::from_fn(|c| weighted([(alone[0], one[c]), (alone[1], other[c])], (both, u[c])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{ControlPoint, Family};
    use crate::volume::SampleRange;
    use proptest::prelude::*;

    const RULES: [ValueRule; 8] = [
        ValueRule::First,
        ValueRule::Second,
        ValueRule::Over,
        ValueRule::Plus,
        ValueRule::In,
        ValueRule::Out,
        ValueRule::Atop,
        ValueRule::Xor,
    ];

    fn operator() -> impl Strategy<Value = Operator> {
        let ops = [
            BooleanOp::Union,
            BooleanOp::Intersection,
            BooleanOp::Subtraction,
            BooleanOp::SubtractionWithRule,
        ];
        let family = prop::sample::select(vec![Family::MinMax, Family::Product]);
        (
            prop::sample::select(ops.to_vec()),
            prop::sample::select(RULES.to_vec()),
            family,
        )
            .prop_map(|(op, rule, family)| Operator { op, rule, family })
    }

    fn color() -> impl Strategy<Value = ColorSample> {
        let unit = || prop_oneof![Just(0.0f32), Just(1.0f32), 0.0f32..=1.0];
        (unit(), unit(), [unit(), unit(), unit()]).prop_map(|(value, coverage, rgb)| match coverage {
            0.0 => ColorSample::EMPTY,
            _ => ColorSample {
                sample: Sample { value, coverage },
                rgb: rgb.map(|c| c * value),
            },
        })
    }

    #[test]
    fn the_operators_are_porter_and_duffs() {
        let solid = |rgb, value| ColorSample {
            sample: Sample::solid(value),
            rgb,
        };
        let (red, blue) = (solid([0.5, 0.0, 0.0], 0.5), solid([0.0, 0.0, 0.25], 0.25));
        let by = |rule| {
            let union = Operator {
                op: BooleanOp::Union,
                rule,
                family: Family::MinMax,
            };
            union.blend(&red, &blue).rgba()
        };
        assert_eq!(by(ValueRule::Over), [0.5, 0.0, 0.125, 0.625]);
        assert_eq!(by(ValueRule::Plus), [0.5, 0.0, 0.25, 0.75]);
        assert_eq!(by(ValueRule::In), [0.125, 0.0, 0.0, 0.125]);
        assert_eq!(by(ValueRule::Out), [0.375, 0.0, 0.0, 0.375]);
        assert_eq!(by(ValueRule::Atop), [0.125, 0.0, 0.125, 0.25]);
        assert_eq!(by(ValueRule::Xor), [0.375, 0.0, 0.125, 0.5]);
    }

    proptest! {
        #[test]
        fn no_colour_is_above_its_opacity(op in operator(), a in color(), b in color()) {
            let c = op.blend(&a, &b);
            prop_assert!((0.0..=1.0).contains(&c.sample.value) && (0.0..=1.0).contains(&c.sample.coverage), "{c:?}");
            prop_assert!(c.rgb.iter().all(|channel| (0.0..=c.sample.value).contains(channel)), "{c:?}");
        }

        #[test]
        fn an_opacity_is_what_its_value_is_combined_to(op in operator(), a in color(), b in color()) {
            let (c, v) = (op.blend(&a, &b), op.apply(a.sample, b.sample));
            prop_assert_eq!(c.sample, v);
            let point = |s: Sample| SampleRange {
                value: if s.coverage > 0.0 { Interval::point(s.value) } else { Interval::EMPTY },
                coverage: Interval::point(s.coverage),
            };
            prop_assert!(op.range(&point(a.sample), &point(b.sample)).contains(v));
        }

        #[test]
        fn an_absent_colour_changes_no_bit(op in operator(), a in color()) {
            match op.op {
                BooleanOp::Intersection => prop_assert_eq!(op.blend(&a, &ColorSample::EMPTY), ColorSample::EMPTY),
                _ => prop_assert_eq!(op.blend(&a, &ColorSample::EMPTY), a),
            }
        }

        #[test]
        fn ranges_of_opacities_hold(lo in -20.0f32..120.0, width in 0.0f32..90.0, t in 0.0f32..=1.0, unit in 0.2f64..3.0) {
            let point = |value, opacity| ControlPoint { value, opacity, color: [1.0, 0.3, 0.6] };
            let points = vec![point(0.0, 0.1), point(40.0, 0.9), point(40.0, 0.0), point(100.0, 1.0)];
            let transfer = TransferFunction::new(points, 2.0).expect("rising values");
            let classifier = Classifier::new(Arc::new(transfer), unit);
            let range = Interval::new(lo, lo + width);
            let value = (lo + t * width).clamp(range.lo, range.hi);
            let c = classifier.apply(Sample::solid(value));
            let image = classifier.range(range);
            prop_assert!(image.contains(c.sample.value), "{c:?} is not in {image:?}");
        }
    }
}
