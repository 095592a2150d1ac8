//! What a frame may lack that does not draw what is hidden.
//!
//! *Theory.* With F all that is in front and R what is left out, the whole is F + (1 − F's alpha)·R, and R is left out only
//! where less than one part in [`HIDES_ALL_BUT`] passes F. So a channel is short of the whole by at most that part of R. No
//! alpha is above 1, and no colour above its alpha times L, the brightest light.
//!
//! Slices in bands are blended from the nearest on, not from the farthest, so they round otherwise. Let each of the three operations
//! of `A + (1 − A)·a` be off by the part u of its result, and A by e before it. After it A is off by at most `(1 − a)·e + r`, where
//! `r = u·A + 2u·(1 − A)·a`. The r of n samples add up to at most (n + 2)·u·A, with A as it ends, and so do e, and the sum of all
//! `a·e`: what does not pass on of an error has been counted once. A colour C is off by the sum of `e·c`, c at most L·a, and by its
//! own r: together by (n + 2)·u·(C + L·A). What is left out may have been let through by an A that is off by e, which is L·e more.

use super::precision::ULP;
use super::source::Spans;
use super::span::Span;
use crate::interface::HIDES_ALL_BUT;
use crate::projection::{FrameSpec, Shading};

/// The bounds of a frame that is drawn in bands, or in one.
pub(super) struct Hiding {
    /// The most that each channel may be in parts of its alpha.
    brightest: [f64; 4],
    in_bands: bool,
}

/// The most of what is behind that passes what hides it.
const PASSES: f64 = 1.0 / HIDES_ALL_BUT as f64;

impl Hiding {
    /// For a frame of `bands` bands.
    pub(super) fn new(spec: &FrameSpec, bands: usize) -> Self {
        let color = spec.shading().map_or(1.0, brightest);
        Self {
            brightest: [color, color, color, 1.0],
            in_bands: bands > 1,
        }
    }

    /// What a pixel of at most so many samples may be of which the whole is in `whole`.
    pub(super) fn of(&self, whole: &Spans, samples: u32) -> Spans {
        if !self.in_bands {
            return *whole;
        }
        // One more for what is of second order.
        let rounding = f64::from(samples + 3) * ULP;
        let alpha = whole[3].magnitude();
        let turned: Spans = std::array::from_fn(|c| {
            let most = whole[c].magnitude() + 2.0 * self.brightest[c] * alpha;
            whole[c].widened(rounding * most)
        });
        let may_end = turned[3].hi >= 1.0 - PASSES;
        std::array::from_fn(|c| match may_end {
            true => Span::new(turned[c].lo - PASSES * self.brightest[c], turned[c].hi),
            false => turned[c],
        })
    }
}

/// The most light that any normal sends back, in parts of a colour and its alpha.
fn brightest(shading: &Shading) -> f64 {
    let material = &shading.material;
    let intensity: f64 = shading.lights.iter().map(|light| f64::from(light.intensity)).sum();
    1.0 + f64::from(material.ambient) + f64::from(material.diffuse + material.specular) * intensity
}

#[cfg(test)]
mod tests {
    use super::*;

    const HIDING: Hiding = Hiding {
        brightest: [2.0, 2.0, 2.0, 1.0],
        in_bands: true,
    };

    #[test]
    fn only_what_may_be_opaque_may_lack_something() {
        let [.., thin] = HIDING.of(&[Span::point(0.5); 4], 10);
        assert!(thin.width() < 1e-5, "{thin:?}");
        let [red, .., alpha] = HIDING.of(&[Span::point(0.5), Span::ZERO, Span::ZERO, Span::point(0.9995)], 10);
        assert!((red.width() - 2.0 * PASSES).abs() < 2e-5 && (alpha.width() - PASSES).abs() < 2e-5);
    }

    /// One ray in single precision, from the nearest sample on, is as far from the exact sum as derived, and not always exact.
    #[test]
    fn blending_from_the_nearest_on_rounds_as_derived() {
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let mut differing = 0;
        for ray in 0..400u32 {
            let thin = 0.2 / (1 + ray % 20) as f32;
            let (mut found, mut exact) = ([0.0f32; 2], [0.0f64; 2]);
            for _ in 0..200 {
                let a = thin * random();
                let source = [2.0 * a * random(), a];
                let (through, passes) = (1.0 - found[1], 1.0 - exact[1]);
                found = std::array::from_fn(|c| found[c] + through * source[c]);
                exact = std::array::from_fn(|c| exact[c] + passes * f64::from(source[c]));
            }
            let whole = [exact[0], exact[0], exact[0], exact[1]].map(Span::point);
            let [color, .., alpha] = HIDING.of(&whole, 200);
            let within = |span: Span, v: f32| (span.lo..=span.hi).contains(&f64::from(v));
            assert!(
                within(color, found[0]) && within(alpha, found[1]),
                "{found:?} of {exact:?}"
            );
            differing += u32::from(f64::from(found[0]) != exact[0]);
        }
        assert!(differing > 300, "{differing} of 400 differ");
    }
}
