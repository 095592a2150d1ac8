//! The algebra of set operations on whole models: what commutes, De Morgan, and transforms that distribute. All of it bit for bit
//! but where a tolerance is derived.

use glam::{DAffine3, DVec3};
use proptest::prelude::*;
use vcsg::model::{BooleanOp, Boundary, ColorSample, Combine, Family, Model, Node, NodeId, Operator, Tree, ValueRule};
use vcsg::voxelize::{Primitive, Solid};

use crate::path::{at, blocks_follow, same_bits, voxels};
use crate::support::cases;
use crate::support::parts;
use crate::support::scenes::{Scene, color_scene, subdivision, value_scene};

/// The nodes of both scenes in one model, and their roots.
fn side_by_side(first: &Scene, second: &Scene) -> (Model, [NodeId; 2]) {
    let mut model = Model::default();
    let roots = [first, second].map(|scene| {
        let begin = model.nodes().len();
        let mut moved: Vec<NodeId> = Vec::new();
        for node in scene.model.nodes() {
            moved.push(model.push(node.with_children(|child| moved[child.index()])));
        }
        assert!(model.nodes().len() > begin);
        moved[moved.len() - 1]
    });
    (model, roots)
}

fn combined(model: &Model, operator: &Operator, [first, second]: [NodeId; 2]) -> Model {
    let mut model = model.clone();
    let Operator { op, rule, family } = operator.clone();
    model.push(Node::Combine(Combine {
        op,
        rule,
        family,
        first,
        second,
    }));
    model
}

/// Samples of `model` at the voxels of the first scene's lattice.
fn samples(model: &Model, scene: &Scene) -> Vec<ColorSample> {
    let tree = Tree::new(model, &scene.lattice.world_from_lattice).expect("a small tree");
    voxels(scene.lattice.dims)
        .step_by(7)
        .map(|v| tree.color_sample(at(v)))
        .collect()
}

fn same(a: &ColorSample, b: &ColorSample) -> bool {
    let (a, b) = (a.sample, b.sample);
    same_bits(a.value, b.value) && same_bits(a.coverage, b.coverage)
}

/// The combination of two nodes moved, and that of both moved.
fn moved_whole_and_in_parts(model: &Model, operands: [NodeId; 2], operator: &Operator, by: DAffine3) -> [Model; 2] {
    let moved = |model: &mut Model, child| {
        model.push(Node::Transform {
            child,
            parent_from_child: by,
        })
    };
    let mut whole = combined(model, operator, operands);
    let root = whole.root().expect("a node");
    moved(&mut whole, root);
    let mut parts = model.clone();
    let each = operands.map(|operand| moved(&mut parts, operand));
    [whole, combined(&parts, operator, each)]
}

/// Everything but `of`.
fn complement(model: &mut Model, of: NodeId, family: Family) -> NodeId {
    let first = model.push(Node::Primitive(Primitive::crisp(Solid::Everything, 1.0)));
    let (op, rule) = (BooleanOp::Subtraction, ValueRule::First);
    model.push(Node::Combine(Combine {
        op,
        rule,
        family,
        first,
        second: of,
    }))
}

proptest! {
    #![proptest_config(cases(96))]

    #[test]
    fn union_and_intersection_commute_for_symmetric_rules(first in value_scene(), second in value_scene(), operator in parts::operator()) {
        let rule = if operator.rule.is_symmetric() { operator.rule } else { ValueRule::Average };
        let (model, [a, b]) = side_by_side(&first, &second);
        for op in [BooleanOp::Union, BooleanOp::Intersection] {
            let operator = Operator { op, rule: rule.clone(), ..operator };
            let one = samples(&combined(&model, &operator, [a, b]), &first);
            let other = samples(&combined(&model, &operator, [b, a]), &first);
            for (x, y) in one.iter().zip(&other) {
                prop_assert!(same(x, y), "{x:?} and {y:?} by {operator:?}");
            }
        }
    }

    #[test]
    fn a_complement_of_a_union_is_the_intersection_of_complements(first in value_scene(), second in value_scene(), family in family()) {
        let (mut united, [a, b]) = side_by_side(&first, &second);
        let mut apart = united.clone();
        let whole = united.fold(BooleanOp::Union, ValueRule::First, family, [a, b]).expect("two operands");
        complement(&mut united, whole, family);
        let parts = [a, b].map(|of| complement(&mut apart, of, family));
        apart.fold(BooleanOp::Intersection, ValueRule::First, family, parts);
        for (x, y) in samples(&united, &first).iter().zip(&samples(&apart, &first)) {
            // 1 − c falls as c rises, rounded or not, so min and max meet bit for bit. The product's side rounds 1 − a, b·(1 − a),
            // their sum and 1 minus it, the other 1 − a, 1 − b and their product: seven roundings of numbers up to 1.
            let allowed = if family == Family::MinMax { 0.0 } else { 7.0 * 0.5 * f32::EPSILON };
            prop_assert!((x.sample.coverage - y.sample.coverage).abs() <= allowed, "{x:?} and {y:?}");
        }
    }

    #[test]
    fn transforms_distribute(first in value_scene(), second in value_scene(), operator in parts::operator(), by in parts::placement()) {
        let (model, operands) = side_by_side(&first, &second);
        let [whole, parts] = moved_whole_and_in_parts(&model, operands, &operator, by);
        for (x, y) in samples(&whole, &first).iter().zip(&samples(&parts, &first)) {
            prop_assert!(same(x, y), "{x:?} and {y:?} by {operator:?}");
        }
    }

    #[test]
    fn transforms_distribute_over_colours(
        first in color_scene(),
        second in color_scene(),
        operator in parts::color_operator(),
        by in parts::placement(),
    ) {
        let (model, operands) = side_by_side(&first, &second);
        let [whole, parts] = moved_whole_and_in_parts(&model, operands, &operator, by);
        for (x, y) in samples(&whole, &first).iter().zip(&samples(&parts, &first)) {
            prop_assert_eq!(x.rgb, y.rgb);
            prop_assert!(same(x, y), "{x:?} and {y:?} by {operator:?}");
        }
    }

    #[test]
    fn colours_add_in_either_order_and_exclude_each_other(first in color_scene(), second in color_scene()) {
        let (model, [a, b]) = side_by_side(&first, &second);
        for rule in [ValueRule::Plus, ValueRule::Xor] {
            for op in [BooleanOp::Union, BooleanOp::Intersection] {
                let operator = Operator { op, rule: rule.clone(), family: Family::Product };
                let one = samples(&combined(&model, &operator, [a, b]), &first);
                let other = samples(&combined(&model, &operator, [b, a]), &first);
                for (x, y) in one.iter().zip(&other) {
                    prop_assert_eq!(x, y);
                }
            }
        }
    }

    #[test]
    fn a_quotient_keeps_to_its_path(first in value_scene(), second in value_scene(), subdivision in subdivision(Boundary::Exact)) {
        let (model, operands) = side_by_side(&first, &second);
        let quotient = Operator { op: BooleanOp::Union, rule: ValueRule::Quotient, family: Family::Product };
        let model = combined(&model, &quotient, operands);
        let scene = Scene { model, ..first };
        let target = scene.target(&subdivision);
        prop_assert_eq!(blocks_follow(&target, &target.tree), Ok(()));
    }
}

fn family() -> impl Strategy<Value = Family> {
    prop::sample::select(vec![Family::MinMax, Family::Product])
}

/// What the laws above would not say of rules that do not commute, or of a transform of one operand alone.
#[test]
fn what_does_not_hold_is_seen() {
    let ball = |model: &mut Model, x: f64, value: f32| {
        let solid = Solid::Sphere {
            center: DVec3::X * x,
            radius: 6.0,
        };
        model.push(Node::Primitive(Primitive::soft(solid, value)))
    };
    let mut model = Model::default();
    let operands = [ball(&mut model, 0.0, 10.0), ball(&mut model, 3.0, 30.0)];
    let differ = |one: &Model, other: &Model| {
        let tree = |model| Tree::new(model, &DAffine3::IDENTITY).expect("a small tree");
        let (one, other) = (tree(one), tree(other));
        (-9..12).any(|x| {
            !same(
                &one.color_sample(DVec3::X * f64::from(x)),
                &other.color_sample(DVec3::X * f64::from(x)),
            )
        })
    };
    let by = |rule| Operator {
        op: BooleanOp::Union,
        rule,
        family: Family::Product,
    };
    let [a, b] = operands;
    let turned = |rule: ValueRule| {
        (
            combined(&model, &by(rule.clone()), [a, b]),
            combined(&model, &by(rule), [b, a]),
        )
    };
    let (one, other) = turned(ValueRule::Difference);
    assert!(differ(&one, &other), "a difference commutes");
    let (one, other) = turned(ValueRule::Max);
    assert!(!differ(&one, &other), "a maximum does not commute");
}
