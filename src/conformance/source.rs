//! What a fragment can be: the shader's steps, in intervals.

use super::field::Hull;
use super::light::LightSpans;
use super::precision::{Precision, ULP};
use super::span::Span;
use super::storage::Storage;
use super::table::TableSpans;
use crate::projection::{FrameSpec, Lens, Mode};

/// The numbers that a fragment's channels can be.
pub(super) type Spans = [Span; 4];

/// Fragments of one frame.
pub(super) struct Sources<'a> {
    spec: &'a FrameSpec<'a>,
    table: TableSpans,
    lights: Option<LightSpans>,
    storage: Storage,
    /// Error of a filtered value and of a filtered coverage: steps of the format, and of single precision.
    sum: f64,
    /// See [`FrameSpec::slab_units`].
    slab_units: Option<f64>,
    near_mm: f64,
    far_mm: f64,
}

/// Value times coverage, coverage, and their quotient, as the shader has them.
struct Filtered {
    weighted: Span,
    coverage: Span,
    fraction: Span,
}

impl<'a> Sources<'a> {
    pub(super) fn new(spec: &'a FrameSpec<'a>, storage: &Storage, precision: &Precision, depth_mm: [f64; 2]) -> Self {
        Self {
            spec,
            table: TableSpans::new(&spec.table(), precision),
            lights: spec
                .shading()
                .map(|shading| LightSpans::new(spec.camera, shading, precision)),
            storage: *storage,
            sum: precision.sum_steps * Storage::STEP + precision.sum,
            slab_units: spec.slab_units(),
            near_mm: depth_mm[0],
            far_mm: depth_mm[1],
        }
    }

    /// The fragment of a sample at `depth` on a ray of `path` millimetres a millimetre of depth.
    pub(super) fn over(&self, hull: &Hull, depth: f64, path: Span) -> Spans {
        let filtered = self.filtered(hull);
        let mode = self.spec.settings.mode;
        if !mode.classifies() {
            return accumulated(mode, &filtered, path);
        }
        let (entry, coverage) = match self.slab_units {
            Some(units) => (self.colored(hull, path.scaled(units).relaxed(2.0 * ULP)), Span::ONE),
            None => (self.classified(filtered.fraction, path), filtered.coverage),
        };
        let [r, g, b, alpha] = entry;
        let alpha_covered = (alpha * coverage).relaxed(2.0 * ULP);
        if mode == Mode::XRay {
            return [alpha_covered; 4];
        }
        let (factor, highlight) = self
            .lights
            .as_ref()
            .map_or((Span::ONE, Span::ZERO), |lights| lights.over(&hull.normal));
        let cue = self.cue(depth);
        // Three products and a sum, and the product with the cue and with the coverage.
        let lit = |c: Span| ((factor * c + highlight * alpha) * cue * coverage).relaxed(6.0 * ULP);
        [lit(r), lit(g), lit(b), alpha_covered]
    }

    fn classified(&self, fraction: Span, path: Span) -> Spans {
        let entry = self.table.over(fraction);
        match self.spec.camera.lens {
            Lens::Perspective { .. } => lengthened(&entry, path),
            Lens::Orthographic { .. } => entry,
        }
    }

    /// A filtered colour, which the shader keeps at or below its opacity, over a path of so many unit lengths.
    fn colored(&self, hull: &Hull, units: Span) -> Spans {
        let by = self.sum + self.storage.rounding;
        let alpha = hull.weighted.widened(by).not_negative();
        let below = |c: Span| {
            let c = c.widened(by).not_negative();
            Span::new(c.lo.min(alpha.lo), c.hi.min(alpha.hi))
        };
        let [r, g, b] = hull.rgb.map(below);
        lengthened(&[r, g, b, alpha], units)
    }

    fn filtered(&self, hull: &Hull) -> Filtered {
        // What is partly covered is rounded where it is stored, its value too.
        let covering = if hull.crisp { 0.0 } else { 0.5 * Storage::STEP };
        let by = self.sum + self.storage.rounding.max(covering);
        if !hull.mixed {
            let fraction = hull.weighted.widened(by);
            return Filtered {
                weighted: fraction,
                coverage: Span::ONE,
                fraction,
            };
        }
        let coverage_by = self.sum + covering;
        Filtered {
            weighted: hull.weighted.widened(by),
            coverage: hull.coverage.widened(coverage_by).not_negative(),
            fraction: quotient(hull, by, coverage_by),
        }
    }

    /// Depth, its distance from the nearest point, and the span between: three operations on rounded numbers.
    fn cue(&self, depth: f64) -> Span {
        let cue = &self.spec.settings.depth_cue;
        let span = (self.far_mm - self.near_mm).max(f64::MIN_POSITIVE);
        let farthest = self.near_mm.abs().max(self.far_mm.abs());
        let by = f64::from(cue.strength) * 6.0 * ULP * (farthest / span + 1.0);
        Span::around(cue.factor(depth, self.near_mm, self.far_mm), by + ULP)
    }
}

/// A value mode's fragment: at most a difference and a product.
fn accumulated(mode: Mode, filtered: &Filtered, path: Span) -> Spans {
    let Filtered { weighted, coverage, .. } = *filtered;
    let (value, weight) = match mode {
        Mode::MinIp => (coverage - weighted, coverage),
        Mode::Average => (weighted * path, coverage * path),
        _ => (weighted, coverage),
    };
    let value = value.widened(2.0 * ULP * (weighted.magnitude() + coverage.magnitude()));
    [value, value, value, weight.relaxed(2.0 * ULP)]
}

/// (w + e) / (c + d) for |e| ≤ `by` and |d| ≤ `coverage_by` differs from w/c by (e − (w/c)·d) / (c + d). Where the
/// denominator may be 0, anything may come out.
fn quotient(hull: &Hull, by: f64, coverage_by: f64) -> Span {
    let least = hull.coverage.lo - coverage_by;
    if least <= 0.0 {
        return Span::new(f64::NEG_INFINITY, f64::INFINITY);
    }
    let error = (by + hull.fraction.magnitude() * coverage_by) / least;
    // Vulkan lets a quotient be off by 2.5 units in the last place.
    hull.fraction.widened(error).relaxed(3.0 * ULP)
}

/// A colour for a path `path` times as long: `α' = 1 − (1−α)^path`, colour scaled by `α'/α`, which falls as α rises if `path` is
/// above 1, and else rises up to α = 1, above which rounding may bring it, and falls beyond; it always rises with `path`.
///
/// The power is `exp2(path · log2(1 − α))`. Vulkan lets log2 be off by 2⁻²¹ in [0.5, 2] and by 3 units elsewhere, and exp2
/// by 3 + 2|x| units. No colour is above its α, so an error of α' is at most as large in the colour.
fn lengthened([r, g, b, alpha]: &Spans, path: Span) -> Spans {
    let longer = |a: f64, path: f64| 1.0 - (1.0 - a).max(0.0).powf(path);
    let scale = |a: f64, path: f64| if a > 0.0 { longer(a, path) / a } else { path };
    let error = power_error(*alpha, path);
    let least = scale(alpha.hi, path.lo).min(scale(alpha.lo, path.lo));
    let opaque = 1f64.clamp(alpha.lo, alpha.hi);
    let most = [alpha.lo, opaque, alpha.hi]
        .map(|a| scale(a, path.hi))
        .into_iter()
        .fold(0.0, f64::max);
    let color = |c: Span| {
        Span::new(c.lo * least, c.hi * most)
            .widened(error)
            .relaxed(5.0 * ULP)
            .not_negative()
    };
    let opacity = Span::new(longer(alpha.lo, path.lo), longer(alpha.hi, path.hi));
    [color(*r), color(*g), color(*b), opacity.widened(error).not_negative()]
}

/// The most that 1 − (1 − α)^path is off: relative to the power the more, the smaller 1 − α is, and by no more than its largest value
/// times that. What is below 1 in single precision is so by 2⁻²⁴ at least, and the power of 0 is exact.
fn power_error(alpha: Span, path: Span) -> f64 {
    let [least, most] = [alpha.hi, alpha.lo].map(|a| (1.0 - a).clamp(0.0, 1.0));
    if most == 0.0 {
        return 0.0;
    }
    let log = least.max(0.5f64.powi(24)).log2();
    let log_error = (3.0 * ULP * log.abs()).max(0.5f64.powi(21)) + ULP;
    let exponent = path.hi * log;
    let exponent_error = path.hi * log_error + ULP * exponent.abs();
    let relative = exponent_error * std::f64::consts::LN_2 + (3.0 + 2.0 * exponent.abs()) * ULP;
    // And the difference from 1.
    most.powf(path.lo) * relative + ULP
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The span of a colour over a longer path, which holds that of a colour in between.
    fn held(alpha: f64, width: f64, shade: f64, path: f64, t: f64) -> Result<Spans, TestCaseError> {
        let spans = [shade, shade, shade, 1.0].map(|c| Span::new(alpha, alpha + width).scaled(c));
        let entry = [shade, shade, shade, 1.0].map(|c| (alpha + t * width) * c);
        let longer_alpha = 1.0 - (1.0 - entry[3]).powf(path);
        let exact = entry.map(|c| c * longer_alpha / entry[3].max(1e-300));
        let longer = lengthened(&spans, Span::around(path, 1e-3));
        for (span, c) in longer.into_iter().zip(exact) {
            prop_assert!(span.lo <= c && c <= span.hi, "{c} is not in {span:?}");
        }
        Ok(longer)
    }

    proptest! {
        #[test]
        fn a_shorter_path_of_a_member_is_in_the_shorter_path_of_the_span(
            alpha in 0.0f64..0.99,
            width in 0.0f64..0.01,
            shade in 0.0f64..=1.0,
            path in 0.05f64..1.0,
            t in 0.0f64..=1.0,
        ) {
            let shorter = held(alpha, width, shade, path, t)?;
            let end = |a: f64, by: f64| 1.0 - (1.0 - a).powf(path + by);
            // Beside the exact ends, the errors of a power whose exponent is at most 24: below 2⁻¹⁴ each.
            let exact = end(alpha + width, 1e-3) - end(alpha, -1e-3);
            prop_assert!(shorter[3].width() <= exact + 0.5f64.powi(13), "{shorter:?}");
        }

        #[test]
        fn a_longer_path_of_a_member_is_in_the_longer_path_of_the_span(
            alpha in 0.0f64..0.99,
            width in 0.0f64..0.01,
            shade in 0.0f64..=1.0,
            path in 1.0f64..1.5,
            t in 0.0f64..=1.0,
        ) {
            let longer = held(alpha, width, shade, path, t)?;
            prop_assert!(longer[3].width() < 2.0 * width + 1e-2);
        }

        /// An opaque colour is itself over any path, whatever rounding adds to it and to its opacity.
        #[test]
        fn an_opaque_colour_is_in_the_other_path_of_the_span(
            width_log2 in -18.0f64..-6.0,
            shade in 0.0f64..0.9,
            path in 0.05f64..1.5,
            t in 0.0f64..=1.0,
        ) {
            let width = width_log2.exp2();
            let color = Span::new(shade, shade + width);
            let alpha = Span::new(1.0 - t * width, 1.0 + (1.0 - t) * width);
            let longer = lengthened(&[color, color, color, alpha], Span::point(path));
            prop_assert!(longer[0].lo <= color.lo && longer[0].hi >= color.hi, "{longer:?}");
        }
    }
}
