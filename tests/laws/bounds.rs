//! Nothing of a model lies outside its box.

use glam::DVec3;
use proptest::prelude::*;
use vcsg::math::Aabb;
use vcsg::model::Tree;

use crate::support::scenes::{Scene, scene, undeformed_scene};
use crate::support::{cases, seeded};

/// No covered point of the tree, which is in world coordinates, lies outside `bounds` by more than rounding.
fn nothing_outside(tree: &Tree, bounds: &Aabb, points: &[DVec3]) -> Result<(), String> {
    let rounded = bounds.expand(DVec3::splat(rounding_mm(bounds)));
    points
        .iter()
        .filter(|&&p| !rounded.contains(p))
        .find(|&&p| tree.sample(p).coverage > 0.0)
        .map_or(Ok(()), |p| Err(format!("{p} is covered, outside {bounds:?}")))
}

/// The tree snaps the entries of a leaf's map by up to 1e-9, so at coordinates up to `m` mm a leaf is off by up to
/// 1e-9·(1 + 3m) of its units, which are below 2 mm here. All other rounding is far less.
fn rounding_mm(bounds: &Aabb) -> f64 {
    6e-9 * (1.0 + bounds.min.abs().max(bounds.max.abs()).max_element())
}

/// Points round `bounds`, and for each of them six more, moved to just outside each face.
fn points_round(bounds: &Aabb, fractions: &[DVec3]) -> Vec<DVec3> {
    let gap = 2.0 * rounding_mm(bounds);
    let just_outside = |p: DVec3| {
        (0..6).map(move |face| {
            let (axis, mut q) = (face / 2, p);
            q[axis] = match face % 2 {
                0 => bounds.min[axis] - gap,
                _ => bounds.max[axis] + gap,
            };
            q
        })
    };
    fractions
        .iter()
        .map(|f| bounds.min + bounds.size() * (f * 2.0 - 0.5))
        .flat_map(|p| just_outside(p).chain([p]))
        .collect()
}

/// The model without soft surfaces, and its box.
fn world_tree(scene: &Scene) -> (Tree, Aabb) {
    let tree = Tree::in_world(&scene.model, 0.0).expect("a small tree");
    let bounds = scene.model.bounds()[scene.model.nodes().len() - 1];
    (tree, bounds)
}

fn fractions() -> impl Strategy<Value = Vec<DVec3>> {
    prop::collection::vec(prop::array::uniform3(0.0f64..=1.0).prop_map(DVec3::from), 60)
}

proptest! {
    #![proptest_config(cases(300))]

    /// A tree interpolates deformations, and is beside what a model's box speaks of by their error; the test `deformation` has that
    /// box without a tree.
    #[test]
    fn the_box_holds_the_model(scene in undeformed_scene(), fractions in fractions()) {
        let (tree, bounds) = world_tree(&scene);
        let points = points_round(&bounds, &fractions);
        prop_assert_eq!(nothing_outside(&tree, &bounds, &points), Ok(()));
    }

    #[test]
    fn the_tree_s_box_holds_soft_surfaces(scene in scene(), fractions in fractions(), voxel_mm in 0.1f64..2.0) {
        let tree = Tree::in_world(&scene.model, voxel_mm).expect("a small tree");
        let bounds = tree.bounds_in(&glam::DAffine3::IDENTITY);
        let points = points_round(&bounds, &fractions);
        prop_assert_eq!(nothing_outside(&tree, &bounds, &points), Ok(()));
    }
}

#[test]
fn a_box_too_small_on_one_side_is_seen() {
    let missed = |seed: &u64| {
        let (tree, mut bounds) = world_tree(&seeded(&scene(), *seed));
        bounds.max.z -= 0.25 * bounds.size().z;
        let points = points_round(&bounds, &seeded(&fractions(), *seed));
        nothing_outside(&tree, &bounds, &points).is_err()
    };
    let seen = (0..40).filter(missed).count();
    assert!(seen > 10, "{seen} of 40");
}
