//! Design law 1: a block's path gives the tree's samples, bit for bit.

use glam::DVec3;
use proptest::prelude::*;
use vcsg::math::Interval;
use vcsg::model::{Boundary, Operator, Step, Tree};
use vcsg::target::{Block, BlockVoxels, OctreeNode, Subdivision, Target};

use crate::support::scenes::{Scene, crisp_scene, deformed_scene, scene, subdivision};
use crate::support::{cases, seeded};

/// Whether two numbers have the same bits. All NaN count as one: Rust leaves the bits of a computed NaN open.
pub fn same_bits(a: f32, b: f32) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

/// The voxel `[i, j, k]` as a point.
pub fn at(voxel: [usize; 3]) -> DVec3 {
    DVec3::from(voxel.map(|i| i as f64))
}

/// All `[i, j, k]` below `dims`.
pub fn voxels(dims: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    let [nx, ny, nz] = dims;
    (0..nx * ny * nz).map(move |n| [n % nx, n / nx % ny, n / (nx * ny)])
}

/// Every voxel that a block's picture can depend on has `tree`'s sample in the block, and voxels in no block are empty.
pub fn blocks_follow(target: &Target, tree: &Tree) -> Result<(), String> {
    for block in &target.blocks {
        block_follows(target, block, tree)?;
    }
    nothing_outside_blocks(target, tree)
}

fn block_follows(target: &Target, block: &Block, tree: &Tree) -> Result<(), String> {
    let stored = BlockVoxels::reconstruct(target, block, Block::REACH);
    for (n, place) in voxels(stored.dims).enumerate() {
        let Some(voxel) = lattice_voxel(target, block, place) else {
            continue;
        };
        let point = target.lattice.grid_point(at(voxel));
        let truth = tree.sample(point);
        let found = (stored.premultiplied[n], stored.coverage.as_ref().map_or(1.0, |c| c[n]));
        if !same_bits(found.0, truth.premultiplied()) || !same_bits(found.1, truth.coverage) {
            return Err(format!("voxel {voxel:?} of {block:?} is {found:?}, not {truth:?}"));
        }
        if let Some(stored) = stored.rgb() {
            let truth = tree.color_sample(point).premultiplied_rgb();
            if stored[n].map(f32::to_bits) != truth.map(f32::to_bits) {
                return Err(format!(
                    "voxel {voxel:?} of {block:?} is {:?}, not {truth:?}",
                    stored[n]
                ));
            }
        }
    }
    Ok(())
}

/// The voxel of the lattice that is stored at `place` of a block with its reach; `None` beyond the lattice.
fn lattice_voxel(target: &Target, block: &Block, place: [usize; 3]) -> Option<[usize; 3]> {
    let mut voxel = [0; 3];
    for a in 0..3 {
        voxel[a] = (block.origin[a] + place[a]).checked_sub(Block::REACH)?;
        if voxel[a] >= target.lattice.dims[a] {
            return None;
        }
    }
    Some(voxel)
}

fn nothing_outside_blocks(target: &Target, tree: &Tree) -> Result<(), String> {
    voxels(target.lattice.dims)
        .filter(|&voxel| target.block_at(voxel).is_none())
        .map(|voxel| (voxel, tree.sample(target.lattice.grid_point(at(voxel)))))
        .find(|(_, sample)| sample.coverage != 0.0)
        .map_or(Ok(()), |lost| Err(format!("in no block: {lost:?}")))
}

/// Under [`Boundary::Centre`], blocks that no boundary crosses follow `tree` too.
fn uncrossed_blocks_follow(target: &Target, tree: &Tree) -> Result<(), String> {
    for block in &target.blocks {
        let reach = block.bounds().expand(DVec3::splat(Block::REACH as f64));
        let exact = tree.prune(tree.steps(), &target.lattice.grid_box(&reach), None);
        let crossed = |s: &Step| matches!(s, Step::Leaf(_) | Step::Cut(_));
        if !exact.steps.iter().any(crossed) {
            block_follows(target, block, tree)?;
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases(96))]

    #[test]
    fn every_block_follows_the_tree(scene in scene(), subdivision in subdivision(Boundary::Exact)) {
        let target = scene.target(&subdivision);
        prop_assert_eq!(blocks_follow(&target, &target.tree), Ok(()));
    }

    #[test]
    fn every_block_of_what_is_deformed_follows_the_tree(
        scene in deformed_scene(),
        subdivision in subdivision(Boundary::Exact),
    ) {
        let target = scene.target(&subdivision);
        prop_assert_eq!(blocks_follow(&target, &target.tree), Ok(()));
    }

    #[test]
    fn blocks_assigned_by_their_centre_follow_the_tree_where_no_boundary_crosses(
        scene in scene(),
        subdivision in subdivision(Boundary::Centre),
    ) {
        let target = scene.target(&subdivision);
        prop_assert_eq!(uncrossed_blocks_follow(&target, &target.tree), Ok(()));
    }
}

proptest! {
    #![proptest_config(cases(24))]

    #[test]
    fn blocks_of_one_voxel_assigned_by_their_centre_are_exact(scene in scene()) {
        let one_voxel = Subdivision { min_block: 1, max_block: 1, boundary: Boundary::Centre, ..Subdivision::default() };
        let target = scene.target(&one_voxel);
        for voxel in voxels(target.lattice.dims) {
            let truth = target.sample(at(voxel));
            let (premultiplied, coverage) = target.block_at(voxel).map_or((0.0, 0.0), |b| {
                let stored = BlockVoxels::reconstruct(&target, &target.blocks[b], 0);
                (stored.premultiplied[0], stored.coverage.map_or(1.0, |c| c[0]))
            });
            let same = same_bits(premultiplied, truth.premultiplied()) && coverage == truth.coverage;
            prop_assert!(same, "{:?}: {} {} {:?}", voxel, premultiplied, coverage, truth);
        }
    }
}

/// A scene whose picture has several blocks and no symmetry.
fn example() -> (Scene, Target) {
    let two_sided = |scene: &Scene| {
        let target = scene.target(&small_blocks());
        let swapped = swapped(scene).target(&small_blocks());
        let differs = |v: &[usize; 3]| target.sample(at(*v)) != swapped.sample(at(*v));
        target.blocks.len() > 3 && voxels(target.lattice.dims).any(|v| differs(&v))
    };
    let scene = (0..)
        .map(|seed| seeded(&crisp_scene(), seed))
        .find(two_sided)
        .expect("one of endlessly many");
    let target = scene.target(&small_blocks());
    (scene, target)
}

fn small_blocks() -> Subdivision {
    Subdivision {
        min_block: 4,
        max_block: 8,
        ..Subdivision::default()
    }
}

/// The scene with the operands of its last combination swapped.
fn swapped(scene: &Scene) -> Scene {
    let mut nodes = scene.model.nodes().to_vec();
    let last = nodes.iter_mut().rev().find_map(|node| match node {
        vcsg::model::Node::Combine(c) => Some(c),
        _ => None,
    });
    if let Some(c) = last {
        std::mem::swap(&mut c.first, &mut c.second);
    }
    let mut model = vcsg::model::Model::default();
    nodes.into_iter().for_each(|node| {
        model.push(node);
    });
    Scene { model, ..scene.clone() }
}

#[test]
fn swapped_operands_are_seen() {
    let (scene, target) = example();
    assert_eq!(blocks_follow(&target, &target.tree), Ok(()));
    let swapped = swapped(&scene).target(&small_blocks());
    assert!(blocks_follow(&target, &swapped.tree).is_err());
}

#[test]
fn a_dropped_block_is_seen() {
    let (_, mut target) = example();
    let holds_something = |b: &Block| b.range.coverage.lo > 0.0;
    let dropped = target.blocks.iter().position(holds_something).unwrap_or(0) as u32;
    for node in &mut target.octree.nodes {
        if *node == OctreeNode::Block(dropped) {
            *node = OctreeNode::Empty;
        }
    }
    assert!(blocks_follow(&target, &target.tree).is_err());
}

#[test]
fn a_shift_by_one_voxel_is_seen() {
    let (scene, target) = example();
    let frame = *scene.lattice.world_from_grid() * glam::DAffine3::from_translation(DVec3::X);
    let shifted = Tree::new(&scene.model, &frame).expect("a small tree");
    assert!(blocks_follow(&target, &shifted).is_err());
}

#[test]
fn a_path_without_its_last_step_is_seen() {
    let (_, mut target) = example();
    let longest = target.paths.iter_mut().max_by_key(|p| p.len()).expect("a path");
    longest.pop();
    assert!(blocks_follow(&target, &target.tree).is_err());
}

/// Where arithmetic overflows, path and tree still agree.
#[test]
fn overflow_is_the_same_in_both() {
    use vcsg::model::{BooleanOp, Family, Model, Node, ValueMap, ValueRule};
    use vcsg::voxelize::{Primitive, Solid};
    let mut model = Model::default();
    let ball = Solid::Sphere {
        center: DVec3::ZERO,
        radius: 5.0,
    };
    let ball = model.push(Node::Primitive(Primitive::crisp(ball, -3e38)));
    let map = ValueMap::Quadratic {
        a: 1.0,
        b: 0.0,
        c: f32::NEG_INFINITY,
    };
    let indeterminate = model.push(Node::Transfer { child: ball, map });
    let sum = Operator {
        op: BooleanOp::Union,
        rule: ValueRule::Sum,
        family: Family::Product,
    };
    model.fold(sum.op, sum.rule, sum.family, [indeterminate, ball]);
    let target = Target::build(&model, Some(1.0), &small_blocks()).expect("a target");
    let centre = target.sample(at(target.lattice.dims.map(|n| n / 2)));
    assert!(centre.value.is_nan() && Interval::point(centre.coverage).contains(1.0));
    assert_eq!(blocks_follow(&target, &target.tree), Ok(()));
}
