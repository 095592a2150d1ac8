//! What a mesh bounds.

use std::collections::HashMap;

use glam::DVec3;
use vcsg::surface::Mesh;

pub fn corners(mesh: &Mesh, n: usize) -> [DVec3; 3] {
    mesh.corners(n).map(|at| glam::Vec3::from(at).as_dvec3())
}

/// How many more triangles run along a side from its lower to its higher vertex than back, and how many run along it at all.
pub fn sides(mesh: &Mesh) -> HashMap<[u32; 2], [i32; 2]> {
    let mut sides = HashMap::new();
    for [a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let [balance, count] = sides.entry([*from.min(to), *from.max(to)]).or_insert([0, 0]);
            *balance += if from < to { 1 } else { -1 };
            *count += 1;
        }
    }
    sides
}

/// The first side without an opposite, unless `allowed` says that it need not have one.
pub fn open_side(mesh: &Mesh, allowed: impl Fn([DVec3; 2]) -> bool) -> Option<String> {
    let place = |v: u32| glam::Vec3::from(mesh.positions[v as usize]).as_dvec3();
    let mut open: Vec<_> = sides(mesh)
        .into_iter()
        .filter(|(_, [balance, _])| *balance != 0)
        .collect();
    open.sort();
    let open = open.into_iter().find(|(side, _)| !allowed(side.map(place)))?;
    Some(format!("{open:?} at {:?}", open.0.map(place)))
}

/// How many sides have more than two triangles.
pub fn crowded_sides(mesh: &Mesh) -> usize {
    sides(mesh).values().filter(|[_, count]| *count > 2).count()
}

/// The volume that a closed mesh bounds.
pub fn volume(mesh: &Mesh) -> f64 {
    let cone = |n| {
        let [a, b, c] = corners(mesh, n);
        a.dot(b.cross(c)) / 6.0
    };
    (0..mesh.triangles.len()).map(cone).sum()
}

pub fn areas(mesh: &Mesh) -> Vec<f64> {
    let area = |n| {
        let [a, b, c] = corners(mesh, n);
        (b - a).cross(c - a).length() / 2.0
    };
    mesh.parts
        .iter()
        .map(|part| part.triangles.clone().map(area).sum())
        .collect()
}

/// The sum of the lengths of all triangles' sides.
pub fn perimeters(mesh: &Mesh) -> f64 {
    let perimeter = |n| {
        let [a, b, c] = corners(mesh, n);
        (b - a).length() + (c - b).length() + (a - c).length()
    };
    (0..mesh.triangles.len()).map(perimeter).sum()
}

/// How far rounding to `f32` moves a vertex at most: half a unit in the last place, at most 2⁻²⁴ of the size, on each axis.
pub fn rounding(mesh: &Mesh) -> f64 {
    let size = mesh
        .positions
        .iter()
        .flatten()
        .fold(0.0_f32, |size, x| size.max(x.abs()));
    3.0_f64.sqrt() * f64::from(size) * 2.0_f64.powi(-24)
}
