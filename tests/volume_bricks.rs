//! Bricks against the definition of trilinear interpolation, over random grids of every voxel type.

use glam::{DAffine3, DQuat, DVec3, EulerRot};
use proptest::prelude::*;
use vcsg::math::{Aabb, Interval, affine};
use vcsg::volume::{Bricks, Field, Grid, Voxels};

/// Trilinear interpolation in `f64`, as it is defined: the sum of the eight voxels times their weights.
fn trilinear(grid: &Grid, p: DVec3) -> f64 {
    let dims = grid.dims();
    let last = |a: usize| (dims[a] - 1) as f64;
    let p: [f64; 3] = std::array::from_fn(|a| p[a].clamp(0.0, last(a)));
    let mut sum = 0.0;
    for corner in 0..8 {
        let step = [corner & 1, corner >> 1 & 1, corner >> 2 & 1];
        let index: [usize; 3] = std::array::from_fn(|a| (p[a].floor() as usize + step[a]).min(dims[a] - 1));
        let weight = |a: usize| {
            let t = p[a] - p[a].floor();
            if step[a] == 1 { t } else { 1.0 - t }
        };
        sum += weight(0) * weight(1) * weight(2) * f64::from(grid.value_at(index) as f32);
    }
    sum
}

/// How far a sample may be from [`trilinear`].
///
/// Three roundings of a position to 2⁻²⁴ voxel move the value by at most 2⁻²⁵ of the grid's width each; three nested
/// interpolations in `f32` are off by at most 5 roundings (half an ε of the magnitude, differences counted twice) each.
fn bound(range: Interval) -> f64 {
    let magnitude = f64::from(range.lo.abs().max(range.hi.abs()));
    let width = f64::from(range.hi) - f64::from(range.lo);
    3.0 * width * 2f64.powi(-25) + 15.0 * magnitude * f64::from(f32::EPSILON) / 2.0
}

/// Random voxels with constant stretches; `kind` picks the type.
fn voxels(kind: usize, count: usize, seed: u64) -> Voxels {
    let mut state = seed | 1;
    let mut next = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state
    };
    let quiet = seed.is_multiple_of(3);
    let mut bits = move || {
        if quiet && next() % 500 != 0 { 7 } else { next() }
    };
    match kind {
        0 => Voxels::U8((0..count).map(|_| bits() as u8).collect()),
        1 => Voxels::I8((0..count).map(|_| bits() as i8).collect()),
        2 => Voxels::U16((0..count).map(|_| bits() as u16).collect()),
        3 => Voxels::I16((0..count).map(|_| bits() as i16).collect()),
        4 => Voxels::U32((0..count).map(|_| bits() as u32).collect()),
        5 => Voxels::I32((0..count).map(|_| bits() as i32).collect()),
        6 => Voxels::F32((0..count).map(|_| bits() as i16 as f32 / 1e3).collect()),
        _ => Voxels::F64((0..count).map(|_| bits() as i32 as f64 * 1e-7).collect()),
    }
}

fn axis() -> impl Strategy<Value = usize> {
    prop_oneof![Just(1), Just(2), 3usize..12, 31usize..36, 60usize..70]
}

prop_compose! {
    /// Grids of any type; at most one long axis more than is quick.
    fn grids()(dims in [axis(), axis(), axis()], kind in 0usize..8, seed: u64) -> Grid {
        let dims = if dims.iter().product::<usize>() > 80_000 { [dims[0], 33, 5] } else { dims };
        let voxels = voxels(kind, dims.iter().product(), seed);
        Grid::new(dims, placement(seed), voxels).unwrap()
    }
}

/// A transform with rotation, mirror and shear.
fn placement(seed: u64) -> DAffine3 {
    let angle = seed as f64 / u64::MAX as f64;
    let turn = DQuat::from_euler(EulerRot::XYZ, angle, 2.0 * angle, 3.0 - angle);
    let mut m =
        DAffine3::from_scale_rotation_translation(DVec3::new(0.7, -1.1, 2.0), turn, DVec3::new(-40.0, 3.0, 1.0));
    m.matrix3.x_axis += 0.2 * m.matrix3.y_axis;
    m
}

/// A point of the box at fractions `f`.
fn point_in(b: &Aabb, f: [f64; 3]) -> DVec3 {
    b.min + b.size() * DVec3::from_array(f)
}

fn fractions() -> impl Strategy<Value = [f64; 3]> {
    let fraction = || prop_oneof![8 => 0.0..=1.0f64, 1 => Just(0.0), 1 => Just(1.0)];
    [fraction(), fraction(), fraction()]
}

/// The box between two fractions of another, on voxel centres when `snapped`.
fn sub_box(bounds: &Aabb, a: [f64; 3], b: [f64; 3], snapped: bool) -> Aabb {
    let ends = [point_in(bounds, a), point_in(bounds, b)];
    Aabb::of_points(ends.map(|p| if snapped { p.round() } else { p }))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn samples_are_trilinear(grid in grids(), at in proptest::collection::vec(fractions(), 40)) {
        let bricks = Bricks::new(&grid);
        for f in at {
            let p = point_in(&bricks.index_bounds(), f);
            let (fast, slow) = (f64::from(bricks.sample_index(p)), trilinear(&grid, p));
            prop_assert!((fast - slow).abs() <= bound(bricks.value_range()), "{fast} {slow} at {p}");
        }
    }

    #[test]
    fn voxels_and_copied_rows_are_the_grid(grid in grids(), f in fractions()) {
        let bricks = Bricks::new(&grid);
        let [nx, ny, nz] = grid.dims();
        let [i0, j, k] = [(nx, f[0]), (ny, f[1]), (nz, f[2])].map(|(n, f)| ((n - 1) as f64 * f) as usize);
        let mut row = vec![0.0; nx - i0];
        bricks.copy_row(i0, j, k, &mut row);
        for (n, v) in row.into_iter().enumerate() {
            let i = i0 + n;
            prop_assert_eq!(v.to_bits(), (grid.value_at([i, j, k]) as f32).to_bits());
            prop_assert_eq!(v.to_bits(), bricks.voxel(i, j, k).to_bits());
            let p = DVec3::new(i as f64, j as f64, k as f64);
            prop_assert_eq!(v.to_bits(), bricks.sample_index(p).to_bits());
        }
    }

    #[test]
    fn rows_are_their_points(grid in grids(), a in fractions(), b in fractions(), count in 1usize..200) {
        let bricks = Bricks::new(&grid);
        let bounds = bricks.index_bounds();
        let (from, to) = (point_in(&bounds, a), point_in(&bounds, b));
        let mut index_from_lattice = DAffine3::from_translation(from);
        index_from_lattice.matrix3.x_axis = (to - from) / count as f64;
        let row = affine::row(&index_from_lattice, 0.0, 0.0);
        let mut out = vec![f32::NAN; count];
        bricks.sample_row(&index_from_lattice, row, 0.0, &mut out);
        for (n, v) in out.into_iter().enumerate() {
            let p = affine::step(&index_from_lattice, row, n as f64);
            prop_assert_eq!(v.to_bits(), bricks.sample_index(p).to_bits(), "sample {}", n);
        }
    }

    #[test]
    fn ranges_hold_their_samples(
        grid in grids(), a in fractions(), b in fractions(), snapped: bool,
        at in proptest::collection::vec(fractions(), 40),
    ) {
        let bricks = Bricks::new(&grid);
        let region = sub_box(&bricks.index_bounds(), a, b, snapped).intersect(&bricks.index_bounds());
        prop_assume!(!region.is_empty());
        let range = bricks.range_index(&region);
        prop_assert!(bricks.value_range().widen_ulps(5.0).encloses(range));
        for f in at {
            let p = point_in(&region, f).clamp(region.min, region.max);
            prop_assert!(range.contains(bricks.sample_index(p)), "{range:?} at {p} in {region:?}");
        }
    }

    #[test]
    fn any_region_can_be_fetched(grid in grids(), a in fractions(), b in fractions(), snapped: bool) {
        let bricks = Bricks::new(&grid);
        let around = bricks.index_bounds().expand(DVec3::ONE);
        bricks.fetch(&sub_box(&around, a, b, snapped));
    }

    #[test]
    fn the_field_keeps_its_range(grid in grids(), a in fractions(), b in fractions(), f in fractions()) {
        let bricks = Bricks::new(&grid);
        let bounds = Field::bounds(&bricks);
        let region = sub_box(&bounds, a, b, false);
        let p = point_in(&region, f).clamp(region.min, region.max);
        let range = bricks.range(&region);
        prop_assert!(range.contains(bricks.sample(p)), "{range:?} {:?}", bricks.sample(p));
        prop_assert!(bounds.contains(p) || bricks.sample(p).coverage == 0.0);
    }
}

fn grid(dims: [usize; 3], voxels: Voxels) -> Grid {
    Grid::new(dims, DAffine3::IDENTITY, voxels).unwrap()
}

/// Large enough for four bricks, zero but for one voxel.
fn one_hot(at: usize) -> Grid {
    let mut v = vec![0u8; 64 * 64 * 5];
    v[at] = 200;
    grid([64, 64, 5], Voxels::U8(v))
}

#[test]
fn constant_bricks_hold_one_value() {
    let empty = Bricks::new(&grid([128; 3], Voxels::U16(vec![9; 128 * 128 * 128])));
    assert!(empty.bytes() < 64 * 32 + 4096 * 10, "{}", empty.bytes());
    assert_eq!(empty.sample_index(DVec3::new(3.3, 127.4, 64.2)), 9.0);
    assert_eq!(empty.range_index(&empty.index_bounds()), Interval::point(9.0));
}

#[test]
fn a_range_of_equal_voxels_is_a_point() {
    let bricks = Bricks::new(&one_hot(0));
    let far = Aabb::new(DVec3::new(9.0, -0.5, -0.5), DVec3::new(63.5, 63.5, 4.5));
    assert_eq!(bricks.range_index(&far), Interval::point(0.0));
    assert_eq!(bricks.value_range(), Interval::new(0.0, 200.0));
}

#[test]
fn a_seam_voxel_is_seen_from_both_sides() {
    let bricks = Bricks::new(&one_hot(32));
    for x in [31.25, 32.75] {
        let p = DVec3::new(x, 0.0, 0.0);
        let expected = 200.0 * (1.0 - (x - 32.0).abs()) as f32;
        assert_eq!(bricks.sample_index(p), expected);
        let range = bricks.range_index(&Aabb::new(p, p));
        assert!(range.contains(expected), "{range:?}");
    }
}

#[test]
fn samples_next_to_missing_voxels_are_missing() {
    let mut v: Vec<f32> = (0..27).map(|i| i as f32).collect();
    (v[0], v[26]) = (f32::NAN, f32::INFINITY);
    let bricks = Bricks::new(&grid([3; 3], Voxels::F32(v)));
    assert!(bricks.has_missing());
    assert!(bricks.sample_index(DVec3::splat(0.9)).is_nan());
    assert!(bricks.sample_index(DVec3::splat(1.1)).is_nan());
    assert_eq!(bricks.sample(DVec3::splat(0.9)).coverage, 0.0);
    assert_eq!(bricks.value_range(), Interval::new(1.0, 25.0));
    let range = bricks.range(&Aabb::new(DVec3::ZERO, DVec3::ONE));
    assert_eq!(range.coverage, Interval::new(0.0, 1.0));
    let mut row = [0.0; 3];
    bricks.copy_row(0, 1, 1, &mut row);
    for (i, v) in row.into_iter().enumerate() {
        let p = DVec3::new(i as f64, 1.0, 1.0);
        assert_eq!(v.to_bits(), bricks.sample_index(p).to_bits());
    }
}

#[test]
fn a_volume_of_missing_voxels_has_no_range() {
    let bricks = Bricks::new(&grid([2; 3], Voxels::F64(vec![f64::NAN; 8])));
    assert!(bricks.value_range().is_empty());
    assert!(bricks.range(&Aabb::ALL).value.is_empty());
}

#[test]
fn large_values_do_not_overflow() {
    let bricks = Bricks::new(&grid([2, 1, 1], Voxels::F32(vec![-1.7e38, 1.7e38])));
    let v = bricks.sample_index(DVec3::new(0.75, 0.0, 0.0));
    assert!((v - 0.85e38).abs() < 1e32, "{v}");
    let bricks = Bricks::new(&grid([2, 1, 1], Voxels::F64(vec![0.0, 1e300])));
    assert!(bricks.has_missing());
}

#[test]
fn negative_zero_is_zero() {
    let bricks = Bricks::new(&grid([2, 1, 1], Voxels::F32(vec![-0.0, -5.0])));
    assert_eq!(bricks.voxel(0, 0, 0).to_bits(), 0);
    assert_eq!(bricks.sample_index(DVec3::ZERO).to_bits(), 0);
}

#[test]
fn the_gradient_of_a_ramp_is_its_slope() {
    // Voxels of 3x − 2y + z in world millimetres under a sheared, rotated lattice. Differences of `f32` values of magnitude
    // 200 over one voxel are off by 4 ε·200 = 1e-4, and by the inverse transform's norm (below 2) more.
    let slope = DVec3::new(3.0, -2.0, 1.0);
    let place = placement(u64::MAX / 3);
    let world = |n: usize| {
        let p = DVec3::new((n % 9) as f64, (n / 9 % 8) as f64, (n / 72) as f64);
        affine::point(&place, p)
    };
    let v = (0..9 * 8 * 7).map(|n| slope.dot(world(n)) as f32).collect();
    let bricks = Bricks::new(&Grid::new([9, 8, 7], place, Voxels::F32(v)).unwrap());
    for p in [
        DVec3::splat(3.3),
        DVec3::ZERO,
        DVec3::new(7.9, 0.2, 5.5),
        DVec3::new(-0.4, 7.4, 6.4),
    ] {
        let g = bricks.gradient(affine::point(&place, p));
        assert!((g - slope).length() < 1e-3, "{g} at {p}");
    }
}

#[test]
fn a_thin_axis_has_no_gradient() {
    let bricks = Bricks::new(&grid([3, 1, 1], Voxels::U8(vec![0, 10, 20])));
    assert_eq!(
        bricks.gradient_index(DVec3::new(1.0, 0.3, -0.2)),
        DVec3::new(10.0, 0.0, 0.0)
    );
}
