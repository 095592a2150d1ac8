//! A primitive: a solid or a shell of one value, how soft its surface is, and what it is where it is put.
//!
//! *Theory.* A volume-sampled primitive is the convolution of its solid with the filter (WK94). That of a shell is the
//! difference of two: of the solid, and of what is left when its surface moves inwards.
//! *Changes from the paper.* Densities are computed where they are asked for, so that a primitive is as sharp as the lattice it
//! is sampled on. Voxelised onto a lattice of its own it is a volume ([`beams`](super::beams)).
//! *Practice.* The filter is a ball in the world. A primitive that is put with a stretch or a shear sees it as an ellipsoid.

use glam::{DAffine3, DMat3, DVec3};

use super::filter::{self, Support};
use super::grade::Grade;
use super::solid::{NoInset, Solid, TOGETHER};
use crate::math::{Aabb, Interval, Overlap};
use crate::volume::{Field, Sample, SampleRange};

/// A geometric primitive in its own frame, millimetres.
#[derive(Clone, Debug, PartialEq)]
pub struct Primitive {
    /// Its outside.
    pub solid: Solid,
    /// What is taken out of it, where it is a shell.
    pub hollow: Option<Solid>,
    /// The filter's radius in voxels of the lattice that it is sampled on; 0 for coverage that is 0 or 1.
    pub filter_voxels: f64,
    /// Its value.
    pub value: f32,
}

impl Primitive {
    /// The widest filter, in voxels.
    pub const MAX_FILTER_VOXELS: f64 = 64.0;

    /// A solid with the default filter.
    pub fn soft(solid: Solid, value: f32) -> Self {
        Self {
            solid,
            hollow: None,
            filter_voxels: filter::DEFAULT_RADIUS_VOXELS,
            value,
        }
    }

    /// A solid that is there or not, by each voxel's middle (WK94's point sampling).
    pub fn crisp(solid: Solid, value: f32) -> Self {
        Self {
            filter_voxels: 0.0,
            ..Self::soft(solid, value)
        }
    }

    /// The shell of `thickness` inside the surface; all of the solid where that leaves no inside.
    ///
    /// # Errors
    /// If the solid's inside has no form here.
    pub fn shell(self, thickness: f64) -> Result<Self, NoInset> {
        let hollow = self.solid.inset(thickness)?;
        Ok(Self { hollow, ..self })
    }

    /// The primitive put into the world and sampled every `voxel_mm`, above 0.
    pub fn placed(&self, world_from_local: &DAffine3, voxel_mm: f64) -> Placed {
        let local_from_world = world_from_local.inverse();
        let radius_mm = self.filter_voxels * voxel_mm;
        let support = (radius_mm > 0.0)
            .then(|| Support::new(local_from_world.matrix3 * DMat3::from_diagonal(DVec3::splat(radius_mm))));
        let stretched = support.is_some_and(|support| !support.is_ball);
        if stretched && let Some(solid) = self.solid.moved(world_from_local) {
            return Placed {
                solid,
                hollow: self.hollow.as_ref().and_then(|hollow| hollow.moved(world_from_local)),
                support: Some(Support::ball(radius_mm)),
                wider: None,
                value: self.value,
                local_from_world: DAffine3::IDENTITY,
            };
        }
        let softened = |solid: &Solid| support.as_ref().map_or(solid.clone(), |by| solid.softened(by));
        Placed {
            solid: softened(&self.solid),
            hollow: self.hollow.as_ref().map(softened),
            support,
            wider: None,
            value: self.value,
            local_from_world,
        }
    }
}

/// A primitive and the filter that it is sampled with.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
    solid: Solid,
    hollow: Option<Solid>,
    /// `None` for a crisp one.
    support: Option<Support>,
    /// The filter that it changes to on the way to the next level, if it does.
    wider: Option<Wider>,
    value: f32,
    /// From the world to the frame in which it is evaluated.
    pub local_from_world: DAffine3,
}

/// The next level's filter, and where it takes over.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Wider {
    support: Support,
    grade: Grade,
}

impl Placed {
    /// The same, changing to the next level's filter as `grade` (world) says. A crisp one has no filter to change.
    pub fn graded(self, grade: &Grade) -> Self {
        let wider = self.support.map(|support| Wider {
            support: Support::new(support.local_from_unit * Grade::WIDER),
            grade: grade.moved(&self.local_from_world.inverse()),
        });
        let softened = |solid: Solid| wider.as_ref().map_or(solid.clone(), |by| solid.softened(&by.support));
        Self {
            solid: softened(self.solid),
            hollow: self.hollow.map(softened),
            wider,
            ..self
        }
    }

    /// The widest filter that it is sampled with.
    fn widest(&self) -> Option<&Support> {
        self.wider
            .as_ref()
            .map(|wider| &wider.support)
            .or(self.support.as_ref())
    }

    /// Its value.
    pub fn value(&self) -> f32 {
        self.value
    }

    /// How far beyond the surface it is more than nothing, in its frame.
    pub fn reach(&self) -> f64 {
        self.widest().map_or(0.0, |support| support.reach)
    }

    /// A box of its frame outside which it is nothing; infinite for a half-space.
    pub fn local_bounds(&self) -> Aabb {
        self.solid.bounds().expand(DVec3::splat(self.reach()))
    }

    /// At most the distances of up to [`TOGETHER`] points of its frame to the surface of the solid or shell; above 0 outside.
    pub(super) fn distances(&self, points: &[DVec3], distances: &mut [f64]) {
        self.solid.distances(points, distances);
        if let Some(hollow) = &self.hollow {
            let mut inner = [0.0; TOGETHER];
            hollow.distances(points, &mut inner[..points.len()]);
            for (distance, inner) in distances.iter_mut().zip(inner) {
                *distance = distance.max(-inner);
            }
        }
    }

    /// The half-space that it is, moved outwards to where it is nothing.
    pub fn as_half_space(&self) -> Option<crate::math::Plane> {
        match self.solid {
            Solid::HalfSpace(plane) => Some(crate::math::Plane {
                offset: plane.offset - self.reach(),
                ..plane
            }),
            _ => None,
        }
    }

    /// The coverage at `p`, a point of its frame.
    pub fn coverage(&self, p: DVec3) -> f32 {
        let mut coverage = [0.0];
        self.coverages(&[p], &mut coverage);
        coverage[0]
    }

    /// [`Self::coverage`] at up to [`TOGETHER`] points of its frame at once.
    pub(super) fn coverages(&self, points: &[DVec3], coverages: &mut [f32]) {
        let mut densities = [0.0; TOGETHER];
        self.densities(&self.solid, points, &mut densities);
        if let Some(hollow) = &self.hollow {
            let mut inner = [0.0; TOGETHER];
            self.densities(hollow, points, &mut inner);
            for (density, inner) in densities.iter_mut().zip(inner) {
                *density = (*density - inner).max(0.0);
            }
        }
        for (coverage, density) in coverages.iter_mut().zip(densities) {
            *coverage = density as f32;
        }
    }

    fn densities(&self, solid: &Solid, points: &[DVec3], densities: &mut [f64; TOGETHER]) {
        match (&self.support, &self.wider) {
            (Some(support), None) => solid.densities(points, support, &mut densities[..points.len()]),
            _ => {
                for (density, p) in densities.iter_mut().zip(points) {
                    *density = self.density(solid, *p);
                }
            }
        }
    }

    /// The density of one of its solids at `p`.
    fn density(&self, solid: &Solid, p: DVec3) -> f64 {
        let Some(support) = &self.support else {
            return f64::from(u8::from(solid.contains(p)));
        };
        let Some(wider) = &self.wider else {
            return solid.density(p, support);
        };
        let share = wider.grade.share(p);
        if share >= 1.0 {
            return solid.density(p, &wider.support);
        }
        let own = solid.density(p, support);
        if share <= 0.0 {
            return own;
        }
        // In this form two equal densities stay what they are.
        own + share * (solid.density(p, &wider.support) - own)
    }

    /// The sample at `p`, a point of its frame.
    #[inline]
    pub fn sample(&self, p: DVec3) -> Sample {
        let coverage = self.coverage(p);
        if coverage > 0.0 {
            Sample {
                value: self.value,
                coverage,
            }
        } else {
            Sample::EMPTY
        }
    }

    /// Where `region`, a box of its frame, lies: full everywhere, empty everywhere, or neither. `margin` is how far points
    /// may be off.
    pub fn overlap(&self, region: &Aabb, margin: f64) -> Overlap {
        let solid = overlap(&self.solid, region, self.reach() + margin);
        let hollow = self
            .hollow
            .as_ref()
            .map(|hollow| overlap(hollow, region, self.reach() + margin));
        match (solid, hollow) {
            (Overlap::Outside, _) | (_, Some(Overlap::Inside)) => Overlap::Outside,
            (Overlap::Inside, None | Some(Overlap::Outside)) => Overlap::Inside,
            _ => Overlap::Partial,
        }
    }

    /// The coverages over a box of its frame.
    pub fn coverage_range(&self, region: &Aabb) -> Interval {
        // The wider the filter, the farther from 0 and 1.
        let Some(support) = self.widest() else {
            return Interval::new(0.0, 1.0);
        };
        let of = |solid: &Solid| {
            let range = solid.distance_range(region);
            let least = 1.0 - filter::most_at(-range.hi / support.reach);
            Interval::new(least as f32, filter::most_at(range.lo / support.reach) as f32)
        };
        let solid = of(&self.solid);
        let hollow = self.hollow.as_ref().map_or(Interval::point(0.0), of);
        // The subtraction and two conversions round.
        let range = Interval::new((solid.lo - hollow.hi).max(0.0), (solid.hi - hollow.lo).max(0.0));
        range.widen_ulps(4.0).intersect(Interval::new(0.0, 1.0))
    }

    fn to_local(&self, p: DVec3) -> DVec3 {
        crate::math::affine::point(&self.local_from_world, p)
    }
}

/// Where a box lies of a solid whose surface is `reach` thick on both sides.
fn overlap(solid: &Solid, region: &Aabb, reach: f64) -> Overlap {
    let range = solid.distance_range(region);
    if range.lo > reach {
        Overlap::Outside
    } else if range.hi < -reach {
        Overlap::Inside
    } else {
        Overlap::Partial
    }
}

/// In world millimetres.
impl Field for Placed {
    fn bounds(&self) -> Aabb {
        self.local_bounds().transformed(&self.local_from_world.inverse())
    }

    fn sample(&self, p: DVec3) -> Sample {
        Placed::sample(self, self.to_local(p))
    }

    /// By central differences over a sixteenth of the filter's radius; 0 for a crisp primitive.
    fn gradient(&self, p: DVec3) -> DVec3 {
        let Some(support) = &self.support else {
            return DVec3::ZERO;
        };
        let step = support.reach / 16.0 / self.local_from_world.matrix3.x_axis.length();
        let along = |axis: DVec3| {
            let at = |p: DVec3| f64::from(self.coverage(self.to_local(p)));
            (at(p + axis * step) - at(p - axis * step)) / (2.0 * step)
        };
        DVec3::from_array(DVec3::AXES.map(along)) * f64::from(self.value)
    }

    fn range(&self, region: &Aabb) -> SampleRange {
        let coverage = self.coverage_range(&region.transformed(&self.local_from_world));
        if coverage.hi <= 0.0 {
            return SampleRange::EMPTY;
        }
        SampleRange {
            value: Interval::point(self.value),
            coverage,
        }
    }
}
