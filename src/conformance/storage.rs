//! How a device holds a target's voxels, as far as rounding goes.

use crate::math::Interval;
use crate::render::PagedTarget;

use super::precision::ULP;

/// What storing costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Storage {
    /// The most that a stored value is off before it is filtered, in fractions of the value range.
    pub rounding: f64,
    /// The longest edge of a page, texels.
    pub page_edge: f64,
}

impl Storage {
    /// One over the largest stored number, which stands for 1.
    pub const STEP: f64 = 1.0 / 65535.0;

    /// What `paged` holds of a target with values in `range`.
    pub fn of(paged: &PagedTarget, range: Interval) -> Self {
        let edges = paged.pages.iter().flat_map(|page| page.dims);
        Self {
            page_edge: edges.max().map_or(1.0, f64::from),
            ..Self::without_pages(range)
        }
    }

    /// 16 bits of values in `range`, read by whole numbers instead of places in a page.
    pub fn without_pages(range: Interval) -> Self {
        Self {
            rounding: 0.5 * Self::STEP + fraction_rounding(range),
            page_edge: 1.0,
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
