//! How the samples along a ray become a pixel, in each mode.
//!
//! *Practice.* Every mode is one blend equation on four channels, so a device's fixed-function blending does it. The value
//! modes accumulate fractions of the target's value range weighted by coverage, which is continuous where an object ends; a
//! last step ([`resolve`]) turns what was accumulated into premultiplied RGBA.

use super::{Mode, TransferFunction};
use crate::image::{Frame, Rgba};
use crate::math::Interval;

/// The blend equation of a mode, back to front, on `[red, green, blue, alpha]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blending {
    /// `source + (1 − source alpha) · destination`.
    Over,
    /// `source + destination`.
    Add,
    /// The larger, channel by channel.
    Max,
}

impl Mode {
    /// How a sample is blended over what is behind it.
    pub fn blending(self) -> Blending {
        match self {
            Self::Composite | Self::XRay => Blending::Over,
            Self::Additive | Self::Average => Blending::Add,
            Self::Mip | Self::MinIp => Blending::Max,
        }
    }

    /// Whether samples go through the transfer function's colours; otherwise their values are accumulated.
    pub fn classifies(self) -> bool {
        matches!(self, Self::Composite | Self::XRay | Self::Additive)
    }
}

impl Blending {
    /// One sample blended over what is behind it.
    pub fn blend(self, source: [f64; 4], behind: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|c| match self {
            Self::Over => source[c] + (1.0 - source[3]) * behind[c],
            Self::Add => source[c] + behind[c],
            Self::Max => source[c].max(behind[c]),
        })
    }
}

/// What a value mode accumulates of a sample: `weighted` is the fraction of the value range times coverage.
pub fn value_source(mode: Mode, weighted: f64, coverage: f64, path_per_depth: f64) -> [f64; 4] {
    let (value, weight) = match mode {
        Mode::MinIp => (coverage - weighted, coverage),
        Mode::Average => (weighted * path_per_depth, coverage * path_per_depth),
        _ => (weighted, coverage),
    };
    [value, value, value, weight]
}

/// Accumulated pixels as premultiplied RGBA. Value modes show greys of the transfer function's window.
pub fn resolve(mode: Mode, accumulated: Frame, value_range: Interval, transfer: &TransferFunction) -> Frame {
    if mode.classifies() {
        return accumulated;
    }
    let window = transfer.window();
    accumulated.map(|[value, .., weight]| {
        if weight <= 0.0 {
            return [0.0; 4];
        }
        let fraction = match mode {
            Mode::MinIp => 1.0 - value,
            Mode::Average => value / weight,
            _ => value,
        };
        let shown = value_range.lo + fraction * value_range.width();
        let grey = ((shown - window.lo) / window.width().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        let alpha = weight.min(1.0);
        [grey * alpha, grey * alpha, grey * alpha, alpha]
    })
}

/// `projection`, whose samples end at opaque surfaces, with the surfaces behind it: what shows of them depends on what the mode means.
///
/// - Composite: what the samples before it let through.
/// - Additive: all of it, since nothing absorbs; the light of the samples is added.
/// - The other modes show a grey that has no opacity of its own. Bright is what they are after, so a grey hides as much as it is
///   bright: a maximum before the surface shines over it, and what is black lets it through.
pub fn over_surfaces(mode: Mode, projection: &Frame, surfaces: &Frame) -> Frame {
    let mut frame = projection.clone();
    for (pixel, surface) in frame.pixels_mut().iter_mut().zip(surfaces.pixels()) {
        if surface[3] > 0.0 {
            *pixel = over_surface(mode, *pixel, *surface);
        }
    }
    frame
}

fn over_surface(mode: Mode, pixel: Rgba, surface: Rgba) -> Rgba {
    let through = match mode {
        Mode::Composite => 1.0 - pixel[3],
        Mode::Additive => 1.0,
        Mode::Mip | Mode::MinIp | Mode::Average | Mode::XRay => 1.0 - pixel[0],
    };
    let [r, g, b] = [0, 1, 2].map(|c| pixel[c] + through * surface[c]);
    [r, g, b, surface[3]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_shows_as_much_as_the_mode_lets_it() {
        let surface = Frame::from_pixels(2, 1, vec![[0.5, 0.25, 1.0, 1.0], [0.0; 4]]).expect("two pixels");
        let with = |mode, pixel: Rgba| {
            let projection = Frame::from_pixels(2, 1, vec![pixel; 2]).expect("two pixels");
            let frame = over_surfaces(mode, &projection, &surface);
            assert_eq!(frame.pixel(1, 0), Some(pixel), "{mode:?} without a surface");
            frame.pixel(0, 0).expect("a pixel")
        };
        let half = [0.25, 0.0, 0.0, 0.5];
        assert_eq!(with(Mode::Composite, half), [0.5, 0.125, 0.5, 1.0]);
        assert_eq!(with(Mode::Additive, half), [0.75, 0.25, 1.0, 1.0]);
        for mode in [Mode::Mip, Mode::MinIp, Mode::Average] {
            assert_eq!(
                with(mode, [0.0, 0.0, 0.0, 1.0]),
                [0.5, 0.25, 1.0, 1.0],
                "{mode:?} of black"
            );
            assert_eq!(with(mode, [1.0; 4]), [1.0; 4], "{mode:?} of white");
        }
        assert_eq!(with(Mode::XRay, [0.5; 4]), [0.75, 0.625, 1.0, 1.0]);
    }
}
