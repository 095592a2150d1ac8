//! Sources blended from front to back: each under what is in front of it.

use super::simd::{Simd, larger};
use crate::interface::HIDES_ALL_BUT;
use crate::projection::composite::Blending;

/// The opacity at which nothing behind shows.
const OPAQUE: f32 = 1.0 - 1.0 / HIDES_ALL_BUT as f32;

/// Red, green, blue and opacity of each ray's pixel, or sample.
pub type Colours<S> = [<S as Simd>::Float; 4];

/// `pixels`, of which some are `hidden`, with the sources of a bundle behind them. Sources of nothing leave them as they are.
#[inline(always)]
pub fn under<S: Simd>(blending: Blending, hidden: S::Mask, pixels: &mut Colours<S>, sources: &Colours<S>) {
    // How much of what is behind each pixel shows.
    let through = S::choose(hidden, S::float(0.0), S::float(1.0) - pixels[3]);
    for (pixel, &source) in pixels.iter_mut().zip(sources) {
        *pixel = match blending {
            Blending::Over => *pixel + through * source,
            Blending::Add => *pixel + source,
            Blending::Max => larger::<S>(source, *pixel),
        };
    }
}

/// Which pixels hide all that is behind them.
#[inline(always)]
pub fn hidden<S: Simd>(blending: Blending, pixels: &Colours<S>) -> S::Mask {
    match blending {
        Blending::Over => S::greater(pixels[3], S::float(OPAQUE)),
        Blending::Add | Blending::Max => S::none(),
    }
}
