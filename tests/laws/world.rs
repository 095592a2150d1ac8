//! The tree in lattice coordinates agrees with the model evaluated in the world.

use glam::DVec3;
use proptest::prelude::*;
use vcsg::math::{Aabb, affine};
use vcsg::model::{Model, Tree};
use vcsg::target::Lattice;

use crate::support::scenes::{MAX_DIM, crisp_scene};
use crate::support::truth::{self, Undecided};
use crate::support::{cases, seeded};

/// Whether `tree`, in `lattice` coordinates, is `model` at the fraction `at` of the lattice's box; `None` when the point is
/// too near a boundary to tell. The tolerance is worked out with the truth.
fn agrees(model: &Model, lattice: &Lattice, tree: &Tree, at: DVec3) -> Option<Result<(), String>> {
    let Aabb { min, max } = lattice.bounds();
    let p = min + (max - min) * at;
    let world = affine::point(&lattice.world_from_lattice, p);
    let root = model.root()?;
    let found = tree.sample(p);
    let wrong = |truth: &dyn std::fmt::Debug| Err(format!("{found:?} at {p}, not {truth:?}"));
    match truth::sample(model, root, world) {
        Err(Undecided) => None,
        Ok(None) if found.coverage == 0.0 => Some(Ok(())),
        Ok(Some(v)) if found.coverage == 1.0 => {
            let off = (f64::from(found.value) - v.value).abs();
            // A bound that is not finite says that the arithmetic overflowed.
            Some(if off <= v.error || !v.error.is_finite() {
                Ok(())
            } else {
                wrong(&v)
            })
        }
        Ok(truth) => Some(wrong(&truth)),
    }
}

fn points() -> impl Strategy<Value = Vec<DVec3>> {
    prop::collection::vec(prop::array::uniform3(0.0f64..=1.0).prop_map(DVec3::from), 200)
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn the_tree_is_the_model(scene in crisp_scene(), points in points()) {
        prop_assert!(scene.lattice.dims.iter().all(|&n| n <= MAX_DIM), "the tolerance holds up to there");
        let tree = Tree::new(&scene.model, &scene.lattice.world_from_lattice).expect("a small tree");
        let told: Vec<_> = points.iter().filter_map(|&p| agrees(&scene.model, &scene.lattice, &tree, p)).collect();
        for result in &told {
            prop_assert_eq!(result, &Ok(()));
        }
    }
}

#[test]
fn nearly_all_points_are_decided_and_many_are_covered() {
    let (mut decided, mut covered) = (0, 0);
    for seed in 0..100 {
        let (scene, points) = (seeded(&crisp_scene(), seed), seeded(&points(), seed));
        let tree = Tree::new(&scene.model, &scene.lattice.world_from_lattice).expect("a small tree");
        for p in points {
            decided += usize::from(agrees(&scene.model, &scene.lattice, &tree, p).is_some());
            let at = scene.lattice.bounds().min + scene.lattice.bounds().size() * p;
            covered += usize::from(tree.sample(at).coverage > 0.0);
        }
    }
    assert!(decided > 18_000, "{decided} of 20000");
    assert!(covered > 2_000, "{covered} of 20000");
}

/// How many of some scenes show a mistake that `mutate` makes.
fn seen(mutate: impl Fn(&mut Lattice)) -> usize {
    let shows = |seed: &u64| {
        let (scene, points) = (seeded(&crisp_scene(), *seed), seeded(&points(), *seed));
        let mut lattice = scene.lattice;
        mutate(&mut lattice);
        let tree = Tree::new(&scene.model, &lattice.world_from_lattice).expect("a small tree");
        let results = points
            .iter()
            .filter_map(|&p| agrees(&scene.model, &scene.lattice, &tree, p));
        results.into_iter().any(|r| r.is_err())
    };
    (0..40).filter(shows).count()
}

#[test]
fn a_shift_and_a_mirror_are_seen() {
    let shifted = seen(|l| l.world_from_lattice *= glam::DAffine3::from_translation(DVec3::Y));
    assert!(shifted > 20, "{shifted} of 40");
    let mirrored = seen(|l| l.world_from_lattice.matrix3.x_axis *= -1.0);
    assert!(mirrored > 20, "{mirrored} of 40");
    assert_eq!(seen(|_| ()), 0);
}
