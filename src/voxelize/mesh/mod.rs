//! Solids bounded by a closed mesh of triangles.
//!
//! *Theory.* The density is the winding number at the sample less what each face near it cuts off the filter's ball
//! ([`facet`]), with the sign of the side that the sample lies on. That holds for any closed surface: by the
//! divergence theorem the convolution is a sum of signed cones over the faces.
//! *Changes from the paper.* WK94 tabulates convex features one by one. Here dihedral and corner angles, convex or not, come out
//! of the sum.
//! *Practice.* A mesh is checked once, when it is made. The winding number counts the faces that a ray crosses, and decides
//! each by the same plane distance that the cut's sign comes from, so that the two jump together.

mod bvh;
mod check;
mod closed;
mod cross;
mod error;
mod face;
pub mod read;
mod weld;

use std::fmt;

use glam::{DAffine3, DVec3};

pub use self::error::MeshError;
pub use self::read::{MeshReadError, TriangleMesh};

use self::bvh::Bvh;
use self::face::Face;
use super::facet;
use super::filter::Support;
use crate::math::{Aabb, affine};

/// A solid bounded by triangles; share it, since it is large.
#[derive(Clone, PartialEq)]
pub struct TriangleSolid {
    /// In the order of the hierarchy.
    faces: Vec<Face>,
    hierarchy: Bvh,
    bounds: Aabb,
}

impl TriangleSolid {
    /// The solid within `mesh`. Vertices at one place are one vertex, triangles of which nothing is left then are dropped, and a
    /// mesh whose volume is negative is turned inside out. Pieces may touch, and a hollow is a piece that faces inwards.
    ///
    /// # Errors
    /// If the mesh is no boundary of a solid: [`MeshError`] says what is wrong, and where.
    pub fn new(mesh: &TriangleMesh) -> Result<Self, MeshError> {
        let welded = weld::welded(mesh)?;
        closed::check(&welded)?;
        let solid = Self::of_faces(check::outwards(check::faces(&welded)?)?);
        cross::check(&solid)?;
        check::sides(&solid)?;
        Ok(solid)
    }

    /// From at least one face.
    fn of_faces(faces: Vec<Face>) -> Self {
        let bounds = faces.iter().fold(Aabb::EMPTY, |all, face| all.hull(&face.bounds()));
        // A point that rounding puts into a triangle's shadow is in its box's too.
        let rounding = 16.0 * f64::EPSILON * bounds.min.abs().max(bounds.max.abs()).max_element();
        let boxes: Vec<Aabb> = faces
            .iter()
            .map(|face| face.bounds().expand(DVec3::splat(rounding)))
            .collect();
        let (hierarchy, order) = Bvh::new(&boxes);
        Self {
            faces: order.iter().map(|n| faces[*n as usize]).collect(),
            hierarchy,
            bounds,
        }
    }

    /// How many triangles bound it.
    pub fn triangle_count(&self) -> usize {
        self.faces.len()
    }

    /// The corners of its triangles, counter-clockwise seen from outside.
    pub fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        self.faces.iter().map(|face| face.corners)
    }

    /// A box that holds it.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The same solid moved by an invertible map.
    pub fn moved(&self, new_from_old: &DAffine3) -> Self {
        let mirrors = new_from_old.matrix3.determinant() < 0.0;
        let moved = |[a, b, c]: [DVec3; 3]| {
            let corners = if mirrors { [a, c, b] } else { [a, b, c] };
            Face::new(corners.map(|corner| affine::point(new_from_old, corner)))
        };
        Self::of_faces(self.triangles().filter_map(moved).collect())
    }

    /// Whether `p` is inside.
    pub fn contains(&self, p: DVec3) -> bool {
        self.winding(p) > 0
    }

    /// How often the surface winds round `p`: 1 inside, 0 outside.
    fn winding(&self, p: DVec3) -> i32 {
        if !self.bounds.contains(p) {
            return 0;
        }
        let mut winding = 0;
        let meets = |bounds: &Aabb| face::ray_meets(p, bounds);
        self.hierarchy
            .visit(meets, |n| winding += self.faces[n].crossing_ahead(p));
        winding
    }

    /// The distance to the surface, above 0 outside and below 0 inside.
    pub fn distance(&self, p: DVec3) -> f64 {
        self.distance_within(p, f64::INFINITY)
    }

    /// [`Self::distance`], or `limit` on the same side if the surface is farther.
    pub fn distance_within(&self, p: DVec3, limit: f64) -> f64 {
        let distance = self.to_surface(p, limit);
        if self.contains(p) { -distance } else { distance }
    }

    /// The distance to the surface, or `limit` if that is less.
    fn to_surface(&self, p: DVec3, limit: f64) -> f64 {
        let to_face = |n: usize| self.faces[n].distance_squared(p);
        self.hierarchy.nearest_squared(p, limit * limit, to_face).sqrt()
    }

    /// The density at `p` of a filter whose support is a ball.
    pub fn density(&self, p: DVec3, support: &Support) -> f64 {
        let radius = support.reach;
        let distance = self.to_surface(p, facet::ON_SURFACE * radius);
        facet::through_surface(p, distance, radius, |p| self.density_beside(p, radius))
    }

    /// The density at a point that is not on the surface.
    fn density_beside(&self, p: DVec3, radius: f64) -> f64 {
        let mut density = f64::from(self.winding(p));
        let near = |bounds: &Aabb| bvh::distance_squared(bounds, p) < radius * radius;
        self.hierarchy.visit(near, |n| density -= self.faces[n].cut(p, radius));
        density.clamp(0.0, 1.0)
    }
}

/// Not its triangles, of which there are too many.
impl fmt::Debug for TriangleSolid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut shown = f.debug_struct("TriangleSolid");
        shown.field("triangles", &self.faces.len());
        shown.field("bounds", &self.bounds).finish_non_exhaustive()
    }
}
