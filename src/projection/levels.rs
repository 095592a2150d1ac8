//! A frame of several levels: cut in depth into zones, each drawn from the level that its pixels ask for (WK94, figure 7).
//!
//! *Theory.* At the depth where a pixel covers 2^l voxels of the base, level l has as many voxels as there are pixels. Zone l
//! reaches from there to where level l + 1 has. *Over* is associative, so zones are drawn one by one and put together.
//! *Changes from the paper.* WK94 interpolates between two stored levels. A zone holds what lies between them, with the share of
//! the next one at each voxel's own depth ([`Grade`]): at a zone's far face it is the next level alone,
//! as at the near face of the zone behind, and nothing pops.
//! *Practice.* All zones share one comb of slabs, 2^l of them in a slab of zone l, and zones meet between whole slabs of both: so
//! each depth belongs to one slab, and each slab to one zone. So a face may lie half a slab from where the next level is reached, and
//! the share there be off by half a slab over d ln 2: 0.72 over the focal length in pixels and the samples a voxel, on every level, which
//! is less than a step of 8 bits in a frame of some hundred pixels. The comb begins at a corner of the base lattice and moves with
//! the model, not with the zones.

use glam::DVec3;

use super::{Camera, Lens, Planes, Settings, SlicePlan};
use crate::math::{Aabb, Plane};
use crate::target::{Block, Lattice, Levels};
use crate::voxelize::{Footprint, Grade};

/// A stretch of depth that is drawn from one level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zone {
    /// Its level.
    pub level: u32,
    /// Where it begins, millimetres from the eye.
    pub near_mm: f64,
    /// Where it ends, above that; it belongs to what is behind.
    pub far_mm: f64,
}

/// The zones of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Zones {
    /// The zones that hold a part of the model, the nearest first.
    pub zones: Vec<Zone>,
    /// The depths that a depth cue spans, millimetres: those of the base.
    pub cue_mm: [f64; 2],
    /// The middles of the slabs of level 0.
    pub comb: Planes,
}

/// What a pixel of `camera` covers, in the world.
pub fn footprint(camera: &Camera) -> Footprint {
    let in_eye = match camera.lens {
        Lens::Orthographic { pixels_per_mm } => Footprint {
            gradient: DVec3::ZERO,
            offset: pixels_per_mm.recip(),
        },
        Lens::Perspective { focal_px, .. } => Footprint {
            gradient: DVec3::Z / focal_px,
            offset: 0.0,
        },
    };
    in_eye.moved(&camera.eye_from_world)
}

impl Zones {
    /// The zones of what `camera` sees of `levels`, with `samples_per_voxel` slabs for a voxel of each level.
    pub fn new(levels: &Levels, camera: &Camera, samples_per_voxel: f64) -> Self {
        let comb = Planes::new(&levels.base, camera, samples_per_voxel);
        let depths = |bounds: Aabb| bounds.transformed(&camera.eye_from_world);
        let (base, all) = (depths(levels.base.world_bounds()), depths(levels.bounds));
        let (first, last) = (all.min.z.max(camera.near_mm()), all.max.z);
        let faces = faces(levels, camera, &comb);
        let zone = |(level, pair): (usize, &[f64])| {
            let (near_mm, far_mm) = (pair[0].max(first), pair[1].min(last));
            (near_mm < far_mm).then_some(Zone {
                level: level as u32,
                near_mm,
                far_mm,
            })
        };
        Self {
            zones: faces.windows(2).enumerate().filter_map(zone).collect(),
            cue_mm: [base.min.z, base.max.z],
            comb,
        }
    }
}

/// Where zones meet, one more than there are levels, never falling.
fn faces(levels: &Levels, camera: &Camera, comb: &Planes) -> Vec<f64> {
    let mut faces = vec![f64::NEG_INFINITY];
    for level in 1..levels.count {
        let voxel_mm = levels.voxel_mm(level);
        let face = match camera.lens {
            Lens::Orthographic { pixels_per_mm } if pixels_per_mm * voxel_mm <= 1.0 => f64::NEG_INFINITY,
            Lens::Orthographic { .. } => f64::INFINITY,
            Lens::Perspective { focal_px, .. } => whole_slabs(comb, level, focal_px * voxel_mm),
        };
        faces.push(face.max(faces[level as usize - 1]));
    }
    faces.push(f64::INFINITY);
    faces
}

/// The face between slabs of `level` that is nearest to `depth_mm`.
fn whole_slabs(comb: &Planes, level: u32, depth_mm: f64) -> f64 {
    let slab_mm = slab_mm(comb, level);
    let first = comb.first_mm - 0.5 * comb.step_mm;
    first + ((depth_mm - first) / slab_mm).round() * slab_mm
}

/// The thickness of a slab of `level`.
fn slab_mm(comb: &Planes, level: u32) -> f64 {
    comb.step_mm * Grade::WIDER.powi(level as i32)
}

impl Zone {
    /// The middles of its level's slabs.
    pub fn planes(&self, comb: &Planes) -> Planes {
        let step_mm = slab_mm(comb, self.level);
        Planes {
            first_mm: comb.first_mm + 0.5 * (step_mm - comb.step_mm),
            step_mm,
        }
    }

    /// Whether a depth is in it.
    pub fn holds(&self, depth_mm: f64) -> bool {
        self.near_mm <= depth_mm && depth_mm < self.far_mm
    }

    /// `plan` without the slices of other zones, its depth cue that of the whole frame.
    pub fn part_of(&self, mut plan: SlicePlan, zones: &Zones) -> SlicePlan {
        let slices = std::mem::take(&mut plan.slices);
        plan.slices = slices.into_iter().filter(|s| self.holds(plan.depth_mm(s))).collect();
        plan.cue_mm = zones.cue_mm;
        plan
    }

    /// `settings` for its target, which is on `lattice`: the slabs of the comb, and gradients that are as soft a millimetre on
    /// every level, so that shading does not jump where zones meet.
    pub fn settings(&self, settings: &Settings, comb: &Planes, base: &Lattice, lattice: &Lattice) -> Settings {
        let finest_mm = lattice.spacing_mm().min_element();
        let mut settings = settings.clone();
        settings.samples_per_voxel = finest_mm / slab_mm(comb, self.level);
        if let Some(shading) = &mut settings.shading {
            shading.soft_gradient *= finest_mm / base.spacing_mm().min_element();
        }
        settings
    }

    /// The planes (world) beyond which no voxel of its level, `voxel_mm` apart, is seen or has a part in what is seen.
    pub fn sides(&self, camera: &Camera, voxel_mm: f64) -> Vec<Plane> {
        // A sample depends on voxels this far off along each axis, a face on the rounding of its place.
        let margin_mm = (Block::REACH as f64 + 1.0) * 3f64.sqrt() * voxel_mm;
        let across = [
            Plane {
                normal: -DVec3::Z,
                offset: self.near_mm,
            },
            Plane {
                normal: DVec3::Z,
                offset: -self.far_mm,
            },
        ];
        let all = across.into_iter().chain(frame_sides(camera));
        all.map(|plane| Plane {
            normal: camera.eye_from_world.matrix3.transpose() * plane.normal,
            offset: plane.distance(camera.eye_from_world.translation) - margin_mm,
        })
        .collect()
    }
}

/// The planes through the frame's edges, in the eye frame.
fn frame_sides(camera: &Camera) -> impl Iterator<Item = Plane> {
    let outwards = [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y];
    let half = camera.size.map(|n| 0.5 * f64::from(n));
    let lens = camera.lens;
    outwards.into_iter().enumerate().map(move |(side, normal)| {
        let half_px = half[side / 2];
        match lens {
            Lens::Orthographic { pixels_per_mm } => Plane {
                normal,
                offset: -half_px / pixels_per_mm,
            },
            Lens::Perspective { focal_px, .. } => Plane {
                normal: (focal_px * normal - half_px * DVec3::Z).normalize(),
                offset: 0.0,
            },
        }
    })
}
