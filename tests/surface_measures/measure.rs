//! Figures against closed forms and VTK.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};
use vcsg::surface::{Measures, Mesh, components, keep_largest, marching_cubes};
use vcsg::volume::{Grid, Voxels};

use crate::oracle::{Figures, Oracle, checksum};
use crate::shapes::{cuboid, head, joined, mesh, surface, torus, two_balls};

#[test]
fn a_box_is_exact() {
    let found = Measures::of(&cuboid([-3.0, 5.0, 100.0], [2.0, 3.0, 5.0]));
    assert_eq!(
        found,
        Measures {
            vertices: 8,
            non_finite_vertices: 0,
            triangles: 12,
            left_out_triangles: 0,
            area_mm2: 62.0,
            volume_mm3: Some(30.0),
            components: 1,
            boundary_edges: 0,
            non_manifold_edges: 0,
            euler_characteristic: 2,
            bounds_mm: Some([[-3.0, 5.0, 100.0], [-1.0, 8.0, 105.0]]),
        }
    );
}

#[test]
fn a_mesh_far_away_keeps_its_volume() {
    // All coordinates are exact in f32, and all products of differences in f64.
    let far = cuboid([1e6, -2e6, 4e6], [2.0, 3.0, 5.0]);
    assert_eq!(Measures::of(&far).volume_mm3, Some(30.0));
}

#[test]
fn a_box_turned_inside_out_has_a_negative_volume() {
    let mut inward = cuboid([0.0; 3], [2.0, 3.0, 5.0]);
    inward.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert_eq!(Measures::of(&inward).volume_mm3, Some(-30.0));
}

/// The vertices are on the lattice's edges, where the distance from the sphere is interpolated linearly. Along a line, that
/// distance has a second derivative of at most 1 / (distance from the centre), so a vertex is at most
/// e = h² / 8(r − h) off the sphere. A point of a triangle, of which no two vertices are farther apart than d = √3 h, is not
/// farther from the centre than they are, and the square of its distance is less than theirs by at most d²/3: it is
/// ∑λᵢ|vᵢ|² − ∑λᵢλⱼ|vᵢ − vⱼ|², and ∑λᵢλⱼ ≤ 1/3. So the mesh lies between two spheres, which bound its volume; and its area from
/// below, since projection to the inner one shortens what is outside. From above its area is bounded by 3V/c, if all its
/// planes are at least c from the centre; or triangle for triangle, by the solid angles: ∑ A cos θ ≤ 4πR².
#[test]
fn a_ball_is_within_the_error_of_its_lattice() {
    for (n, h) in [(24, 1.0), (47, 0.5), (93, 0.25)] {
        let radius = 10.0;
        let ball = surface(n, h, |p| radius - p.length());
        let found = Measures::of(&ball);
        let e = h * h / (8.0 * (radius - h));
        let (inner, outer) = (((radius - e).powi(2) - h * h).sqrt(), radius + e);
        let volume = found.volume_mm3.expect("a closed mesh");
        let sphere = |r: f64| 4.0 / 3.0 * PI * r.powi(3);
        assert!(sphere(inner) <= volume && volume <= sphere(outer), "{volume}");
        let tilted: f64 = (0..ball.triangles.len()).map(|n| lost_to_tilt(&ball, n)).sum();
        let area = found.area_mm2;
        assert!(4.0 * PI * inner.powi(2) <= area, "{area}");
        assert!(area - tilted <= 4.0 * PI * outer.powi(2), "{area} of which {tilted}");
        assert_eq!((found.components, found.euler_characteristic), (1, 2));
        assert_eq!((found.boundary_edges, found.non_manifold_edges), (0, 0));
    }
}

/// A (1 − cos θ) of a triangle, where θ is the largest angle between its normal and the direction from the origin.
fn lost_to_tilt(mesh: &Mesh, n: usize) -> f64 {
    let corners = mesh.corners(n).map(|p| Vec3::from(p).as_dvec3());
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    let cosine = |p: DVec3| normal.dot(p) / (normal.length() * p.length());
    let smallest = corners.map(cosine).into_iter().fold(1.0, f64::min);
    let area = normal.length() / 2.0;
    if area > 0.0 { area * (1.0 - smallest) } else { 0.0 }
}

#[test]
fn a_torus_has_euler_characteristic_0() {
    let found = Measures::of(&surface(26, 1.0, torus));
    assert_eq!((found.euler_characteristic, found.components), (0, 1));
    assert_eq!((found.boundary_edges, found.non_manifold_edges), (0, 0));
}

#[test]
fn two_balls_are_two_components() {
    let found = Measures::of(&surface(24, 1.0, two_balls));
    assert_eq!((found.euler_characteristic, found.components), (4, 2));
}

#[test]
fn a_sheet_has_a_border_and_no_volume() {
    // A plane through a lattice of 8³ voxels, half-way between slices: 7 cells a side, each two triangles.
    let found = Measures::of(&surface(8, 1.0, |p| p.z));
    assert_eq!((found.triangles, found.boundary_edges), (98, 28));
    assert_eq!((found.volume_mm3, found.euler_characteristic), (None, 1));
    assert_eq!(found.area_mm2, 49.0);
}

#[test]
fn three_triangles_at_an_edge_are_not_a_manifold() {
    let positions = vec![
        [0.0; 3],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, -1.0, 0.0],
    ];
    let three = mesh(positions.clone(), vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
    let found = Measures::of(&three);
    assert_eq!((found.non_manifold_edges, found.boundary_edges), (1, 6));
    let same_way = Measures::of(&mesh(positions, vec![[0, 1, 2], [0, 1, 4]]));
    assert_eq!((same_way.non_manifold_edges, same_way.boundary_edges), (1, 4));
}

#[test]
fn four_triangles_at_an_edge_may_enclose_a_volume() {
    let mut pair = joined(cuboid([0.0; 3], [1.0; 3]), cuboid([1.0, 1.0, 0.0], [1.0; 3]));
    // The second box's edge at x = 1, y = 1 is the first's.
    for triangle in &mut pair.triangles[12..] {
        *triangle = triangle.map(|v| match v {
            8 => 3,
            12 => 7,
            v => v,
        });
    }
    let found = Measures::of(&pair);
    assert_eq!((found.non_manifold_edges, found.volume_mm3), (1, Some(2.0)));
    assert_eq!(
        (found.components, found.euler_characteristic, found.vertices),
        (1, 3, 16)
    );
}

#[test]
fn what_is_no_triangle_is_left_out() {
    let mut broken = cuboid([0.0; 3], [1.0; 3]);
    let whole = Measures::of(&broken);
    broken
        .positions
        .to_mut()
        .extend([[f32::NAN, 0.0, 0.0], [0.0, f32::INFINITY, 0.0]]);
    broken
        .triangles
        .to_mut()
        .extend([[0, 1, 8], [0, 9, 2], [0, 0, 1], [0, 1, 10], [u32::MAX; 3]]);
    let found = Measures::of(&broken);
    let counts = Measures {
        vertices: 10,
        non_finite_vertices: 2,
        triangles: 17,
        left_out_triangles: 5,
        ..whole
    };
    assert_eq!(found, counts);
    assert_eq!(components(&broken).len(), 1);
}

#[test]
fn nothing_measures_nothing() {
    let found = Measures::of(&Mesh::default());
    assert_eq!(
        (found.area_mm2, found.volume_mm3, found.bounds_mm),
        (0.0, Some(0.0), None)
    );
    assert_eq!((found.components, found.euler_characteristic), (0, 0));
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let skin = marching_cubes(&head(), 60.0).expect("a mesh");
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads").install(|| Measures::of(&skin))
    };
    let one = with(1);
    for threads in [2, 3, 7] {
        assert_eq!(with(threads), one, "{threads} threads");
    }
}

/// Holds our figures against VTK's.
fn check(oracle: &mut Oracle, mesh: &Mesh) -> Result<(Measures, Figures), TestCaseError> {
    let ours = Measures::of(mesh);
    let theirs = oracle.measure(mesh);
    let error = VtkError::of(mesh);
    prop_assert_eq!(ours.boundary_edges, theirs.boundary);
    prop_assert_eq!(ours.non_manifold_edges, theirs.non_manifold);
    prop_assert_eq!(ours.components, theirs.regions.len());
    prop_assert!(
        (ours.area_mm2 - theirs.area).abs() <= error.area,
        "area {} and {}, within {}",
        ours.area_mm2,
        theirs.area,
        error.area
    );
    if let Some(volume) = ours.volume_mm3 {
        prop_assert!(
            (volume.abs() - theirs.volume).abs() <= error.volume,
            "volume {} and {}, within {}",
            volume,
            theirs.volume,
            error.volume
        );
    }
    let mut sizes: Vec<usize> = components(mesh).iter().map(|c| c.triangles).collect();
    let mut expected = theirs.regions.clone();
    sizes.sort_unstable();
    expected.sort_unstable();
    prop_assert_eq!(sizes, expected);
    Ok((ours, theirs))
}

/// How far rounding takes VTK's sums from the truth.
///
/// It has a triangle's area A from the lengths a, b, c of its sides, s half their sum, as √(s (s−a) (s−b) (s−c)). Lengths err by
/// 4ε of themselves, s and the differences so by less than 8ε s, and the product of the four by less than 32ε s⁴; the root by
/// that over A, or, if A is small, by the root of it. The volume is a sum of A times a unit normal's component, which errs by
/// 8ε, times the mean of a coordinate, at most R; a sum of n such numbers adds n ε of the sum of their sizes. Ours err less.
struct VtkError {
    area: f64,
    volume: f64,
}

impl VtkError {
    fn of(mesh: &Mesh) -> Self {
        let n = mesh.triangles.len() as f64;
        let reach = mesh.positions.iter().flatten().fold(0.0, |r: f32, x| r.max(x.abs()));
        let mut error = 0.0;
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(t).map(|p| Vec3::from(p).as_dvec3());
            let area = (b - a).cross(c - a).length() / 2.0;
            let s = (a.distance(b) + b.distance(c) + c.distance(a)) / 2.0;
            let product = 32.0 * f64::EPSILON * s.powi(4);
            error += (product / area).min(product.sqrt()) + (8.0 + n) * f64::EPSILON * area;
        }
        Self {
            area: error,
            volume: error * f64::from(reach),
        }
    }
}

#[test]
fn vtk_agrees_on_shapes() {
    let mut oracle = Oracle::start();
    let gyroid = |p: DVec3| p.x.sin() * p.y.cos() + p.y.sin() * p.z.cos() + p.z.sin() * p.x.cos();
    let shapes = [
        cuboid([1.0, 2.0, 3.0], [1.0; 3]),
        surface(26, 1.0, torus),
        surface(24, 1.0, two_balls),
        surface(30, 0.4, gyroid),
    ];
    for shape in &shapes {
        check(&mut oracle, shape).unwrap_or_else(|error| panic!("{error}"));
    }
}

/// Random values, many of them equal, in a lattice whose border is below them all or not.
fn random_grid() -> impl Strategy<Value = Grid> {
    let values = prop_oneof![Just(4_u8), Just(200)].prop_flat_map(|top| prop::collection::vec(0..top, 512));
    (values, any::<bool>()).prop_map(|(mut values, is_open): (Vec<u8>, bool)| {
        let is_border = |v: usize| [v % 8, v / 8 % 8, v / 64].iter().any(|i| [0, 7].contains(i));
        for (v, value) in values.iter_mut().enumerate() {
            *value *= u8::from(is_open || !is_border(v));
        }
        Grid::new([8; 3], glam::DAffine3::IDENTITY, Voxels::U8(values)).expect("a grid")
    })
}

#[test]
fn vtk_agrees_on_random_meshes() {
    let oracle = std::cell::RefCell::new(Oracle::start());
    let config = ProptestConfig {
        cases: 150,
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let [closed, complex] = [std::cell::Cell::new(0), std::cell::Cell::new(0)];
    let outcome = runner.run(&(random_grid(), 1..4_u8), |(grid, iso)| {
        let mesh = marching_cubes(&grid, f64::from(iso)).expect("a mesh");
        prop_assume!(!mesh.is_empty());
        let (found, _) = check(&mut oracle.borrow_mut(), &mesh)?;
        closed.set(closed.get() + u32::from(found.volume_mm3.is_some()));
        complex.set(complex.get() + u32::from(found.non_manifold_edges > 0));
        Ok(())
    });
    outcome.unwrap_or_else(|error| panic!("{error}"));
    assert!(closed.get() > 20 && complex.get() > 20, "{closed:?} {complex:?}");
}

#[test]
fn vtk_agrees_on_a_head() {
    let mut oracle = Oracle::start();
    let mesh = marching_cubes(&head(), 90.5).expect("a mesh");
    let (_, theirs) = check(&mut oracle, &mesh).unwrap_or_else(|error| panic!("{error}"));
    // The largest by area has the most triangles too.
    assert_eq!(checksum(&keep_largest(&mesh, 1)), theirs.largest);
}
