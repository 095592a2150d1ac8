//! How much light reaches a point.
//!
//! *Theory.* Shadow rays are cast as all rays are, so shadows have no jagged borders, and volumes cast shadows as thin as they are.
//! *Practice.* Light goes straight: a solid that lets light through dims it by what its surfaces mirror and tints it, and does not gather
//! it. Half of the light that a medium scatters goes on forwards, so a shadow has something of the colour of what casts it.

use std::ops::ControlFlow;

use super::light::Beam;
use super::media::Media;
use super::ray::Ray;
use super::surface;
use super::world::{Inside, World};

/// The part of scattered light that goes on forwards.
const FORWARDS: f64 = 0.5;

/// Where less light than this is left, none is.
const DARK: f64 = 1.0 / 512.0;

/// What is left, in each channel, of a beam at the origin of `ray`, which goes to its light and begins `inside` of some solids; samples of media
/// are half a step and the part `phase` of one behind the origin.
pub fn visibility(world: &World, ray: &Ray, beam: &Beam, inside: Inside, phase: f64) -> [f64; 3] {
    let mut left = [1.0; 3];
    for (n, object) in world.objects().iter().enumerate() {
        if object.optics.is_some() {
            pass_solid(world, n, ray, beam, inside, &mut left);
        }
        if is_dark(&left) {
            return [0.0; 3];
        }
    }
    pass_media(world, ray, beam, phase, &mut left);
    left
}

fn is_dark(left: &[f64; 3]) -> bool {
    left.iter().all(|left| *left < DARK)
}

fn pass_solid(world: &World, n: usize, ray: &Ray, beam: &Beam, inside: Inside, left: &mut [f64; 3]) {
    let object = &world.objects()[n];
    let Some(optics) = &object.optics else { return };
    let mut probe = object.probe(ray);
    let mut within = inside.has(n);
    let [mut from_mm, mut entered_mm] = [0.0; 2];
    while !is_dark(left) {
        let met = surface::next(&mut probe, within, from_mm, beam.distance_mm);
        if within {
            let length_mm = met.map_or(beam.distance_mm, |met| met.at_mm) - entered_mm;
            let through = optics.through(length_mm.clamp(0.0, f64::MAX));
            *left = [0, 1, 2].map(|c| left[c] * through[c]);
        }
        let Some(met) = met.filter(|met| met.at_mm < beam.distance_mm) else {
            return;
        };
        let passing = match optics.transmits() {
            true => {
                let cos = met.normal(&probe, ray).dot(ray.direction).abs();
                // As from outside: straight light is not mirrored back for good.
                optics.shares(cos, 1.0, optics.index()).transmitted
            }
            false => 0.0,
        };
        *left = left.map(|left| left * (1.0 - met.opacity * (1.0 - passing)));
        within ^= met.is_full();
        entered_mm = met.at_mm;
        from_mm = met.end_mm.max(met.at_mm);
    }
}

fn pass_media(world: &World, ray: &Ray, beam: &Beam, phase: f64, left: &mut [f64; 3]) {
    let mut media = Media::new(world.objects(), ray, world.samples_per_voxel());
    // The sample that is lit does not shade itself.
    media.march(0.0..beam.distance_mm, 0.5 + phase, |_, slabs, _| {
        for slab in slabs {
            let clear = 1.0 - slab.opacity;
            *left = [0, 1, 2].map(|c| left[c] * clear.powf(1.0 - FORWARDS * slab.color[c]));
        }
        match is_dark(left) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    });
    if is_dark(left) {
        *left = [0.0; 3];
    }
}
