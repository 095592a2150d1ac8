//! Design law 5: a target that follows an edit is the one that is built anew, bit for bit.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use proptest::prelude::*;
use proptest::sample::Index;
use vcsg::math::{Aabb, Interval, Plane};
use vcsg::model::deform::Morph;
use vcsg::model::{Admitted, Boundary, Combine, Model, Node, NodeId, Operator, TransferFunction, ValueMap};
use vcsg::target::{Block, BlockVoxels, Lattice, Subdivision, Target, Update, VoxelTarget};
use vcsg::voxelize::{Primitive, Solid};

use super::alike::{same, same_pictures, same_voxels};
use super::twig::{Leafless, Twig};
use crate::support::landmarks::landmarks;
use crate::support::scenes::{Scene, undeformed_scene};
use crate::support::{cases, parts, seeded};

/// What a random edit takes its numbers from.
#[derive(Clone, Debug)]
struct Parameters {
    primitive: Primitive,
    placement: DAffine3,
    plane: Plane,
    map: ValueMap,
    operator: Operator,
    window: Interval,
    transfer: TransferFunction,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Change,
    Nudge,
    Insert,
    Wrap,
    Remove,
    Move,
    Undo,
}

#[derive(Clone, Debug)]
struct Edit {
    kind: Kind,
    at: Index,
    to: Index,
    with: Parameters,
}

fn parameters() -> impl Strategy<Value = Parameters> {
    let window = (-100.0f32..200.0, 0.0f32..150.0).prop_map(|(lo, width)| Interval::new(lo, lo + width));
    let primitive = prop_oneof![parts::crisp(), parts::soft()];
    (
        primitive,
        parts::placement(),
        parts::plane(),
        parts::value_map(),
        parts::operator(),
        window,
        parts::transfer(),
    )
        .prop_map(
            |(primitive, placement, plane, map, operator, window, transfer)| Parameters {
                primitive,
                placement,
                plane,
                map,
                operator,
                window,
                transfer,
            },
        )
}

fn edit() -> impl Strategy<Value = Edit> {
    let kind = prop_oneof![
        3 => Just(Kind::Change),
        3 => Just(Kind::Nudge),
        3 => Just(Kind::Insert),
        1 => Just(Kind::Wrap),
        2 => Just(Kind::Remove),
        1 => Just(Kind::Move),
        1 => Just(Kind::Undo),
    ];
    (kind, any::<Index>(), any::<Index>(), parameters()).prop_map(|(kind, at, to, with)| Edit { kind, at, to, with })
}

impl Edit {
    /// The tree after the edit; `before` is what it was before the last one.
    fn apply(&self, tree: &Twig, before: &Twig) -> Twig {
        let mut edited = tree.clone();
        let node = edited.nth(self.at.index(tree.len()));
        let with = &self.with;
        match self.kind {
            Kind::Change => change(&mut node.node, with),
            Kind::Nudge => nudge(&mut node.node),
            Kind::Insert if tree.len() < 40 => {
                *node = Twig::combined(with.operator.clone(), node.clone(), Twig::leaf(&with.primitive));
            }
            Kind::Wrap if tree.len() < 40 => *node = wrapped(node.clone(), with, self.to.index(3)),
            Kind::Remove if !node.children.is_empty() => {
                *node = node.children[self.to.index(node.children.len())].clone()
            }
            Kind::Move if !node.children.is_empty() => {
                let moved = node.children[0].clone();
                *node = node.children[node.children.len() - 1].clone();
                let to = self.to.index(edited.len());
                let beside = edited.nth(to);
                *beside = Twig::combined(with.operator.clone(), beside.clone(), moved);
            }
            Kind::Undo => return before.clone(),
            _ => {}
        }
        edited
    }
}

/// Another node of the same kind.
fn change(node: &mut Node, with: &Parameters) {
    match node {
        Node::Volume(leaf) => leaf.window = with.window,
        Node::Mask(leaf) => leaf.value += 1.0,
        Node::Primitive(primitive) => *primitive = with.primitive.clone(),
        Node::Transform { parent_from_child, .. } => *parent_from_child = with.placement,
        Node::Transfer { map, .. } => *map = with.map.clone(),
        Node::Cut { plane, .. } => *plane = with.plane,
        Node::Deform { error_voxels, .. } => *error_voxels *= 1.5,
        Node::Classify { transfer, .. } => *transfer = Arc::new(with.transfer.clone()),
        Node::Combine(c) => {
            let Operator { op, rule, family } = with.operator.clone();
            (c.op, c.rule, c.family) = (op, rule, family);
        }
    }
}

/// Nearly the same node.
fn nudge(node: &mut Node) {
    let by = DVec3::new(0.5, -0.25, 0.0);
    match node {
        Node::Volume(leaf) => leaf.window = Interval::new(leaf.window.lo.max(-50.0), leaf.window.hi),
        Node::Mask(leaf) => leaf.admitted = Admitted::NotZero,
        Node::Deform { .. } | Node::Classify { .. } => {}
        Node::Primitive(primitive) => match &mut primitive.solid {
            Solid::Sphere { center, .. } => *center += by,
            Solid::Box(bounds) => *bounds = Aabb::new(bounds.min + by, bounds.max + by),
            _ => primitive.value += 1.0,
        },
        Node::Transform { parent_from_child, .. } => parent_from_child.translation += by,
        Node::Transfer { map, .. } => {
            *map = ValueMap::Linear {
                scale: 1.0,
                offset: 1.0,
            }
        }
        Node::Cut { plane, .. } => plane.offset += 0.5,
        Node::Combine(c) => std::mem::swap(&mut c.first, &mut c.second),
    }
}

/// The child in a unary node of its own.
fn wrapped(child: Twig, with: &Parameters, kind: usize) -> Twig {
    let mut model = Model::default();
    let id = model.push(child.node.clone().leafless());
    let node = match kind {
        0 => Node::Transform {
            child: id,
            parent_from_child: with.placement,
        },
        1 => Node::Transfer {
            child: id,
            map: with.map.clone(),
        },
        _ => Node::Cut {
            child: id,
            plane: with.plane,
        },
    };
    Twig {
        node,
        children: vec![child],
    }
}

/// A sequence of edits, and where the models are sampled.
#[derive(Clone, Debug)]
struct Sequence {
    /// Of values.
    scene: Scene,
    /// What combines the scene's colours with those of a ball, if it has any; edits bring transfer functions.
    blend: Option<Operator>,
    /// What deforms what is beside the scene, in turns, if anything does.
    morphs: Vec<Arc<Morph>>,
    /// Balls that make the paths long.
    balls: usize,
    subdivision: Subdivision,
    edits: Vec<Edit>,
}

const EDITS: usize = 25;

pub fn ball() -> Solid {
    Solid::Sphere {
        center: DVec3::ONE,
        radius: 5.0,
    }
}

fn sequence() -> impl Strategy<Value = Sequence> {
    // Blocks of 16 are reconstructed in several parts.
    let subdivision = (1u32..=4, 0u32..=2, any::<bool>()).prop_map(|(min, more, exact)| Subdivision {
        min_block: 1 << min,
        max_block: 1 << (min + more),
        boundary: if exact { Boundary::Exact } else { Boundary::Centre },
        ..Subdivision::default()
    });
    let balls = prop_oneof![15 => Just(0usize), 1 => Just(70)];
    let blend = prop::option::weighted(0.4, parts::color_operator());
    let edits = prop::collection::vec(edit(), EDITS);
    let bounds = Aabb::new(DVec3::splat(-8.0), DVec3::splat(10.0));
    let morph = landmarks().prop_map(move |landmarks| Arc::new(landmarks.morph(&bounds)));
    let morphs = prop_oneof![7 => Just(vec![]).boxed(), 1 => prop::collection::vec(morph, 2).boxed()];
    let all = (undeformed_scene(), blend, morphs, balls, subdivision, edits);
    all.prop_map(|(scene, blend, morphs, balls, subdivision, edits)| Sequence {
        scene,
        blend,
        morphs,
        balls,
        subdivision,
        edits,
    })
}

impl Sequence {
    fn tree(&self) -> Twig {
        let root = self.scene.model.root().expect("a node");
        let mut tree = Twig::of(&self.scene.model, root);
        for n in 0..self.balls {
            let center = DVec3::new(n as f64 * 0.3 - 10.0, 3.0, (n % 7) as f64);
            let solid = Solid::Sphere { center, radius: 1.5 };
            let operator = seeded(&parts::operator(), 3);
            tree = Twig::combined(operator, tree, Twig::leaf(&Primitive::crisp(solid, n as f32)));
        }
        tree
    }

    /// The model of a tree after edit `n`, and what is beside it. Some of the edits change the tree's colours, if it has any, some those of
    /// what is beside it, and some how that is deformed.
    fn model(&self, tree: &Twig, n: usize) -> Model {
        let mut model = tree.model();
        let Some(first) = model.root() else {
            return model;
        };
        let second = self.beside(&mut model, n);
        let classified = |model: &mut Model, child, edit: usize| {
            let transfer = Arc::new(self.edits[edit].with.transfer.clone());
            model.push(Node::Classify { child, transfer })
        };
        let (first, second, operator) = match &self.blend {
            None => (first, second, seeded(&parts::operator(), 3)),
            Some(blend) => {
                let first = classified(&mut model, first, n / 5 * 5);
                (first, classified(&mut model, second, n / 3), blend.clone())
            }
        };
        model.push(combined(&operator, first, second));
        model
    }

    /// A ball that deformations come and go about, one within the other, and a box that is always deformed, if anything is: their numbers
    /// change.
    fn beside(&self, model: &mut Model, n: usize) -> NodeId {
        let ball = model.push(Node::Primitive(Primitive::soft(ball(), 50.0)));
        let Some(last) = self.morphs.last() else {
            return ball;
        };
        let inner = self.deformed(model, ball, n / 8 % 3);
        let ball = self.deformed(model, inner, (n / 5 + 1) % 3);
        let solid = Solid::Box(Aabb::new(DVec3::splat(-6.0), DVec3::splat(-1.0)));
        let child = model.push(Node::Primitive(Primitive::crisp(solid, 20.0)));
        let part = model.push(deform(child, last));
        model.push(combined(&seeded(&parts::operator(), 5), ball, part))
    }

    /// `child` deformed by morph `n`, if there is one.
    fn deformed(&self, model: &mut Model, child: NodeId, n: usize) -> NodeId {
        self.morphs
            .get(n)
            .map_or(child, |morph| model.push(deform(child, morph)))
    }

    /// Some voxels about what of the model is near to where the scene was, on one grid: with the edits, its faces move.
    fn lattice(&self, model: &Model) -> Lattice {
        let bounds = self.scene.lattice.world_bounds();
        // A chain of maps may have moved a model beyond all numbers.
        let usable = |b: &Aabb| !b.is_empty() && b.is_finite() && b.size().max_element() < 1e6;
        let start = [bounds, Aabb::new(DVec3::splat(-13.0), DVec3::splat(13.0))];
        let start = start.into_iter().find(usable).expect("the second is");
        let spacing_mm = start.size().max_element() / 7.0;
        let of_model = model.root().map_or(Aabb::EMPTY, |root| model.bounds()[root.index()]);
        let filled = of_model.intersect(&start.expand(DVec3::splat(1.5 * spacing_mm)));
        let filled = if usable(&filled) { filled } else { start };
        Lattice::axis_aligned(&filled, spacing_mm).expect("a small lattice")
    }

    /// Follows the edits, each time by what `update` makes of the target before and the one built anew.
    fn follow(&self, mut update: impl FnMut(&Target, &Model, Lattice) -> Update) -> Result<(), String> {
        let mut tree = self.tree();
        let mut before = tree.clone();
        let model = self.model(&tree, 0);
        let mut target = Target::on_lattice(&model, self.lattice(&model), &self.subdivision).expect("a small target");
        let mut voxels = VoxelTarget::new(&target).voxels;
        for (n, edit) in self.edits.iter().enumerate() {
            let edited = edit.apply(&tree, &before);
            let model = self.model(&edited, n);
            let lattice = self.lattice(&model);
            let update = update(&target, &model, lattice);
            same_pictures(&target, &update).map_err(|what| format!("edit {n}, {:?}: {what}", edit.kind))?;
            voxels = update.voxels(&target, &voxels);
            target = update.target;
            let anew = Target::on_lattice(&model, lattice, &self.subdivision).expect("a small target");
            same(&target, &voxels, &anew).map_err(|what| format!("edit {n}, {:?}: {what}", edit.kind))?;
            before = std::mem::replace(&mut tree, edited);
        }
        Ok(())
    }
}

fn combined(operator: &Operator, first: NodeId, second: NodeId) -> Node {
    let Operator { op, rule, family } = operator.clone();
    Node::Combine(Combine {
        op,
        rule,
        family,
        first,
        second,
    })
}

fn deform(child: NodeId, morph: &Arc<Morph>) -> Node {
    Node::Deform {
        child,
        morph: Arc::clone(morph),
        error_voxels: 0.5,
    }
}

pub fn updated(target: &Target, model: &Model, lattice: Lattice) -> Update {
    target
        .updated(model, lattice, &target.subdivision)
        .expect("a small target")
}

proptest! {
    // 10,000 edits in all.
    #![proptest_config(cases(400))]

    #[test]
    fn an_edited_target_is_the_one_built_anew(sequence in sequence()) {
        prop_assert_eq!(sequence.follow(updated), Ok(()));
    }
}

/// How many of some sequences show a mistake in their updates.
fn seen(mistake: impl Fn(&Target, Update) -> Update) -> usize {
    let shows = |seed: &u64| {
        let sequence = seeded(&sequence(), *seed);
        let follow = |target: &Target, model: &Model, lattice| mistake(target, updated(target, model, lattice));
        sequence.follow(follow).is_err()
    };
    (0..40).filter(shows).count()
}

#[test]
fn forgetting_what_has_changed_is_seen() {
    assert_eq!(seen(|_, update| update), 0);
    let forgotten = seen(|_, update| Update {
        changed: vec![],
        ..update
    });
    assert!(forgotten > 20, "{forgotten} of 40");
}

/// What an edit that moves a face of the lattice does to blocks there is seen, even if their own voxels stay.
#[test]
fn keeping_blocks_at_faces_that_have_moved_is_seen() {
    let cube = |target: &Target, block: &Block| {
        let first = target.lattice.first().to_array();
        let origin = [0, 1, 2].map(|a| block.origin[a] as i64 + first[a]);
        (origin, block.size, block.extent, block.layout)
    };
    let careless = seen(|before, update| {
        let voxels = |target: &Target, block: &Block| BlockVoxels::reconstruct(target, block, 0);
        let kept = update.target.blocks.iter().map(|block| {
            let same = |old: &&Block| cube(before, old) == cube(&update.target, block);
            let old = before.blocks.iter().find(same)?;
            let alike = same_voxels(&voxels(before, old), &voxels(&update.target, block)).is_ok();
            let index = before.blocks.iter().position(|b| std::ptr::eq(b, old))?;
            alike.then_some(index as u32)
        });
        Update {
            kept: kept.collect(),
            ..update.clone()
        }
    });
    assert!(careless > 10, "{careless} of 40");
}

#[test]
fn keeping_blocks_by_their_place_alone_is_seen() {
    let place = |b: &Block| (b.origin, b.size, b.layout);
    let careless = seen(|before, update| {
        let kept = update.target.blocks.iter().map(|block| {
            let old = before.blocks.iter().position(|old| place(old) == place(block));
            old.map(|index| index as u32)
        });
        Update {
            kept: kept.collect(),
            ..update
        }
    });
    assert!(careless > 20, "{careless} of 40");
}

/// How many edits of some sequences there are, and blocks that they keep: those that move a face of the lattice, and those that change
/// a deformation.
#[derive(Debug, Default)]
struct Count {
    moved: [usize; 2],
    deformed: [usize; 2],
}

#[test]
fn edits_that_move_bounds_or_deform_keep_blocks() {
    let mut count = Count::default();
    for seed in 0..60 {
        let sequence = seeded(&sequence(), seed);
        let followed = sequence.follow(|target, model, lattice| {
            let update = updated(target, model, lattice);
            let kept = update.kept.iter().flatten().count();
            let add = |[edits, blocks]: &mut [usize; 2]| (*edits, *blocks) = (*edits + 1, *blocks + kept);
            if lattice != target.lattice {
                add(&mut count.moved);
            }
            let morphs = |target: &Target| -> Vec<_> { target.tree.deformations().map(|(m, _)| m.clone()).collect() };
            if morphs(target) != morphs(&update.target) {
                add(&mut count.deformed);
            }
            update
        });
        assert_eq!(followed, Ok(()), "seed {seed}");
    }
    println!("{count:?}");
    assert!(count.moved.iter().all(|&n| n > 100), "{count:?}");
    assert!(count.deformed.iter().all(|&n| n > 10), "{count:?}");
}
