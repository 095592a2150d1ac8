//! How a device holds a target's voxels, as far as rounding goes.

use crate::math::Interval;
use crate::render::{Encoding, PagedTarget};

use super::precision::ULP;

/// The steps of what is stored, and how stored numbers become fractions of the value range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Storage {
    /// One over the largest integer of the format.
    pub step: f64,
    /// The most that a stored value is off before it is filtered.
    pub rounding: f64,
    /// Fractions of the value range for each unit of a filtered value.
    pub scale: f64,
    /// Fractions of the value range for each unit of coverage.
    pub offset: f64,
    /// The longest edge of a page, texels.
    pub page_edge: f64,
}

impl Storage {
    /// What `paged` holds of a target with values in `range`.
    pub fn of(paged: &PagedTarget, range: Interval) -> Self {
        let bytes = paged.encoding == Encoding::Bytes;
        let edges = paged.pages.iter().flat_map(|page| page.dims);
        let [scale, offset] = paged.encoding.fraction_of_stored(range).map(f64::from);
        let step = if bytes { 1.0 / 255.0 } else { 1.0 / 65535.0 };
        Self {
            step,
            // Bytes are stored as they are.
            rounding: if bytes {
                0.0
            } else {
                0.5 * step + fraction_rounding(range)
            },
            scale,
            offset,
            page_edge: edges.max().map_or(1.0, f64::from),
        }
    }
}

/// Rounding of `(v·c − lo·c) / width` in single precision: a product, a difference and a width of two numbers of the range's
/// magnitude, and a quotient.
pub(super) fn fraction_rounding(range: Interval) -> f64 {
    let magnitude = f64::from(range.lo.abs().max(range.hi.abs()));
    let width = f64::from(range.width());
    if width > 0.0 {
        4.0 * ULP * (magnitude / width + 1.0)
    } else {
        0.0
    }
}
