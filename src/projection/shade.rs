//! Soft normals and Phong shading, as every projector does them; see [`Shading`](super::Shading) for the model.

use glam::{DMat3, DVec3};

use super::{DepthCue, Shading};
use crate::target::Lattice;

/// How far empty space lies below the lowest value, in fractions of the value range, where normals are made: so that the
/// lowest value has a surface too, and a cut shows the cut's normal.
pub const EMPTY_BELOW: f32 = 0.5;

/// Makes soft normals of [differences](super::half_differences) on a lattice: of the fraction of the value range times coverage, plus [`EMPTY_BELOW`] times
/// coverage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftNormals {
    /// From half the difference of neighbours along each lattice axis, in fractions of the value range, to multiples of g₀ in
    /// the world.
    world_from_difference: DMat3,
}

impl SoftNormals {
    /// For gradients of `lattice` that are soft below `soft_gradient` (see [`Shading::soft_gradient`]).
    pub fn new(lattice: &Lattice, soft_gradient: f64) -> Self {
        let finest_mm = lattice.spacing_mm().min_element();
        // A gradient is a covector: it transforms with the inverse transpose.
        let world_from_lattice = lattice.world_from_lattice.matrix3.inverse().transpose();
        Self {
            world_from_difference: world_from_lattice * (finest_mm / soft_gradient),
        }
    }

    /// The soft normal in the world: length below 1, pointing to rising values.
    #[inline]
    pub fn normal(&self, half_difference: DVec3) -> DVec3 {
        let g = self.world_from_difference * half_difference;
        g / (1.0 + g.length_squared()).sqrt()
    }

    /// The matrix from half differences to multiples of g₀, for kernels that work in single precision.
    pub fn matrix(&self) -> &DMat3 {
        &self.world_from_difference
    }
}

impl Shading {
    /// The light that a sample of soft normal `m` (eye frame) sends back: a factor of its colour, and a white highlight to be
    /// weighted by its opacity.
    pub fn response(&self, m: DVec3) -> (f64, f64) {
        let length = m.length();
        let material = &self.material;
        let (mut diffuse, mut specular) = (0.0, 0.0);
        for light in &self.lights {
            let half_way = (light.towards - DVec3::Z).normalize_or_zero();
            let intensity = f64::from(light.intensity);
            diffuse += intensity * m.dot(light.towards).abs();
            let shine = (0..material.shininess_log2).fold(m.dot(half_way).abs(), |s, _| s * s);
            specular += intensity * shine;
        }
        let factor = (1.0 - length) + f64::from(material.ambient) * length + f64::from(material.diffuse) * diffuse;
        (factor, f64::from(material.specular) * specular)
    }
}

impl DepthCue {
    /// The factor of a colour at `depth_mm` in a target that reaches from `near_mm` to `far_mm`.
    pub fn factor(&self, depth_mm: f64, near_mm: f64, far_mm: f64) -> f64 {
        let t = ((depth_mm - near_mm) / (far_mm - near_mm).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        1.0 - f64::from(self.strength) * t
    }
}
