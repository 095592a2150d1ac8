//! Rays, and the rays that they spawn.
//!
//! *Theory.* Where a ray meets a surface it spawns a mirrored and a transmitted ray, by a normal from the central differences of density,
//! and shadow rays to the lights; all of them are cast as primary rays are.
//! *Changes from the paper.* The paper traces one generation of mirrored rays. Here generations are bounded by a depth, and by how
//! much a ray can matter.
//! *Practice.* Cut-offs are soft: a ray that is not followed, for one bound or the other, sees the environment, as if it met nothing more.

use std::ops::ControlFlow;
use std::ops::Range;

use glam::DVec3;

use super::media::Media;
use super::object::Probe;
use super::optics::{Optics, reflect, refract};
use super::ray::Ray;
use super::sampling::Stream;
use super::shade::{Lit, Place, Response};
use super::surface::{self, Meeting};
use super::world::{Inside, World};

/// How far rays are followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Generations of mirrored and transmitted rays; primary rays alone at 0.
    pub depth: u32,
    /// A ray that can change a pixel by less than this is not followed.
    pub least_weight: f64,
    /// Each area light is seen through as many times as many places.
    pub light_parts: u32,
}

impl Bounds {
    /// The most generations: what follows one ray nests as deep.
    pub const MAX_DEPTH: u32 = 64;

    /// The most parts of an area light each way.
    pub const MAX_LIGHT_PARTS: u32 = 64;
}

impl Default for Bounds {
    fn default() -> Self {
        Self {
            depth: 6,
            least_weight: 1.0 / 256.0,
            light_parts: 2,
        }
    }
}

/// Premultiplied red, green and blue, and opacity.
type Light = [f64; 4];

/// Where nothing more than this passes, nothing more shows.
const OPAQUE: f64 = 1.0 / 1024.0;

/// The state of a ray.
#[derive(Clone, Copy)]
struct Path {
    inside: Inside,
    generation: u32,
    /// How much of a pixel it is.
    weight: f64,
}

/// Follows the rays of one sample of a pixel.
pub struct Tracer<'a> {
    /// What is seen.
    pub world: &'a World,
    /// How far.
    pub bounds: Bounds,
    /// The random numbers of the sample.
    pub stream: Stream,
    /// By what part of a step samples of media are behind a ray's origin.
    pub phase: f64,
}

/// What a surface gives to a ray that meets it fully.
struct Answer {
    light: Light,
    /// How much of the ray goes straight on.
    straight: f64,
}

/// A surface and the ray that has met it.
struct Met<'a> {
    object: usize,
    optics: &'a Optics,
    meeting: Meeting,
    color: [f64; 3],
    /// The normal on the side that the ray comes from.
    facing: DVec3,
}

impl Tracer<'_> {
    /// What a primary ray sees.
    pub fn primary(&mut self, ray: &Ray) -> Light {
        let path = Path {
            inside: self.world.around(ray),
            generation: 0,
            weight: 1.0,
        };
        self.seen(ray, path)
    }

    fn seen(&mut self, ray: &Ray, path: Path) -> Light {
        let world = self.world;
        let mut media = Media::new(world.objects(), ray, world.samples_per_voxel());
        let mut solids = Solids::new(world, ray);
        let mut view = View {
            light: [0.0; 4],
            through: [1.0; 4],
        };
        let mut from_mm = 0.0;
        loop {
            let met = solids.nearest(ray, path.inside);
            let until_mm = met.as_ref().map_or(f64::INFINITY, |met| met.meeting.at_mm);
            self.add_media(&mut media, ray, path, from_mm..until_mm, &mut view);
            let Some(met) = met.filter(|_| !view.is_closed()) else {
                return view.light;
            };
            view.absorb(self.world, path.inside, until_mm - from_mm);
            let weight = path.weight * view.passing() * met.meeting.opacity;
            let answer = self.surface(ray, Path { weight, ..path }, &met);
            view.add(&answer.light, met.meeting.opacity);
            let opacity = met.meeting.opacity;
            view.through = view.through.map(|t| t * (1.0 - opacity + opacity * answer.straight));
            if view.is_closed() || met.meeting.is_full() {
                return view.light;
            }
            from_mm = until_mm;
        }
    }

    /// Composites the samples of media in a part of a ray.
    fn add_media(&mut self, media: &mut Media, ray: &Ray, path: Path, mm: Range<f64>, view: &mut View) {
        let mut known: Option<Response> = None;
        media.march(mm, self.phase, |mm, slabs, probes| {
            let clear: f64 = slabs.iter().map(|slab| 1.0 - slab.opacity).product();
            let sum: f64 = slabs.iter().map(|slab| slab.opacity).sum();
            for slab in slabs {
                let opacity = (1.0 - clear) * slab.opacity / sum;
                let matters = path.weight * view.passing() * opacity >= self.bounds.least_weight;
                // Samples that hardly matter are lit like the one before.
                let response = match known.filter(|_| !matters) {
                    Some(response) => response,
                    None => self.sample_response(ray, mm, path, &probes[slab.probe]),
                };
                known = Some(response);
                let [r, g, b] = response.of(slab.color);
                view.add(&[r, g, b, 1.0], opacity);
            }
            view.through = view.through.map(|through| through * clear);
            match view.is_closed() {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        });
    }

    fn sample_response(&mut self, ray: &Ray, mm: f64, path: Path, probe: &Probe) -> Response {
        let scale = probe.object.spacing_mm() / self.world.look().soft_gradient;
        let steep = probe.gradient(ray.at(mm)) * scale;
        let place = Place {
            ray,
            mm,
            normal: steep / (1.0 + steep.length_squared()).sqrt(),
            lit: Lit::Both,
            inside: path.inside,
        };
        place.response(self.world, self.bounds.light_parts, &mut self.stream)
    }

    /// What a surface gives to a ray that meets it with weight `path.weight`.
    fn surface(&mut self, ray: &Ray, path: Path, met: &Met) -> Answer {
        let [before, behind] = self.indices(path.inside, met);
        let cos = -ray.direction.dot(met.facing);
        let shares = met.optics.shares(cos.max(0.0), before, behind);
        let mut light = [0.0; 4];
        if shares.scattered > 0.0 {
            let [r, g, b] = self.scattered(ray, path, met);
            add(&mut light, &[r, g, b, 1.0], shares.scattered);
        }
        if shares.reflected > 0.0 {
            let mirrored = ray.turned(met.meeting.at_mm, reflect(ray.direction, met.facing));
            let seen = self.spawned(&mirrored, path, path.inside, shares.reflected);
            let [r, g, b, _] = seen.unwrap_or_default();
            add(&mut light, &[r, g, b, 1.0], shares.reflected);
        }
        if !met.meeting.is_full() || shares.transmitted <= 0.0 {
            let straight = shares.transmitted;
            return Answer { light, straight };
        }
        if let Some(bent) = refract(ray.direction, met.facing, before, behind) {
            let bent = ray.turned(met.meeting.at_mm, bent);
            let inside = path.inside.toggled(met.object);
            let seen = self.spawned(&bent, path, inside, shares.transmitted);
            add(&mut light, &seen.unwrap_or_default(), shares.transmitted);
        }
        Answer { light, straight: 0.0 }
    }

    /// The indices of refraction before and behind a surface. An opaque surface without an index of its own mirrors by none.
    fn indices(&self, inside: Inside, met: &Met) -> [f64; 2] {
        let before = self.world.index(inside);
        let behind = match met.optics {
            optics if optics.transmits() => self.world.index(inside.toggled(met.object)),
            optics if optics.index() == 1.0 => before,
            optics => optics.index(),
        };
        [before, behind]
    }

    fn scattered(&mut self, ray: &Ray, path: Path, met: &Met) -> [f64; 3] {
        let place = Place {
            ray,
            mm: met.meeting.at_mm,
            normal: met.facing,
            lit: Lit::Front,
            inside: path.inside,
        };
        place
            .response(self.world, self.bounds.light_parts, &mut self.stream)
            .of(met.color)
    }

    /// What a spawned ray of a part of another one's weight sees, before the environment; `None` if there is none and nothing is seen.
    fn spawned(&mut self, ray: &Ray, parent: Path, inside: Inside, share: f64) -> Option<Light> {
        let path = Path {
            inside,
            generation: parent.generation + 1,
            weight: parent.weight * share,
        };
        let followed = path.generation <= self.bounds.depth && path.weight >= self.bounds.least_weight;
        let seen = if followed { self.seen(ray, path) } else { [0.0; 4] };
        match self.world.look().environment {
            Some(environment) => {
                let behind = 1.0 - seen[3];
                let [r, g, b] = [0, 1, 2].map(|c| seen[c] + behind * environment[c]);
                Some([r, g, b, 1.0])
            }
            None => followed.then_some(seen),
        }
    }
}

fn add(sum: &mut Light, light: &Light, share: f64) {
    for (sum, light) in sum.iter_mut().zip(light) {
        *sum += share * light;
    }
}

/// What has been seen along a ray.
struct View {
    light: Light,
    /// How much of what is behind shows, in each channel.
    through: [f64; 4],
}

impl View {
    fn add(&mut self, light: &Light, share: f64) {
        for (n, sum) in self.light.iter_mut().enumerate() {
            *sum += share * self.through[n] * light[n];
        }
    }

    /// The most that passes of any channel.
    fn passing(&self) -> f64 {
        self.through[..3].iter().fold(0.0, |most: f64, t| most.max(*t))
    }

    fn is_closed(&self) -> bool {
        self.passing() < OPAQUE
    }

    /// Dims what is behind by what is `inside`.
    fn absorb(&mut self, world: &World, inside: Inside, length_mm: f64) {
        for (n, object) in world.objects().iter().enumerate() {
            if let Some(optics) = object.optics.filter(|_| inside.has(n)) {
                let tint = optics.through(length_mm.max(0.0));
                for (through, tint) in self.through.iter_mut().zip(tint) {
                    *through *= tint;
                }
            }
        }
    }
}

/// The solids that a ray may meet.
struct Solids<'a> {
    solids: Vec<Solid<'a>>,
}

struct Solid<'a> {
    object: usize,
    optics: &'a Optics,
    probe: Probe<'a>,
    from_mm: f64,
    met: Option<Meeting>,
}

impl<'a> Solids<'a> {
    fn new(world: &'a World, ray: &Ray) -> Self {
        let solid = |(object, of): (usize, &'a super::object::Object)| {
            let optics = of.optics.as_ref().filter(|_| of.classifier.shows())?;
            let probe = of.probe(ray);
            let stretch = probe.stretch();
            (stretch.enter < stretch.leave && stretch.leave > 0.0).then_some(Solid {
                object,
                optics,
                probe,
                from_mm: 0.0,
                met: None,
            })
        };
        Self {
            solids: world.objects().iter().enumerate().filter_map(solid).collect(),
        }
    }

    /// The nearest surface that has not been met yet.
    fn nearest(&mut self, ray: &Ray, inside: Inside) -> Option<Met<'a>> {
        let mut until_mm = f64::INFINITY;
        let mut nearest = None;
        for (n, solid) in self.solids.iter_mut().enumerate() {
            let within = inside.has(solid.object);
            if solid.met.is_none() {
                solid.met = surface::next(&mut solid.probe, within, solid.from_mm, until_mm);
            }
            if let Some(met) = solid.met.filter(|met| met.at_mm < until_mm) {
                until_mm = met.at_mm;
                nearest = Some(n);
            }
        }
        self.solids.get_mut(nearest?)?.take(ray, inside)
    }
}

impl<'a> Solid<'a> {
    fn take(&mut self, ray: &Ray, inside: Inside) -> Option<Met<'a>> {
        let meeting = self.met.take()?;
        self.from_mm = meeting.end_mm;
        let sample = self.probe.sample(meeting.at_mm);
        let color = match sample.coverage > 0.0 {
            true => self.probe.object.classifier.tissue(&sample).color,
            false => [0.0; 3],
        };
        let normal = meeting.normal(&self.probe, ray);
        let towards = if inside.has(self.object) { -normal } else { normal };
        Some(Met {
            object: self.object,
            optics: self.optics,
            meeting,
            color,
            facing: facing(towards, ray.direction),
        })
    }
}

/// A unit normal on the side that a ray comes from. A grazing ray that would see it from behind, for its rounding, sees its edge.
fn facing(normal: DVec3, direction: DVec3) -> DVec3 {
    let cos = normal.dot(direction);
    if cos <= 0.0 {
        return normal;
    }
    (normal - cos * direction).try_normalize().unwrap_or(-direction)
}
