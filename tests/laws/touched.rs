//! Design law 5, the other half: an edit costs what it touches, wherever the model's bounds and deformations go.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, I64Vec3};
use vcsg::math::{Aabb, Interval};
use vcsg::model::deform::{Landmark, Morph, Smoothness, Spline};
use vcsg::model::{BooleanOp, Family, Model, Node, NodeId, Operator, Step, ValueRule, VolumeLeaf};
use vcsg::target::{Block, Lattice, Subdivision, Target, Update, VoxelTarget};
use vcsg::volume::{Bricks, Grid, Voxels};
use vcsg::voxelize::{Primitive, Solid};

use crate::alike::same;
use crate::edit::{ball, updated};
use crate::support::landmarks::landmarks;
use crate::support::{parts, seeded};

/// A row of balls far apart, one of which is moved.
fn row_of_balls(moved_by: f64) -> Model {
    let mut model = Model::default();
    let ids: Vec<NodeId> = (0..6)
        .map(|n| {
            let shift = if n == 2 { DVec3::Y * moved_by } else { DVec3::ZERO };
            let center = DVec3::X * 20.0 * f64::from(n) + shift;
            model.push(Node::Primitive(Primitive::soft(
                Solid::Sphere { center, radius: 6.0 },
                n as f32,
            )))
        })
        .collect();
    let operator = seeded(&parts::operator(), 0);
    model.fold(vcsg::model::BooleanOp::Union, operator.rule, operator.family, ids);
    model
}

#[test]
fn what_an_edit_does_not_touch_is_kept() {
    let subdivision = Subdivision {
        min_block: 8,
        ..Subdivision::default()
    };
    let bounds = Aabb::new(DVec3::splat(-10.0), DVec3::new(110.0, 10.0, 10.0));
    let lattice = Lattice::axis_aligned(&bounds, 1.0).expect("a lattice");
    let target = Target::on_lattice(&row_of_balls(0.0), lattice, &subdivision).expect("a target");
    let update = updated(&target, &row_of_balls(1.5), lattice);
    let touches_third = |b: &Block| b.origin[0] + b.size > 40 && b.origin[0] < 60;
    for (block, kept) in update.target.blocks.iter().zip(&update.kept) {
        assert!(kept.is_some() || touches_third(block), "{block:?}");
    }
    assert!(update.kept.iter().any(Option::is_none));
    let uses_ball_2 = |step: &Step| matches!(step, Step::Leaf(2) | Step::LeafInside(2));
    assert!(update.target.paths.iter().flatten().any(uses_ball_2));
}

#[test]
fn an_edit_beside_a_deformation_keeps_its_table() {
    let bounds = Aabb::new(DVec3::splat(-8.0), DVec3::splat(10.0));
    let morph = Arc::new(seeded(&landmarks(), 5).morph(&bounds));
    let model = |value: f32| {
        let mut model = Model::default();
        let child = model.push(Node::Primitive(Primitive::soft(ball(), 50.0)));
        let first = model.push(Node::Deform {
            child,
            morph: Arc::clone(&morph),
            error_voxels: 0.1,
        });
        let second = model.push(Node::Primitive(Primitive::crisp(ball(), value)));
        let Operator { rule, family, .. } = seeded(&parts::operator(), 0);
        model.fold(vcsg::model::BooleanOp::Union, rule, family, [first, second]);
        model
    };
    let lattice = Lattice::axis_aligned(&bounds, 1.0).expect("a lattice");
    let target = Target::on_lattice(&model(1.0), lattice, &Subdivision::default()).expect("a target");
    let edited = updated(&target, &model(2.0), lattice).target;
    assert!(std::ptr::eq(target.tree.table(0), edited.tree.table(0)));
}

#[test]
fn another_subdivision_is_built_anew() {
    let bounds = Aabb::new(DVec3::splat(-10.0), DVec3::new(110.0, 10.0, 10.0));
    let lattice = Lattice::axis_aligned(&bounds, 1.0).expect("a lattice");
    let [coarse, fine] = [16, 4].map(|min_block| Subdivision {
        min_block,
        ..Subdivision::default()
    });
    let target = Target::on_lattice(&row_of_balls(0.0), lattice, &coarse).expect("a target");
    let update = target.updated(&row_of_balls(0.0), lattice, &fine).expect("a target");
    assert!(update.kept.iter().all(Option::is_none));
    assert_eq!(update.target.subdivision, fine);
}

/// How a volume of 64³ voxels lies in the world.
fn oblique() -> DAffine3 {
    DAffine3::from_scale_rotation_translation(
        DVec3::new(0.8, 1.0, 1.1),
        DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7),
        DVec3::new(20.0, -70.0, 30.0),
    )
}

/// A volume placed by `world_from_index` with parts taken from it, and last a ball: 20 nodes. Places are of the volume's voxels.
fn twenty_nodes(world_from_index: DAffine3, bricks: &Arc<Bricks>, place: DVec3) -> Model {
    let mut model = Model::default();
    let volume = model.push(Node::Volume(VolumeLeaf {
        bricks: Arc::clone(bricks),
        window: Interval::ALL,
    }));
    let part = |model: &mut Model, center: DVec3, radius: f64| {
        let center = world_from_index.transform_point3(center);
        model.push(Node::Primitive(Primitive::soft(Solid::Sphere { center, radius }, 90.0)))
    };
    let taken: Vec<NodeId> = (0..8)
        .map(|n| part(&mut model, DVec3::new(8.0 + 7.0 * n as f64, 20.0, 30.0), 5.0))
        .collect();
    let (rule, family) = (ValueRule::First, Family::MinMax);
    let carved = model
        .fold(
            BooleanOp::Subtraction,
            rule.clone(),
            family,
            [&[volume][..], &taken].concat(),
        )
        .expect("a root");
    let solid = Solid::Sphere {
        center: DVec3::ZERO,
        radius: 3.0,
    };
    let child = model.push(Node::Primitive(Primitive::soft(solid, 90.0)));
    let parent_from_child = DAffine3::from_translation(world_from_index.transform_point3(place));
    let ball = model.push(Node::Transform {
        child,
        parent_from_child,
    });
    model.fold(BooleanOp::Union, rule, family, [carved, ball]);
    assert_eq!(model.nodes().len(), 20);
    model
}

fn bricks(world_from_index: DAffine3) -> Arc<Bricks> {
    let voxel = |n: usize| (40.0 + 30.0 * (n as f64 * 0.1).sin()) as u8;
    let voxels = Voxels::U8((0..1usize << 18).map(voxel).collect());
    Arc::new(Bricks::new(
        &Grid::new([64; 3], world_from_index, voxels).expect("a grid"),
    ))
}

/// The update of a target by a model on that model's own lattice; what it gives is what is built anew.
fn followed(target: &Target, model: &Model, spacing_mm: Option<f64>) -> Update {
    let lattice = Lattice::of_model(model, spacing_mm).expect("a lattice");
    assert!(lattice.shares_grid(&target.lattice), "one grid");
    let update = updated(target, model, lattice);
    let voxels = update.voxels(target, &VoxelTarget::new(target).voxels);
    let anew = Target::build(model, spacing_mm, &target.subdivision).expect("a target");
    assert_eq!(same(&update.target, &voxels, &anew), Ok(()));
    update
}

/// The boxes of the lattice `of` that the faces of one of two have and those of the other lack.
fn moved_faces(of: &Lattice, other: &Lattice) -> Vec<Aabb> {
    let shift = (other.first() - of.first()).as_dvec3();
    let [ours, theirs] = [of.bounds(), other.bounds()];
    let theirs = Aabb::new(theirs.min + shift, theirs.max + shift);
    let mut moved = Vec::new();
    for axis in 0..3 {
        for [a, b] in [[ours.min, theirs.min], [ours.max, theirs.max]] {
            let mut slab = Aabb::ALL;
            (slab.min[axis], slab.max[axis]) = (a[axis].min(b[axis]), a[axis].max(b[axis]));
            moved.extend((a[axis] != b[axis]).then_some(slab));
        }
    }
    moved
}

/// Voxels of blocks that are kept, and of those that are not; each of the latter, or the block before that it is a part of, meets `touched`
/// (world) or where a face has moved.
fn kept_and_made(before: &Target, update: &Update, touched: &[Aabb]) -> [usize; 2] {
    let lattice = &update.target.lattice;
    let lattice_from_world = lattice.world_from_lattice.inverse();
    let mut boxes: Vec<Aabb> = touched.iter().map(|b| b.transformed(&lattice_from_world)).collect();
    boxes.extend(moved_faces(lattice, &before.lattice));
    let shift = lattice.first() - before.lattice.first();
    let part_of = |block: &Block| -> Option<Aabb> {
        let at = (I64Vec3::from_array(block.origin.map(|n| n as i64)) + shift).to_array();
        let at = [at[0].try_into().ok()?, at[1].try_into().ok()?, at[2].try_into().ok()?];
        let bounds = before.blocks[before.block_at(at)?].bounds();
        Some(Aabb::new(bounds.min - shift.as_dvec3(), bounds.max - shift.as_dvec3()))
    };
    let meets = |bounds: Aabb| {
        let reach = bounds.expand(DVec3::splat(Block::REACH as f64));
        boxes.iter().any(|b| !b.intersect(&reach).is_empty())
    };
    let mut voxels = [0; 2];
    for (block, kept) in update.target.blocks.iter().zip(&update.kept) {
        let may_change = meets(block.bounds()) || part_of(block).is_some_and(meets);
        assert!(
            kept.is_some() || may_change,
            "{block:?} is made anew, and nothing touches it"
        );
        voxels[usize::from(kept.is_none())] += block.voxels().len();
    }
    voxels
}

fn small_blocks() -> Subdivision {
    Subdivision {
        min_block: 8,
        ..Subdivision::default()
    }
}

/// The box of the ball at `place` of a volume, and of its soft surface.
fn ball_at(world_from_index: &DAffine3, place: DVec3) -> Aabb {
    let center = world_from_index.transform_point3(place);
    Aabb::new(center - 6.0, center + 6.0)
}

#[test]
fn bounds_that_move_leave_what_they_do_not_touch() {
    let inside = DVec3::new(31.0, 44.0, 33.0);
    let outside = [
        DVec3::new(31.0, 44.0, 75.0),
        DVec3::new(-13.3, 44.0, 33.0),
        DVec3::new(-9.0, -17.2, 80.1),
    ];
    for (world_from_index, spacing_mm) in [
        (oblique(), None),
        (oblique(), Some(1.3)),
        (DAffine3::IDENTITY, None),
        (DAffine3::from_scale(DVec3::splat(1.5)), Some(1.4)),
    ] {
        let bricks = bricks(world_from_index);
        let model = |place| twenty_nodes(world_from_index, &bricks, place);
        let mut target = Target::build(&model(inside), spacing_mm, &small_blocks()).expect("a target");
        let mut place = inside;
        // Out, to other sides, and back in.
        for next in outside.into_iter().chain([inside]) {
            let update = followed(&target, &model(next), spacing_mm);
            assert_ne!(update.target.lattice, target.lattice);
            let touched = [place, next].map(|place| ball_at(&world_from_index, place));
            let [kept, made] = kept_and_made(&target, &update, &touched);
            println!("{kept} voxels kept, {made} made");
            assert!(2 * kept > made, "{kept} voxels kept, {made} made");
            (target, place) = (update.target, next);
        }
    }
}

#[test]
fn another_spacing_is_built_anew() {
    let bricks = bricks(DAffine3::IDENTITY);
    let model = twenty_nodes(DAffine3::IDENTITY, &bricks, DVec3::splat(30.0));
    let target = Target::build(&model, Some(2.0), &small_blocks()).expect("a target");
    let lattice = Lattice::of_model(&model, Some(2.5)).expect("a lattice");
    let update = updated(&target, &model, lattice);
    assert!(update.kept.iter().all(Option::is_none));
    assert_eq!(update.target.lattice, lattice);
}

/// A large volume, and beside it two balls that landmarks deform each, the second of which goes `by`.
fn deformed_beside(bricks: &Arc<Bricks>, by: f64) -> Model {
    let mut model = Model::default();
    let volume = model.push(Node::Volume(VolumeLeaf {
        bricks: Arc::clone(bricks),
        window: Interval::ALL,
    }));
    let mut all = vec![volume];
    for (x, by) in [(-20.0, 2.0), (84.0, by)] {
        let center = DVec3::new(x, 30.0, 30.0);
        let child = model.push(Node::Primitive(Primitive::soft(
            Solid::Sphere { center, radius: 6.0 },
            70.0,
        )));
        let corners = Aabb::new(center - 9.0, center + 9.0).corners();
        let landmark = |(n, from): (usize, DVec3)| Landmark {
            name: n.to_string(),
            from,
            to: from + if n == 7 { DVec3::Y * by } else { DVec3::ZERO },
        };
        let landmarks: Vec<Landmark> = corners.into_iter().enumerate().map(landmark).collect();
        let spline = Spline::new(&landmarks, &Smoothness::default()).expect("a spline");
        let morph = Morph::new(spline, Aabb::new(center - 9.0, center + 9.0)).expect("a morph");
        all.push(model.push(Node::Deform {
            child,
            morph: Arc::new(morph),
            error_voxels: 0.1,
        }));
    }
    model.fold(BooleanOp::Union, ValueRule::First, Family::MinMax, all);
    model
}

#[test]
fn a_landmark_that_moves_leaves_the_volume_and_other_tables() {
    let bricks = bricks(DAffine3::IDENTITY);
    let mut target = Target::build(&deformed_beside(&bricks, 1.0), None, &small_blocks()).expect("a target");
    for by in [1.5, 4.0, 0.5] {
        let model = deformed_beside(&bricks, by);
        let update = followed(&target, &model, None);
        // The second ball, wherever its landmark takes it, with its filter.
        let touched = Aabb::new(DVec3::new(70.0, 10.0, 10.0), DVec3::new(100.0, 55.0, 55.0));
        let [kept, made] = kept_and_made(&target, &update, &[touched]);
        println!("{kept} voxels kept, {made} made");
        assert!(2 * kept > made, "{kept} voxels kept, {made} made");
        let same_table = |n: u32| std::ptr::eq(target.tree.table(n), update.target.tree.table(n));
        assert!(same_table(0) && !same_table(1));
        target = update.target;
    }
}
