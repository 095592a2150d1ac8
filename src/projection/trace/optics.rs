//! What a surface does with light: mirror it, let it through bent, or scatter it.
//!
//! *Theory.* The law of reflection, Snell's law with total internal reflection, and Fresnel's equations for light without
//! polarisation, none of them approximated.
//! *Practice.* What a surface does not mirror it lets through or scatters, in shares that sum up to 1: no surface gives more light
//! than it gets. The factor (n₂/n₁)² of radiance in a denser medium is left out: it cancels for all light that comes out again.

use glam::DVec3;

/// What the surface of a solid does with light. Made by [`Optics::new`], which checks it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Optics {
    reflect: f64,
    transmit: f64,
    index: f64,
    tint: [f64; 3],
    tint_mm: f64,
}

/// Optics that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OpticsError {
    /// A share out of its range.
    #[error("`{what}` is {found}; it must be in 0..1")]
    Share {
        /// Which.
        what: &'static str,
        /// What it is.
        found: f64,
    },
    /// An index of refraction that no matter has.
    #[error("the refraction index is {0}; it must be in 0.1..10 (vacuum has 1, water 1.33, glass 1.5)")]
    Index(f64),
    /// A length that is not above 0.
    #[error("the tint holds for {0} mm; that must be above 0")]
    TintLength(f64),
}

/// How light is divided at a surface; the shares sum up to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shares {
    /// Mirrored.
    pub reflected: f64,
    /// Let through.
    pub transmitted: f64,
    /// Scattered: what lights make visible of the surface itself.
    pub scattered: f64,
}

impl Default for Optics {
    /// An opaque surface that mirrors nothing.
    fn default() -> Self {
        Self {
            reflect: 0.0,
            transmit: 0.0,
            index: 1.0,
            tint: [1.0; 3],
            tint_mm: 1.0,
        }
    }
}

impl Optics {
    /// The indices of refraction that there can be.
    pub const INDICES: [f64; 2] = [0.1, 10.0];

    /// A surface that mirrors the share `reflect`, and of the rest as much as Fresnel's equations say for the `index` of what is
    /// within; and that lets through the share `transmit` of what it does not mirror.
    ///
    /// # Errors
    /// If a share is not in [0, 1], or the index not in [`Self::INDICES`].
    pub fn new(reflect: f64, transmit: f64, index: f64) -> Result<Self, OpticsError> {
        for (what, found) in [("reflect", reflect), ("transmit", transmit)] {
            share(what, found)?;
        }
        let [lowest, highest] = Self::INDICES;
        if !(lowest..=highest).contains(&index) {
            return Err(OpticsError::Index(index));
        }
        Ok(Self {
            reflect,
            transmit,
            index,
            ..Self::default()
        })
    }

    /// The same with matter within that lets through `tint` of the light in each `tint_mm` millimetres.
    ///
    /// # Errors
    /// If a channel of the tint is not in [0, 1], or the length not above 0.
    pub fn tinted(self, tint: [f64; 3], tint_mm: f64) -> Result<Self, OpticsError> {
        for channel in tint {
            share("tint", channel)?;
        }
        if !(tint_mm.is_finite() && tint_mm > 0.0) {
            return Err(OpticsError::TintLength(tint_mm));
        }
        Ok(Self { tint, tint_mm, ..self })
    }

    /// Whether light can pass.
    pub fn transmits(&self) -> bool {
        self.transmit > 0.0
    }

    /// The index of refraction of what is within.
    pub fn index(&self) -> f64 {
        self.index
    }

    /// How light is divided that meets the surface with cosine `cos` (at least 0) of its angle to the normal, from a medium of
    /// `index_before` into one of `index_behind`.
    pub fn shares(&self, cos: f64, index_before: f64, index_behind: f64) -> Shares {
        let reflected = self.reflect + (1.0 - self.reflect) * fresnel(cos, index_before, index_behind);
        let entering = 1.0 - reflected;
        Shares {
            reflected,
            transmitted: entering * self.transmit,
            scattered: entering * (1.0 - self.transmit),
        }
    }

    /// What is left in each channel after `length_mm` within (Beer and Lambert).
    pub fn through(&self, length_mm: f64) -> [f64; 3] {
        self.tint.map(|tint| tint.powf(length_mm / self.tint_mm))
    }
}

fn share(what: &'static str, found: f64) -> Result<(), OpticsError> {
    match (0.0..=1.0).contains(&found) {
        true => Ok(()),
        false => Err(OpticsError::Share { what, found }),
    }
}

/// The mirrored direction of one that meets a surface of unit `normal`; all of length 1.
pub fn reflect(direction: DVec3, normal: DVec3) -> DVec3 {
    direction - 2.0 * direction.dot(normal) * normal
}

/// The direction on the other side of a surface whose unit `normal` is turned against `direction`, by Snell's law; `None` where all
/// light is mirrored.
pub fn refract(direction: DVec3, normal: DVec3, index_before: f64, index_behind: f64) -> Option<DVec3> {
    let ratio = index_before / index_behind;
    let cos = -direction.dot(normal);
    let sin2_behind = ratio * ratio * (1.0 - cos * cos);
    if sin2_behind > 1.0 {
        return None;
    }
    let bent = ratio * direction + (ratio * cos - (1.0 - sin2_behind).sqrt()) * normal;
    Some(bent.normalize_or(direction))
}

/// The share of light without polarisation that the surface between two media mirrors.
pub fn fresnel(cos: f64, index_before: f64, index_behind: f64) -> f64 {
    if index_before == index_behind {
        return 0.0;
    }
    let cos = cos.clamp(0.0, 1.0);
    let sin2_behind = (index_before / index_behind).powi(2) * (1.0 - cos * cos);
    if sin2_behind >= 1.0 {
        return 1.0;
    }
    let cos_behind = (1.0 - sin2_behind).sqrt();
    let (a, b) = (index_before * cos, index_behind * cos_behind);
    let across = (a - b) / (a + b);
    let (a, b) = (index_before * cos_behind, index_behind * cos);
    let along = (a - b) / (a + b);
    0.5 * (across * across + along * along)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The direction that meets a surface of normal z under `degrees`.
    fn incident(degrees: f64) -> DVec3 {
        let (sin, cos) = degrees.to_radians().sin_cos();
        DVec3::new(sin, 0.0, -cos)
    }

    #[test]
    fn snell() {
        let bent = refract(incident(40.0), DVec3::Z, 1.0, 1.5).expect("a way in");
        assert!((bent.x - 40f64.to_radians().sin() / 1.5).abs() < 1e-12);
        assert!((bent.length() - 1.0).abs() < 1e-12);
        let back = refract(bent, DVec3::Z, 1.5, 1.0).expect("a way out");
        assert!((back - incident(40.0)).length() < 1e-12);
        // The critical angle is 41.8 degrees.
        assert!(refract(incident(41.7), DVec3::Z, 1.5, 1.0).is_some());
        assert!(refract(incident(41.9), DVec3::Z, 1.5, 1.0).is_none());
    }

    #[test]
    fn fresnel_at_angles_that_are_known() {
        let upright = ((1.5f64 - 1.0) / 2.5).powi(2);
        assert!((fresnel(1.0, 1.0, 1.5) - upright).abs() < 1e-12);
        assert!((fresnel(1.0, 1.5, 1.0) - upright).abs() < 1e-12);
        assert_eq!(fresnel(0.0, 1.0, 1.5), 1.0);
        assert_eq!(fresnel(0.5, 1.5, 1.0), 1.0);
        // At Brewster's angle only light of one polarisation is mirrored: half of ((1 − n²)/(1 + n²))².
        let brewster = 1.5f64.atan();
        let known = 0.5 * ((1.0 - 2.25f64) / (1.0 + 2.25)).powi(2);
        assert!((fresnel(brewster.cos(), 1.0, 1.5) - known).abs() < 1e-12);
    }

    #[test]
    fn shares_sum_up_to_one() {
        for reflect in [0.0, 0.3, 1.0] {
            for transmit in [0.0, 0.6, 1.0] {
                let optics = Optics::new(reflect, transmit, 1.5).expect("optics");
                for cos in [0.0, 0.2, 0.9, 1.0] {
                    for [before, behind] in [[1.0, 1.5], [1.5, 1.0], [1.0, 1.0]] {
                        let Shares {
                            reflected,
                            transmitted,
                            scattered,
                        } = optics.shares(cos, before, behind);
                        assert!([reflected, transmitted, scattered].iter().all(|s| *s >= 0.0));
                        assert!((reflected + transmitted + scattered - 1.0).abs() < 1e-12);
                    }
                }
            }
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        for index in [0.0, -1.5, f64::NAN, f64::INFINITY] {
            assert!(
                matches!(Optics::new(0.0, 1.0, index), Err(OpticsError::Index(_))),
                "{index}"
            );
        }
        for bad in [-0.1, 1.1, f64::NAN] {
            assert!(matches!(Optics::new(bad, 0.0, 1.0), Err(OpticsError::Share { .. })));
            assert!(matches!(Optics::new(0.0, bad, 1.0), Err(OpticsError::Share { .. })));
            assert!(matches!(
                Optics::default().tinted([bad, 1.0, 1.0], 1.0),
                Err(OpticsError::Share { .. })
            ));
        }
        assert!(matches!(
            Optics::default().tinted([1.0; 3], 0.0),
            Err(OpticsError::TintLength(_))
        ));
    }

    #[test]
    fn tints_multiply() {
        let optics = Optics::default().tinted([0.5, 1.0, 0.0], 10.0).expect("a tint");
        assert_eq!(optics.through(0.0), [1.0; 3]);
        assert_eq!(optics.through(20.0), [0.25, 1.0, 0.0]);
    }
}
