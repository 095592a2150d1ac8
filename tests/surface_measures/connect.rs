//! Which pieces stay, and what stays with them.

use glam::DVec3;
use vcsg::surface::{Mesh, components, keep_largest, keep_touching};

use crate::shapes::{cuboid, joined, marked, surface, two_balls};

/// Three boxes, a part each: of area 24, 6 and 54.
fn boxes() -> Mesh {
    let large = joined(cuboid([0.0; 3], [2.0; 3]), cuboid([10.0, 0.0, 0.0], [1.0; 3]));
    marked(joined(large, cuboid([20.0, 0.0, 0.0], [3.0; 3])))
}

/// The values of `mesh`, which tell what the vertices were before.
fn numbers(mesh: &Mesh) -> Vec<usize> {
    mesh.values.iter().map(|v| *v as usize).collect()
}

fn part_sizes(mesh: &Mesh) -> Vec<usize> {
    mesh.parts.iter().map(|part| part.triangles.len()).collect()
}

#[test]
fn components_come_in_order_with_their_areas() {
    let found: Vec<_> = components(&boxes()).iter().map(|c| (c.triangles, c.area_mm2)).collect();
    assert_eq!(found, [(12, 24.0), (12, 6.0), (12, 54.0)]);
}

#[test]
fn the_largest_stay_in_their_order() {
    let all = boxes();
    assert_eq!(numbers(&keep_largest(&all, 1)), Vec::from_iter(16..24));
    let two = keep_largest(&all, 2);
    assert_eq!(numbers(&two), Vec::from_iter((0..8).chain(16..24)));
    assert_eq!(part_sizes(&two), [12, 0, 12]);
    assert_eq!(two.parts[2].triangles, 12..24);
    assert_eq!(two.corners(12), all.corners(24));
    let colors: Vec<_> = (16..24).map(|v| all.colors[v]).collect();
    assert_eq!(two.colors[8..], colors);
    assert_eq!(two.normals.len(), 16);
    assert_eq!(keep_largest(&all, 3), all);
    assert_eq!(keep_largest(&all, 9), all);
    let none = keep_largest(&all, 0);
    assert!(none.is_empty() && none.positions.is_empty());
    assert_eq!(part_sizes(&none), [0, 0, 0]);
}

#[test]
fn area_counts_and_not_triangles() {
    // The small ball of a fine lattice, and a box of 12 triangles around it.
    let fine = surface(24, 0.1, |p| 1.0 - p.length());
    let both = joined(fine, cuboid([-2.0; 3], [4.0; 3]));
    assert_eq!(keep_largest(&both, 1).triangles.len(), 12);
}

#[test]
fn a_seed_touches_what_is_nearest() {
    let all = boxes();
    let kept = |seeds: &[DVec3]| part_sizes(&keep_touching(&all, seeds));
    assert_eq!(kept(&[DVec3::new(10.5, 0.5, 0.5)]), [0, 12, 0]);
    assert_eq!(
        kept(&[DVec3::new(-50.0, 0.0, 0.0), DVec3::new(23.0, 1.0, 1.0)]),
        [12, 0, 12]
    );
    // Nearer to a side of the third box than to any vertex of it; the nearest vertex is the second's.
    assert_eq!(kept(&[DVec3::new(16.0, 0.5, 0.5)]), [0, 0, 12]);
    assert_eq!(kept(&[DVec3::NAN, DVec3::INFINITY]), [0, 0, 0]);
    assert_eq!(kept(&[]), [0, 0, 0]);
}

#[test]
fn the_nearest_point_may_be_inside_a_triangle() {
    // A large square, far from whose corners there is a small box.
    let square = joined(
        cuboid([-100.0, -100.0, -1.0], [200.0, 200.0, 1.0]),
        cuboid([0.0, 0.0, 5.0], [1.0; 3]),
    );
    let kept = keep_touching(&square, &[DVec3::new(0.5, 0.5, 2.0)]);
    assert_eq!(part_sizes(&kept), [12, 0]);
}

#[test]
fn one_of_two_balls() {
    let both = surface(24, 1.0, two_balls);
    let small = keep_touching(&both, &[DVec3::splat(6.0)]);
    let large = keep_largest(&both, 1);
    assert_eq!(small.triangles.len() + large.triangles.len(), both.triangles.len());
    assert_eq!(small.positions.len() + large.positions.len(), both.positions.len());
    let within = |mesh: &Mesh, center: f64, radius: f64| {
        mesh.positions
            .iter()
            .all(|p| glam::Vec3::from(*p).as_dvec3().distance(DVec3::splat(center)) < radius + 0.1)
    };
    assert!(within(&small, 6.0, 2.5) && within(&large, -2.0, 5.0));
}

#[test]
fn what_is_no_triangle_goes_without_harm() {
    let mut broken = boxes();
    broken.triangles[13] = [8, 8, 9];
    broken.triangles[14] = [8, 9, 99];
    broken.positions[0] = [f32::NAN; 3];
    (broken.parts[1].triangles.start, broken.parts[1].triangles.end) = (40, 7);
    assert_eq!(keep_largest(&broken, 1).triangles.len(), 12);
    let kept = keep_touching(&broken, &[DVec3::ZERO]);
    assert!(kept.positions.iter().flatten().all(|x| x.is_finite()));
    assert_eq!(kept.values.len(), kept.positions.len());
}
