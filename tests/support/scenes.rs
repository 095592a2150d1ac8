//! Random models on lattices of at most some 30,000 voxels.

use std::fmt;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use proptest::prelude::*;
use vcsg::math::{Aabb, Plane};
use vcsg::model::{
    Admitted, BooleanOp, Boundary, Combine, Family, Kind, Model, Node, NodeId, Operator, TransferFunction, Tree,
    ValueMap, ValueRule,
};
use vcsg::target::{Lattice, Subdivision, Target};
use vcsg::voxelize::{Primitive, Solid};

use super::landmarks::{self, Landmarks};
use super::parts::{self, Scan};
use super::seeded;

/// A model before it is one.
#[derive(Clone, Debug)]
pub enum Part {
    Volume(Scan),
    Mask(Scan, Admitted),
    Primitive(Primitive),
    Transform(Box<Part>, DAffine3),
    /// Deformed as far as landmarks, gone part of their way, do not fold it.
    Deform(Box<Part>, Landmarks),
    Transfer(Box<Part>, ValueMap),
    Classify(Box<Part>, Arc<TransferFunction>),
    Cut(Box<Part>, Plane),
    Combine(Operator, Box<Part>, Box<Part>),
    /// Some node of values that is already in the model.
    Again(prop::sample::Index),
}

/// A model that remembers the nodes it has.
#[derive(Default)]
struct Builder {
    model: Model,
    made: Vec<NodeId>,
}

impl Builder {
    fn push(&mut self, part: &Part) -> NodeId {
        let node = match part {
            Part::Volume(scan) => Node::Volume(scan.leaf()),
            Part::Mask(scan, admitted) => Node::Mask(scan.mask(*admitted)),
            Part::Primitive(primitive) => Node::Primitive(primitive.clone()),
            Part::Transform(child, parent_from_child) => Node::Transform {
                child: self.push(child),
                parent_from_child: *parent_from_child,
            },
            Part::Deform(child, landmarks) => {
                let child = self.push(child);
                self.deformed(child, landmarks)
            }
            Part::Transfer(child, map) => Node::Transfer {
                child: self.push(child),
                map: map.clone(),
            },
            Part::Classify(child, transfer) => Node::Classify {
                child: self.push(child),
                transfer: Arc::clone(transfer),
            },
            Part::Cut(child, plane) => Node::Cut {
                child: self.push(child),
                plane: *plane,
            },
            Part::Combine(operator, first, second) => {
                let (first, second) = (self.push(first), self.push(second));
                Node::Combine(combination(operator.clone(), first, second))
            }
            Part::Again(_) if self.made.is_empty() => ball(),
            Part::Again(which) => return *which.get(&self.made),
        };
        let id = self.model.push(node);
        if self.model.kind(id) == Kind::Value {
            self.made.push(id);
        }
        id
    }
}

impl Builder {
    /// What is endless is deformed within a box.
    fn deformed(&mut self, child: NodeId, landmarks: &Landmarks) -> Node {
        let bounds = self.model.bounds()[child.index()];
        let (child, bounds) = match bounds.is_finite() || bounds.is_empty() {
            true => (child, bounds),
            false => {
                let second = self.model.push(everywhere());
                let (rule, family) = (ValueRule::First, Family::MinMax);
                let both = self.model.fold(BooleanOp::Intersection, rule, family, [child, second]);
                (both.expect("two"), everywhere_bounds())
            }
        };
        Node::Deform {
            child,
            morph: landmarks.morph(&bounds).into(),
            error_voxels: landmarks.error_voxels,
        }
    }
}

fn everywhere_bounds() -> Aabb {
    Aabb::new(DVec3::splat(-13.0), DVec3::splat(11.5))
}

fn everywhere() -> Node {
    Node::Primitive(Primitive::crisp(Solid::Box(everywhere_bounds()), 1.0))
}

fn ball() -> Node {
    let solid = Solid::Sphere {
        center: DVec3::ZERO,
        radius: 6.0,
    };
    Node::Primitive(Primitive::crisp(solid, 40.0))
}

fn combination(operator: Operator, first: NodeId, second: NodeId) -> Combine {
    Combine {
        op: operator.op,
        rule: operator.rule,
        family: operator.family,
        first,
        second,
    }
}

/// A random model and where it is sampled.
#[derive(Clone)]
pub struct Scene {
    pub part: Part,
    pub model: Model,
    pub lattice: Lattice,
}

/// What it was made of tells how to make it again.
impl fmt::Debug for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} on {:?}", self.part, self.lattice)
    }
}

impl Scene {
    fn new(part: Part) -> Self {
        let mut builder = Builder::default();
        let root = builder.push(&part);
        let model = bounded(builder.model.rooted_at(root));
        let lattice = small_lattice(&model);
        Self { part, model, lattice }
    }

    /// The scene's target.
    pub fn target(&self, subdivision: &Subdivision) -> Target {
        Target::on_lattice(&self.model, self.lattice, subdivision).expect("a small target")
    }
}

/// `model`, with a ball where it is nowhere, and within a box where it is endless.
fn bounded(mut model: Model) -> Model {
    let root = model.root().expect("a node");
    let bounds = model.bounds()[root.index()];
    let (op, node) = if bounds.is_empty() || bounds.size().min_element() <= 0.0 {
        (BooleanOp::Union, ball())
    } else if !bounds.is_finite() {
        (BooleanOp::Intersection, everywhere())
    } else {
        return model;
    };
    let mut second = model.push(node);
    if model.kind(root) == Kind::Color {
        let transfer = Arc::new(seeded(&parts::transfer(), 1));
        second = model.push(Node::Classify {
            child: second,
            transfer,
        });
    }
    model.fold(op, ValueRule::First, Family::MinMax, [root, second]);
    // A union with something endless has to be bounded in its turn.
    bounded(model)
}

/// Voxels along an axis, at most.
pub const MAX_DIM: usize = 64;

/// The model's own lattice if it is small, a coarse one over its box otherwise; one somewhere where the boxes alone show that
/// nothing is left of it.
fn small_lattice(model: &Model) -> Lattice {
    let tree = Tree::new(model, &DAffine3::IDENTITY).expect("a small tree");
    let own = Lattice::of_model(model, None);
    if let Ok(own) = own
        && own.len() <= 30_000
        && own.dims.iter().all(|&n| n <= MAX_DIM)
    {
        return own;
    }
    let whole = tree.bounds_in(&DAffine3::IDENTITY);
    let somewhere = Aabb::new(DVec3::splat(-13.0), DVec3::splat(13.0));
    let bounds = if whole.is_empty() { somewhere } else { whole };
    Lattice::axis_aligned(&bounds, bounds.size().max_element() / 26.0).expect("a bounded model")
}

/// Random scenes of values or of colours.
pub fn scene() -> impl Strategy<Value = Scene> {
    prop_oneof![3 => value_scene().boxed(), 2 => color_scene().boxed()]
}

/// Random scenes of colours: scenes of values classified each by a transfer function of its own, and combined.
pub fn color_scene() -> impl Strategy<Value = Scene> {
    let primitive = prop_oneof![2 => parts::crisp(), 3 => parts::soft()].boxed();
    let values = tree(parts::placement().boxed(), primitive, true, 1);
    let leaf = (values, parts::transfer()).prop_map(|(p, t)| Part::Classify(Box::new(p), Arc::new(t)));
    let colored = leaf.prop_recursive(3, 4, 2, |part| {
        let boxed = || part.clone().prop_map(Box::new);
        prop_oneof![
            6 => (parts::color_operator(), boxed(), boxed()).prop_map(|(o, a, b)| Part::Combine(o, a, b)),
            1 => (boxed(), parts::plane()).prop_map(|(p, plane)| Part::Cut(p, plane)),
            1 => (boxed(), parts::placement()).prop_map(|(p, m)| Part::Transform(p, m)),
        ]
    });
    colored.prop_map(Scene::new)
}

/// Random scenes of values: freely placed, or with all volumes on one lattice; primitives are soft or crisp.
pub fn value_scene() -> impl Strategy<Value = Scene> {
    scene_of(prop_oneof![2 => parts::crisp(), 3 => parts::soft()].boxed(), 1)
}

/// Random scenes that are deformed as a whole.
pub fn deformed_scene() -> impl Strategy<Value = Scene> {
    let primitive = prop_oneof![2 => parts::crisp(), 3 => parts::soft()].boxed();
    let whole = tree(parts::placement().boxed(), primitive, true, 1);
    (whole, landmarks::landmarks()).prop_map(|(part, landmarks)| Scene::new(Part::Deform(Box::new(part), landmarks)))
}

/// Random scenes in which nothing is deformed.
pub fn undeformed_scene() -> impl Strategy<Value = Scene> {
    scene_of(prop_oneof![2 => parts::crisp(), 3 => parts::soft()].boxed(), 0)
}

/// Random scenes in which coverage is 0 or 1 and nothing is deformed.
pub fn crisp_scene() -> impl Strategy<Value = Scene> {
    scene_of(parts::crisp().boxed(), 0)
}

/// Random scenes of these primitives, with `deformed` deformations for each cut.
fn scene_of(primitive: BoxedStrategy<Primitive>, deformed: u32) -> impl Strategy<Value = Scene> {
    let free = tree(parts::placement().boxed(), primitive.clone(), true, deformed);
    let aligned = parts::placement().prop_flat_map(move |frame| {
        let placement = parts::shift().prop_map(move |by| frame * by).boxed();
        tree(placement, primitive.clone(), false, deformed)
    });
    prop_oneof![2 => free, 1 => aligned].prop_map(Scene::new)
}

fn tree(
    placement: BoxedStrategy<DAffine3>,
    primitive: BoxedStrategy<Primitive>,
    transforms: bool,
    deformed: u32,
) -> impl Strategy<Value = Part> {
    let leaf = prop_oneof![
        4 => parts::scan(placement.clone()).prop_map(Part::Volume),
        1 => (parts::scan(placement), parts::admitted()).prop_map(|(scan, admitted)| Part::Mask(scan, admitted)),
        3 => primitive.prop_map(Part::Primitive),
        1 => any::<prop::sample::Index>().prop_map(Part::Again),
    ];
    leaf.prop_recursive(5, 10, 2, move |part| {
        let boxed = || part.clone().prop_map(Box::new);
        let moves = u32::from(transforms);
        prop_oneof![
            6 => (parts::operator(), boxed(), boxed()).prop_map(|(o, a, b)| Part::Combine(o, a, b)),
            1 + moves => (boxed(), parts::value_map()).prop_map(|(p, m)| Part::Transfer(p, m)),
            deformed => (boxed(), landmarks::landmarks()).prop_map(|(p, l)| Part::Deform(p, l)),
            1 => (boxed(), parts::plane()).prop_map(|(p, plane)| Part::Cut(p, plane)),
            1 => (boxed(), moved(transforms)).prop_map(|(p, m)| Part::Transform(p, m)),
        ]
    })
}

fn moved(free: bool) -> BoxedStrategy<DAffine3> {
    if free {
        parts::placement().boxed()
    } else {
        Just(DAffine3::IDENTITY).boxed()
    }
}

/// Subdivisions with `boundary`, from a few blocks to many.
pub fn subdivision(boundary: Boundary) -> impl Strategy<Value = Subdivision> {
    (2u32..=5, 0u32..=3).prop_map(move |(min, more)| Subdivision {
        min_block: 1 << min,
        max_block: 1 << (min + more),
        boundary,
        ..Subdivision::default()
    })
}
