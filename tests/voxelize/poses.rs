//! A density belongs to the place and not to the lattice, and the filter is a ball in the world whatever is done to the solid.

use glam::{DAffine3, DMat3, DVec3};
use vcsg::math::Aabb;
use vcsg::volume::Field;
use vcsg::voxelize::{Primitive, Profile, Solid};

use crate::cases::{Case, KINDS, Random};
use crate::convolution::{BAR, RADIUS, counted};

/// Moved by a part of a voxel, the field is the same field, moved: samples differ by the rounding of their places only.
#[test]
fn a_shift_moves_the_field_and_changes_nothing() {
    for (name, make) in KINDS {
        for seed in 0..20 {
            let mut random = Random(seed);
            let primitive = Primitive::soft(make(&mut random).solid, 1.0);
            let pose = random.pose();
            let shift = random.point(&Aabb::new(DVec3::ZERO, DVec3::ONE));
            let [still, moved] =
                [pose, DAffine3::from_translation(shift) * pose].map(|pose| primitive.placed(&pose, 1.0));
            for _ in 0..40 {
                let p = random.point(&Aabb::new(DVec3::splat(-15.0), DVec3::splat(15.0)));
                let [a, b] = [Field::sample(&still, p), Field::sample(&moved, p + shift)].map(|s| s.coverage);
                // Places round to 1e-14 of 20 mm, densities change by at most 1 a millimetre, and the way of evaluation may
                // change there by no more than the bar.
                let same = (a - b).abs() < 1e-6;
                assert!(same, "{name} {seed} at {p}: {a} and {b}");
            }
        }
    }
}

/// A stretch and a shear, invertible.
fn stretch(random: &mut Random) -> DMat3 {
    let mut part = || random.within(0.5, 1.6);
    let scale = DVec3::new(part(), part(), part());
    DMat3::from_cols(DVec3::X, DVec3::new(random.within(-0.4, 0.4), 1.0, 0.0), DVec3::Z) * DMat3::from_diagonal(scale)
}

#[test]
fn stretched_solids_are_filtered_in_the_world() {
    for (name, make) in KINDS {
        for seed in 0..60 {
            let mut random = Random(7000 + seed);
            let Case { solid, inside } = make(&mut random);
            let mut world_from_local = random.pose();
            world_from_local.matrix3 *= stretch(&mut random);
            let placed = Primitive::soft(solid.clone(), 1.0).placed(&world_from_local, 1.0);
            let near = match &solid {
                Solid::HalfSpace(_) => Aabb::new(DVec3::splat(-3.0), DVec3::splat(3.0)),
                solid => solid.bounds().expand(DVec3::ONE),
            };
            let world = world_from_local.transform_point3(random.point(&near));
            let local_from_world = world_from_local.inverse();
            let density = f64::from(Field::sample(&placed, world).coverage);
            let truth = counted(|p| inside(local_from_world.transform_point3(p)), world, density);
            assert!(
                (density - truth).abs() <= BAR,
                "{name} {seed}: {density}, counted {truth}, {solid:?}"
            );
        }
    }
}

#[test]
fn a_shell_is_the_difference_of_two_solids() {
    let outer = Solid::revolved(Profile::cylinder(9.0, 20.0));
    let inner = Solid::revolved(Profile::cylinder(7.5, 17.0));
    let shell = Primitive::soft(outer.clone(), 1.0)
        .shell(1.5)
        .expect("a cylinder has an inside");
    let [shell, outer, inner] = [shell, Primitive::soft(outer, 1.0), Primitive::soft(inner, 1.0)]
        .map(|primitive| primitive.placed(&DAffine3::IDENTITY, 1.0));
    let mut random = Random(3);
    for _ in 0..2000 {
        let p = random.point(&Aabb::new(DVec3::splat(-12.0), DVec3::splat(12.0)));
        let difference = outer.coverage(p) - inner.coverage(p);
        assert!((shell.coverage(p) - difference).abs() < 1e-6, "{p}");
    }
    // What is thinner than its shell is all there.
    let thin = Primitive::soft(
        Solid::Sphere {
            center: DVec3::ZERO,
            radius: 2.0,
        },
        1.0,
    );
    assert_eq!(thin.clone().shell(3.0), Ok(thin));
}

/// A solid much smaller than the filter is as dense as the filter weighs its volume: 3/π r³ at the filter's middle.
#[test]
fn what_is_smaller_than_the_filter_is_faint() {
    let radius = 0.05;
    let dot = Primitive::soft(
        Solid::Sphere {
            center: DVec3::ZERO,
            radius,
        },
        1.0,
    )
    .placed(&DAffine3::IDENTITY, 1.0);
    let volume = 4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius;
    let expected = volume * 3.0 / (std::f64::consts::PI * RADIUS * RADIUS * RADIUS);
    let density = f64::from(dot.coverage(DVec3::ZERO));
    // Across the dot the weight falls from 1 to 1 − radius/RADIUS.
    assert!(
        density > 0.0 && (density / expected - 1.0).abs() < radius / RADIUS,
        "{density} {expected}"
    );
}
