//! What light a sample can send back whose normal is known up to a box.

use glam::DVec3;

use super::precision::{Precision, ULP};
use super::span::Span;
use super::storage::fraction_rounding;
use crate::projection::{FrameSpec, Shading, SoftNormals};

/// Lights in the frame that normals are stored in, the world.
pub(super) struct LightSpans {
    lights: Vec<WorldLight>,
    shading: Shading,
    /// Error of a part of a filtered normal.
    normal: f64,
}

struct WorldLight {
    towards: DVec3,
    half_way: DVec3,
    intensity: f64,
}

impl LightSpans {
    pub(super) fn new(spec: &FrameSpec, shading: &Shading, precision: &Precision) -> Self {
        let world_from_eye = spec.camera.eye_from_world.matrix3.transpose();
        let lights = shading.lights.iter().map(|light| WorldLight {
            towards: world_from_eye * light.towards,
            half_way: world_from_eye * (light.towards - DVec3::Z).normalize_or_zero(),
            intensity: f64::from(light.intensity),
        });
        let soft = SoftNormals::new(&spec.target.lattice, shading.soft_gradient);
        let m = soft.matrix();
        let steepest = (0..3)
            .map(|row| m.row(row).abs().element_sum())
            .fold(0.0, f64::max);
        let range = spec.target.value_range;
        // A difference of two fractions times the matrix, and its softening, which only shrinks errors.
        let gradient = steepest * (fraction_rounding(range) + 4.0 * ULP);
        // Stored in steps of 1/127: half of one, and those of the sum; then one product and one difference.
        let stored = (0.5 + precision.sum_steps) / 127.0 + (255.0 / 127.0) * precision.sum;
        Self {
            lights: lights.collect(),
            shading: shading.clone(),
            normal: gradient + stored + 4.0 * ULP,
        }
    }

    /// The factor of the colour and the white highlight: the interval extension of [`Shading::response`].
    pub(super) fn over(&self, normal: &[Span; 3]) -> (Span, Span) {
        let m = normal.map(|part| part.widened(self.normal));
        let squares = m.map(Span::squared);
        let length = (squares[0] + squares[1] + squares[2])
            .rising(f64::sqrt)
            .relaxed(8.0 * ULP);
        let material = &self.shading.material;
        let (mut diffuse, mut specular) = (Span::ZERO, Span::ZERO);
        for light in &self.lights {
            diffuse = diffuse + projected(&m, light.towards).scaled(light.intensity);
            specular = specular + self.shine(&m, light).scaled(light.intensity);
        }
        let factor = Span::ONE - length.scaled(1.0 - f64::from(material.ambient))
            + diffuse.scaled(f64::from(material.diffuse));
        // Sums of as many terms as there are lights, and of four.
        let terms = 8.0 + self.lights.len() as f64;
        (
            factor.widened(terms * ULP * (1.0 + length.hi + diffuse.hi)),
            specular
                .scaled(f64::from(material.specular))
                .relaxed(terms * ULP),
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
