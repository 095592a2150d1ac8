//! What a frame may lack that does not draw what is hidden.
//!
//! *Theory.* With F all that is in front and R what is left out, the whole is F + (1 − F's alpha)·R, and R is left out only
//! where less than one part in [`HIDES_ALL_BUT`] passes F. So a channel is short of the whole by at most that part of R. No
//! alpha is above 1, and no colour above its alpha times the brightest light.

use super::precision::ULP;
use super::source::Spans;
use super::span::Span;
use crate::interface::HIDES_ALL_BUT;
use crate::projection::{FrameSpec, Shading};

/// The bounds of a frame that is drawn in bands.
pub(super) struct Hiding {
    /// The most that each channel may lack where what is behind is left out.
    lacking: [f64; 4],
    bands: f64,
}

impl Hiding {
    /// For a frame of `bands` bands.
    pub(super) fn new(spec: &FrameSpec, bands: usize) -> Self {
        let passes = 1.0 / f64::from(HIDES_ALL_BUT);
        let color = passes * spec.shading().map_or(1.0, brightest);
        Self {
            lacking: [color, color, color, passes],
            bands: bands as f64,
        }
    }

    /// What a pixel may be of which the whole is in `whole`: with three operations for each band put behind another.
    pub(super) fn of(&self, whole: &Spans) -> Spans {
        if self.bands <= 1.0 {
            return *whole;
        }
        let merged = whole.map(|span| span.relaxed(3.0 * self.bands * ULP));
        let may_end = merged[3].hi >= 1.0 - self.lacking[3];
        std::array::from_fn(|c| match may_end {
            true => Span::new(merged[c].lo - self.lacking[c], merged[c].hi),
            false => merged[c],
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
        lacking: [0.002, 0.002, 0.002, 0.001],
        bands: 2.0,
    };

    #[test]
    fn only_what_may_be_opaque_may_lack_something() {
        let [.., thin] = HIDING.of(&[Span::point(0.5); 4]);
        assert!(thin.width() < 1e-5, "{thin:?}");
        let [red, .., alpha] = HIDING.of(&[Span::point(0.5), Span::ZERO, Span::ZERO, Span::point(0.9995)]);
        assert!((red.width() - 0.002).abs() < 1e-5 && (alpha.width() - 0.001).abs() < 1e-5);
    }
}
