//! Solids within closed meshes: density, distance, and what is refused.

use std::sync::Arc;
use std::time::Instant;

use glam::{DAffine3, DMat3, DVec2, DVec3};
use rayon::prelude::*;
use vcsg::math::{Aabb, Overlap};
use vcsg::voxelize::filter::Support;
use vcsg::voxelize::{MeshError, Polyhedron, Primitive, Solid, TriangleMesh, TriangleSolid};

use crate::cases::Random;
use crate::mesh_shapes::{
    angle_iron, ball, both, cuboid, extruded, fan, in_torus, inside_out, shifted, solid, soup, torus,
};

const BOX: Aabb = Aabb::new(DVec3::new(-3.0, -2.0, -5.0), DVec3::new(4.0, 6.0, 1.0));

fn refusal(mesh: &TriangleMesh) -> MeshError {
    TriangleSolid::new(mesh).expect_err("a refusal")
}

#[test]
fn a_box_has_the_density_of_its_polyhedron() {
    let (mesh, polyhedron) = (solid(&cuboid(&BOX)), Polyhedron::cuboid(&BOX));
    let mut random = Random(7);
    for radius in [0.5, 2.0, 9.0] {
        let support = Support::ball(radius);
        for _ in 0..4000 {
            let p = random.point(&BOX.expand(DVec3::splat(radius)));
            let (one, other) = (
                mesh.density(p, &support),
                polyhedron.density(p, polyhedron.distance(p) / support.reach, &support),
            );
            assert!((one - other).abs() < 1e-9, "{p} {radius}: {one} is not {other}");
        }
    }
}

/// What is left of a ball round a point of a face, an edge or a corner is a part of it that is plain to see.
#[test]
fn on_the_surface_the_density_is_the_part_of_the_ball_within() {
    let support = Support::ball(0.5);
    let iron = solid(&angle_iron(DVec2::splat(8.0), DVec2::splat(4.0), 2.0));
    let places = [
        (DVec3::new(1.0, -4.0, 0.5), 0.5),
        (DVec3::new(-4.0, -4.0, 0.0), 0.25),
        (DVec3::new(-4.0, -4.0, 2.0), 0.125),
        (DVec3::new(0.0, 0.0, 0.0), 0.75),
        (DVec3::new(0.0, 0.0, 2.0), 0.375),
        (DVec3::new(-1.0, -1.0, 2.0), 0.5),
    ];
    for (p, part) in places {
        let density = Solid::Mesh(Arc::new(iron.clone())).density(p, &support);
        assert!((density - part).abs() < 1e-4, "{p}: {density} is not {part}");
    }
    let boxed = Solid::Box(BOX);
    for (p, part) in [
        (BOX.max, 0.125),
        (BOX.max - DVec3::Y, 0.25),
        (BOX.max - DVec3::new(0.0, 2.0, 2.0), 0.5),
    ] {
        let density = boxed.density(p, &support);
        assert!((density - part).abs() < 1e-4, "{p}: {density} is not {part}");
    }
}

/// A density rises by at most 1 over the filter's radius: the integral of the weight over any surface, in one direction, is at
/// most that over the plane through the middle, which is 1. Rounding and the mean on the surface leave the rest.
#[test]
fn the_density_is_continuous_through_faces_edges_and_corners() {
    const STEP: f64 = 1e-4;
    let mut random = Random(11);
    for mesh in [
        torus(9, 6, [6.0, 2.5]),
        angle_iron(DVec2::splat(8.0), DVec2::splat(3.0), 2.0),
        cuboid(&BOX),
    ] {
        let (solid, support) = (solid(&mesh), Support::ball(2.0));
        for n in 0..60 {
            let corners = mesh.triangles[n % mesh.triangles.len()].map(|v| mesh.positions[v as usize]);
            let through = match n % 3 {
                0 => corners[0],
                1 => 0.5 * (corners[0] + corners[1]),
                _ => corners.iter().sum::<DVec3>() / 3.0,
            };
            let direction = random
                .point(&Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0)))
                .normalize();
            let at = |k: i32| solid.density(through + direction * (STEP * f64::from(k)), &support);
            let densities: Vec<f64> = (-300..=300).into_par_iter().map(at).collect();
            for pair in densities.windows(2) {
                let change = (pair[1] - pair[0]).abs();
                assert!(change <= STEP / 2.0 + 2e-5, "{n}: {change} near {through}");
            }
        }
    }
}

#[test]
fn inside_is_what_it_is_by_definition() {
    let (sizes, mut random) = ([6.0, 2.5], Random(3));
    let torus = solid(&torus(11, 7, sizes));
    let near = torus.bounds().expand(DVec3::splat(0.5));
    for _ in 0..20_000 {
        let p = random.point(&near);
        assert_eq!(torus.contains(p), in_torus(11, 7, sizes, p), "{p}");
        assert_eq!(torus.distance(p) <= 0.0, torus.contains(p));
    }
    // Points in line with faces, edges and corners.
    let cube = solid(&cuboid(&Aabb::new(DVec3::ZERO, DVec3::splat(4.0))));
    for n in 0..13 * 13 * 13 {
        let p = DVec3::new(f64::from(n % 13), f64::from(n / 13 % 13), f64::from(n / 169)) - 4.0;
        let is_on = (p - p.clamp(DVec3::ZERO, DVec3::splat(4.0))) == DVec3::ZERO;
        let is_in = p.cmpgt(DVec3::ZERO).all() && p.cmplt(DVec3::splat(4.0)).all();
        if is_in == is_on {
            assert_eq!(cube.contains(p), is_in, "{p}");
        }
    }
}

/// Upright triangles, upright but for rounding: in their planes, beside them, is outside.
#[test]
fn in_the_plane_of_a_face_but_beside_it_is_outside() {
    let corners = [DVec2::ZERO, DVec2::new(5.0, 0.0), DVec2::new(1.0, 3.0)];
    for n in 0..300 {
        let turn = DMat3::from_rotation_z(f64::from(n) * 0.37) * DMat3::from_rotation_x(std::f64::consts::FRAC_PI_2);
        let mut mesh = extruded(&corners, &fan(3), 1.0);
        mesh.positions.iter_mut().for_each(|p| *p = turn * *p);
        let solid = solid(&mesh);
        for k in 0..200 {
            let (s, t) = (f64::from(k % 20) * 0.05, f64::from(k / 20) * 0.1);
            let [a, b, c] = [0, 1, 2].map(|v| mesh.positions[v]);
            let beyond = a + (b - a) * (s + 0.05) + (c - a) * (1.0 - s + t);
            assert!(!solid.contains(beyond), "{n}: {beyond}");
        }
    }
}

#[test]
fn the_distance_is_the_least_to_a_triangle() {
    let (cube, mut random) = (solid(&cuboid(&BOX)), Random(5));
    for _ in 0..5000 {
        let p = random.point(&BOX.expand(DVec3::splat(4.0)));
        let outwards = (BOX.min - p).max(p - BOX.max);
        let exact = outwards.max(DVec3::ZERO).length() + outwards.max_element().min(0.0);
        assert!((cube.distance(p) - exact).abs() < 1e-12, "{p}");
    }
}

#[test]
fn ranges_and_bounds_hold_what_is_sampled() {
    let mesh = Solid::Mesh(Arc::new(solid(&torus(9, 6, [6.0, 2.5]))));
    let mut random = Random(13);
    let world_from_local = random.pose() * DAffine3::from_scale(DVec3::new(1.0, 2.0, -0.5));
    let placed = Primitive::soft(mesh, 1.0).placed(&world_from_local, 0.5);
    for _ in 0..300 {
        let middle = random.point(&placed.local_bounds());
        let region = Aabb::new(middle, middle).expand(DVec3::splat(random.within(0.01, 1.0)));
        let (range, overlap) = (placed.coverage_range(&region), placed.overlap(&region, 0.0));
        for _ in 0..20 {
            let coverage = placed.coverage(random.point(&region));
            assert!(range.lo <= coverage && coverage <= range.hi, "{range:?} {coverage}");
            match overlap {
                Overlap::Inside => assert_eq!(coverage, 1.0),
                Overlap::Outside => assert_eq!(coverage, 0.0),
                Overlap::Partial => {}
            }
        }
    }
}

#[test]
fn a_moved_solid_is_the_moved_mesh() {
    let mesh = torus(9, 6, [6.0, 2.5]);
    let mut random = Random(17);
    for scale in [DVec3::new(1.0, 2.0, 0.5), DVec3::new(-1.0, 1.5, 1.0)] {
        let new_from_old = random.pose() * DAffine3::from_mat3(DMat3::from_diagonal(scale));
        let moved = solid(&mesh).moved(&new_from_old);
        let positions = mesh
            .positions
            .iter()
            .map(|p| new_from_old.transform_point3(*p))
            .collect();
        let made = solid(&TriangleMesh {
            positions,
            triangles: mesh.triangles.clone(),
        });
        for _ in 0..500 {
            let p = random.point(&made.bounds().expand(DVec3::ONE));
            let density = |solid: &TriangleSolid| solid.density(p, &Support::ball(1.0));
            assert!((density(&moved) - density(&made)).abs() < 1e-9);
        }
    }
}

#[test]
fn a_mesh_that_is_inside_out_is_turned() {
    let cube = solid(&cuboid(&BOX));
    assert_eq!(
        solid(&inside_out(cuboid(&BOX))).contains(BOX.center()),
        cube.contains(BOX.center())
    );
    assert!(cube.contains(BOX.center()));
}

#[test]
fn vertices_at_one_place_are_one() {
    let unshared = soup(solid(&cuboid(&BOX)).triangles());
    assert_eq!(unshared.positions.len(), 36);
    let mut extra = unshared.clone();
    extra.positions.push(DVec3::splat(900.0));
    extra.triangles.extend([[0, 0, 1], [36, 36, 36]]);
    assert_eq!(
        solid(&extra),
        solid(&unshared),
        "what has no area or no triangle is dropped"
    );
}

#[test]
fn an_open_mesh_is_refused_with_a_place() {
    let mut open = cuboid(&BOX);
    open.triangles.pop();
    let text = refusal(&open).to_string();
    assert!(
        text.starts_with("the mesh is not watertight: it is open at 3 edge(s), one of them at ("),
        "{text}"
    );
    let mut turned = cuboid(&BOX);
    turned.triangles[0].swap(0, 1);
    let text = refusal(&turned).to_string();
    assert!(text.contains("face different sides at 3 edge(s)"), "{text}");
}

#[test]
fn what_encloses_nothing_is_refused() {
    assert_eq!(refusal(&TriangleMesh::default()), MeshError::Empty);
    let sheet = soup([[DVec3::ZERO, DVec3::X, DVec3::Y], [DVec3::ZERO, DVec3::Y, DVec3::X]].into_iter());
    assert_eq!(refusal(&sheet), MeshError::NoVolume);
    let mut bad = cuboid(&BOX);
    bad.positions[5].y = f64::NAN;
    assert!(matches!(refusal(&bad), MeshError::NotFinite { vertex: 5, .. }));
    bad.positions[5].y = f64::INFINITY;
    assert!(matches!(refusal(&bad), MeshError::NotFinite { vertex: 5, .. }));
    let mut bad = cuboid(&BOX);
    bad.triangles[3][1] = 8;
    let error = MeshError::Index {
        triangle: 3,
        vertex: 8,
        vertices: 8,
    };
    assert_eq!(refusal(&bad), error);
}

/// A triangle whose corners lie on a line fills the gap at a corner on a side.
#[test]
fn a_triangle_without_area_is_refused() {
    let mut mesh = cuboid(&BOX);
    let [a, b, c] = mesh.triangles[0];
    let middle = 0.5 * (mesh.positions[a as usize] + mesh.positions[b as usize]);
    mesh.positions.push(middle);
    mesh.triangles[0] = [a, 8, c];
    mesh.triangles.extend([[8, b, c], [a, b, 8]]);
    assert!(matches!(refusal(&mesh), MeshError::NoArea { .. }), "{}", refusal(&mesh));
}

#[test]
fn a_mesh_that_crosses_itself_is_refused_with_a_place() {
    let cube = || cuboid(&BOX);
    for by in [DVec3::new(1.0, 1.3, 0.7), DVec3::X, DVec3::ZERO] {
        let error = refusal(&both(cube(), &shifted(cube(), by)));
        let MeshError::Crosses { at } = error else {
            panic!("{by}: {error}")
        };
        assert!(BOX.contains(at), "{at}");
    }
    // A corner drawn through the opposite side.
    let mut pierced = torus(9, 6, [6.0, 2.5]);
    pierced.positions[0] = DVec3::new(-9.0, 0.3, 0.2);
    assert!(matches!(refusal(&pierced), MeshError::Crosses { .. }));
}

#[test]
fn pieces_may_touch_or_hold_hollows_but_not_each_other() {
    let inner = Aabb::new(BOX.center() - 1.0, BOX.center() + 1.0);
    let hollow = solid(&both(cuboid(&BOX), &inside_out(cuboid(&inner))));
    assert!(!hollow.contains(inner.center()) && hollow.contains(BOX.min + 0.1));
    assert!(matches!(
        refusal(&both(cuboid(&BOX), &cuboid(&inner))),
        MeshError::Sides { .. }
    ));
    let apart = shifted(cuboid(&inner), DVec3::X * 40.0);
    assert!(matches!(
        refusal(&both(cuboid(&BOX), &inside_out(apart.clone()))),
        MeshError::Sides { .. }
    ));
    assert_eq!(solid(&both(cuboid(&BOX), &apart)).triangle_count(), 24);
    // By a corner, by an edge.
    for by in [BOX.size(), BOX.size() * DVec3::new(1.0, 1.0, 0.0)] {
        let touching = solid(&both(cuboid(&BOX), &shifted(cuboid(&BOX), by)));
        let quarter = touching.density(BOX.max - 0.5 * by * DVec3::new(0.0, 0.0, 1.0), &Support::ball(0.5));
        assert!(quarter < 0.51, "{quarter}");
    }
}

/// Shows how long a large mesh takes.
#[test]
fn a_large_mesh_is_a_solid() {
    let mesh = ball(50.0, 6);
    let start = Instant::now();
    let solid = Arc::new(solid(&mesh));
    println!(
        "{} triangles checked in {:.2?}",
        solid.triangle_count(),
        start.elapsed()
    );
    let start = Instant::now();
    let placed = Primitive::soft(Solid::Mesh(Arc::clone(&solid)), 1.0).placed(&DAffine3::IDENTITY, 1.0);
    let row = |n: i32| {
        let at = |x: i32| DVec3::new(f64::from(x), f64::from(n % 128), f64::from(n / 128)) - 63.5;
        (0..128).map(|x| f64::from(placed.coverage(at(x)))).sum::<f64>()
    };
    let sum: f64 = (0..128 * 128).into_par_iter().map(row).collect::<Vec<_>>().iter().sum();
    println!("128³ samples in {:.2?}", start.elapsed());
    // A field that keeps volumes, over a polyhedron within the ball and beyond one that is a little smaller.
    let ball = |radius: f64| 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    assert!(ball(49.95) < sum && sum < ball(50.0), "{sum}");
}
