//! What a mesh measures.
//!
//! *Theory.* The volume that a closed mesh encloses is, by the divergence theorem, the sum of the signed tetrahedra between its
//! triangles and any point. It does not depend on the point if each edge is run along as often in one direction as in the other.
//! *Practice.* The point is the middle of the mesh's box, so that a mesh far from the origin loses no digits. Sums are made in
//! `f64` over runs of triangles of fixed length, in their order, so that they do not depend on the number of threads.

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::components::Components;
use super::edges::EdgeCounts;
use super::mesh::Mesh;
use super::sound;

/// The figures of a mesh. Triangles that have a vertex twice, one that is not finite or one that is not there are left out of
/// all but [`triangles`](Self::triangles) and counted as [`left_out_triangles`](Self::left_out_triangles).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Measures {
    /// Vertices, of triangles or not.
    pub vertices: usize,
    /// Vertices with a coordinate that is not finite.
    pub non_finite_vertices: usize,
    /// Triangles.
    pub triangles: usize,
    /// Triangles that are none.
    pub left_out_triangles: usize,
    /// Area, square millimetres.
    pub area_mm2: f64,
    /// Enclosed volume, cubic millimetres: positive where triangles face outwards. `None` for a mesh that does not enclose
    /// one, because along some edge not as many triangles run in one direction as in the other.
    pub volume_mm3: Option<f64>,
    /// Pieces that share no vertex.
    pub components: usize,
    /// Edges of one triangle.
    pub boundary_edges: usize,
    /// Edges of more than two triangles, or of two that run along it in the same direction.
    pub non_manifold_edges: usize,
    /// Vertices of triangles − edges + triangles: 2 for a sphere, 0 for a torus.
    pub euler_characteristic: i64,
    /// The lowest and the highest coordinates of the triangles, LPS millimetres; `None` without triangles.
    pub bounds_mm: Option<[[f64; 3]; 2]>,
}

impl Measures {
    /// Those of `mesh`. They are the same for any number of threads.
    pub fn of(mesh: &Mesh) -> Self {
        let extent = Extent::of(mesh);
        let sums = Sums::of(mesh, extent.middle());
        let edges = EdgeCounts::of(mesh);
        let components = Components::of(mesh);
        let is_finite = |p: &&[f32; 3]| p.iter().all(|x| x.is_finite());
        let finite_vertices = mesh.positions.par_iter().filter(is_finite).count();
        Self {
            vertices: mesh.positions.len(),
            non_finite_vertices: mesh.positions.len() - finite_vertices,
            triangles: mesh.triangles.len(),
            left_out_triangles: mesh.triangles.len() - sums.triangles,
            area_mm2: sums.double_area / 2.0,
            volume_mm3: (edges.unbalanced == 0).then_some(sums.six_volumes / 6.0),
            components: components.count,
            boundary_edges: edges.boundary,
            non_manifold_edges: edges.non_manifold,
            euler_characteristic: components.vertices as i64 - edges.edges as i64 + sums.triangles as i64,
            bounds_mm: (sums.triangles > 0).then(|| [extent.min.to_array(), extent.max.to_array()]),
        }
    }
}

/// The box of a mesh's triangles.
#[derive(Clone, Copy)]
struct Extent {
    min: DVec3,
    max: DVec3,
}

impl Extent {
    const NONE: Self = Self {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };

    fn of(mesh: &Mesh) -> Self {
        let corners = (0..mesh.triangles.len())
            .into_par_iter()
            .filter_map(|n| sound::corners(mesh, n));
        let boxes = corners.fold(
            || Self::NONE,
            |extent, corners| {
                corners.into_iter().fold(extent, |extent, p| Self {
                    min: extent.min.min(p),
                    max: extent.max.max(p),
                })
            },
        );
        boxes.reduce(
            || Self::NONE,
            |a, b| Self {
                min: a.min.min(b.min),
                max: a.max.max(b.max),
            },
        )
    }

    fn middle(&self) -> DVec3 {
        (self.min + self.max) / 2.0
    }
}

/// What is summed over triangles.
#[derive(Clone, Copy, Default)]
struct Sums {
    triangles: usize,
    double_area: f64,
    six_volumes: f64,
}

impl Sums {
    /// Triangles in a run.
    const RUN: usize = 1 << 14;

    fn of(mesh: &Mesh, middle: DVec3) -> Self {
        let runs: Vec<Self> = (0..mesh.triangles.len().div_ceil(Self::RUN))
            .into_par_iter()
            .map(|run| Self::of_run(mesh, run * Self::RUN, middle))
            .collect();
        runs.into_iter().fold(Self::default(), Self::with)
    }

    fn of_run(mesh: &Mesh, first: usize, middle: DVec3) -> Self {
        let run = first..mesh.triangles.len().min(first + Self::RUN);
        run.filter_map(|n| sound::corners(mesh, n))
            .map(|corners| {
                let double_area = sound::double_area(corners);
                Self {
                    triangles: 1,
                    double_area: double_area.length(),
                    six_volumes: double_area.dot(corners[0] - middle),
                }
            })
            .fold(Self::default(), Self::with)
    }

    fn with(self, other: Self) -> Self {
        Self {
            triangles: self.triangles + other.triangles,
            double_area: self.double_area + other.double_area,
            six_volumes: self.six_volumes + other.six_volumes,
        }
    }
}
