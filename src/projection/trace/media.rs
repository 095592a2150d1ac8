//! Samples of media along a ray.
//!
//! *Theory.* A pixel's colour is made of the shaded samples along its ray, composited from front to back until nothing more shows.
//! Volumes may overlap, each at its own resolution and pose: where several are at a point their opacities are united by the algebraic sum
//! (WK94, *intermixing*), and their colours by opacity.
//! *Practice.* All media that a ray goes through are sampled at the finest one's steps. Opacities hold for a length, so the step does not change
//! how dense things look.

use std::ops::{ControlFlow, Range};

use super::object::{Object, Probe};
use super::ray::Ray;
use super::voxels::Quest;

/// One medium's part of a step.
#[derive(Clone, Copy, Debug)]
pub struct Slab {
    /// Which of the media that the ray goes through.
    pub probe: usize,
    /// Straight colour.
    pub color: [f64; 3],
    /// Opacity over the step, coverage counted in.
    pub opacity: f64,
}

/// The media that a ray goes through.
pub struct Media<'a> {
    /// Each of them along the ray.
    pub probes: Vec<Probe<'a>>,
    step_mm: f64,
}

impl<'a> Media<'a> {
    /// Those of `objects` without a surface that `ray` goes through, `samples_per_voxel` of each voxel.
    pub fn new(objects: &'a [Object], ray: &Ray, samples_per_voxel: f64) -> Self {
        let seen = |object: &'a Object| {
            let probe = object.probe(ray);
            let stretch = probe.stretch();
            (stretch.enter < stretch.leave && stretch.leave > 0.0).then_some(probe)
        };
        let media = objects
            .iter()
            .filter(|object| object.optics.is_none() && object.classifier.shows());
        let probes: Vec<Probe> = media.filter_map(seen).collect();
        let step_mm = |probe: &Probe| probe.object.spacing_mm() * probe.coarseness() / samples_per_voxel;
        Self {
            step_mm: probes.iter().map(step_mm).fold(f64::INFINITY, f64::min),
            probes,
        }
    }

    /// Gives `visit` the slabs of each step in a part of the ray in which something shows, until it breaks off; the first step is the
    /// part `phase` of a step behind the ray's origin.
    pub fn march(
        &mut self,
        mm: Range<f64>,
        phase: f64,
        mut visit: impl FnMut(f64, &[Slab], &[Probe]) -> ControlFlow<()>,
    ) {
        let Some(inside) = self.inside(mm) else { return };
        let place = |k: i64| (k as f64 + phase) * self.step_mm;
        let after = |mm: f64| (mm / self.step_mm - phase).ceil() as i64;
        let mut k = after(inside.start);
        let mut known_until = f64::NEG_INFINITY;
        let mut slabs = Vec::with_capacity(self.probes.len());
        while place(k) < inside.end {
            let at = place(k);
            if at >= known_until {
                let (worthwhile, end) = region(&mut self.probes, at);
                if !worthwhile {
                    k = after(end).max(k + 1);
                    continue;
                }
                known_until = end;
            }
            slabs.clear();
            for (n, probe) in self.probes.iter_mut().enumerate() {
                slabs.extend(slab(n, probe, at, self.step_mm));
            }
            if !slabs.is_empty() && visit(at, &slabs, &self.probes).is_break() {
                return;
            }
            k += 1;
        }
    }

    /// The part of a stretch of the ray in which there are media.
    fn inside(&self, mm: Range<f64>) -> Option<Range<f64>> {
        let stretches = self.probes.iter().map(Probe::stretch);
        let [enter, leave] = stretches.fold([f64::INFINITY, f64::NEG_INFINITY], |[enter, leave], s| {
            [enter.min(s.enter), leave.max(s.leave)]
        });
        let inside = mm.start.max(enter)..mm.end.min(leave);
        (inside.start < inside.end).then_some(inside)
    }
}

/// Whether anything can show at a place, and how far that holds.
fn region(probes: &mut [Probe], mm: f64) -> (bool, f64) {
    probes
        .iter_mut()
        .fold((false, f64::INFINITY), |(worthwhile, end), probe| {
            let region = probe.region(mm, Quest::Shown);
            (worthwhile || region.worthwhile, end.min(region.end))
        })
}

fn slab(n: usize, probe: &mut Probe, mm: f64, step_mm: f64) -> Option<Slab> {
    let sample = probe.sample(mm);
    if sample.coverage <= 0.0 {
        return None;
    }
    let classifier = &probe.object.classifier;
    let tissue = classifier.tissue(&sample);
    let opacity = sample.coverage * tissue.opacity(step_mm);
    (opacity > 0.0).then_some(Slab {
        probe: n,
        color: tissue.color,
        opacity,
    })
}
