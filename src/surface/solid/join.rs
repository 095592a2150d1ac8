//! From the pieces of all layers to one mesh.

use std::collections::HashMap;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::cell::Vertex;
use super::{Border, CAP, Creases, FIRST_FACE, Group, Pieces, Point, SURFACE, Task};
use crate::surface::extract::ExtractError;
use crate::surface::mesh::{Mesh, Part};
use crate::surface::ties::is_whole;
use crate::surface::weld;

/// Puts the pieces together.
pub(super) fn join(task: &Task<'_>, pieces: Vec<Pieces>, creases: Creases) -> Result<Mesh, ExtractError> {
    let mut pieces = of_all_layers(pieces);
    weld(task, &mut pieces);
    let names = Names::new(task, &pieces, creases)?;
    let mut mesh = names.vertices(task, &pieces.points);
    add_triangles(&mut mesh, task, &pieces, &names)?;
    if task.surface.level.is_mirrored() {
        mesh.triangles.par_iter_mut().for_each(|t| t.swap(1, 2));
    }
    Ok(mesh)
}

fn of_all_layers(pieces: Vec<Pieces>) -> Pieces {
    let mut all = Pieces::default();
    for layer in pieces {
        all.surface.extend(layer.surface);
        all.triangles.extend(layer.triangles);
        all.points.extend(layer.points);
    }
    // A stable order keeps the lowest layer's point of each name.
    all.points.par_sort_by_key(|(vertex, _)| *vertex);
    all.points.dedup_by_key(|(vertex, _)| *vertex);
    all
}

/// Merges the scan's vertices as marching cubes does, and drops the triangles that lose a corner.
fn weld(task: &Task<'_>, pieces: &mut Pieces) {
    let [nx, ny, _] = task.grid.dims();
    let merged = weld::merged(&task.surface.hits, nx * ny);
    if merged.is_empty() {
        return;
    }
    let into: HashMap<u32, u32> = merged.iter().map(|m| (m.gone, m.into)).collect();
    let number = |v: u32| into.get(&v).copied().unwrap_or(v);
    pieces.surface.par_iter_mut().for_each(|t| *t = t.map(number));
    pieces.surface.retain(|t| is_whole(*t));
    let name = |vertex| match vertex {
        Vertex::Surface(v) => Vertex::Surface(number(v)),
        other => other,
    };
    pieces.triangles.iter_mut().for_each(|(_, t)| *t = t.map(name));
    pieces.triangles.retain(|(_, t)| is_whole(*t));
}

/// The numbers that vertices get: first those of the scan's surface, then all others in the order of their names.
struct Names {
    creases: Creases,
    /// The new number of each vertex of the scan's surface, where it has one.
    surface: Vec<u32>,
    /// How many have.
    used: usize,
    /// The other vertices, and the group that each belongs to: the first that has it if groups share.
    others: Vec<(Vertex, Group)>,
}

impl Names {
    fn new(task: &Task<'_>, pieces: &Pieces, creases: Creases) -> Result<Self, ExtractError> {
        let mut names = Self {
            creases,
            surface: vec![0; task.surface.mesh.positions.len()],
            used: 0,
            others: Vec::new(),
        };
        pieces
            .surface
            .iter()
            .flatten()
            .for_each(|v| names.surface[*v as usize] = 1);
        for (group, triangle) in &pieces.triangles {
            for vertex in triangle {
                match names.on_surface(*vertex, *group) {
                    Some(v) => names.surface[v as usize] = 1,
                    None => names.others.push((*vertex, *group)),
                }
            }
        }
        names.others.par_sort_unstable();
        match creases {
            Creases::Shared => names.others.dedup_by_key(|(vertex, _)| *vertex),
            Creases::Sharp => names.others.dedup(),
        }
        for number in &mut names.surface {
            let is_used = *number == 1;
            *number = names.used as u32;
            names.used += usize::from(is_used);
        }
        countable(names.used + names.others.len(), "vertices")?;
        Ok(names)
    }

    /// The number in the scan's surface of a vertex that is taken from there.
    fn on_surface(&self, vertex: Vertex, group: Group) -> Option<u32> {
        match vertex {
            Vertex::Surface(v) if group == SURFACE || self.creases == Creases::Shared => Some(v),
            _ => None,
        }
    }

    fn number(&self, vertex: Vertex, group: Group) -> u32 {
        if let Some(v) = self.on_surface(vertex, group) {
            return self.surface[v as usize];
        }
        let before = match self.creases {
            Creases::Shared => self.others.partition_point(|other| other.0 < vertex),
            Creases::Sharp => self.others.partition_point(|other| *other < (vertex, group)),
        };
        (self.used + before) as u32
    }

    /// A mesh without triangles.
    fn vertices(&self, task: &Task<'_>, points: &[(Vertex, Point)]) -> Mesh {
        let surface = &task.surface.mesh;
        let next = |v: usize| self.surface.get(v + 1).map_or(self.used, |n| *n as usize);
        let is_used = |v: &usize| self.surface[*v] as usize != next(*v);
        let used: Vec<usize> = (0..self.surface.len()).filter(is_used).collect();
        let others: Vec<Point> = self
            .others
            .par_iter()
            .map(|other| point(task, points, *other))
            .collect();
        let normals = others.iter().map(|p| p.normal.as_vec3().to_array());
        let values = others.iter().map(|p| p.value);
        Mesh {
            positions: used
                .iter()
                .map(|v| surface.positions[*v])
                .chain(others.iter().map(|p| p.position.to_array()))
                .collect(),
            normals: used.iter().map(|v| surface.normals[*v]).chain(normals).collect(),
            values: std::iter::repeat_n(task.iso as f32, self.used).chain(values).collect(),
            ..Mesh::default()
        }
    }
}

/// A vertex with the normal that it has in a group.
fn point(task: &Task<'_>, points: &[(Vertex, Point)], (vertex, group): (Vertex, Group)) -> Point {
    let found = match vertex {
        Vertex::Surface(v) => Point {
            position: Vec3::from(task.surface.mesh.positions[v as usize]),
            value: task.iso as f32,
            normal: DVec3::ZERO,
        },
        _ => points[points.partition_point(|(name, _)| *name < vertex)].1,
    };
    let normal = match group {
        SURFACE => found.normal,
        CAP if task.operation.turns_cutter() => -task.cutter.normal(found.position.as_dvec3()),
        CAP => task.cutter.normal(found.position.as_dvec3()),
        face => border_normal(task, face - FIRST_FACE),
    };
    Point { normal, ..found }
}

/// The outward direction of a face of the lattice: the lower (0) or upper (1) one across `face / 2`.
fn border_normal(task: &Task<'_>, face: Group) -> DVec3 {
    let index_from_world = task.grid.world_from_index().matrix3.inverse();
    let upwards = index_from_world.row(usize::from(face / 2)).normalize_or_zero();
    if face.is_multiple_of(2) { -upwards } else { upwards }
}

fn add_triangles(mesh: &mut Mesh, task: &Task<'_>, pieces: &Pieces, names: &Names) -> Result<(), ExtractError> {
    countable(pieces.surface.len() + pieces.triangles.len(), "triangles")?;
    let surface = pieces.surface.par_iter().map(|t| t.map(|v| names.surface[v as usize]));
    mesh.triangles.to_mut().par_extend(surface);
    let labels = if task.border == Border::Closed { 0..=2 } else { 0..=1 };
    for label in labels {
        let start = if label == 0 { 0 } else { mesh.triangles.len() };
        let of_part = pieces
            .triangles
            .par_iter()
            .filter(|(group, _)| u32::from((*group).min(FIRST_FACE)) == label);
        let triangles: Vec<[u32; 3]> = of_part.map(|(group, t)| t.map(|v| names.number(v, *group))).collect();
        mesh.triangles.to_mut().extend(triangles);
        mesh.parts.push(Part {
            label,
            iso: (label == 0).then_some(task.iso),
            triangles: start..mesh.triangles.len(),
        });
    }
    Ok(())
}

fn countable(n: usize, what: &'static str) -> Result<(), ExtractError> {
    match u32::try_from(n) {
        Ok(_) => Ok(()),
        Err(_) => Err(ExtractError::TooLarge { what }),
    }
}
