//! The tabulated inverse against the spline.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use proptest::prelude::*;
use vcsg::math::Aabb;
use vcsg::model::deform::{Landmark, Morph, Smoothness, Spline};
use vcsg::model::{Model, Node, Tree};
use vcsg::target::Lattice;
use vcsg::voxelize::{Primitive, Solid};

use crate::random::landmarks;

fn bounds() -> Aabb {
    Aabb::new(DVec3::splat(-60.0), DVec3::splat(60.0))
}

/// A box deformed by `landmarks` gone as much of their way as does not fold it.
fn deformed(landmarks: &[Landmark], smoothness: &Smoothness, error_voxels: f64) -> (Model, Arc<Morph>) {
    let part = |part: f64| -> Vec<Landmark> {
        let gone = |l: &Landmark| Landmark {
            to: l.from.lerp(l.to, part),
            ..l.clone()
        };
        landmarks.iter().map(gone).collect()
    };
    let morph = (0..10)
        .filter_map(|n| Morph::new(Spline::new(&part(0.7f64.powi(n)), smoothness).ok()?, bounds()).ok())
        .next()
        .expect("little movement folds nothing");
    let morph = Arc::new(morph);
    let mut model = Model::default();
    let child = model.push(Node::Primitive(Primitive::crisp(Solid::Box(bounds()), 1.0)));
    model.push(Node::Deform {
        child,
        morph: Arc::clone(&morph),
        error_voxels,
    });
    (model, morph)
}

/// The most, in voxels, that the table's places of voxels are from where they come from, and how many are compared; infinite if
/// one has no place but comes from what is deformed.
fn worst(tree: &Tree, lattice: &Lattice, spline: &Spline) -> (f64, usize) {
    let spacing = lattice.spacing_mm().x;
    let [nx, ny, nz] = lattice.dims;
    let (mut worst, mut compared) = (0.0f64, 0);
    for n in (0..nx * ny * nz).step_by(7) {
        let voxel = DVec3::from([n % nx, n / nx % ny, n / (nx * ny)].map(|i| i as f64));
        let seen = lattice.world_from_lattice.transform_point3(voxel);
        let place = lattice
            .world_from_lattice
            .transform_point3(tree.in_space(Some(0), voxel));
        let off = match bounds().contains(place) {
            true => off_from_preimage(spline, place, seen),
            false if place.is_nan() && spline.inverse(seen).is_some_and(|p| bounds().contains(p)) => f64::INFINITY,
            false => continue,
        };
        compared += 1;
        worst = worst.max(off / spacing);
    }
    (worst, compared)
}

/// How far `place` is from what goes to `seen`: from there Newton's iteration needs but a few steps.
fn off_from_preimage(spline: &Spline, place: DVec3, seen: DVec3) -> f64 {
    let step = |x: DVec3| {
        let (value, jacobian) = spline.point_and_jacobian(x);
        x + jacobian.inverse() * (seen - value)
    };
    (0..6).fold(place, |x, _| step(x)).distance(place)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_voxel_is_within_the_error(
        landmarks in landmarks(3..40, 15.0),
        support in prop_oneof![Just(None), (40.0f64..200.0).prop_map(Some)],
        error in prop_oneof![Just(0.1), 0.02f64..1.0],
        spacing in 1.5f64..4.0,
    ) {
        let (model, morph) = deformed(&landmarks, &Smoothness { stiffness: 0.0, support_mm: support }, error);
        let lattice = Lattice::of_model(&model, Some(spacing)).expect("a lattice");
        let tree = Tree::new(&model, &lattice.world_from_lattice).expect("a tree");
        let (off, compared) = worst(&tree, &lattice, morph.spline());
        prop_assert!(off <= error, "{off} voxels off, by {error} allowed, of {compared}");
        let measured = tree.deformations().next().expect("one").1.measured_voxels;
        prop_assert!(measured <= error && off <= 2.0 * measured.max(0.05 * error), "measured {measured}, seen {off}");
        prop_assert!(compared > 1000);
    }

    #[test]
    fn the_box_of_a_deformed_box_holds_it(landmarks in landmarks(3..40, 15.0), fractions in prop::collection::vec(prop::array::uniform3(0.0f64..=1.0), 300)) {
        let (model, morph) = deformed(&landmarks, &Smoothness::default(), 0.1);
        let holds = model.bounds()[1];
        let mut reached = Aabb::EMPTY;
        for f in fractions.into_iter().map(DVec3::from).chain(Aabb::new(DVec3::ZERO, DVec3::ONE).corners()) {
            // Half of the points lie on faces.
            let f = if f.x < 0.5 { DVec3::new(f.x, f.y, f.z.round()) } else { f };
            let moved = morph.spline().point(bounds().min + bounds().size() * f);
            prop_assert!(holds.contains(moved), "{moved} of {holds:?}");
            reached = reached.hull(&Aabb::of_points([moved]));
        }
        // Some hundred points do not reach everywhere, and patches are bounded: of 120 mm and their movement a fifth is much.
        let loose = (holds.size() - reached.size()).max_element();
        prop_assert!(loose < 24.0, "{loose} mm too large");
    }
}

/// What a cell holds depends on neither the rest of the model nor where its box ends.
#[test]
fn the_table_does_not_depend_on_what_is_deformed() {
    use proptest::strategy::ValueTree;
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let landmarks = landmarks(10..11, 10.0)
        .new_tree(&mut runner)
        .expect("a value")
        .current();
    let (model, morph) = deformed(&landmarks, &Smoothness::default(), 0.1);
    let mut smaller = Model::default();
    let part = Aabb::new(DVec3::splat(-33.0), DVec3::splat(20.0));
    let child = smaller.push(Node::Primitive(Primitive::crisp(Solid::Box(part), 1.0)));
    smaller.push(Node::Deform {
        child,
        morph,
        error_voxels: 0.1,
    });
    let frame = DAffine3::from_scale(DVec3::splat(2.0));
    let trees = [&model, &smaller].map(|m| Tree::new(m, &frame).expect("a tree"));
    let mut compared = 0;
    for n in 0..40usize.pow(3) {
        let p = DVec3::from([n % 40, n / 40 % 40, n / 1600].map(|i| i as f64 - 20.0));
        let [whole, part] = trees.each_ref().map(|t| t.in_space(Some(0), p));
        if !part.is_nan() {
            assert_eq!(whole, part, "at {p}");
            compared += 1;
        }
    }
    assert!(compared > 20_000, "{compared}");
}
