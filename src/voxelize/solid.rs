//! The solids that primitives are made of, each in its own frame, in millimetres.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::filter::Support;
use super::mesh::TriangleSolid;
use super::polyhedron::Polyhedron;
use super::profile::Profile;
use super::relief::{Relief, RoundedBox};
use super::thread::Thread;
use super::{ball, filter, lines, revolved};
use crate::math::{Aabb, Plane, affine};

/// A solid whose density is known.
#[derive(Clone, Debug, PartialEq)]
pub enum Solid {
    /// A ball.
    Sphere {
        /// Its middle.
        center: DVec3,
        /// Its radius, above 0.
        radius: f64,
    },
    /// An axis-aligned box.
    Box(Aabb),
    /// Everything on the kept side of a plane.
    HalfSpace(Plane),
    /// All of space.
    Everything,
    /// A convex solid with plane faces.
    Polyhedron(Polyhedron),
    /// An outline turned about z.
    Revolved(Arc<Profile>),
    /// An outline screwed along z.
    Thread(Arc<Thread>),
    /// A solid between two heights.
    Relief(Relief),
    /// A solid within a closed mesh.
    Mesh(Arc<TriangleSolid>),
}

/// Points whose distances and densities are found together.
pub(super) const TOGETHER: usize = 16;

/// The least and the greatest value of [`Solid::distance`] over a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceRange {
    /// No distance is below it.
    pub lo: f64,
    /// No distance is above it.
    pub hi: f64,
}

impl Solid {
    /// A solid of revolution.
    pub fn revolved(profile: Profile) -> Self {
        Self::Revolved(Arc::new(profile))
    }

    /// A box that holds it; infinite for a half-space.
    pub fn bounds(&self) -> Aabb {
        match self {
            Self::Sphere { center, radius } => Aabb::new(*center, *center).expand(DVec3::splat(*radius)),
            Self::Box(bounds) => *bounds,
            Self::HalfSpace(_) | Self::Everything => Aabb::ALL,
            Self::Polyhedron(polyhedron) => polyhedron.bounds(),
            Self::Revolved(profile) => {
                let (lo, hi) = profile.bounds();
                Aabb::new(DVec3::new(-hi.x, -hi.x, lo.y), DVec3::new(hi.x, hi.x, hi.y))
            }
            Self::Thread(thread) => thread.bounds(),
            Self::Relief(relief) => relief.bounds(),
            Self::Mesh(mesh) => mesh.bounds(),
        }
    }

    /// Whether `p` is inside, the surface included.
    pub fn contains(&self, p: DVec3) -> bool {
        match self {
            Self::Sphere { center, radius } => p.distance_squared(*center) <= radius * radius,
            Self::Box(bounds) => bounds.contains(p),
            Self::Thread(thread) => thread.contains(p),
            Self::Mesh(mesh) => mesh.contains(p),
            _ => self.distance(p) <= 0.0,
        }
    }

    /// A number of at most the distance to the surface, above 0 outside and below 0 inside.
    pub fn distance(&self, p: DVec3) -> f64 {
        match self {
            Self::Sphere { center, radius } => p.distance(*center) - radius,
            Self::Box(bounds) => (bounds.min - p).max(p - bounds.max).max_element(),
            Self::HalfSpace(plane) => plane.distance(p),
            Self::Everything => f64::NEG_INFINITY,
            Self::Polyhedron(polyhedron) => polyhedron.distance(p),
            Self::Revolved(profile) => profile.distance(revolved::beside_axis(p)),
            Self::Thread(thread) => thread.distance(p),
            Self::Relief(relief) => relief.distance(p),
            Self::Mesh(mesh) => mesh.distance(p),
        }
    }

    /// [`Self::distances`]; beyond `limit` on either side that may be said instead, which is quicker for meshes.
    fn distances_within(&self, points: &[DVec3], limit: f64, distances: &mut [f64]) {
        let Self::Mesh(mesh) = self else {
            return self.distances(points, distances);
        };
        for (distance, p) in distances.iter_mut().zip(points) {
            *distance = mesh.distance_within(*p, limit);
        }
    }

    /// [`Self::distance`] for up to [`TOGETHER`] points at once.
    pub(super) fn distances(&self, points: &[DVec3], distances: &mut [f64]) {
        match self {
            Self::Sphere { center, radius } => {
                for (distance, p) in distances.iter_mut().zip(points) {
                    *distance = p.distance(*center) - radius;
                }
            }
            Self::Polyhedron(polyhedron) => polyhedron.distances(points, distances),
            Self::Revolved(profile) => {
                let (mut rho, mut z) = ([0.0; TOGETHER], [0.0; TOGETHER]);
                for ((rho, z), p) in rho.iter_mut().zip(&mut z).zip(points) {
                    (*rho, *z) = revolved::beside_axis(*p).into();
                }
                profile.distances(&rho[..points.len()], &z[..points.len()], distances);
            }
            _ => {
                for (distance, p) in distances.iter_mut().zip(points) {
                    *distance = self.distance(*p);
                }
            }
        }
    }

    /// Bounds of [`Self::distance`] over a box. Where nothing tighter is known they follow from the middle: distances change
    /// by no more than the way between two points.
    pub fn distance_range(&self, region: &Aabb) -> DistanceRange {
        match self {
            Self::Sphere { center, radius } => {
                let nearest = center.clamp(region.min, region.max).distance(*center);
                let farthest = (region.max - *center).abs().max((region.min - *center).abs()).length();
                DistanceRange {
                    lo: nearest - radius,
                    hi: farthest - radius,
                }
            }
            Self::Box(bounds) => DistanceRange {
                lo: (bounds.min - region.max).max(region.min - bounds.max).max_element(),
                hi: (bounds.min - region.min).max(region.max - bounds.max).max_element(),
            },
            Self::HalfSpace(plane) => over_corners(region, |p| plane.distance(p)),
            Self::Everything => DistanceRange {
                lo: f64::NEG_INFINITY,
                hi: f64::NEG_INFINITY,
            },
            _ => {
                let (middle, half) = (self.distance(region.center()), 0.5 * region.size().length());
                DistanceRange {
                    lo: middle - half,
                    hi: middle + half,
                }
            }
        }
    }

    /// The convolution of the solid with the filter of this support, at `p`; exactly 0 and 1 where the support lies outside
    /// and inside. docs/PAPERS.md has the errors.
    ///
    /// # Panics
    /// If the solid has plane faces and the support is not a ball: [`Self::moved`] it to a frame where it is one.
    pub fn density(&self, p: DVec3, support: &Support) -> f64 {
        let mut density = [0.0];
        self.densities(&[p], support, &mut density);
        density[0]
    }

    /// [`Self::density`] at up to [`TOGETHER`] points at once.
    pub(super) fn densities(&self, points: &[DVec3], support: &Support, densities: &mut [f64]) {
        self.distances_within(points, support.reach, densities);
        for (density, p) in densities.iter_mut().zip(points) {
            let distance = *density / support.reach;
            *density = if distance.abs() >= 1.0 {
                f64::from(u8::from(distance < 0.0))
            } else {
                let most = filter::most_at(distance.abs());
                let (least, most) = match distance >= 0.0 {
                    true => (0.0, most),
                    false => (1.0 - most, 1.0),
                };
                self.soft_density(*p, distance, support).max(least).min(most)
            };
        }
    }

    /// The density at `p`, `distance` filter radii from the surface.
    #[inline]
    fn soft_density(&self, p: DVec3, distance: f64, support: &Support) -> f64 {
        match self {
            Self::Sphere { radius, .. } if support.is_ball => {
                let radius = radius / support.reach;
                ball::density(distance + radius, radius)
            }
            Self::Sphere { center, radius } => ball_integrated(p - *center, *radius, support),
            Self::Box(bounds) => Polyhedron::cuboid(bounds).density(p, distance, support),
            Self::HalfSpace(_) => filter::half_space(distance),
            Self::Everything => 1.0,
            Self::Polyhedron(polyhedron) => polyhedron.density(p, distance, support),
            Self::Revolved(profile) => revolved::density(profile, p, distance, support),
            Self::Thread(thread) => thread.density(p, support),
            Self::Relief(relief) => relief.density(p, support),
            Self::Mesh(mesh) => mesh.density(p, support),
        }
    }

    /// The same solid, as it is quickest to find densities of by the filter `support`.
    pub fn softened(&self, support: &Support) -> Self {
        match self {
            Self::Thread(thread) if support.is_ball => Self::Thread(thread.tabulated(support.reach).into()),
            Self::Box(bounds) => Self::Polyhedron(Polyhedron::cuboid(bounds)),
            _ => self.clone(),
        }
    }

    /// The solid in another frame, for those with plane faces, which stay plane; `None` for others.
    pub fn moved(&self, new_from_old: &DAffine3) -> Option<Self> {
        match self {
            Self::Box(bounds) => Some(Self::Polyhedron(Polyhedron::cuboid(bounds).moved(new_from_old))),
            Self::Polyhedron(polyhedron) => Some(Self::Polyhedron(polyhedron.moved(new_from_old))),
            Self::HalfSpace(plane) => {
                let normal = new_from_old.matrix3.inverse().transpose() * plane.normal;
                let on = affine::point(new_from_old, plane.normal * -plane.offset);
                Plane::through(on, normal).map(Self::HalfSpace)
            }
            Self::Everything => Some(Self::Everything),
            Self::Mesh(mesh) => Some(Self::Mesh(mesh.moved(new_from_old).into())),
            _ => None,
        }
    }

    /// What is left when the surface moves inwards by `by`, above 0.
    ///
    /// # Errors
    /// If the solid's inside has no form here.
    pub fn inset(&self, by: f64) -> Result<Option<Self>, NoInset> {
        Ok(match self {
            Self::Sphere { center, radius } => (by < *radius).then(|| Self::Sphere {
                center: *center,
                radius: radius - by,
            }),
            Self::Box(bounds) => {
                let inner = bounds.expand(DVec3::splat(-by));
                inner.min.cmplt(inner.max).all().then_some(Self::Box(inner))
            }
            Self::HalfSpace(plane) => Some(Self::HalfSpace(Plane {
                offset: plane.offset + by,
                ..*plane
            })),
            Self::Polyhedron(polyhedron) => polyhedron.inset(by).map(Self::Polyhedron),
            Self::Revolved(profile) => profile.inset(by).map(Self::revolved),
            Self::Relief(Relief::RoundedBox(rounded)) => inset_rounded(rounded, by),
            Self::Everything | Self::Thread(_) | Self::Relief(Relief::Waves(_)) | Self::Mesh(_) => return Err(NoInset),
        })
    }
}

/// A solid that cannot be made hollow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("threads, waves and meshes cannot be shells: subtract a smaller one instead")]
pub struct NoInset;

fn inset_rounded(rounded: &RoundedBox, by: f64) -> Option<Solid> {
    let half = rounded.half - by;
    if half.min_element() <= 0.0 {
        return None;
    }
    Some(if rounded.radius > by {
        Solid::Relief(Relief::RoundedBox(RoundedBox {
            half,
            radius: rounded.radius - by,
        }))
    } else {
        Solid::Box(Aabb::new(-half, half))
    })
}

fn over_corners(region: &Aabb, distance: impl Fn(DVec3) -> f64) -> DistanceRange {
    let distances = region.corners().map(distance);
    DistanceRange {
        lo: distances.into_iter().fold(f64::INFINITY, f64::min),
        hi: distances.into_iter().fold(f64::NEG_INFINITY, f64::max),
    }
}

/// The density of a ball about the origin under a stretched support.
fn ball_integrated(p: DVec3, radius: f64, support: &Support) -> f64 {
    let lines = lines::Lines::new(p, support);
    let interval = |rho: f64| {
        let half = (radius * radius - rho * rho).max(0.0).sqrt();
        Some((-half, half))
    };
    let sum = revolved::over_rings(&lines, &[radius], &[], interval, |interval, _, at| {
        lines.stretch(at, interval)
    });
    sum.clamp(0.0, 1.0)
}
