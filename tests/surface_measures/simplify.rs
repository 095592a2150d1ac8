//! Fewer triangles, nearly the same surface.

use std::collections::HashMap;

use glam::Vec3;
use vcsg::surface::{Measures, Mesh, Simplified, SimplifyGoal, simplify};

use crate::shapes::{cuboid, joined, marked, mesh, surface, torus, two_balls};

/// Those bits of a vertex that tell it from others.
type Vertex = ([u32; 3], [u32; 3], u32, [u8; 4]);

fn vertices(mesh: &Mesh) -> Vec<Vertex> {
    let vertex = |v: usize| {
        let bits = |p: [f32; 3]| p.map(f32::to_bits);
        (
            bits(mesh.positions[v]),
            bits(mesh.normals[v]),
            mesh.values[v].to_bits(),
            mesh.colors[v],
        )
    };
    (0..mesh.positions.len()).map(vertex).collect()
}

#[test]
fn the_number_of_triangles_is_met_and_the_topology_stays() {
    for (shape, target) in [(surface(48, 0.5, torus), 2000), (surface(47, 0.5, two_balls), 1000)] {
        let before = Measures::of(&shape);
        let after = Measures::of(&simplify(&shape, SimplifyGoal::Triangles(target)).mesh);
        assert!(
            after.triangles <= target && after.triangles > target * 9 / 10,
            "{after:?}"
        );
        assert_eq!(after.euler_characteristic, before.euler_characteristic);
        assert_eq!((after.components, after.non_manifold_edges), (before.components, 0));
        assert!(after.volume_mm3.is_some());
    }
}

#[test]
fn vertices_that_stay_are_the_old_ones_with_their_attributes() {
    let shape = marked(surface(30, 0.8, torus));
    let simple = simplify(&shape, SimplifyGoal::Triangles(1000)).mesh;
    let old: HashMap<Vertex, usize> = vertices(&shape).into_iter().zip(0..).collect();
    let order: Vec<usize> = vertices(&simple).iter().map(|v| old[v]).collect();
    assert!(order.is_sorted(), "vertices keep their order");
    assert_eq!(simple.parts[0].triangles, 0..simple.triangles.len());
    assert_eq!(simple.parts[0].iso, Some(0.0));
    // None is left that no triangle has.
    assert_eq!(Measures::of(&simple).euler_characteristic, 0);
}

/// Every collapse leaves a vertex whose root mean square distance from the planes of what was merged into it is at most the error
/// that is told. So the new surface is that far from the old one, which has a distance from the torus of its own; root mean
/// squares of sums are no more than their sums.
#[test]
fn the_surface_stays_within_its_error() {
    let shape = surface(30, 0.8, torus);
    let mut count = shape.triangles.len();
    for limit in [0.01, 0.05, 0.2] {
        let Simplified { mesh, error_mm } = simplify(&shape, SimplifyGoal::ErrorMm(limit));
        assert!(error_mm <= limit && error_mm > limit / 4.0, "{error_mm} of {limit}");
        assert!(off(&mesh) <= off(&shape) + f64::from(error_mm), "{}", off(&mesh));
        assert!(mesh.triangles.len() < count);
        count = mesh.triangles.len();
    }
}

/// The root mean square distance from the torus, by 15 points in each triangle.
fn off(mesh: &Mesh) -> f64 {
    let places = (0..=4).flat_map(|i| (0..=4 - i).map(move |j| (f64::from(i) / 4.0, f64::from(j) / 4.0)));
    let places: Vec<_> = places.collect();
    let (mut sum, mut weight) = (0.0, 0.0);
    for n in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(n).map(|p| Vec3::from(p).as_dvec3());
        let area = (b - a).cross(c - a).length();
        for (s, t) in &places {
            sum += torus(a + (b - a) * *s + (c - a) * *t).powi(2) * area;
            weight += area;
        }
    }
    f64::sqrt(sum / weight)
}

#[test]
fn borders_and_vertices_between_parts_stay() {
    // A plane through a lattice, whose triangles are two parts.
    let mut sheet = surface(20, 1.0, |p| p.z);
    let middle = sheet.triangles.len() / 2;
    let mut second = sheet.parts[0].clone();
    (sheet.parts[0].triangles.end, second.triangles.start, second.label) = (middle, middle, 7);
    sheet.parts.push(second);
    let simple = simplify(&sheet, SimplifyGoal::Triangles(0)).mesh;
    let (before, after) = (Measures::of(&sheet), Measures::of(&simple));
    assert_eq!(after.boundary_edges, before.boundary_edges);
    assert_eq!((after.area_mm2, after.euler_characteristic), (before.area_mm2, 1));
    assert!(after.triangles < before.triangles / 4, "{}", after.triangles);
    for (old, new) in sheet.parts.iter().zip(&simple.parts) {
        let area = |mesh: &Mesh, part: &vcsg::surface::Part| {
            let triangles = mesh.triangles[part.triangles.clone()].to_vec();
            Measures::of(&Mesh {
                triangles: triangles.into(),
                parts: Vec::new(),
                ..mesh.clone()
            })
            .area_mm2
        };
        assert_eq!((old.label, area(&sheet, old)), (new.label, area(&simple, new)));
    }
}

#[test]
fn what_is_simple_stays() {
    let cube = marked(joined(cuboid([0.0; 3], [1.0; 3]), cuboid([5.0; 3], [1.0; 3])));
    for goal in [
        SimplifyGoal::Triangles(24),
        SimplifyGoal::Triangles(usize::MAX),
        SimplifyGoal::ErrorMm(1e-3),
    ] {
        assert_eq!(simplify(&cube, goal).mesh, cube);
    }
    let none = simplify(&Mesh::default(), SimplifyGoal::Triangles(7));
    assert_eq!((none.mesh, none.error_mm), (Mesh::default(), 0.0));
}

#[test]
fn bad_input_does_no_harm() {
    let mut broken = cuboid([0.0; 3], [1.0; 3]);
    broken.positions.to_mut().push([f32::NAN; 3]);
    broken.triangles.to_mut().extend([[0, 1, 8], [0, 1, 99], [3, 3, 3]]);
    broken.parts.clear();
    let whole = simplify(&broken, SimplifyGoal::ErrorMm(f32::NAN)).mesh;
    assert_eq!((whole.triangles.len(), whole.parts.len()), (12, 0));
    let far = [
        [f32::MAX, 0.0, 0.0],
        [-f32::MAX, 0.0, 0.0],
        [0.0, f32::MAX, 0.0],
        [0.0, 0.0, -f32::MAX],
    ];
    let huge = mesh(far.to_vec(), vec![[0, 1, 2], [1, 0, 3], [2, 1, 3], [0, 2, 3]]);
    for goal in [
        SimplifyGoal::Triangles(1),
        SimplifyGoal::ErrorMm(f32::INFINITY),
        SimplifyGoal::ErrorMm(-1.0),
    ] {
        assert!(simplify(&huge, goal).mesh.triangles.len() <= 4);
    }
}
