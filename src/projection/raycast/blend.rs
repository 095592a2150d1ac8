//! Sources blended from front to back: each under what is in front of it.

use super::bundle::{RAYS, STEPS};
use super::classify::Sources;
use crate::interface::HIDES_ALL_BUT;
use crate::projection::composite::Blending;

/// The opacity at which nothing behind shows.
const OPAQUE: f32 = 1.0 - 1.0 / HIDES_ALL_BUT as f32;

/// The pixels of a bundle's rays.
pub type Pixels = [[f32; 4]; RAYS];

/// `pixels` with the sources of a bundle behind them. Sources of nothing leave them as they are.
#[inline(always)]
pub fn under(blending: Blending, pixels: &mut Pixels, sources: &Sources) {
    for s in 0..STEPS {
        for r in 0..RAYS {
            let (pixel, source) = (&mut pixels[r], &sources[s * RAYS + r]);
            let through = through(pixel[3]);
            for c in 0..4 {
                let (p, s) = (pixel[c], source[c]);
                pixel[c] = match blending {
                    Blending::Over => p + through * s,
                    Blending::Add => p + s,
                    Blending::Max if s > p => s,
                    Blending::Max => p,
                };
            }
        }
    }
}

/// How much of what is behind a pixel of such an opacity shows.
#[inline(always)]
fn through(opacity: f32) -> f32 {
    if opacity > OPAQUE { 0.0 } else { 1.0 - opacity }
}

/// Whether `pixel` hides all that is behind it.
#[inline(always)]
pub fn hides(blending: Blending, pixel: &[f32; 4]) -> bool {
    blending == Blending::Over && pixel[3] > OPAQUE
}

/// Which sources of a bundle show behind `pixels`.
#[inline(always)]
pub fn shown(blending: Blending, pixels: &Pixels, sources: &Sources) -> [bool; STEPS * RAYS] {
    let mut opacity = pixels.map(|pixel| pixel[3]);
    let mut shown = [false; STEPS * RAYS];
    for s in 0..STEPS {
        for (r, opacity) in opacity.iter_mut().enumerate() {
            let n = s * RAYS + r;
            let source = sources[n][3];
            let through = through(*opacity);
            shown[n] = source > 0.0 && (blending != Blending::Over || through > 0.0);
            *opacity += through * source;
        }
    }
    shown
}
