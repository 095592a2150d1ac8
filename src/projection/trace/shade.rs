//! What a place sends back of the light that reaches it.
//!
//! *Theory.* Phong's model, as in [`Shading`](crate::projection::Shading), with shadow rays to each light.
//! *Changes from the paper.* Samples of media have soft normals and are lit on both sides; what a light does on the far side is for
//! its shadow ray to find. Surfaces are lit on the side that the ray comes from.

use glam::DVec3;

use super::light::Beam;
use super::ray::Ray;
use super::sampling::Stream;
use super::shadow;
use super::world::{Inside, World};
use crate::projection::Material;

/// A place that is lit.
pub struct Place<'a> {
    /// The ray that sees it.
    pub ray: &'a Ray,
    /// Where on the ray, millimetres.
    pub mm: f64,
    /// Its soft normal, of length 1 for surfaces.
    pub normal: DVec3,
    /// Which sides are lit.
    pub lit: Lit,
    /// The solids that the ray is inside of.
    pub inside: Inside,
}

/// Which sides of a place are lit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lit {
    /// Where the normal points.
    Front,
    /// Both.
    Both,
}

/// What lights make of a place: factors of its colour, and of white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// Of its colour, in each channel.
    pub factor: [f64; 3],
    /// Of white.
    pub highlight: [f64; 3],
}

impl Response {
    /// What is seen of a colour.
    pub fn of(&self, color: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|c| self.factor[c] * color[c] + self.highlight[c])
    }
}

impl Place<'_> {
    /// What the lights of `world` make of it, areas seen through `parts` times `parts` places.
    pub fn response(&self, world: &World, parts: u32, stream: &mut Stream) -> Response {
        let Some(material) = &world.look().material else {
            return Response {
                factor: [1.0; 3],
                highlight: [0.0; 3],
            };
        };
        let length = self.normal.length();
        let unshaded = (1.0 - length).max(0.0) + f64::from(material.ambient) * length;
        let mut response = Response {
            factor: [unshaded; 3],
            highlight: [0.0; 3],
        };
        for light in world.lights() {
            for beam in light.beams(self.ray.at(self.mm), parts, stream) {
                let phase = stream.in_pixel()[0];
                self.add(world, material, &beam, phase, &mut response);
            }
        }
        response
    }

    fn add(&self, world: &World, material: &Material, beam: &Beam, phase: f64, response: &mut Response) {
        let facing = |towards: DVec3| match self.lit {
            Lit::Front => self.normal.dot(towards).max(0.0),
            Lit::Both => self.normal.dot(towards).abs(),
        };
        let cos = facing(beam.towards);
        if cos <= 0.0 || beam.intensity <= 0.0 {
            return;
        }
        let half_way = (beam.towards - self.ray.direction).normalize_or_zero();
        let shine = (0..material.shininess_log2).fold(facing(half_way), |shine, _| shine * shine);
        let towards_light = self.ray.turned(self.mm, beam.towards);
        let visible = shadow::visibility(world, &towards_light, beam, self.inside, phase);
        for (c, visible) in visible.into_iter().enumerate() {
            let light = visible * beam.intensity;
            response.factor[c] += f64::from(material.diffuse) * cos * light;
            response.highlight[c] += f64::from(material.specular) * shine * light;
        }
    }
}
