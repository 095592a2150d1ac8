//! Volumes in the traced world, each with a lattice, a classifier and optics of its own, and the level of detail that a ray takes of one.
//!
//! *Theory.* Objects close to the eye are sampled from a fine level, distant ones from a coarse level; in between the values of the two
//! adjacent levels are interpolated, so that nothing pops (WK94, figure 7).
//! *Changes from the paper.* The level follows from the width of a ray's pixel, not from its depth alone: rays that a mirror or a lens has turned
//! are wider, and take coarser levels. One width holds for all of a ray in an object, that in the middle of its way through the
//! object's box.

use glam::DVec3;

use super::classifier::{Classifier, Sample};
use super::optics::Optics;
use super::ray::{Ray, Stretch};
use super::voxels::{Level, Nearby, Quest, Region, Walk};
use crate::math::Aabb;
use crate::model::TransferFunction;
use crate::projection::half_differences;
use crate::target::Target;

/// A volume and what it is made of.
pub struct Object {
    /// From the finest to the coarsest.
    levels: Vec<Level>,
    /// What its samples are.
    pub classifier: Classifier,
    /// What its surface does with light; a medium without a surface when `None`.
    pub optics: Option<Optics>,
    /// Where it is in the world.
    pub bounds: Aabb,
}

impl Object {
    /// The object that `target` holds, its samples made colours by `transfer` unless they are colours.
    pub fn new(target: &Target, transfer: &TransferFunction, optics: Option<Optics>) -> Self {
        let classifier = Classifier::new(target, transfer);
        Self {
            bounds: target.lattice.world_bounds(),
            levels: vec![Level::new(target, &classifier)],
            classifier,
            optics,
        }
    }

    /// The same with the next coarser level of its model, whose values have the same range.
    pub fn with_level(mut self, target: &Target) -> Self {
        self.bounds = self.bounds.hull(&target.lattice.world_bounds());
        self.levels.push(Level::new(target, &self.classifier));
        self
    }

    /// The smallest distance between voxels of the finest level, millimetres.
    pub fn spacing_mm(&self) -> f64 {
        self.levels[0].lattice.spacing_mm().min_element()
    }

    /// The object as `ray` sees it.
    pub fn probe(&self, ray: &Ray) -> Probe<'_> {
        let whole = Walk::new(&self.levels[0], ray);
        let middle_mm = 0.5 * (whole.enter.max(0.0) + whole.leave);
        let (fine, part) = self.detail(ray.width_at(middle_mm.max(0.0)));
        let coarse = (part > 0.0).then(|| (Walk::new(&self.levels[fine + 1], ray), part));
        let fine = match fine {
            0 => whole,
            level => Walk::new(&self.levels[level], ray),
        };
        Probe {
            object: self,
            fine,
            coarse,
        }
    }

    /// The object at a place of the world, in all detail.
    pub fn density_at(&self, world: DVec3) -> f64 {
        match self.levels[0].holds(world) {
            true => self.classifier.density(&Nearby::new(&self.levels[0]).sample(world)),
            false => 0.0,
        }
    }

    /// The finer of the two levels whose voxels are about as wide as a pixel, and how much of the next one is seen.
    fn detail(&self, width_mm: f64) -> (usize, f64) {
        let last = self.levels.len() - 1;
        let octaves = (width_mm / self.levels[0].voxel_mm()).log2();
        if last == 0 || octaves.is_nan() || octaves <= 0.0 {
            return (0, 0.0);
        }
        if octaves >= last as f64 {
            return (last, 0.0);
        }
        (octaves as usize, octaves.fract())
    }
}

/// An object along a ray: one level, or two and how much of the second is seen.
pub struct Probe<'a> {
    /// The object.
    pub object: &'a Object,
    fine: Walk<'a>,
    coarse: Option<(Walk<'a>, f64)>,
}

impl Probe<'_> {
    /// Where the ray enters and leaves the object's box, millimetres, and the axes of the faces there.
    pub fn stretch(&self) -> Stretch {
        let fine = Stretch {
            enter: self.fine.enter,
            leave: self.fine.leave,
            axes: self.fine.axes,
        };
        match &self.coarse {
            Some((coarse, _)) if coarse.enter < coarse.leave => {
                // A coarser level has wider filters, and so the larger box.
                Stretch {
                    enter: fine.enter.min(coarse.enter),
                    leave: fine.leave.max(coarse.leave),
                    axes: fine.axes,
                }
            }
            _ => fine,
        }
    }

    /// Half a voxel, millimetres of ray.
    pub fn half_voxel(&self) -> f64 {
        self.fine.half_voxel()
    }

    /// Voxels of the level that is seen for each of the finest level.
    pub fn coarseness(&self) -> f64 {
        let finest = &self.object.levels[0];
        self.fine.level().voxel_mm() / finest.voxel_mm()
    }

    /// The region that the place `mm` is in, for `quest`.
    pub fn region(&mut self, mm: f64, quest: Quest) -> Region {
        let fine = self.fine.region(mm, quest);
        let Some((coarse, _)) = &mut self.coarse else {
            return fine;
        };
        let coarse = coarse.region(mm, quest);
        Region {
            worthwhile: fine.worthwhile || coarse.worthwhile,
            end: fine.end.min(coarse.end),
        }
    }

    /// The sample at the place `mm`.
    pub fn sample(&mut self, mm: f64) -> Sample {
        let fine = self.fine.sample(mm);
        match &mut self.coarse {
            Some((coarse, part)) => fine.mixed(&coarse.sample(mm), *part),
            None => fine,
        }
    }

    /// The density at the place `mm`.
    pub fn density(&mut self, mm: f64) -> f64 {
        let sample = self.sample(mm);
        self.object.classifier.density(&sample)
    }

    /// The gradient about a place of the world of what normals are the gradient of, by central differences.
    pub fn gradient(&self, world: DVec3) -> DVec3 {
        let level = self.fine.level();
        let mut around = self.around();
        level.gradient(level.axes().map(|step| {
            let [before, behind] = [-step, step].map(|by| self.object.classifier.height(&around.sample(world + by)));
            0.5 * (behind - before)
        }))
    }

    /// The same, by differences smoothed across ([`half_differences`]), and the same of density.
    pub fn surface_gradients(&self, world: DVec3) -> [DVec3; 2] {
        let level = self.fine.level();
        let [x, y, z] = level.axes();
        let by = |n: usize| n as f64 - 1.0;
        let mut around = self.around();
        let sample = |n: usize| around.sample(world + x * by(n % 3) + y * by(n / 3 % 3) + z * by(n / 9));
        let samples: [Sample; 27] = std::array::from_fn(sample);
        let classifier = &self.object.classifier;
        let slope = |numbers: [f64; 27]| {
            let differences = half_differences(|[x, y, z]| numbers[(13 + x + 3 * y + 9 * z) as usize]);
            level.gradient(differences.to_array())
        };
        [
            slope(samples.map(|sample| classifier.height(&sample))),
            slope(samples.map(|sample| classifier.density(&sample))),
        ]
    }

    /// The direction across the face of the lattice's box that the ray enters (0) or leaves (1) by, outwards.
    pub fn face_normal(&self, side: usize) -> DVec3 {
        let axis = self.fine.axes[side];
        let mut across = [0.0; 3];
        let towards = if side == 0 { -1.0 } else { 1.0 };
        across[axis] = towards * self.fine.line.step[axis].signum();
        self.fine.level().gradient(across).normalize_or_zero()
    }

    /// Its samples off the ray.
    fn around(&self) -> Around<'_> {
        Around {
            fine: Nearby::new(self.fine.level()),
            coarse: self
                .coarse
                .as_ref()
                .map(|(coarse, part)| (Nearby::new(coarse.level()), *part)),
        }
    }
}

/// An object about a place, in the detail that a ray sees.
struct Around<'a> {
    fine: Nearby<'a>,
    coarse: Option<(Nearby<'a>, f64)>,
}

impl Around<'_> {
    fn sample(&mut self, world: DVec3) -> Sample {
        let fine = self.fine.sample(world);
        match &mut self.coarse {
            Some((coarse, part)) => fine.mixed(&coarse.sample(world), *part),
            None => fine,
        }
    }
}
