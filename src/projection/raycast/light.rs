//! Light on samples, and the depth cue.

use glam::Vec3;

use super::rays::{Depths, Rays};
use super::simd::{ALL_WEIGHTS, ONE_NORMAL, Simd, each};
use crate::projection::{DepthCue, FrameSpec, Light, Shading};

/// Lights and material, for normals in the world: see [`Shading::response`].
pub struct Lights {
    lights: Vec<Lit>,
    /// What a normal takes of what is not lit, by its length as it is sampled.
    by_length: f32,
    shininess_log2: u32,
}

/// A light on a material. Directions are as short as normals are sampled long, so that these along those are cosines.
struct Lit {
    towards: Vec3,
    /// Half-way between light and eye.
    half_way: Vec3,
    diffuse: f32,
    specular: f32,
}

/// What a part of a normal is times its sample; the sign is nothing to a normal.
const NORMAL: f32 = 1.0 / (ONE_NORMAL * ALL_WEIGHTS.abs());

impl Lights {
    /// For the frame of `spec`.
    pub fn new(spec: &FrameSpec, shading: &Shading) -> Self {
        let world_from_eye = spec.camera.eye_from_world.matrix3.transpose();
        let material = &shading.material;
        let lit = |light: &Light| {
            let half_way = (light.towards - glam::DVec3::Z).normalize_or_zero();
            let [towards, half_way] = [light.towards, half_way].map(|v| (world_from_eye * v).as_vec3() * NORMAL);
            Lit {
                towards,
                half_way,
                diffuse: material.diffuse * light.intensity,
                specular: material.specular * light.intensity,
            }
        };
        Self {
            lights: shading.lights.iter().map(lit).collect(),
            by_length: (material.ambient - 1.0) * NORMAL,
            shininess_log2: material.shininess_log2,
        }
    }

    /// The factor of a colour and the white highlight for each soft normal, as it is sampled: in parts of [`ONE_NORMAL`] times [`ALL_WEIGHTS`].
    #[inline(always)]
    pub fn response<S: Simd>(&self, normals: &[S::Float; 3]) -> (S::Float, S::Float) {
        let [x, y, z] = *normals;
        let length = S::root(S::mul_add(x, x, S::mul_add(y, y, z * z)));
        let mut factor = S::mul_add(S::float(self.by_length), length, S::float(1.0));
        let mut highlight = S::float(0.0);
        for light in &self.lights {
            let mut shine = along::<S>(normals, &light.half_way);
            for _ in 0..self.shininess_log2 {
                shine = shine * shine;
            }
            factor = S::mul_add(S::float(light.diffuse), along::<S>(normals, &light.towards), factor);
            highlight = S::mul_add(S::float(light.specular), shine, highlight);
        }
        (factor, highlight)
    }
}

/// How far normals point along a direction, or against it.
#[inline(always)]
fn along<S: Simd>([x, y, z]: &[S::Float; 3], direction: &Vec3) -> S::Float {
    let [a, b, c] = each!(part of [direction.x, direction.y, direction.z] => S::float(part));
    S::absolute(S::mul_add(*x, a, S::mul_add(*y, b, *z * c)))
}

/// The depth cue by plane number: see [`DepthCue::factor`](crate::projection::DepthCue::factor).
pub struct Cue {
    strength: f32,
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

    /// Whether it changes any colour.
    pub fn is_there(&self) -> bool {
        self.strength != 0.0
    }

    /// The factor of a colour at a plane.
    #[inline(always)]
    pub fn at(&self, plane: i32) -> f32 {
        let t = self.first + plane as f32 * self.step;
        1.0 - self.strength * t.clamp(0.0, 1.0)
    }
}
