//! Light on samples, and the depth cue.

use glam::Vec3;

use super::rays::{Depths, Rays};
use super::simd::{Simd, each};
use super::voxels::ONE_NORMAL;
use crate::projection::{DepthCue, FrameSpec, Light, Shading};

/// Lights and material, for normals in the world: see [`Shading::response`].
pub struct Lights {
    /// Towards each light, half-way between light and eye, and intensity.
    lights: Vec<(Vec3, Vec3, f32)>,
    ambient: f32,
    diffuse: f32,
    specular: f32,
    shininess_log2: u32,
}

impl Lights {
    /// For the frame of `spec`.
    pub fn new(spec: &FrameSpec, shading: &Shading) -> Self {
        let world_from_eye = spec.camera.eye_from_world.matrix3.transpose();
        let light = |light: &Light| {
            let half_way = (light.towards - glam::DVec3::Z).normalize_or_zero();
            let [towards, half_way] = [light.towards, half_way].map(|v| (world_from_eye * v).as_vec3());
            (towards, half_way, light.intensity)
        };
        let material = &shading.material;
        Self {
            lights: shading.lights.iter().map(light).collect(),
            ambient: material.ambient,
            diffuse: material.diffuse,
            specular: material.specular,
            shininess_log2: material.shininess_log2,
        }
    }

    /// The factor of a colour and the white highlight for each soft normal, which is in parts of [`ONE_NORMAL`].
    #[inline(always)]
    pub fn response<S: Simd>(&self, normals: &[S::Float; 3]) -> (S::Float, S::Float) {
        let normals = each!(axis of [0, 1, 2] => normals[axis] * S::float(1.0 / ONE_NORMAL));
        let (mut diffuse, mut specular) = (S::float(0.0), S::float(0.0));
        for (towards, half_way, intensity) in &self.lights {
            let mut shine = along::<S>(&normals, half_way);
            for _ in 0..self.shininess_log2 {
                shine = shine * shine;
            }
            diffuse = diffuse + S::float(*intensity) * along::<S>(&normals, towards);
            specular = specular + S::float(*intensity) * shine;
        }
        let [x, y, z] = normals;
        let length = S::root(x * x + y * y + z * z);
        let factor = (S::float(1.0) - length) + S::float(self.ambient) * length + S::float(self.diffuse) * diffuse;
        (factor, S::float(self.specular) * specular)
    }
}

/// How far normals point along a direction, or against it.
#[inline(always)]
fn along<S: Simd>([x, y, z]: &[S::Float; 3], direction: &Vec3) -> S::Float {
    S::absolute(*x * S::float(direction.x) + *y * S::float(direction.y) + *z * S::float(direction.z))
}

/// The depth cue by plane number: see [`DepthCue::factor`](crate::projection::DepthCue::factor).
pub struct Cue {
    pub strength: f32,
    /// How far the first plane is on the way from the nearest to the farthest point, and how far a plane is from the next.
    first: f32,
    step: f32,
}

impl Cue {
    /// In `depths`, at the planes of `rays`.
    pub fn new(cue: &DepthCue, depths: &Depths, rays: &Rays) -> Self {
        let [near_mm, far_mm] = depths.cue_mm;
        let span = (far_mm - near_mm).max(f64::MIN_POSITIVE);
        let [first_mm, step_mm] = rays.depth_mm();
        Self {
            strength: cue.strength,
            first: ((first_mm - near_mm) / span) as f32,
            step: (step_mm / span) as f32,
        }
    }

    /// The factor of a colour at a plane.
    #[inline(always)]
    pub fn at(&self, plane: i32) -> f32 {
        let t = self.first + plane as f32 * self.step;
        1.0 - self.strength * t.clamp(0.0, 1.0)
    }
}
