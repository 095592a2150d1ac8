//! Random lattices and cutters.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use proptest::prelude::*;
use vcsg::surface::Cutter;
use vcsg::volume::{Grid, Voxels};

/// A grid of `n`³ voxels that spans the cube [−1, 1]³.
pub fn sampled(n: usize, f: impl Fn(DVec3) -> f64) -> Grid {
    let h = 2.0 / (n - 1) as f64;
    let place = DAffine3::from_scale_rotation_translation(DVec3::splat(h), DQuat::IDENTITY, DVec3::NEG_ONE);
    let at = |i: usize| h * i as f64 - 1.0;
    let values = (0..n * n * n).map(|v| f(DVec3::new(at(v % n), at(v / n % n), at(v / (n * n)))) as f32);
    Grid::new([n; 3], place, Voxels::F32(values.collect())).expect("a grid")
}

/// Few different values, so that many are the isovalue itself, or many.
fn voxels(count: usize) -> impl Strategy<Value = Voxels> {
    let of = move |range: std::ops::Range<i16>| prop::collection::vec(range, count);
    prop_oneof![
        of(0..2).prop_map(|v| Voxels::U8(v.into_iter().map(|x| x as u8).collect())),
        of(0..5).prop_map(|v| Voxels::U8(v.into_iter().map(|x| x as u8).collect())),
        of(-1024..3071).prop_map(Voxels::I16),
        prop::collection::vec(-4.0_f32..4.0, count).prop_map(Voxels::F32),
        // So close to the isovalue 1 that vertices round to voxels.
        of(-3..4).prop_map(|v| Voxels::F64(
            v.into_iter()
                .map(|x| 1.0 + f64::from(x) * 1e-12 * f64::from(x * x))
                .collect()
        )),
    ]
}

fn places() -> impl Strategy<Value = DAffine3> {
    let oblique = (
        prop::array::uniform3(-3.0..3.0_f64),
        prop::array::uniform3(0.3..3.0_f64),
        any::<bool>(),
    );
    let oblique = oblique.prop_map(|([a, b, c], spacing, mirror)| DAffine3 {
        matrix3: DMat3::from_euler(glam::EulerRot::ZYX, a, b, c)
            * DMat3::from_diagonal(DVec3::from(spacing) * DVec3::new(if mirror { -1.0 } else { 1.0 }, 1.0, 1.0)),
        translation: DVec3::new(10.0 * a, 10.0 * b, 10.0 * c),
    });
    prop_oneof![Just(DAffine3::IDENTITY), oblique]
}

fn grid(dims: [usize; 3]) -> impl Strategy<Value = Grid> {
    (voxels(dims.iter().product()), places())
        .prop_map(move |(voxels, place)| Grid::new(dims, place, voxels).expect("a grid"))
}

/// What a cutter is made of, with all that it borrows.
#[derive(Clone, Debug)]
pub enum Knife {
    /// In the index space of the scan.
    Plane { through: DVec3, normal: DVec3 },
    /// On the scan's own lattice.
    Level(Voxels, f64),
    /// On a lattice of its own in the scan's index space.
    Other(Grid),
}

fn knives(count: usize) -> impl Strategy<Value = Knife> {
    let whole = || prop::array::uniform3(-2..3_i32).prop_map(|v| DVec3::from(v.map(f64::from)));
    let free = || prop::array::uniform3(-2.0..2.0_f64).prop_map(DVec3::from);
    let plane = |p: BoxedStrategy<DVec3>, n: BoxedStrategy<DVec3>| {
        (p, n).prop_map(|(p, normal)| Knife::Plane {
            through: p + DVec3::splat(2.0),
            normal,
        })
    };
    prop_oneof![
        // Through voxels, along axes and diagonals.
        plane(whole().boxed(), whole().boxed()),
        plane(free().boxed(), free().boxed()),
        (voxels(count), prop::sample::select(vec![0.5, 1.0, 2.0])).prop_map(|(voxels, iso)| Knife::Level(voxels, iso)),
        grid([3, 4, 3]).prop_map(Knife::Other),
    ]
}

/// A scan and what it is cut by.
#[derive(Clone, Debug)]
pub struct Case {
    pub scan: Grid,
    knife: Knife,
    other: Option<Grid>,
}

impl Case {
    fn new(scan: Grid, knife: Knife) -> Self {
        let other = match &knife {
            Knife::Plane { .. } => None,
            Knife::Level(voxels, _) => {
                Some(Grid::new(scan.dims(), *scan.world_from_index(), voxels.clone()).expect("a grid"))
            }
            Knife::Other(grid) => {
                let small = DAffine3::from_scale(DVec3::splat(0.5)) * *grid.world_from_index();
                let place = *scan.world_from_index() * small;
                Some(Grid::new(grid.dims(), place, grid.voxels().clone()).expect("a grid"))
            }
        };
        Self { scan, knife, other }
    }

    pub fn cutter(&self) -> Cutter<'_> {
        let world = self.scan.world_from_index();
        match (&self.knife, &self.other) {
            (Knife::Plane { through, normal }, _) => Cutter::half_space(
                world.transform_point3(*through),
                world.matrix3.inverse().transpose() * *normal,
            ),
            (Knife::Level(_, iso), Some(grid)) => Cutter::level(grid, *iso),
            (_, Some(grid)) => Cutter::mask(grid),
            (_, None) => Cutter::half_space(DVec3::ZERO, DVec3::X),
        }
    }
}

pub fn cases() -> impl Strategy<Value = Case> {
    (2..7_usize, 2..7_usize, 2..7_usize).prop_flat_map(|(nx, ny, nz)| {
        let dims = [nx, ny, nz];
        (grid(dims), knives(nx * ny * nz)).prop_map(|(scan, knife)| Case::new(scan, knife))
    })
}
