//! What is traced: objects, lights, and what the material of all of them scatters.

use super::light::Source;
use super::object::Object;
use super::ray::Ray;
use crate::math::Aabb;
use crate::projection::{Camera, Material, Shading};

/// Objects and lights in the world.
pub struct World {
    objects: Vec<Object>,
    lights: Vec<Source>,
    look: Look,
}

/// How the objects of a world are seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// What surfaces and samples answer to light, which is not above the light: factors that sum up to more than 1 are scaled down to
    /// that. Colours are flat when `None`.
    pub material: Option<Material>,
    /// See [`Shading::soft_gradient`].
    pub soft_gradient: f64,
    /// Samples of a medium for each of its smallest voxel spacings, above 0.
    pub samples_per_voxel: f64,
    /// What rays see that have been mirrored or bent and meet nothing more; they see what is behind the frame when `None`.
    pub environment: Option<[f64; 3]>,
}

/// Too many objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{count} objects are more than can be traced; the limit is {}", World::MAX_OBJECTS)]
pub struct TooManyObjects {
    /// How many.
    pub count: usize,
}

impl World {
    /// The most objects.
    pub const MAX_OBJECTS: usize = 64;

    /// A world. Where solids overlap, what is within both is that of the last one.
    ///
    /// # Errors
    /// If there are more than [`Self::MAX_OBJECTS`] objects.
    pub fn new(objects: Vec<Object>, lights: Vec<Source>, look: Look) -> Result<Self, TooManyObjects> {
        match objects.len() {
            count if count > Self::MAX_OBJECTS => Err(TooManyObjects { count }),
            _ => Ok(Self {
                objects,
                lights,
                look: look.normalised(),
            }),
        }
    }

    /// The objects.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// The lights.
    pub fn lights(&self) -> &[Source] {
        &self.lights
    }

    /// How it is seen.
    pub fn look(&self) -> &Look {
        &self.look
    }

    /// See [`Look::samples_per_voxel`].
    pub fn samples_per_voxel(&self) -> f64 {
        self.look.samples_per_voxel
    }

    /// A depth before all objects, millimetres.
    pub fn nearest_mm(&self, camera: &Camera) -> f64 {
        let boxes = self.objects.iter().map(|object| object.bounds);
        let all = boxes.fold(Aabb::EMPTY, |all, bounds| all.hull(&bounds));
        let nearest_mm = all.transformed(&camera.eye_from_world).min.z;
        if nearest_mm.is_finite() { nearest_mm } else { 0.0 }
    }

    /// The solids that hold the origin of `ray`.
    pub fn around(&self, ray: &Ray) -> Inside {
        let solids = self
            .objects
            .iter()
            .enumerate()
            .filter(|(_, object)| object.optics.is_some());
        let holding = solids.filter(|(_, object)| object.density_at(ray.origin) > 0.5);
        holding.fold(Inside::default(), |inside, (n, _)| inside.toggled(n))
    }

    /// The index of refraction of what is inside of some solids: that of the last one that lets light through.
    pub fn index(&self, inside: Inside) -> f64 {
        let held = self.objects.iter().enumerate().rev().filter(|(n, _)| inside.has(*n));
        let mut optics = held.filter_map(|(_, object)| object.optics);
        optics
            .find(|optics| optics.transmits())
            .map_or(1.0, |optics| optics.index())
    }
}

impl Look {
    /// That of a frame with `shading`.
    pub fn new(shading: Option<&Shading>, samples_per_voxel: f64, environment: Option<[f64; 3]>) -> Self {
        Self {
            material: shading.map(|shading| shading.material),
            soft_gradient: shading.map_or(1.0, |shading| shading.soft_gradient),
            samples_per_voxel,
            environment,
        }
    }

    fn normalised(mut self) -> Self {
        if let Some(material) = &mut self.material {
            let sum = material.ambient + material.diffuse + material.specular;
            let scale = 1.0 / sum.max(1.0);
            for factor in [&mut material.ambient, &mut material.diffuse, &mut material.specular] {
                *factor *= scale;
            }
        }
        self
    }
}

/// Which solids a ray is inside of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inside(u64);

impl Inside {
    /// Whether it is inside of solid `n`.
    pub fn has(self, n: usize) -> bool {
        self.0 >> n & 1 == 1
    }

    /// The same, the surface of solid `n` passed.
    pub fn toggled(self, n: usize) -> Self {
        Self(self.0 ^ 1 << n)
    }
}
