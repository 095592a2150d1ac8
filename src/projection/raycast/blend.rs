//! Sources blended from front to back: each under what is in front of it.

use crate::interface::HIDES_ALL_BUT;
use crate::projection::composite::Blending;

/// The opacity at which nothing behind shows.
const OPAQUE: f32 = 1.0 - 1.0 / HIDES_ALL_BUT as f32;

/// `pixel` with `source` behind it.
#[inline(always)]
pub fn under(blending: Blending, pixel: &mut [f32; 4], source: &[f32; 4]) {
    match blending {
        Blending::Over => {
            let through = 1.0 - pixel[3];
            for (p, s) in pixel.iter_mut().zip(source) {
                *p += through * s;
            }
        }
        Blending::Add => {
            for (p, s) in pixel.iter_mut().zip(source) {
                *p += s;
            }
        }
        Blending::Max => {
            for (p, s) in pixel.iter_mut().zip(source) {
                *p = if s > p { *s } else { *p };
            }
        }
    }
}

/// Whether `pixel` hides all that is behind it.
#[inline(always)]
pub fn hides(blending: Blending, pixel: &[f32; 4]) -> bool {
    blending == Blending::Over && pixel[3] > OPAQUE
}
