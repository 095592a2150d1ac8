//! Lights, material and depth cue (VCSG §4 renders with five lights and depth cue).
//!
//! *Theory.* Phong shading with the data's gradient as the normal.
//! *Changes from the paper.* The normal is softened: `m = g / √(|g|² + g₀²)`, of length below 1, so that a faint gradient
//! (noise) shades faintly, and where there is none the sample keeps its own colour. The lit colour is
//! `colour · ((1−|m|) + kₐ|m| + k_d Σ Iₗ|m·l|) + kₛ Σ Iₗ |m·h|ⁿ`, continuous in `m`: a small error of the normal is a small
//! error of the picture, which the derived bounds rest on. Both sides of a surface are lit.
//! *Practice.* Lights are directions in the eye frame (they move with the viewer), and `n` is a power of two, computed by
//! repeated squaring.

use glam::DVec3;

/// A directional light in the eye frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Unit vector from the scene towards the light (x right, y down, z away from the viewer).
    pub towards: DVec3,
    /// Brightness; 1 is a full light.
    pub intensity: f32,
}

/// How a sample answers to light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Ambient factor kₐ.
    pub ambient: f32,
    /// Diffuse factor k_d.
    pub diffuse: f32,
    /// Specular factor kₛ.
    pub specular: f32,
    /// Specular exponent as a power of two: n = 2^this, at most 10.
    pub shininess_log2: u32,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            ambient: 0.15,
            diffuse: 0.85,
            specular: 0.2,
            shininess_log2: 4,
        }
    }
}

/// Everything shading needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Shading {
    /// One to five lights.
    pub lights: Vec<Light>,
    /// The material of all that is drawn.
    pub material: Material,
    /// g₀: the gradient, in fractions of the target's value range a finest voxel, at which `|m| = 1/√2`; above 0.
    pub soft_gradient: f64,
}

impl Shading {
    /// The most lights that a frame can have.
    pub const MAX_LIGHTS: usize = 5;

    /// A key light from the upper left and a weaker fill from the right.
    pub fn key_and_fill() -> Vec<Light> {
        vec![
            Light {
                towards: DVec3::new(-0.45, -0.6, -1.0).normalize(),
                intensity: 0.85,
            },
            Light {
                towards: DVec3::new(0.9, 0.1, -0.7).normalize(),
                intensity: 0.3,
            },
        ]
    }

    /// One light from the viewer.
    pub fn headlight() -> Vec<Light> {
        vec![Light {
            towards: -DVec3::Z,
            intensity: 1.0,
        }]
    }
}

impl Default for Shading {
    fn default() -> Self {
        Self {
            lights: Self::key_and_fill(),
            material: Material::default(),
            soft_gradient: 0.02,
        }
    }
}

/// Depth cue: samples darken with depth, from the nearest to the farthest point of the target.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DepthCue {
    /// How much of the colour is lost at the far end, in [0, 1].
    pub strength: f32,
}
