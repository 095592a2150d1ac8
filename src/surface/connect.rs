//! The pieces of a mesh (LC87 §6: connectivity makes large models smaller).
//!
//! *Theory.* Triangles that share a vertex are of one component.
//! *Practice.* Components are ranked by area, not by their number of triangles: where a surface runs along a slice it is cut in
//! more and smaller triangles, so that a noisy speck can have more of them than a smooth bone.

use glam::DVec3;
use rayon::prelude::*;

use super::components::Components;
use super::mesh::Mesh;
use super::nearest::distance_squared;
use super::{sound, subset};

/// A connected piece of a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Component {
    /// How many triangles it has.
    pub triangles: usize,
    /// Their area, square millimetres.
    pub area_mm2: f64,
}

/// The components of `mesh`, in the order of their first triangles. Triangles that have a vertex twice, one that is not finite or
/// one that is not there are of none.
pub fn components(mesh: &Mesh) -> Vec<Component> {
    Division::of(mesh).components
}

/// The `n` components of `mesh` with the largest area (of equal ones, those that come first), with what belongs to them.
/// Vertices and triangles keep their order; those of no component go, and parts stay even if nothing is left of them.
pub fn keep_largest(mesh: &Mesh, n: usize) -> Mesh {
    let division = Division::of(mesh);
    let area = |c: &usize| division.components[*c].area_mm2;
    let mut ranking: Vec<usize> = (0..division.components.len()).collect();
    // A stable sort.
    ranking.sort_by(|a, b| area(b).total_cmp(&area(a)));
    ranking.truncate(n);
    division.keep(mesh, &ranking)
}

/// The components of `mesh` that a seed touches, as [`keep_largest`] keeps them. A seed, LPS millimetres, touches the component
/// of the triangle that is nearest to it, however far; of equally near ones the first. One that is not finite touches none.
///
/// Every seed is held against every triangle.
pub fn keep_touching(mesh: &Mesh, seeds: &[DVec3]) -> Mesh {
    let division = Division::of(mesh);
    let finite = seeds.iter().filter(|seed| seed.is_finite());
    let touched: Vec<usize> = finite
        .filter_map(|seed| division.of_triangle(mesh, nearest(mesh, *seed)?))
        .collect();
    division.keep(mesh, &touched)
}

/// The triangle nearest to `p`.
fn nearest(mesh: &Mesh, p: DVec3) -> Option<usize> {
    let distances = (0..mesh.triangles.len())
        .into_par_iter()
        .filter_map(|n| Some((distance_squared(p, sound::corners(mesh, n)?), n)));
    let nearest = distances.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    nearest.map(|(_, n)| n)
}

/// A mesh's components by number.
struct Division {
    components: Vec<Component>,
    /// Of each vertex that triangles have.
    of_vertex: Vec<u32>,
}

impl Division {
    fn of(mesh: &Mesh) -> Self {
        const NONE: u32 = u32::MAX;
        let mut root = Components::of(&sound::triangles(mesh), mesh.positions.len()).root;
        let mut number = vec![NONE; root.len()];
        let mut components: Vec<Component> = Vec::new();
        for (n, triangle) in mesh.triangles.iter().enumerate() {
            let Some(corners) = sound::corners(mesh, n) else {
                continue;
            };
            let number = &mut number[root[triangle[0] as usize] as usize];
            if *number == NONE {
                *number = components.len() as u32;
                components.push(Component::default());
            }
            let component = &mut components[*number as usize];
            component.triangles += 1;
            component.area_mm2 += sound::double_area(corners).length() / 2.0;
        }
        root.par_iter_mut().for_each(|v| *v = number[*v as usize]);
        Self {
            components,
            of_vertex: root,
        }
    }

    /// The component of triangle `n`.
    fn of_triangle(&self, mesh: &Mesh, n: usize) -> Option<usize> {
        sound::corners(mesh, n)?;
        Some(self.of_vertex[mesh.triangles[n][0] as usize] as usize)
    }

    /// What is left of `mesh` if only these components stay.
    fn keep(&self, mesh: &Mesh, components: &[usize]) -> Mesh {
        let mut stays = vec![false; self.components.len()];
        for c in components {
            stays[*c] = true;
        }
        subset::select(mesh, |n| self.of_triangle(mesh, n).is_some_and(|c| stays[c]))
    }
}
