//! Fragments blended over what is behind them, and the last step, in intervals.

use super::precision::ULP;
use super::source::Spans;
use super::span::Span;
use crate::math::Interval;
use crate::projection::Mode;
use crate::projection::TransferFunction;
use crate::projection::composite::Blending;

/// One fragment blended over `behind`, drawn between `times[0]` and `times[1]` times.
pub(super) fn blend(blending: Blending, source: &Spans, behind: &Spans, times: [u32; 2]) -> Spans {
    let mut now = *behind;
    let mut result = (times[0] == 0).then_some(now);
    for n in 1..=times[1] {
        now = once(blending, source, &now);
        if n >= times[0] {
            result = Some(result.map_or(now, |r| std::array::from_fn(|c| r[c].hull(now[c]))));
        }
    }
    result.unwrap_or(now)
}

/// A float target keeps its own precision: a rounding for each operation, either way.
fn once(blending: Blending, source: &Spans, behind: &Spans) -> Spans {
    let through = (Span::ONE - source[3]).relaxed(ULP);
    std::array::from_fn(|c| match blending {
        Blending::Over => {
            let dimmed = (through * behind[c]).relaxed(ULP);
            (source[c] + dimmed).relaxed(ULP).rounded()
        }
        Blending::Add => (source[c] + behind[c]).relaxed(ULP).rounded(),
        Blending::Max => source[c].max(behind[c]),
    })
}

/// The interval extension of [`composite::resolve`](crate::projection::composite::resolve) for one pixel.
pub(super) fn resolve(mode: Mode, accumulated: &Spans, range: Interval, transfer: &TransferFunction) -> Spans {
    if mode.classifies() {
        return *accumulated;
    }
    let [value, .., weight] = *accumulated;
    if weight.hi <= 0.0 {
        return [Span::ZERO; 4];
    }
    let fraction = match mode {
        Mode::MinIp => Span::ONE - value,
        Mode::Average => mean(value, weight),
        _ => value,
    };
    let grey = grey(fraction, range, transfer.window());
    let alpha = weight.rising(|w| w.clamp(0.0, 1.0));
    let shown = (grey * alpha).relaxed(2.0 * ULP);
    [shown, shown, shown, alpha]
}

fn mean(value: Span, weight: Span) -> Span {
    if weight.lo <= 0.0 {
        return Span::new(f64::NEG_INFINITY, f64::INFINITY);
    }
    (value * Span::new(1.0 / weight.hi, 1.0 / weight.lo)).relaxed(2.0 * ULP)
}

/// Five operations in single precision on numbers of the range's and the window's size.
fn grey(fraction: Span, range: Interval, window: Interval) -> Span {
    let [lo, width] = [range.lo, range.width()].map(f64::from);
    let window_width = f64::from(window.width().max(f32::MIN_POSITIVE));
    let shift = f64::from(window.lo);
    let size = lo.abs() + width * fraction.magnitude().min(2.0) + shift.abs();
    let rounding = 5.0 * ULP * size / window_width;
    // A mean over next to nothing may be anything, but among values that are all the same it is they.
    let value = |f: f64| if width > 0.0 { lo + f * width } else { lo };
    fraction
        .rising(|f| (value(f) - shift) / window_width)
        .widened(rounding)
        .rising(|g| g.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::ControlPoint;

    const SOURCE: Spans = [Span::new(0.25, 0.26); 4];
    const BEHIND: Spans = [Span::new(0.5, 0.5); 4];

    #[test]
    fn a_sample_that_may_be_missing_leaves_what_was_there_possible() {
        let drawn = blend(Blending::Over, &SOURCE, &BEHIND, [1, 1])[0];
        let unsure = blend(Blending::Over, &SOURCE, &BEHIND, [0, 1])[0];
        assert!(drawn.lo > 0.6 && unsure.lo == 0.5 && unsure.hi == drawn.hi);
    }

    #[test]
    fn a_sample_that_may_be_drawn_twice_may_be_denser() {
        let once = blend(Blending::Over, &SOURCE, &BEHIND, [1, 1])[0];
        let twice = blend(Blending::Over, &SOURCE, &BEHIND, [1, 2])[0];
        assert!(twice.lo == once.lo && twice.hi > once.hi + 0.05);
    }

    #[test]
    fn a_mean_over_next_to_nothing_is_a_grey_of_the_window() {
        let point = |value| ControlPoint {
            value,
            color: [1.0; 3],
            opacity: 0.5,
        };
        let transfer = TransferFunction::new(vec![point(0.0), point(100.0)], 1.0).expect("rising values");
        let accumulated = [Span::new(0.0, 0.1), Span::ZERO, Span::ZERO, Span::new(0.0, 0.2)];
        for (range, greys) in [([0.0, 100.0], [0.0, 1.0]), ([40.0, 40.0], [0.4, 0.4])] {
            let shown = resolve(
                Mode::Average,
                &accumulated,
                Interval::new(range[0], range[1]),
                &transfer,
            )[0];
            let alpha = 0.2;
            assert_eq!(shown.lo.max(0.0), 0.0, "{shown:?}");
            assert!((shown.hi - greys[1] * alpha).abs() < 1e-4, "{shown:?}");
        }
    }

    #[test]
    fn the_largest_value_is_not_rounded() {
        let behind = [Span::new(0.1, 0.3); 4];
        let max = blend(Blending::Max, &SOURCE, &behind, [1, 1])[0];
        assert_eq!(max, Span::new(0.25, 0.3));
    }
}
