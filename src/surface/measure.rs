//! What a mesh measures.
//!
//! *Theory.* The volume that a closed mesh encloses is, by the divergence theorem, the sum of the signed tetrahedra between its
//! triangles and any point. It does not depend on the point if each edge is run along as often in one direction as in the other.
//! *Practice.* The point is the middle of the mesh's box, so that a mesh far from the origin loses no digits. Sums are made in
//! `f64` over runs of triangles of fixed length, in their order, so that they do not depend on the number of threads.

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use serde::Serialize;

use super::components::Components;
use super::edges::EdgeCounts;
use super::mesh::Mesh;
use super::sound;
use crate::math::Aabb;

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
        let vertices = mesh.positions.len();
        let triangles = &*sound::triangles(mesh);
        let components = Components::of(triangles, vertices);
        let edges = EdgeCounts::of(triangles, vertices);
        let bounds = bounds(&mesh.positions, &components.is_used);
        let sums = Sums::of(&mesh.positions, triangles, bounds.center());
        let finite_vertices = mesh.positions.par_iter().filter(|p| sound::is_finite(p)).count();
        let used_vertices = components.is_used.par_iter().filter(|used| **used).count();
        Self {
            vertices,
            non_finite_vertices: vertices - finite_vertices,
            triangles: mesh.triangles.len(),
            left_out_triangles: mesh.triangles.len() - triangles.len(),
            area_mm2: sums.double_area / 2.0,
            volume_mm3: (edges.unbalanced == 0).then_some(sums.six_volumes / 6.0),
            components: components.count(),
            boundary_edges: edges.boundary,
            non_manifold_edges: edges.non_manifold,
            euler_characteristic: used_vertices as i64 - edges.edges as i64 + triangles.len() as i64,
            bounds_mm: (!bounds.is_empty()).then(|| [bounds.min.to_array(), bounds.max.to_array()]),
        }
    }
}

/// The box of the vertices that are used.
fn bounds(positions: &[[f32; 3]], is_used: &[bool]) -> Aabb {
    let used = positions.par_iter().zip(is_used).filter(|(_, used)| **used);
    // A negative zero is made positive: which of the two zeros is the smaller would depend on their order.
    let places = used.map(|(p, _)| Vec3::from(*p).as_dvec3() + 0.0);
    let boxes = places.map(|p| Aabb::new(p, p));
    boxes.reduce(|| Aabb::EMPTY, |a, b| a.hull(&b))
}

/// What is summed over triangles.
#[derive(Clone, Copy, Default)]
struct Sums {
    double_area: f64,
    six_volumes: f64,
}

impl Sums {
    /// Triangles in a run.
    const RUN: usize = 1 << 14;

    /// Of `triangles`, all of whose vertices are there; volumes are those of tetrahedra with `middle`.
    fn of(positions: &[[f32; 3]], triangles: &[[u32; 3]], middle: DVec3) -> Self {
        let of_triangle = |t: &[u32; 3]| {
            let corners = t.map(|v| Vec3::from(positions[v as usize]).as_dvec3());
            let double_area = sound::double_area(corners);
            Self {
                double_area: double_area.length(),
                six_volumes: double_area.dot(corners[0] - middle),
            }
        };
        let runs: Vec<Self> = triangles
            .par_chunks(Self::RUN)
            .map(|run| run.iter().map(of_triangle).fold(Self::default(), Self::with))
            .collect();
        runs.into_iter().fold(Self::default(), Self::with)
    }

    fn with(self, other: Self) -> Self {
        Self {
            double_area: self.double_area + other.double_area,
            six_volumes: self.six_volumes + other.six_volumes,
        }
    }
}
