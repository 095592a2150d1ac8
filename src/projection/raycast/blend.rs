//! Sources blended from front to back: each under what is in front of it.

use super::simd::{Simd, each, larger};
use crate::interface::HIDES_ALL_BUT;
use crate::projection::composite::Blending;

/// The opacity at which nothing behind shows.
const OPAQUE: f32 = 1.0 - 1.0 / HIDES_ALL_BUT as f32;

/// Red, green, blue and opacity of each ray's pixel, or sample.
pub type Colours<S> = [<S as Simd>::Float; 4];

/// `pixels` with the sources of a bundle behind them. Sources of nothing leave them as they are.
#[inline(always)]
pub fn under<S: Simd>(blending: Blending, pixels: &mut Colours<S>, sources: &Colours<S>) {
    // How much of what is behind each pixel shows.
    let through = S::float(1.0) - pixels[3];
    *pixels = match blending {
        Blending::Over => each!(c of [0, 1, 2, 3] => S::mul_add(through, sources[c], pixels[c])),
        Blending::Add => each!(c of [0, 1, 2, 3] => pixels[c] + sources[c]),
        Blending::Max => each!(c of [0, 1, 2, 3] => larger::<S>(sources[c], pixels[c])),
    };
}

/// Which pixels hide all that is behind them.
#[inline(always)]
pub fn hidden<S: Simd>(blending: Blending, pixels: &Colours<S>) -> S::Mask {
    match blending {
        Blending::Over => S::greater(pixels[3], S::float(OPAQUE)),
        Blending::Add | Blending::Max => S::none(),
    }
}
