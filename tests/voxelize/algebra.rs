//! Which laws of sets densities obey (WK94, *manipulating volume-sampled models*; docs/PAPERS.md has the table).

use glam::{DAffine3, DVec3};
use vcsg::model::{BooleanOp, Family, Model, Node, NodeId, Tree, ValueRule};
use vcsg::voxelize::{Primitive, Solid, filter};

const RADIUS: f64 = 8.0;

fn ball(center: DVec3) -> Node {
    Node::Primitive(Primitive::soft(Solid::Sphere { center, radius: RADIUS }, 1.0))
}

fn combined(op: BooleanOp, family: Family, nodes: impl FnOnce(&mut Model) -> Vec<NodeId>) -> Tree {
    let mut model = Model::default();
    let operands = nodes(&mut model);
    model.fold(op, ValueRule::First, family, operands).expect("operands");
    Tree::in_world(&model, 1.0).expect("a small tree")
}

/// What is left of space without the ball.
fn complement(model: &mut Model, family: Family) -> NodeId {
    let everything = model.push(Node::Primitive(Primitive::crisp(Solid::Everything, 1.0)));
    let ball = model.push(ball(DVec3::ZERO));
    model
        .fold(BooleanOp::Subtraction, ValueRule::First, family, [everything, ball])
        .expect("two operands")
}

fn coverage(tree: &Tree, x: f64) -> f64 {
    f64::from(tree.sample(DVec3::X * x).coverage)
}

/// Places along x through the soft surface, from the inside out.
fn through_the_surface() -> impl Iterator<Item = f64> {
    (-22..=22).map(|n| RADIUS + f64::from(n) / 10.0)
}

#[test]
fn the_middle_is_excluded_no_more() {
    for family in [Family::MinMax, Family::Product] {
        let both = combined(BooleanOp::Intersection, family, |model| {
            vec![model.push(ball(DVec3::ZERO)), complement(model, family)]
        });
        let either = combined(BooleanOp::Union, family, |model| {
            vec![model.push(ball(DVec3::ZERO)), complement(model, family)]
        });
        let most = through_the_surface().map(|x| coverage(&both, x)).fold(0.0, f64::max);
        let least = through_the_surface().map(|x| coverage(&either, x)).fold(1.0, f64::min);
        // Where a density is a half, min is a half and the product a quarter.
        let half = if family == Family::MinMax { 0.5 } else { 0.25 };
        assert!(
            (most - half).abs() < 0.02 && (least - (1.0 - half)).abs() < 0.02,
            "{family:?}: {most} {least}"
        );
        for x in [0.0, RADIUS - 3.0, RADIUS + 3.0] {
            assert_eq!(
                (coverage(&both, x), coverage(&either, x)),
                (0.0, 1.0),
                "{family:?}: away from the surface"
            );
        }
    }
}

/// Not (A or B) is not A and not B.
#[test]
fn de_morgan_holds_in_both_families() {
    let apart = DVec3::X * 6.0;
    for family in [Family::MinMax, Family::Product] {
        let outside = |model: &mut Model, of: NodeId| {
            let everything = model.push(Node::Primitive(Primitive::crisp(Solid::Everything, 1.0)));
            model.fold(BooleanOp::Subtraction, ValueRule::First, family, [everything, of])
        };
        let neither = combined(BooleanOp::Union, family, |model| {
            let pair = [model.push(ball(-apart)), model.push(ball(apart))];
            let either = model
                .fold(BooleanOp::Union, ValueRule::First, family, pair)
                .expect("two operands");
            outside(model, either).into_iter().collect()
        });
        let both_not = combined(BooleanOp::Intersection, family, |model| {
            let pair = [model.push(ball(-apart)), model.push(ball(apart))];
            pair.into_iter().filter_map(|ball| outside(model, ball)).collect()
        });
        for n in -60..=60 {
            let p = DVec3::new(f64::from(n) / 4.0, 3.0, 1.0);
            let [a, b] = [&neither, &both_not].map(|tree| tree.sample(p).coverage);
            // Three roundings on either side of the product's.
            assert!((a - b).abs() <= 6.0 * f32::EPSILON, "{family:?} at {p}: {a} {b}");
        }
    }
}

#[test]
fn twice_is_once_for_min_and_max_only() {
    let twice = |family| {
        combined(BooleanOp::Union, family, |model| {
            let ball = model.push(ball(DVec3::ZERO));
            vec![ball, ball]
        })
    };
    let once = combined(BooleanOp::Union, Family::MinMax, |model| {
        vec![model.push(ball(DVec3::ZERO))]
    });
    let (minmax, product) = (twice(Family::MinMax), twice(Family::Product));
    for x in through_the_surface() {
        let d = coverage(&once, x);
        assert_eq!(coverage(&minmax, x), d);
        // d + d − d², in single precision.
        assert!((coverage(&product, x) - d * (2.0 - d)).abs() < 1e-6, "{x}");
    }
}

/// A ball swept round a circle in `revolutions` of 24 steps each, by the algebraic sum.
fn swept(revolutions: usize) -> Tree {
    combined(BooleanOp::Union, Family::Product, |model| {
        let ball = model.push(ball(DVec3::X * 20.0));
        let step = |n: usize| DAffine3::from_rotation_z(n as f64 * std::f64::consts::TAU / 24.0);
        let copies = 0..24 * revolutions;
        copies
            .map(|n| {
                model.push(Node::Transform {
                    child: ball,
                    parent_from_child: step(n),
                })
            })
            .collect()
    })
}

#[test]
fn sweeping_twice_is_not_sweeping_once() {
    let (once, twice) = (swept(1), swept(2));
    let at = 20.0 + RADIUS;
    assert!(coverage(&twice, at) > coverage(&once, at) + 0.1);
    assert_eq!([coverage(&once, 20.0), coverage(&twice, 20.0)], [1.0, 1.0]);
}

/// Where two soft surfaces meet, the larger of two densities has a kink and the algebraic sum has none: the second difference
/// along a line that crosses the middle between two balls.
#[test]
fn the_product_family_is_smooth_where_surfaces_meet() {
    let apart = DVec3::X * (RADIUS - 0.3);
    let pair = |family| {
        combined(BooleanOp::Union, family, |model| {
            vec![model.push(ball(-apart)), model.push(ball(apart))]
        })
    };
    let step = 0.05;
    let kink = |tree: &Tree| {
        let at = |n: i32| f64::from(tree.sample(DVec3::new(f64::from(n) * step, 2.5, 0.0)).coverage);
        (-10..=10)
            .map(|n| (at(n - 1) - 2.0 * at(n) + at(n + 1)).abs())
            .fold(0.0, f64::max)
            / step
    };
    let (minmax, product) = (kink(&pair(Family::MinMax)), kink(&pair(Family::Product)));
    // A kink of slope s changes it by 2s at one place however small the step; a smooth one changes it by the step's part.
    assert!(minmax > 0.1 && product < 0.5 * minmax, "{minmax} {product}");
}

#[test]
fn a_matte_lets_through_what_it_covers() {
    let value = 120.0;
    let matted = combined(BooleanOp::Intersection, Family::Product, |model| {
        let data = Primitive::crisp(
            Solid::Sphere {
                center: DVec3::ZERO,
                radius: 30.0,
            },
            value,
        );
        vec![model.push(Node::Primitive(data)), model.push(ball(DVec3::ZERO))]
    });
    let matte = combined(BooleanOp::Union, Family::MinMax, |model| {
        vec![model.push(ball(DVec3::ZERO))]
    });
    for x in through_the_surface() {
        let sample = matted.sample(DVec3::X * x);
        assert_eq!(f64::from(sample.coverage), coverage(&matte, x));
        assert!(sample.coverage == 0.0 || sample.value == value);
    }
}

#[test]
fn half_a_density_is_where_the_surface_is() {
    assert_eq!(filter::half_space(0.0), 0.5);
    let once = combined(BooleanOp::Union, Family::MinMax, |model| {
        vec![model.push(ball(DVec3::ZERO))]
    });
    // On a ball of four radii of the filter the bend takes 0.15 of the mean curvature: 0.0375.
    assert!((coverage(&once, RADIUS) - (0.5 - 0.0375)).abs() < 0.002);
}
