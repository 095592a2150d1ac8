//! The surface of a model from its target's blocks: where it must be, and that blocks do not show (design laws 2 and 4).

use std::collections::HashMap;

use glam::{DVec3, Vec3};
use proptest::prelude::*;
use vcsg::math::Plane;
use vcsg::model::{BooleanOp, Boundary, Combine, Family, Model, Node, NodeId, ValueRule};
use vcsg::surface::{Mesh, Topology, extract_target, marching_cubes};
use vcsg::target::{Subdivision, Target, VoxelTarget};
use vcsg::volume::{Grid, Voxels};
use vcsg::voxelize::{Primitive, Solid};

use crate::support::cases;
use crate::support::scenes::{scene, subdivision};

fn built(model: &Model, spacing_mm: f64, min_block: usize) -> Target {
    let subdivision = Subdivision {
        min_block,
        ..Subdivision::default()
    };
    Target::build(model, Some(spacing_mm), &subdivision).expect("a target")
}

fn surface(target: &Target, iso: f64, topology: Topology) -> Mesh {
    extract_target(target, iso, topology, &mut |_| ()).expect("a mesh")
}

fn ball(model: &mut Model, center: DVec3, radius: f64) -> NodeId {
    model.push(Node::Primitive(Primitive::crisp(
        Solid::Sphere { center, radius },
        100.0,
    )))
}

/// Every directed edge once, and its opposite once: closed, and each edge between two triangles.
fn assert_closed(mesh: &Mesh) {
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for [a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((*from, *to)).or_default() += 1;
        }
    }
    for ((from, to), count) in &edges {
        assert_eq!((*count, edges.get(&(*to, *from))), (1, Some(&1)), "edge {from} to {to}");
    }
}

/// What a vertex may be off: half of the last halving of an edge, and the rounding of an index and of a place, which are below
/// 128 and rounded to 24 bits each.
fn off(spacing_mm: f64) -> f64 {
    spacing_mm * 0.5_f64.powi(21) + 128.0 * 0.5_f64.powi(24) * (1.0 + spacing_mm)
}

/// Each vertex as a point.
fn points(mesh: &Mesh) -> impl Iterator<Item = DVec3> {
    mesh.positions.iter().map(|p| Vec3::from_array(*p).as_dvec3())
}

#[test]
fn a_crisp_ball_is_round() {
    let mut model = Model::default();
    let center = DVec3::new(1.3, -2.2, 0.7);
    ball(&mut model, center, 20.0);
    for (spacing_mm, topology) in [(1.0, Topology::Vtk), (2.7, Topology::Trilinear)] {
        let mesh = surface(&built(&model, spacing_mm, 8), 50.0, topology);
        assert!(mesh.triangles.len() > 500);
        assert_closed(&mesh);
        for p in points(&mesh) {
            let apart = (p.distance(center) - 20.0).abs();
            assert!(apart <= off(spacing_mm), "{p} is {apart} off the sphere");
        }
        // A normal here is a mean over triangles of edges up to √3 voxels: each turns by less than that over the radius.
        for (p, n) in points(&mesh).zip(&mesh.normals) {
            let cosine = Vec3::from_array(*n).as_dvec3().dot((p - center).normalize());
            assert!(
                cosine > (2.0 * 3.0_f64.sqrt() * spacing_mm / 20.0).cos(),
                "{n:?} at {p}: {cosine}"
            );
        }
    }
}

#[test]
fn a_cut_is_a_plane() {
    let mut model = Model::default();
    let child = ball(&mut model, DVec3::ZERO, 15.0);
    let normal = DVec3::new(1.0, 2.0, -0.4);
    let plane = Plane::through(DVec3::new(2.0, 1.0, 0.0), normal).expect("a plane");
    model.push(Node::Cut { child, plane });
    let mesh = surface(&built(&model, 1.0, 8), 50.0, Topology::Vtk);
    assert_closed(&mesh);
    let on_plane = |p: DVec3| plane.distance(p).abs() <= off(1.0);
    let on_ball = |p: DVec3| (p.length() - 15.0).abs() <= off(1.0);
    assert!(points(&mesh).all(|p| on_plane(p) || on_ball(p)));
    // The disc of radius √(15² − d²): every vertex away from its rim faces along the plane's normal.
    let inner = points(&mesh)
        .zip(&mesh.normals)
        .filter(|(p, _)| on_plane(*p) && p.length() < 12.0);
    let mut count = 0;
    for (p, n) in inner {
        let cosine = Vec3::from_array(*n).as_dvec3().dot(normal.normalize());
        assert!(cosine > 1.0 - 1e-4, "{n:?} at {p}");
        count += 1;
    }
    assert!(count > 300, "{count} vertices");
}

#[test]
fn a_cut_carries_what_it_cuts_through() {
    // A volume whose value is 4x + 20: a cut across x shows one value, and one along it all of them.
    let values = (0..32 * 32 * 32).map(|n| 4.0 * (n % 32) as f32 + 20.0).collect();
    let grid = Grid::new([32; 3], glam::DAffine3::IDENTITY, Voxels::F32(values)).expect("a grid");
    for (normal, value) in [(DVec3::X, Some(4.0 * 13.3 + 20.0)), (DVec3::Y, None)] {
        let mut model = Model::default();
        let volume = model.push(Node::Volume(vcsg::model::VolumeLeaf {
            bricks: std::sync::Arc::new(vcsg::volume::Bricks::new(&grid)),
            window: vcsg::math::Interval::ALL,
        }));
        let plane = Plane::through(DVec3::splat(13.3), normal).expect("a plane");
        model.push(Node::Cut { child: volume, plane });
        let mesh = surface(&built(&model, 1.0, 8), 40.0, Topology::Vtk);
        assert_closed(&mesh);
        let on_cut = points(&mesh)
            .zip(&mesh.values)
            .filter(|(p, _)| plane.distance(*p).abs() <= off(1.0));
        let mut count = 0;
        for (p, v) in on_cut {
            let expected = value.unwrap_or(4.0 * p.x.clamp(0.0, 31.0) + 20.0);
            // The last halving's remainder, times 4 a millimetre, and the rounding of places and values below 256.
            assert!(
                (f64::from(*v) - expected).abs() <= 8.0 * off(1.0) + 256.0 * 0.5_f64.powi(23),
                "{v} at {p}, not {expected}"
            );
            count += 1;
        }
        assert!(count > 200, "{count} vertices");
    }
}

#[test]
fn a_hole_is_a_surface_too() {
    let mut model = Model::default();
    let first = ball(&mut model, DVec3::ZERO, 12.0);
    let second = ball(&mut model, DVec3::ZERO, 6.0);
    model.push(Node::Combine(Combine {
        op: BooleanOp::Subtraction,
        rule: ValueRule::First,
        family: Family::MinMax,
        first,
        second,
    }));
    let mesh = surface(&built(&model, 1.0, 8), 50.0, Topology::Vtk);
    assert_closed(&mesh);
    let [mut inner, mut outer] = [0, 0];
    for (p, n) in points(&mesh).zip(&mesh.normals) {
        let outwards = Vec3::from_array(*n).as_dvec3().dot(p) > 0.0;
        match p.length() < 9.0 {
            true => inner += 1,
            false => outer += 1,
        }
        assert_eq!(outwards, p.length() > 9.0, "the normal at {p} faces the solid");
    }
    assert!(inner > 300 && outer > 300);
}

#[test]
fn nothing_is_an_empty_mesh() {
    let mut model = Model::default();
    ball(&mut model, DVec3::ZERO, 5.0);
    assert!(surface(&built(&model, 1.0, 8), 101.0, Topology::Vtk).is_empty());
}

/// The target's samples as one grid, NaN where nothing is.
fn baked(target: &Target) -> Result<Grid, TestCaseError> {
    let [nx, ny, nz] = target.lattice.dims;
    let voxels = VoxelTarget::new(target);
    let value = |n: usize| {
        let at = [n % nx, n / nx % ny, n / (nx * ny)].map(|i| i as i64);
        let sample = voxels.sample(at);
        // Half covered is there: a soft surface lies where its solid's does.
        if sample.coverage >= 0.5 { sample.value } else { f32::NAN }
    };
    let values = (0..nx * ny * nz).map(value).collect();
    Grid::new([nx, ny, nz], target.lattice.world_from_lattice, Voxels::F32(values))
        .map_err(|_| TestCaseError::reject("a lattice that is flat in the world"))
}

/// How often each triangle occurs, by its corners' bits from the smallest on, but for those with a corner at NaN.
fn triangles(mesh: &Mesh) -> HashMap<[[u32; 3]; 3], i32> {
    let mut counts = HashMap::new();
    for n in 0..mesh.triangles.len() {
        let corners = mesh.corners(n);
        if corners.iter().flatten().all(|x| x.is_finite()) {
            let [a, b, c] = corners.map(|p| p.map(f32::to_bits));
            *counts.entry([a, b, c].min([b, c, a]).min([c, a, b])).or_default() += 1;
        }
    }
    counts
}

proptest! {
    #![proptest_config(cases(64))]

    /// Whatever the blocks and the number of threads, the mesh has the same bits.
    #[test]
    fn one_block_or_many(scene in scene(), subdivision in subdivision(Boundary::Exact), iso in -20.0..150.0_f64) {
        let whole = surface(&scene.target(&Subdivision::default()), iso, Topology::Vtk);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads");
        let blocks = pool.install(|| surface(&scene.target(&subdivision), iso, Topology::Vtk));
        prop_assert!(whole == blocks);
    }

    /// The trilinear surface of any scene is closed: each edge is between two triangles.
    #[test]
    fn a_manifold_of_any_scene(scene in scene(), iso in -20.0..150.0_f64) {
        let target = scene.target(&Subdivision::default());
        let mesh = surface(&target, iso, Topology::Trilinear);
        assert_closed(&mesh);
    }

    /// Away from where the model ends, the mesh is that of a grid of its samples.
    #[test]
    fn the_samples_own_surface(scene in scene(), iso in -20.0..150.0_f64) {
        let target = scene.target(&Subdivision::default());
        let ours = surface(&target, iso, Topology::Vtk);
        let of_grid = marching_cubes(&baked(&target)?, iso).expect("a mesh");
        let found = triangles(&ours);
        for (corners, count) in triangles(&of_grid) {
            prop_assert!(found.get(&corners).is_some_and(|n| *n >= count), "{corners:?} is missing");
        }
    }
}
