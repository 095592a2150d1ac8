//! What light a sample can send back whose normal is known up to a box.

use glam::DVec3;

use super::precision::{Precision, ULP};
use super::span::Span;
use crate::projection::{Camera, Shading};

/// Lights in the frame that normals are stored in, the world.
pub(super) struct LightSpans {
    lights: Vec<WorldLight>,
    shading: Shading,
    precision: Precision,
}

struct WorldLight {
    towards: DVec3,
    half_way: DVec3,
    intensity: f64,
}

impl LightSpans {
    pub(super) fn new(camera: &Camera, shading: &Shading, precision: &Precision) -> Self {
        let world_from_eye = camera.eye_from_world.matrix3.transpose();
        let lights = shading.lights.iter().map(|light| WorldLight {
            towards: world_from_eye * light.towards,
            half_way: world_from_eye * (light.towards - DVec3::Z).normalize_or_zero(),
            intensity: f64::from(light.intensity),
        });
        Self {
            lights: lights.collect(),
            shading: shading.clone(),
            precision: *precision,
        }
    }

    /// What a normal that is read from texels gives.
    pub(super) fn over(&self, normal: &[Span; 3]) -> (Span, Span) {
        // In units of a normal: the steps of the sum, then a product, a difference and a quotient.
        let read =
            self.precision.sum_steps / 32767.0 + (65535.0 / 32767.0) * self.precision.sum + self.precision.normals;
        self.response(&normal.map(|part| part.widened(read + 6.0 * ULP)))
    }

    /// The factor of the colour and the white highlight: the interval extension of [`Shading::response`].
    pub(super) fn response(&self, m: &[Span; 3]) -> (Span, Span) {
        let squares = m.map(Span::squared);
        let length = (squares[0] + squares[1] + squares[2])
            .rising(f64::sqrt)
            .relaxed(8.0 * ULP);
        let material = &self.shading.material;
        let (mut diffuse, mut specular) = (Span::ZERO, Span::ZERO);
        for light in &self.lights {
            diffuse = diffuse + projected(m, light.towards).scaled(light.intensity);
            specular = specular + self.shine(m, light).scaled(light.intensity);
        }
        let factor =
            Span::ONE - length.scaled(1.0 - f64::from(material.ambient)) + diffuse.scaled(f64::from(material.diffuse));
        // Sums of as many terms as there are lights, and of four.
        let terms = 8.0 + self.lights.len() as f64;
        (
            factor.widened(terms * ULP * (1.0 + length.hi + diffuse.hi)),
            specular.scaled(f64::from(material.specular)).relaxed(terms * ULP),
        )
    }

    /// |m·h| squared again and again: each squaring doubles the relative error and adds its own.
    fn shine(&self, m: &[Span; 3], light: &WorldLight) -> Span {
        let squarings = self.shading.material.shininess_log2;
        let power = f64::from(squarings).exp2();
        let shine = (0..squarings).fold(projected(m, light.half_way), |s, _| s.squared());
        shine.relaxed(2.0 * power * ULP)
    }
}

/// |m·l|: three products and two sums of rounded numbers.
fn projected(m: &[Span; 3], l: DVec3) -> Span {
    let along = m[0].scaled(l.x) + m[1].scaled(l.y) + m[2].scaled(l.z);
    let size: f64 = (0..3).map(|a| m[a].magnitude() * l[a].abs()).sum();
    along.abs().widened(6.0 * ULP * size).not_negative()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::Light;
    use proptest::prelude::*;

    fn lights() -> LightSpans {
        let shading = Shading::default();
        let world = |light: &Light| WorldLight {
            towards: light.towards,
            half_way: (light.towards - DVec3::Z).normalize(),
            intensity: f64::from(light.intensity),
        };
        LightSpans {
            lights: shading.lights.iter().map(world).collect(),
            shading,
            precision: Precision::EXACT,
        }
    }

    proptest! {
        #[test]
        fn the_response_to_a_normal_is_in_the_response_to_its_box(
            middle in prop::array::uniform3(-0.7f64..0.7),
            reach in 0.0f64..0.1,
            at in prop::array::uniform3(-1.0f64..1.0),
        ) {
            let lights = lights();
            let normal = middle.map(|part| Span::around(part, reach));
            let m = DVec3::from_array(middle) + reach * DVec3::from_array(at);
            let (factor, highlight) = lights.shading.response(m);
            let (factors, highlights) = lights.over(&normal);
            prop_assert!(factors.lo <= factor && factor <= factors.hi);
            prop_assert!(highlights.lo <= highlight && highlight <= highlights.hi);
        }
    }
}
