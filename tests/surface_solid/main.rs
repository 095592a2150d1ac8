//! Solids: cut meshes are closed, bound what they should, and carry the scan's values (LC87 §5.2).

mod fields;
mod measure;
mod oracle;

use std::collections::HashMap;
use std::f64::consts::PI;
use std::path::Path;

use fields::{Case, cases, sampled};
use glam::{DAffine3, DVec3};
use measure::{areas, crowded_sides, open_side, perimeters, rounding, sides, volume};
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};
use vcsg::surface::{Border, Creases, Cutter, Mesh, Operation, SolidOptions, combine, marching_cubes};
use vcsg::volume::{Grid, Voxels, io};

const CLOSED: SolidOptions = SolidOptions {
    border: Border::Closed,
    creases: Creases::Shared,
};

const OPERATIONS: [Operation; 3] = [Operation::Intersection, Operation::Difference, Operation::Union];

fn solid(grid: &Grid, iso: f64, operation: Operation, cutter: Cutter<'_>) -> Mesh {
    combine(grid, iso, operation, cutter, CLOSED).expect("a mesh")
}

/// A half-space that has all of the lattices here inside.
fn everything() -> Cutter<'static> {
    Cutter::half_space(DVec3::new(1e4, 0.0, 0.0), DVec3::X)
}

fn nothing() -> Cutter<'static> {
    Cutter::half_space(DVec3::new(1e4, 0.0, 0.0), DVec3::NEG_X)
}

fn random(cases_count: u32, check: impl Fn(Case, f64) -> Result<(), TestCaseError>) {
    let config = ProptestConfig {
        cases: cases_count,
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let inputs = (cases(), prop::sample::select(vec![0.5, 1.0, 2.0, 77.7]));
    let outcome = runner.run(&inputs, |(case, iso)| check(case, iso));
    outcome.unwrap_or_else(|error| panic!("{error}"));
}

/// Whether both ends lie in one face of the lattice's border.
fn in_border(grid: &Grid, ends: [DVec3; 2]) -> bool {
    let index_from_world = grid.world_from_index().inverse();
    let ends = ends.map(|p| index_from_world.transform_point3(p).to_array());
    (0..3).any(|axis| {
        [0.0, (grid.dims()[axis] - 1) as f64]
            .iter()
            .any(|face| ends.iter().all(|p| (p[axis] - face).abs() < 1e-3))
    })
}

#[test]
fn every_side_has_its_opposite() {
    random(1000, |case, iso| {
        for operation in OPERATIONS {
            let closed = solid(&case.scan, iso, operation, case.cutter());
            prop_assert_eq!(open_side(&closed, |_| false), None, "{:?}", operation);
            let open = combine(&case.scan, iso, operation, case.cutter(), SolidOptions::default()).expect("a mesh");
            let open_side = open_side(&open, |ends| in_border(&case.scan, ends));
            prop_assert_eq!(open_side, None, "{:?}, open border", operation);
        }
        Ok(())
    });
}

#[test]
fn a_dropped_or_turned_cap_is_seen() {
    let ball = sampled(20, |p| 0.7 - p.length());
    let mesh = solid(
        &ball,
        0.0,
        Operation::Intersection,
        Cutter::half_space(DVec3::ZERO, DVec3::ONE),
    );
    assert_eq!(open_side(&mesh, |_| false), None);
    let cap = mesh.parts[1].triangles.clone();
    let mut dropped = mesh.clone();
    dropped.triangles.to_mut().drain(cap.clone());
    assert!(open_side(&dropped, |_| false).is_some());
    let mut turned = mesh.clone();
    turned.triangles[cap].iter_mut().for_each(|t| t.swap(0, 1));
    assert!(open_side(&turned, |_| false).is_some());
}

/// Rounding moves the vertices on a cut by `rounding` at most, once for each of the two meshes, and that moves no more volume
/// than its product with the area of the triangles. Sums of n terms in `f64` are off by n·2⁻⁵³ of their sizes at most.
#[test]
fn what_is_cut_off_is_what_is_missing() {
    random(500, |case, iso| {
        let whole = solid(&case.scan, iso, Operation::Intersection, everything());
        let kept = solid(&case.scan, iso, Operation::Intersection, case.cutter());
        let lost = solid(&case.scan, iso, Operation::Difference, case.cutter());
        let area: f64 = [&whole, &kept, &lost].into_iter().flat_map(areas).sum();
        let reach = whole
            .positions
            .iter()
            .map(|p| glam::Vec3::from(*p).as_dvec3().length())
            .fold(0.0, f64::max);
        let terms = (kept.triangles.len() + lost.triangles.len()) as f64;
        let bound = 2.0 * rounding(&whole) * area + terms * f64::EPSILON * area * reach;
        let difference = volume(&kept) + volume(&lost) - volume(&whole);
        prop_assert!(difference.abs() <= bound, "{} off, {} allowed", difference, bound);
        Ok(())
    });
}

type Triangles = Vec<[[u32; 3]; 3]>;

/// The triangles by position, each from its lowest corner on.
fn triangles(mesh: &Mesh) -> Triangles {
    let turned = |n: usize| {
        let mut corners = mesh.corners(n).map(|at| at.map(f32::to_bits));
        let first = (0..3).min_by_key(|i| corners[*i]).unwrap_or(0);
        corners.rotate_left(first);
        corners
    };
    let mut all: Triangles = (0..mesh.triangles.len()).map(turned).collect();
    all.sort();
    all
}

#[test]
fn everything_changes_nothing_and_nothing_leaves_nothing() {
    let open = SolidOptions::default();
    random(300, |case, iso| {
        let surface = triangles(&marching_cubes(&case.scan, iso).expect("a mesh"));
        for (operation, cutter) in [
            (Operation::Intersection, everything()),
            (Operation::Difference, nothing()),
            (Operation::Union, nothing()),
        ] {
            let mesh = combine(&case.scan, iso, operation, cutter, open).expect("a mesh");
            prop_assert_eq!(triangles(&mesh), surface.clone(), "{:?}", operation);
            prop_assert_eq!(mesh.values.len(), mesh.positions.len());
        }
        prop_assert!(solid(&case.scan, iso, Operation::Intersection, nothing()).is_empty());
        prop_assert!(solid(&case.scan, iso, Operation::Difference, everything()).is_empty());
        Ok(())
    });
}

/// Two solids on one lattice: where one is inside or outside throughout, the other's surface is that of marching cubes.
#[test]
fn caps_are_marching_cubes_of_the_cutter() {
    let scan = sampled(24, |_| 1.0);
    let ball = sampled(24, |p| 0.7 - p.length());
    let mesh = combine(
        &scan,
        0.0,
        Operation::Intersection,
        Cutter::level(&ball, 0.0),
        SolidOptions::default(),
    );
    let mesh = mesh.expect("a mesh");
    let surface = marching_cubes(&ball, 0.0).expect("a mesh");
    assert_eq!(mesh.triangles.len(), surface.triangles.len());
    assert!((areas(&mesh)[1] / areas(&surface)[0] - 1.0).abs() < 1e-6);
    assert_eq!(areas(&mesh)[0], 0.0);
}

/// Vertices of the scan's surface lie up to 2⁻²⁴ of the lattice's size and of their own off the points where the plane was
/// evaluated, the cut lies between two of them, and is rounded once more.
#[test]
fn caps_of_planes_are_flat_and_carry_the_scan() {
    let field = |p: DVec3| 100.0 * (0.8 - p.length()) + 30.0 * (5.0 * p.x).sin() * (4.0 * p.y).cos();
    let scan = sampled(40, field);
    let index_from_world = scan.world_from_index().inverse();
    for (through, normal) in planes() {
        let plane = Cutter::half_space(through, normal);
        let mesh = solid(&scan, 0.0, Operation::Intersection, plane);
        let bound = 3.0_f64.sqrt() * (1.0 + 2.0 + 2.0) * 2.0_f64.powi(-24);
        let cap = &mesh.triangles[mesh.parts[1].triangles.clone()];
        assert!(cap.len() > 1000);
        for v in cap.iter().flatten().map(|v| *v as usize) {
            let at = glam::Vec3::from(mesh.positions[v]).as_dvec3();
            let off = (at - through).dot(normal.normalize());
            assert!(off.abs() <= bound, "{off} off the plane, {bound} allowed");
            // A voxel is 2/39, and values change by less than 40 across it; positions are rounded as above.
            let expected = trilinear(&scan, index_from_world.transform_point3(at));
            let allowed = 40.0 * 39.0 / 2.0 * 3.0 * bound + 200.0 * 2.0_f64.powi(-24);
            let value = f64::from(mesh.values[v]);
            assert!((value - expected).abs() <= allowed, "{value}, not {expected}");
        }
    }
}

fn trilinear(grid: &Grid, at: DVec3) -> f64 {
    let last = grid.dims().map(|n| n - 2);
    let base = [0, 1, 2].map(|axis| (at[axis].floor().max(0.0) as usize).min(last[axis]));
    let corners = (0..8).map(|c| {
        let upper = [0, 1, 2].map(|axis| c >> axis & 1);
        let weight = |axis: usize| {
            let t = at[axis] - base[axis] as f64;
            if upper[axis] == 1 { t } else { 1.0 - t }
        };
        weight(0) * weight(1) * weight(2) * grid.value_at([0, 1, 2].map(|axis| base[axis] + upper[axis]))
    });
    corners.sum()
}

fn planes() -> [(DVec3, DVec3); 4] {
    [
        (DVec3::ZERO, DVec3::Z),
        (DVec3::new(0.1, 0.2, -0.3), DVec3::new(0.3, -0.5, 0.8)),
        (DVec3::new(-0.2, 0.1, 0.15), DVec3::ONE),
        (DVec3::new(0.05, 0.0, 0.1), DVec3::new(-1.0, 0.01, 0.0)),
    ]
}

/// The distance field of a ball is trilinear to within h²·|second derivatives|/8·3, and these are at most 2/r near its surface:
/// vertices are within 3h²/(4r) of the ball, and chords within another h²·3/(8r). So areas and volumes of the mesh are those of a ball
/// whose radius is off by at most 2h²/r.
#[test]
fn balls_cut_by_planes_and_balls() {
    for n in [33, 65] {
        let h = 2.0 / (n - 1) as f64;
        let (r, d) = (0.75, 0.3);
        let dr = 2.0 * h * h / r;
        let ball = sampled(n, |p| r - p.length());
        let normal = DVec3::new(0.4, 0.2, -0.7).normalize();
        let mesh = solid(
            &ball,
            0.0,
            Operation::Difference,
            Cutter::half_space(normal * d, normal),
        );
        let cap_volume = |r: f64| PI * (r - d).powi(2) * (2.0 * r + d) / 3.0;
        let disc = |r: f64| PI * (r * r - d * d);
        assert_near(volume(&mesh), [cap_volume(r - dr), cap_volume(r + dr)]);
        assert_near(areas(&mesh)[1], [disc(r - dr), disc(r + dr)]);
        // Half the surface of the ball's cap is 2 π r (r − d); facets' areas are second order too.
        let dome = |r: f64| 2.0 * PI * r * (r - d);
        assert_near(areas(&mesh)[0], [dome(r - dr), dome(r + dr)]);

        let (apart, radius) = (0.5, 0.6);
        let dr = 2.0 * h * h / radius;
        let [a, b] = [-0.25, 0.25].map(|x| sampled(n, move |p| radius - (p - DVec3::new(x, 0.1, 0.0)).length()));
        let lens = |r: f64| PI * (4.0 * r + apart) * (2.0 * r - apart).powi(2) / 12.0;
        let sphere = |r: f64| 4.0 / 3.0 * PI * r.powi(3);
        let both = |operation| volume(&solid(&a, 0.0, operation, Cutter::level(&b, 0.0)));
        assert_near(both(Operation::Intersection), [lens(radius - dr), lens(radius + dr)]);
        let less = |r: f64, other: f64| sphere(r) - lens(other);
        let bounds = [less(radius - dr, radius + dr), less(radius + dr, radius - dr)];
        assert_near(both(Operation::Difference), bounds);
        let joined = |r: f64, other: f64| 2.0 * sphere(r) - lens(other);
        let bounds = [joined(radius - dr, radius + dr), joined(radius + dr, radius - dr)];
        assert_near(both(Operation::Union), bounds);
    }
}

fn assert_near(found: f64, [least, most]: [f64; 2]) {
    assert!((least..=most).contains(&found), "{found} is not from {least} to {most}");
}

/// Both cut the same triangles by the same plane. Our vertices on the cut are rounded, theirs are not; moving a vertex by δ
/// changes a triangle's area by at most half of δ times the opposite side. The plane is evaluated at points that are up to as
/// far from the vertices as rounding moves those, twice.
#[test]
fn areas_are_those_of_vtk_clip_closed_surface() {
    let gyroid = |p: DVec3| {
        let q = p * 7.0;
        q.x.sin() * q.y.cos() + q.y.sin() * q.z.cos() + q.z.sin() * q.x.cos()
    };
    let scan = sampled(32, gyroid);
    let whole = solid(&scan, 0.1, Operation::Intersection, everything());
    for (through, normal) in planes() {
        let ours = solid(&scan, 0.1, Operation::Intersection, Cutter::half_space(through, normal));
        let theirs = oracle::clipped_areas(&whole, through, normal);
        let [surface, cap, border] = areas(&ours).try_into().expect("three parts");
        let bound = 4.0 * rounding(&whole) * perimeters(&ours);
        assert!(
            (surface + border - theirs[0]).abs() <= bound,
            "{} {theirs:?} {bound}",
            surface + border
        );
        assert!((cap - theirs[1]).abs() <= bound, "{cap} {theirs:?} {bound}");
    }
}

#[test]
fn a_mask_keeps_what_it_covers() {
    let scan = sampled(20, |p| 0.8 - p.length());
    let inside = (0..8000).map(|v| u8::from(v % 20 > 9)).collect();
    let mask = Grid::new([20; 3], *scan.world_from_index(), Voxels::U8(inside)).expect("a grid");
    let mesh = solid(&scan, 0.0, Operation::Intersection, Cutter::mask(&mask));
    let plane = Cutter::half_space(DVec3::ZERO, DVec3::NEG_X);
    let half = solid(&scan, 0.0, Operation::Intersection, plane);
    // The mask's border lies half-way between voxels 9 and 10, which is 0 but for rounding of the lattice.
    assert!((volume(&mesh) - volume(&half)).abs() <= 1e-12 + 4.0 * rounding(&mesh) * areas(&mesh).iter().sum::<f64>());
    assert_eq!(mesh.triangles.len(), half.triangles.len());
}

#[test]
fn sharp_creases_have_the_same_triangles() {
    let ball = sampled(20, |p| 0.9 - p.abs().max_element() + 0.2 * p.x);
    let normal = DVec3::new(0.3, -0.5, 0.8).normalize();
    let plane = Cutter::half_space(DVec3::new(0.1, 0.0, 0.0), normal);
    let make = |creases| {
        let options = SolidOptions {
            border: Border::Closed,
            creases,
        };
        combine(&ball, 0.0, Operation::Difference, plane, options).expect("a mesh")
    };
    let (shared, sharp) = (make(Creases::Shared), make(Creases::Sharp));
    assert_eq!(triangles(&shared), triangles(&sharp));
    assert!(sharp.positions.len() > shared.positions.len());
    for v in sharp.triangles[sharp.parts[1].triangles.clone()].iter().flatten() {
        assert_eq!(sharp.normals[*v as usize], (-normal).as_vec3().to_array());
    }
}

/// Normals of the surface, of caps and of the border point to where triangles face.
#[test]
fn caps_face_where_their_normals_point() {
    let ball = sampled(24, |p| 1.2 - p.length());
    let other = sampled(24, |p| 0.8 - (p - DVec3::splat(0.4)).length());
    let options = SolidOptions {
        border: Border::Closed,
        creases: Creases::Sharp,
    };
    for operation in OPERATIONS {
        let mesh = combine(&ball, 0.0, operation, Cutter::level(&other, 0.0), options).expect("a mesh");
        for part in &mesh.parts {
            assert!(!part.triangles.is_empty() || (part.label, operation) == (0, Operation::Intersection));
            let facing = part.triangles.clone().map(|n| {
                let [a, b, c] = measure::corners(&mesh, n);
                let normals = mesh.triangles[n].map(|v| glam::Vec3::from(mesh.normals[v as usize]).as_dvec3());
                (b - a).cross(c - a).dot(normals.into_iter().sum())
            });
            // Slivers may turn when they are rounded.
            let (right, wrong) = facing.fold((0.0, 0.0), |(r, w), f| (r + f64::max(f, 0.0), w - f64::min(f, 0.0)));
            assert!(
                wrong <= 1e-6 * right,
                "{operation:?}, part {}: {wrong} of {right}",
                part.label
            );
        }
    }
}

#[test]
fn the_same_for_any_number_of_threads() {
    let scan = sampled(30, |p| (7.0 * p.x).sin() * (6.0 * p.y).cos() + p.z);
    let plane = Cutter::half_space(DVec3::ZERO, DVec3::new(0.3, -0.5, 0.8));
    let make = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a pool");
        pool.install(|| solid(&scan, 0.0, Operation::Intersection, plane))
    };
    assert_eq!(make(1), make(3));
}

/// Where no value is the isovalue, all sides but those on which marching cubes itself has four triangles have two.
#[test]
fn planes_add_no_crowded_sides() {
    let scan = sampled(40, |p| (9.0 * p.x).sin() * (8.0 * p.y).cos() + (7.0 * p.z).sin());
    let whole = solid(&scan, 0.11, Operation::Intersection, everything());
    for (through, normal) in planes() {
        let mesh = solid(
            &scan,
            0.11,
            Operation::Intersection,
            Cutter::half_space(through, normal),
        );
        assert!(crowded_sides(&mesh) <= crowded_sides(&whole));
    }
}

#[test]
fn impossible_isovalues_and_thin_lattices() {
    let thin = Grid::new([3, 3, 1], DAffine3::IDENTITY, Voxels::U8(vec![1; 9])).expect("a grid");
    assert!(solid(&thin, 0.5, Operation::Union, everything()).is_empty());
    assert!(combine(&thin, f64::NAN, Operation::Union, everything(), CLOSED).is_err());
    let bytes = Grid::new([3, 3, 3], DAffine3::IDENTITY, Voxels::U8(vec![1; 27])).expect("a grid");
    assert!(solid(&bytes, 300.0, Operation::Intersection, everything()).is_empty());
    let half = Cutter::half_space(DVec3::ONE, DVec3::X);
    assert!((volume(&solid(&bytes, 300.0, Operation::Union, half)) - 4.0).abs() < 1e-12);
    let holes = Grid::new(
        [3, 3, 3],
        DAffine3::IDENTITY,
        Voxels::F32((0..27).map(|v| [f32::NAN, 1.0, f32::INFINITY][v % 3]).collect()),
    );
    let mesh = solid(&holes.expect("a grid"), 0.5, Operation::Difference, half);
    assert_eq!(open_side(&mesh, |_| false), None);
}

#[test]
fn a_head_cut_by_an_oblique_plane_is_closed() {
    let path = Path::new("target/deps/data/ch2.nii.gz");
    assert!(path.exists(), "{} is missing: run make setup", path.display());
    let head = io::read(path).expect("a volume").grid;
    let middle = DVec3::from(head.dims().map(|n| n as f64 / 2.0));
    let through = head.world_from_index().transform_point3(middle);
    let plane = Cutter::half_space(through, DVec3::new(0.4, -0.3, 0.85));
    let start = std::time::Instant::now();
    let mesh = solid(&head, 60.0, Operation::Intersection, plane);
    println!("{:?}, {} triangles", start.elapsed(), mesh.triangles.len());
    assert_eq!(open_side(&mesh, |_| false), None);
    let ends: HashMap<bool, usize> = sides(&mesh).values().fold(HashMap::new(), |mut n, [_, count]| {
        *n.entry(*count == 2).or_insert(0) += 1;
        n
    });
    println!("{ends:?}, {:?}", mesh.parts);
    assert!(mesh.parts[1].triangles.len() > 10_000);
}
