//! Our mesh is vtkMarchingCubes' mesh (design law 4).
//!
//! Positions are compared bit for bit: both are computed in 64 bits in the lattice, rounded there, mapped to the world in 64
//! bits, and rounded again.

mod oracle;
mod same;

use std::cell::RefCell;

use glam::{DMat3, DQuat, DVec3};
use oracle::{Merging, Oracle, Place};
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};
use same::{same, same_shape};
use vcsg::surface::{Mesh, marching_cubes};
use vcsg::volume::io;
use vcsg::volume::{Grid, Voxels};

/// Extracts with both, compares, and returns ours.
fn check(oracle: &mut Oracle, grid: &Grid, place: &Place, iso: f64) -> Mesh {
    let ours = marching_cubes(grid, iso).expect("a mesh");
    let theirs = oracle.mesh(grid, place, iso, Merging::Usual);
    if let Err(difference) = same(grid, iso, &ours, &theirs) {
        panic!(
            "{:?} {:?} at {iso}, {place:?}: {difference}",
            grid.dims(),
            grid.voxel_type()
        );
    }
    ours
}

fn grid(dims: [usize; 3], place: &Place, voxels: Voxels) -> Grid {
    Grid::new(dims, place.world_from_index(), voxels).expect("a grid")
}

/// `f` at the voxels of a cube of `n` of them, which spans [−1, 1].
fn sampled(n: usize, place: &Place, f: impl Fn(DVec3) -> f64) -> Grid {
    let at = |i: usize| 2.0 * i as f64 / (n - 1) as f64 - 1.0;
    let values = (0..n * n * n).map(|v| f(DVec3::new(at(v % n), at(v / n % n), at(v / (n * n)))) as f32);
    grid([n; 3], place, Voxels::F32(values.collect()))
}

fn oblique() -> Place {
    Place {
        direction: DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7)),
        spacing: DVec3::new(0.7, 0.9, 2.5),
        origin: DVec3::new(-120.5, 33.25, 1004.0),
    }
}

#[test]
fn every_case() {
    let mut oracle = Oracle::start();
    for case in 0..256_u32 {
        let value = |c: u32| {
            if case >> c & 1 == 1 {
                1.0 + c as f32
            } else {
                -1.0 - (c * c % 5) as f32
            }
        };
        let cube = grid([2; 3], &Place::UNIT, Voxels::F32((0..8).map(value).collect()));
        let mesh = check(&mut oracle, &cube, &Place::UNIT, 0.0);
        assert_eq!(mesh.is_empty(), case == 0 || case == 255);
    }
}

#[test]
fn analytic_fields() {
    let mut oracle = Oracle::start();
    let sphere = |p: DVec3| 1.0 - p.length();
    let torus = |p: DVec3| 0.3 - DVec3::new(p.x.hypot(p.y) - 0.6, p.z, 0.0).length();
    let gyroid = |p: DVec3| {
        let q = p * 9.0;
        q.x.sin() * q.y.cos() + q.y.sin() * q.z.cos() + q.z.sin() * q.x.cos()
    };
    let fields: [&dyn Fn(DVec3) -> f64; 3] = [&sphere, &torus, &gyroid];
    for (f, place) in fields.into_iter().zip([Place::UNIT, oblique(), oblique()]) {
        let field = sampled(50, &place, f);
        for iso in [-0.2, 0.0, 0.123, 0.5] {
            check(&mut oracle, &field, &place, iso);
        }
        assert!(check(&mut oracle, &field, &place, 1e9).is_empty());
    }
}

/// A lattice of few different values, so that many are the isovalue itself, or of many.
fn voxels(count: usize) -> impl Strategy<Value = Voxels> {
    let of = move |range: std::ops::Range<i16>| prop::collection::vec(range, count);
    prop_oneof![
        of(0..5).prop_map(|v| Voxels::U8(v.into_iter().map(|x| x as u8).collect())),
        of(0..256).prop_map(|v| Voxels::U8(v.into_iter().map(|x| x as u8).collect())),
        of(-3..3).prop_map(Voxels::I16),
        of(-1024..3071).prop_map(Voxels::I16),
        of(-3..3).prop_map(|v| Voxels::F32(v.into_iter().map(f32::from).collect())),
        prop::collection::vec(-10.0_f32..10.0, count).prop_map(Voxels::F32),
    ]
}

fn places() -> impl Strategy<Value = Place> {
    let angles = (0.0..6.0_f64, -1.0..1.0_f64, 0.0..6.0_f64);
    let spacing = (0.2..4.0_f64, 0.2..4.0_f64, 0.2..4.0_f64);
    let origin = (-200.0..200.0_f64, -200.0..200.0_f64, -200.0..200.0_f64);
    let oblique = (angles, spacing, origin).prop_map(|((a, b, c), spacing, origin)| Place {
        direction: DMat3::from_euler(glam::EulerRot::ZYX, a, b, c),
        spacing: spacing.into(),
        origin: origin.into(),
    });
    prop_oneof![Just(Place::UNIT), oblique]
}

type Comparison = fn(&Grid, f64, &Mesh, &Mesh) -> Result<(), String>;

const ISOVALUES: [f64; 5] = [-1.5, 0.0, 2.0, 3.7, 128.0];

/// Holds our mesh against VTK's for `cases` random fields of the voxels that `voxels` makes.
fn random<V>(cases: u32, merging: Merging, voxels: impl Fn(usize) -> V, compare: Comparison)
where
    V: Strategy<Value = Voxels>,
{
    let field = (2..9_usize, 2..9_usize, 2..9_usize).prop_flat_map(|(nx, ny, nz)| {
        let iso = prop::sample::select(&ISOVALUES[..]);
        (Just([nx, ny, nz]), voxels(nx * ny * nz), places(), iso)
    });
    let config = ProptestConfig {
        cases,
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    let oracle = RefCell::new(Oracle::start());
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let outcome = runner.run(&field, |(dims, voxels, place, iso)| {
        let grid = grid(dims, &place, voxels);
        let ours = marching_cubes(&grid, iso).expect("a mesh");
        let theirs = oracle.borrow_mut().mesh(&grid, &place, iso, merging);
        compare(&grid, iso, &ours, &theirs).map_err(TestCaseError::fail)
    });
    outcome.unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn random_fields() {
    random(400, Merging::Usual, voxels, same);
}

/// Values so close to the isovalue that vertices round to voxels without lying on them. Gradients differ as much, so that the
/// normal depends on which of the vertices on a voxel came first.
#[test]
fn near_hits() {
    let powers = |v: Vec<f64>| Voxels::F64(v.into_iter().map(|x| x.powi(31)).collect());
    let voxels = |count| prop::collection::vec(-1.0_f64..1.0, count).prop_map(powers);
    random(200, Merging::Thorough, voxels, same_shape);
}

#[test]
fn every_voxel_type() {
    let mut oracle = Oracle::start();
    let values = (0..1000_i64).map(|n| n * n % 97 - 40).collect::<Vec<_>>();
    let all = [
        Voxels::I8(values.iter().map(|v| *v as i8).collect()),
        Voxels::U16(values.iter().map(|v| (v * 500 + 25000) as u16).collect()),
        Voxels::U32(values.iter().map(|v| (v + 50) as u32 * 40_000_000).collect()),
        Voxels::I32(values.iter().map(|v| *v as i32 * 20_000_000).collect()),
        Voxels::F64(values.iter().map(|v| *v as f64 / 7.0).collect()),
    ];
    for voxels in all {
        let lattice = grid([10; 3], &Place::UNIT, voxels);
        let stats = lattice.stats();
        for iso in [stats.mean, stats.mean.round(), stats.min, stats.max, stats.max * 2.0] {
            check(&mut oracle, &lattice, &Place::UNIT, iso);
        }
    }
}

#[test]
fn thin_volumes() {
    let mut oracle = Oracle::start();
    for dims in [[1, 5, 5], [5, 1, 5], [5, 5, 1], [1, 1, 1]] {
        let count = dims.iter().product::<usize>();
        let flat = grid(
            dims,
            &Place::UNIT,
            Voxels::U8((0..count).map(|n| (n * 91 % 256) as u8).collect()),
        );
        assert!(check(&mut oracle, &flat, &Place::UNIT, 100.0).is_empty());
    }
    for dims in [[2, 5, 70], [70, 2, 5], [5, 70, 2], [2, 2, 70], [130, 2, 2], [3, 4, 200]] {
        let count = dims.iter().product::<usize>();
        let thin = grid(
            dims,
            &Place::UNIT,
            Voxels::U8((0..count).map(|n| (n * n * 91 % 251) as u8).collect()),
        );
        assert!(!check(&mut oracle, &thin, &Place::UNIT, 100.0).is_empty());
    }
}

#[test]
fn voxels_that_are_not_finite() {
    let mut oracle = Oracle::start();
    let wave = |n: usize| ((n * 37 % 101) as f32 / 101.0).sin();
    let values = (0..1000).map(|n| match n % 89 {
        3 => f32::NAN,
        5 => f32::INFINITY,
        7 => f32::NEG_INFINITY,
        _ => wave(n),
    });
    let holes = grid([10; 3], &Place::UNIT, Voxels::F32(values.collect()));
    let mesh = check(&mut oracle, &holes, &Place::UNIT, 0.4);
    assert!(mesh.positions.iter().flatten().any(|x| x.is_nan()));
}

/// A scan on axes of its own; VTK does not turn triangles over on a reflected lattice.
fn scan(name: &str) -> (Grid, Place) {
    let path = format!("target/deps/data/{name}");
    let volume = io::read(path.as_ref()).unwrap_or_else(|error| panic!("{error}; run make setup"));
    let place = Place {
        spacing: vcsg::math::affine::spacing(volume.grid.world_from_index()),
        ..Place::UNIT
    };
    (grid(volume.grid.dims(), &place, volume.grid.voxels().clone()), place)
}

#[test]
fn an_mr_head() {
    let mut oracle = Oracle::start();
    let (head, place) = scan("ch2.nii.gz");
    for iso in [30.0, 90.5, 150.0] {
        check(&mut oracle, &head, &place, iso);
    }
}

#[test]
fn a_ct_head() {
    let mut oracle = Oracle::start();
    let (head, place) = scan("cranium.nhdr");
    for iso in [-300.0, 200.0, 1000.5] {
        check(&mut oracle, &head, &place, iso);
    }
}

#[test]
fn a_reflected_lattice_has_its_triangles_turned_over() {
    let ball = sampled(12, &Place::UNIT, |p| 0.8 - p.length());
    let mut mirrored = Place::UNIT;
    mirrored.direction.x_axis.x = -1.0;
    let other = grid(ball.dims(), &mirrored, ball.voxels().clone());
    let (plain, mirrored) = (marching_cubes(&ball, 0.0), marching_cubes(&other, 0.0));
    let (plain, mut mirrored) = (plain.expect("a mesh"), mirrored.expect("a mesh"));
    mirrored.positions.iter_mut().for_each(|p| p[0] = -p[0]);
    mirrored.normals.iter_mut().for_each(|n| n[0] = -n[0]);
    mirrored.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    assert_eq!(same(&ball, 0.0, &mirrored, &plain), Ok(()));
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let (head, _) = scan("ch2.nii.gz");
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        pool.install(|| marching_cubes(&head, 60.0).expect("a mesh"))
    };
    let one = with(1);
    for threads in [2, 3, 7] {
        assert!(with(threads) == one, "{threads} threads");
    }
}

#[test]
fn the_comparison_sees_what_is_wrong() {
    let ball = sampled(12, &Place::UNIT, |p| 0.8 - p.length());
    let good = marching_cubes(&ball, 0.0).expect("a mesh");
    let wrong = |change: &dyn Fn(&mut Mesh)| {
        let mut mesh = good.clone();
        change(&mut mesh);
        assert!(same(&ball, 0.0, &mesh, &good).is_err());
        assert!(same(&ball, 0.0, &good, &mesh).is_err());
    };
    wrong(&|mesh| mesh.positions[7][1] = mesh.positions[7][1].next_up());
    wrong(&|mesh| mesh.triangles.truncate(mesh.triangles.len() - 1));
    wrong(&|mesh| mesh.triangles[9].swap(0, 1));
    wrong(&|mesh| {
        let again = mesh.triangles[3];
        mesh.triangles.to_mut().push(again);
    });
    wrong(&|mesh| mesh.normals[11][2] += 1e-4);
    wrong(&|mesh| {
        mesh.positions.to_mut().push([0.0; 3]);
        mesh.normals.to_mut().push([0.0; 3]);
    });
}
