//! Slices averaged two by two, against a slow version of the same.

use glam::{DAffine3, DMat3, DVec3};
use proptest::prelude::*;
use vcsg::volume::{Grid, Voxels, averaged_slices};

fn place() -> DAffine3 {
    DAffine3 {
        matrix3: DMat3::from_cols(
            DVec3::new(0.7, 0.1, -0.2),
            DVec3::new(-0.1, 0.9, 0.3),
            DVec3::new(0.2, -0.3, 2.5),
        ),
        translation: DVec3::new(-120.5, 33.25, 1004.0),
    }
}

fn grid(dims: [usize; 3], voxels: Voxels) -> Grid {
    Grid::new(dims, place(), voxels).expect("a grid")
}

/// The mean of the finite voxels among the four of new voxel `[i, j, k]`, or those of them that there are.
fn mean(grid: &Grid, [i, j, k]: [usize; 3]) -> f64 {
    let [nx, ny, _] = grid.dims();
    let mut finite = Vec::new();
    for y in (2 * j..2 * j + 2).filter(|y| *y < ny) {
        for x in (2 * i..2 * i + 2).filter(|x| *x < nx) {
            finite.push(grid.value_at([x, y, k]));
        }
    }
    finite.retain(|v| v.is_finite());
    finite.iter().sum::<f64>() / finite.len() as f64
}

/// Holds each voxel against `rounded` of the mean.
fn check(grid: &Grid, rounded: fn(f64) -> f64) {
    let [nx, ny, nz] = grid.dims();
    let small = averaged_slices(grid).expect("a grid");
    assert_eq!(small.dims(), [nx.div_ceil(2), ny.div_ceil(2), nz]);
    assert_eq!(small.voxel_type(), grid.voxel_type());
    let [mx, my, _] = small.dims();
    for v in 0..mx * my * nz {
        let at = [v % mx, v / mx % my, v / (mx * my)];
        let (found, expected) = (small.value_at(at), rounded(mean(grid, at)));
        assert!(
            found == expected || found.is_nan() && expected.is_nan(),
            "{at:?}: {found} and {expected}"
        );
    }
}

fn whole(v: f64) -> f64 {
    let floor = v.floor();
    match v - floor {
        d if d < 0.5 => floor,
        d if d > 0.5 => floor + 1.0,
        _ => floor + floor.rem_euclid(2.0),
    }
}

fn single(v: f64) -> f64 {
    f64::from(v as f32)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn each_voxel_is_the_mean_of_four(
        (dims, bits) in (1..8_usize, 1..8_usize, 1..4_usize).prop_flat_map(|(x, y, z)| {
            (Just([x, y, z]), prop::collection::vec(any::<u32>(), x * y * z))
        })
    ) {
        let small = |b: &u32| (b % 7) as f32 - 3.0;
        check(&grid(dims, Voxels::U8(bits.iter().map(|b| *b as u8).collect())), whole);
        check(&grid(dims, Voxels::I8(bits.iter().map(|b| *b as i8).collect())), whole);
        check(&grid(dims, Voxels::U16(bits.iter().map(|b| *b as u16).collect())), whole);
        check(&grid(dims, Voxels::I16(bits.iter().map(|b| *b as i16 % 5).collect())), whole);
        check(&grid(dims, Voxels::U32(bits.clone())), whole);
        check(&grid(dims, Voxels::I32(bits.iter().map(|b| *b as i32).collect())), whole);
        // All bit patterns: NaN and infinities too.
        check(&grid(dims, Voxels::F32(bits.iter().map(|b| f32::from_bits(*b)).collect())), single);
        check(&grid(dims, Voxels::F32(bits.iter().map(small).collect())), single);
        check(&grid(dims, Voxels::F64(bits.iter().map(|b| f64::from(*b) / 7.0).collect())), |v| v);
    }
}

#[test]
fn halves_go_to_even() {
    let slice = grid([4, 2, 1], Voxels::I16(vec![0, 1, 2, 1, 0, 1, 1, 2]));
    assert_eq!(
        *averaged_slices(&slice).expect("a grid").voxels(),
        Voxels::I16(vec![0, 2])
    );
    let negative = grid([4, 2, 1], Voxels::I16(vec![0, -1, -2, -1, 0, -1, -1, -2]));
    assert_eq!(
        *averaged_slices(&negative).expect("a grid").voxels(),
        Voxels::I16(vec![0, -2])
    );
}

#[test]
fn what_is_not_finite_is_left_out() {
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let slice = grid([4, 2, 1], Voxels::F32(vec![1.0, nan, nan, inf, inf, 2.0, -inf, nan]));
    let small = averaged_slices(&slice).expect("a grid");
    assert_eq!(small.value_at([0, 0, 0]), 1.5);
    assert!(small.value_at([1, 0, 0]).is_nan());
}

/// A ramp has at a new voxel's place the mean of the four around it: so values tell where voxels are. At an odd border the mean
/// is that of the last voxels, half a voxel short of the place.
#[test]
fn the_new_voxels_are_in_the_middle_of_the_old() {
    let slope = DVec3::new(2.0, -3.0, 0.5);
    let dims = [6, 5, 3];
    let value = |v: usize| slope.dot(place().transform_point3(at(v, dims)));
    let ramp = grid(dims, Voxels::F64((0..90).map(value).collect()));
    let small = averaged_slices(&ramp).expect("a grid");
    let border = place().matrix3.y_axis.dot(slope) / 2.0;
    for v in 0..27 {
        let index = at(v, [3, 3, 3]);
        let expected = slope.dot(small.world_from_index().transform_point3(index));
        let short = if index.y == 2.0 { border } else { 0.0 };
        let found = small.value_at(index.to_array().map(|x| x as usize));
        // Sums of a few numbers of up to 2000: 10 roundings of 1e-16 of that each.
        assert!(
            (found - (expected - short)).abs() < 1e-11,
            "{index}: {found} and {expected}"
        );
    }
}

fn at(v: usize, [nx, ny, _]: [usize; 3]) -> DVec3 {
    DVec3::new((v % nx) as f64, (v / nx % ny) as f64, (v / (nx * ny)) as f64)
}

#[test]
fn an_axis_of_one_voxel_stays() {
    let column = grid([1, 4, 2], Voxels::U8(vec![0, 2, 4, 6, 8, 10, 12, 14]));
    let small = averaged_slices(&column).expect("a grid");
    assert_eq!(small.dims(), [1, 2, 2]);
    assert_eq!(*small.voxels(), Voxels::U8(vec![1, 5, 9, 13]));
    let expected = place().translation + place().matrix3.y_axis / 2.0;
    assert_eq!(small.world_from_index().translation, expected);
    let voxel = grid([1; 3], Voxels::U8(vec![3]));
    assert_eq!(averaged_slices(&voxel), Ok(voxel));
}

#[test]
fn a_lattice_that_grows_beyond_all_numbers_is_refused() {
    let huge = DAffine3::from_scale(DVec3::new(f64::MAX, 1e-300, 1.0));
    let slice = Grid::new([2, 2, 1], huge, Voxels::U8(vec![0; 4])).expect("a grid");
    assert!(averaged_slices(&slice).is_err());
}
