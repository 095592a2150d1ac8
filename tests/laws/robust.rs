//! Extreme models end in a small target or in an error that says what to do, soon.

use glam::{DAffine3, DMat3, DVec3};
use vcsg::math::{Aabb, Interval, Plane};
use vcsg::model::{BooleanOp, Family, Model, Node, NodeId, Tree, TreeError, ValueRule};
use vcsg::target::{Lattice, LatticeError, Subdivision, Target, TargetError};
use vcsg::voxelize::{Primitive, Solid};

use crate::support::parts::{Kind, Scan, Texture};

fn sphere(center: DVec3, radius: f64) -> Node {
    Node::Primitive(Primitive::crisp(Solid::Sphere { center, radius }, 7.0))
}

fn model_of(node: Node) -> Model {
    let mut model = Model::default();
    model.push(node);
    model
}

fn half_space(point: DVec3, normal: DVec3) -> Node {
    let plane = Plane::through(point, normal).expect("a normal");
    Node::Primitive(Primitive::crisp(Solid::HalfSpace(plane), 1.0))
}

fn one_voxel() -> Scan {
    Scan {
        dims: [1; 3],
        kind: Kind::I16,
        texture: Texture::Constant,
        seed: 3,
        world_from_index: DAffine3::IDENTITY,
        window: Interval::ALL,
    }
}

#[test]
fn nothing_and_endlessness_are_refused() {
    let build = |model: &Model| Target::build(model, None, &Subdivision::default()).map(|_| ());
    let refused = |model: &Model, reason: LatticeError| {
        let found = build(model);
        assert!(
            matches!(&found, Err(TargetError::Lattice(e)) if *e == reason),
            "{found:?}"
        );
    };
    refused(&Model::default(), LatticeError::Empty);
    refused(
        &model_of(half_space(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0))),
        LatticeError::Unbounded,
    );
    let mut apart = Model::default();
    let balls = [0.0, 9.0].map(|x| apart.push(sphere(DVec3::X * x, 1.0)));
    apart.fold(BooleanOp::Intersection, ValueRule::First, Family::MinMax, balls);
    refused(&apart, LatticeError::Empty);
}

#[test]
fn a_box_of_half_spaces_is_bounded() {
    let mut model = Model::default();
    let normals = DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
    let sides: Vec<NodeId> = normals.map(|n| model.push(half_space(n * 3.0, n))).collect();
    model.fold(BooleanOp::Intersection, ValueRule::First, Family::MinMax, sides);
    let target = Target::build(&model, Some(1.0), &Subdivision::default()).expect("a target");
    assert_eq!(target.lattice.dims, [8; 3]);
}

#[test]
fn an_exceeded_budget_is_named_and_coarsening_meets_it() {
    let model = model_of(sphere(DVec3::ZERO, 60.0));
    let tight = Subdivision {
        budget_bytes: 2 << 20,
        ..Subdivision::default()
    };
    let refusal = Target::build(&model, Some(0.5), &tight)
        .map(|_| ())
        .expect_err("over budget");
    let message = refusal.to_string();
    assert!(message.contains("0.5000 mm") && message.contains("2 MiB"), "{message}");
    let target = Target::build_coarsened(&model, Some(0.5), &tight).expect("a coarser target");
    let bytes: usize = target.blocks.iter().map(|b| b.stored_len() * 8).sum();
    assert!(bytes <= tight.budget_bytes, "{bytes}");
    assert!(target.lattice.spacing_mm().x > 0.5);
}

#[test]
fn a_budget_that_no_spacing_meets_is_refused() {
    let tiny = Subdivision {
        budget_bytes: 1,
        ..Subdivision::default()
    };
    let refusal = Target::build_coarsened(&model_of(sphere(DVec3::ZERO, 1.0)), None, &tiny);
    assert!(matches!(refusal, Err(TargetError::OverBudget { .. })), "{refusal:?}");
}

#[test]
fn one_voxel_is_a_target() {
    let model = model_of(Node::Volume(one_voxel().leaf()));
    let target = Target::build(&model, None, &Subdivision::default()).expect("a target");
    assert_eq!((target.lattice.dims, target.blocks.len()), ([1; 3], 1));
    assert_eq!(target.blocks[0].extent, [1; 3]);
}

#[test]
fn impossible_lattices_are_refused() {
    let flat = |solid: Solid| {
        let node = Node::Primitive(Primitive::crisp(solid, 1.0));
        Target::build(&model_of(node), None, &Subdivision::default())
    };
    let point = Solid::Box(Aabb::new(DVec3::ONE, DVec3::ONE));
    assert!(matches!(flat(point), Err(TargetError::Lattice(_))));
    let sheet = Solid::Box(Aabb::new(DVec3::ZERO, DVec3::new(5.0, 5.0, 0.0)));
    assert!(flat(sheet).is_ok());
    let ball = model_of(sphere(DVec3::ZERO, 1e3));
    for spacing_mm in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9] {
        let built = Target::build(&ball, Some(spacing_mm), &Subdivision::default());
        assert!(matches!(built, Err(TargetError::Lattice(_))), "{spacing_mm}");
    }
    let none = Lattice::new([0; 3], DAffine3::IDENTITY);
    let built = Target::on_lattice(&ball, none, &Subdivision::default()).expect("an empty target");
    assert!(built.blocks.is_empty());
}

#[test]
fn a_singular_transform_is_refused() {
    let mut model = Model::default();
    let child = model.push(Node::Volume(one_voxel().leaf()));
    let flat = DMat3::from_diagonal(DVec3::new(1.0, 1.0, 0.0));
    model.push(Node::Transform {
        child,
        parent_from_child: DAffine3::from_mat3(flat),
    });
    let refused = Target::build(&model, Some(0.5), &Subdivision::default());
    assert!(matches!(refused, Err(TargetError::Tree(TreeError::Singular))));
}

/// Paths are split on until they are short: a block of 8 voxels and its reach of 2 on each side meet at most 4 balls along
/// an axis, so at most 64 balls and 63 unions in each of 25 · 25 · 20 blocks (and a layer of them round the lattice).
const STEPS: usize = 127 * 27 * 27 * 22;

#[test]
fn a_union_of_100_000_parts_has_short_paths() {
    let mut model = Model::default();
    let place = |n: usize| DVec3::new((n % 50) as f64, (n / 50 % 50) as f64, (n / 2500) as f64);
    let balls: Vec<NodeId> = (0..100_000).map(|n| model.push(sphere(place(n), 0.4))).collect();
    model.fold(BooleanOp::Union, ValueRule::Max, Family::MinMax, balls);
    let target = Target::build(&model, Some(0.25), &Subdivision::default()).expect("a target");
    let steps: usize = target.paths.iter().map(Vec::len).sum();
    assert!(steps < STEPS, "{steps} steps in {} paths", target.paths.len());
}

#[test]
fn nested_uses_are_counted_before_they_are_written_out() {
    let mut model = Model::default();
    let mut root = model.push(sphere(DVec3::ZERO, 1.0));
    for _ in 0..40 {
        let twice = [root; 2];
        root = model
            .fold(BooleanOp::Union, ValueRule::First, Family::MinMax, twice)
            .expect("two operands");
    }
    assert_eq!(model.root(), Some(root));
    assert_eq!(
        Tree::new(&model, &DAffine3::IDENTITY).map(|_| ()),
        Err(TreeError::TooLarge)
    );
}

#[test]
fn a_deep_chain_needs_no_call_stack() {
    let mut model = Model::default();
    let mut child = model.push(sphere(DVec3::ZERO, 1.0));
    for _ in 0..200_000 {
        child = model.push(Node::Transform {
            child,
            parent_from_child: DAffine3::IDENTITY,
        });
    }
    let target = Target::build(&model, Some(0.5), &Subdivision::default()).expect("a target");
    assert_eq!(target.paths.len(), 1);
}
