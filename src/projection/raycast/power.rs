//! Opacities over longer paths.
//!
//! *Theory.* What is let through by a path is a power of what is let through by its part: `1 − α' = (1 − α)^length`.
//! *Practice.* The power is `exp2(length · log2(1 − α))`, both by series of which the first term that is left out is less than rounding. What
//! exp2 is less than 1 by is summed up as such: an opacity is not rounded once more where it is next to nothing.

use std::f32::consts::{LN_2, LOG2_E};

use super::blend::Colours;
use super::simd::{Simd, larger, smaller};

/// The least that is let through; all that is less is nothing beside 1.
const LEAST: f32 = f32::MIN_POSITIVE;

/// Its logarithm.
const LEAST_POWER: f32 = f32::MIN_EXP as f32 - 1.0;

/// The bits of 1, and of √½.
const ONE_BITS: i32 = 1f32.to_bits() as i32;
const ROOT_HALF_BITS: i32 = std::f32::consts::FRAC_1_SQRT_2.to_bits() as i32;

/// Bits of a number's fraction.
const FRACTION_BITS: i32 = 23;

/// `2/ln 2 · 1/(2n + 1)`: log2 is the sum of these times odd powers of `(m − 1)/(m + 1)`.
const LOG2_SERIES: [f32; 5] = {
    let mut series = [0.0; 5];
    let mut n = 0;
    while n < 5 {
        series[n] = 2.0 * LOG2_E / (2 * n + 1) as f32;
        n += 1;
    }
    series
};

/// `ln 2ⁿ/n!` from 1 on: exp2 is 1 and the sum of these times powers of its exponent.
const EXP2_SERIES: [f32; 7] = {
    let mut series = [LN_2; 7];
    let mut n = 1;
    while n < 7 {
        series[n] = series[n - 1] * LN_2 / (n + 1) as f32;
        n += 1;
    }
    series
};

/// Premultiplied colours for paths of such `lengths`, from 0 on: see [`lengthened`](crate::projection::table::lengthened).
#[inline(always)]
pub fn lengthen<S: Simd>([r, g, b, a]: &Colours<S>, lengths: S::Float) -> Colours<S> {
    let (zero, one) = (S::float(0.0), S::float(1.0));
    // An opacity that rounding has brought above 1 is 1.
    let through = larger::<S>(one - *a, S::float(LEAST));
    let longer = less_than_one::<S>(lengths * log2::<S>(through));
    let shows = S::greater(*a, zero);
    let scale = S::choose(shows, S::divide(longer, S::choose(shows, *a, one)), one);
    [*r * scale, *g * scale, *b * scale, S::choose(shows, longer, *a)]
}

/// The logarithm of numbers from [`LEAST`] to 1.
#[inline(always)]
fn log2<S: Simd>(x: S::Float) -> S::Float {
    let bits = S::to_bits(x);
    // The power of two by which what is left of it is between √½ and √2.
    let biased = S::shift_right(bits + S::int(ONE_BITS - ROOT_HALF_BITS), S::int(FRACTION_BITS));
    let power = biased - S::int(ONE_BITS >> FRACTION_BITS);
    let m = S::from_bits(bits - power * S::int(1 << FRACTION_BITS));
    let t = S::divide(m - S::float(1.0), m + S::float(1.0));
    S::to_float(power) + t * series::<S, 5>(&LOG2_SERIES, t * t)
}

/// What `exp2(x)` is less than 1 by, for x up to 0.
#[inline(always)]
fn less_than_one<S: Simd>(x: S::Float) -> S::Float {
    let x = smaller::<S>(larger::<S>(x, S::float(LEAST_POWER)), S::float(0.0));
    let power = S::whole(x);
    let f = x - S::to_float(power);
    let whole = S::from_bits(power * S::int(1 << FRACTION_BITS) + S::int(ONE_BITS));
    (S::float(1.0) - whole) - whole * (f * series::<S, 7>(&EXP2_SERIES, f))
}

/// The sum of numbers times powers of `x`.
#[inline(always)]
fn series<S: Simd, const LEN: usize>(of: &[f32; LEN], x: S::Float) -> S::Float {
    let mut sum = S::float(of[LEN - 1]);
    for n in (0..LEN - 1).rev() {
        sum = S::float(of[n]) + x * sum;
    }
    sum
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::simd::{Portable, RAYS};
    use super::*;

    /// A step of single precision at 1.
    const ULP: f64 = f32::EPSILON as f64;

    fn lengthened(colour: [f32; 4], length: f32) -> [f32; 4] {
        let longer = lengthen::<Portable>(&colour.map(Portable::float), Portable::float(length));
        let all = Portable::side_by_side(longer);
        assert_eq!(all, [all[0]; RAYS]);
        all[0]
    }

    proptest! {
        /// Beside the rounding of 1 − α, which is exact here: log2 and its product with the length are off by 4 units, which are as many more of the
        /// power as its logarithm is large, exp2 by 2, and the difference from 1 by one; each sum and product of a series by half.
        #[test]
        fn powers_are_those_of_double_precision(
            through in prop_oneof![0f32..=1.0, 0.999f32..=1.0, 0f32..1e-6],
            length in prop_oneof![Just(1f32), 0f32..=4.0, 0f32..1e6],
        ) {
            let opacity = 1.0 - through;
            let exact = (1.0 - f64::from(opacity)).powf(f64::from(length));
            let [colour, .., longer] = lengthened([0.5 * opacity, 0.0, 0.0, opacity], length);
            let logarithm = exact.max(f64::from(LEAST)).log2();
            let error = exact * (4.0 * logarithm.abs() + 4.0) * ULP + 2.0 * ULP;
            prop_assert!((f64::from(longer) - (1.0 - exact)).abs() <= error, "{longer} for {}", 1.0 - exact);
            prop_assert!((f64::from(colour) - 0.5 * f64::from(longer)).abs() <= ULP);
        }
    }

    #[test]
    fn nothing_stays_nothing_and_what_is_opaque_is_so_over_any_path() {
        for length in [0.25, 1.0, 7.5, 1e9] {
            assert_eq!(lengthened([0.0; 4], length), [0.0; 4]);
            let opaque = [0.5, 0.25, 1.0, 1.0];
            assert_eq!(lengthened(opaque, length), opaque);
        }
    }
}
