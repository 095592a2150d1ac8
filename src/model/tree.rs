//! The tree in one frame, flattened: what a point evaluates to, and the truth that every block's path is held against.
//!
//! *Theory.* A node's value at P is its operation on its children's values at P, with P moved into each child's frame
//! (VCSG §2.2, 2.3).
//! *Changes from the paper.* The transforms on the way from the root to a leaf are composed once into that leaf's
//! `local_from_frame`, and values meet on a stack: the post-order list of steps *is* the tree.
//! *Practice.* A tree bound to a target's lattice evaluates at voxel indices, so that paths, which step along rows of voxels,
//! can agree with it bit for bit.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::bounds::placed_bounds;
use super::deform::{Warp, WarpError};
use super::pool::Pool;
use super::spaces::Space;
use super::{Classifier, ColorSample, Combine, Kind, MaskLeaf, Model, Node, NodeId, Operator, ValueMap, VolumeLeaf};
use crate::math::{Aabb, Interval, Plane, affine, linear};
use crate::volume::{Bricks, Sample};
use crate::voxelize::{Grade, Placed, Primitive};

/// One step of a flattened tree: pushes a sample, or replaces those on top of the stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// Pushes leaf `.0`, testing whether the point lies in its box.
    Leaf(u32),
    /// Pushes leaf `.0`, known to hold the point (VCSG §3.1, criterion 1).
    LeafInside(u32),
    /// Maps the value on top by map `.0`.
    Map(u32),
    /// Empties the top where cut `.0` takes it away.
    Cut(u32),
    /// Makes a colour of the value on top, by classifier `.0`.
    Classify(u32),
    /// Combines the two values on top by operator `.0`.
    Combine(u32),
    /// Combines the two colours on top by operator `.0`.
    Blend(u32),
}

/// What a leaf is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// Voxels; the local frame is the volume's index space.
    Volume(VolumeLeaf),
    /// Voxels that say where something is; the local frame is their index space.
    Mask(MaskLeaf),
    /// Geometry of one value; the local frame is the node's, or the world where that shows it better.
    Primitive(Box<Placed>),
}

/// A leaf and where it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Leaf {
    /// What it is.
    pub source: Source,
    /// The deformation that the leaf stands in.
    pub space: Space,
    /// From the tree's frame, as it is in the leaf's space, to the leaf's own.
    pub local_from_frame: DAffine3,
    /// Its box in its own frame.
    pub local_bounds: Aabb,
    /// A box of the tree's frame, as it is in the leaf's space, that holds the leaf.
    pub frame_bounds: Aabb,
}

/// A plane as a linear form in the tree's frame: taken away where `normal · p + offset > 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FramePlane {
    /// Gradient of the signed distance; not of unit length where the frame is scaled.
    pub normal: DVec3,
    /// Signed distance (millimetres) at the frame's origin.
    pub offset: f64,
}

/// Where and how finely a model is sampled.
pub(super) struct Sampling<'a> {
    pub model: &'a Model,
    pub world_from_frame: DAffine3,
    pub voxel_mm: f64,
    /// How filters change to those of the next level, if they do.
    pub grade: Option<Grade>,
}

/// A model flattened in one frame. Parts that are the same are one part: steps with one index.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    steps: Vec<Step>,
    leaves: Pool<Leaf>,
    maps: Pool<ValueMap>,
    cuts: Pool<(Space, FramePlane)>,
    operators: Pool<Operator>,
    pub(super) classifiers: Pool<Classifier>,
    pub(super) color_unit_mm: Option<f64>,
    pub(super) warps: Vec<Warp>,
}

/// Why a model cannot be flattened.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TreeError {
    /// Shared subtrees multiply out to too much.
    #[error(
        "the tree has over {} nodes once its shared parts are written out; use fewer nested uses",
        Tree::MAX_STEPS
    )]
    TooLarge,
    /// A node that is given colours where it wants values, or the other way round.
    #[error(
        "values and colours are mixed: classify all operands of a set operation or none, and give it a rule for them"
    )]
    Mixed,
    /// A transform that flattens space.
    #[error("a transform cannot be undone: its matrix is singular or not finite; scale by numbers other than 0")]
    Singular,
    /// A deformation that cannot be tabulated.
    #[error(transparent)]
    Warp(#[from] WarpError),
}

impl From<&Plane> for FramePlane {
    fn from(plane: &Plane) -> Self {
        Self {
            normal: plane.normal,
            offset: plane.offset,
        }
    }
}

impl FramePlane {
    /// Signed distance (millimetres) of the frame's point `p`.
    #[inline]
    pub fn distance(&self, p: DVec3) -> f64 {
        linear(self.normal, self.offset, p)
    }

    /// The same plane in another frame.
    pub fn moved(&self, this_from_frame: &DAffine3) -> Self {
        Self {
            normal: this_from_frame.matrix3.transpose() * self.normal,
            offset: self.distance(this_from_frame.translation),
        }
    }
}

impl Leaf {
    fn new(source: Source, space: Space, local_from_frame: DAffine3, local_bounds: Aabb) -> Self {
        let local_from_frame = affine::snapped(&local_from_frame);
        let hull = local_bounds.transformed(&local_from_frame.inverse());
        // Far more than the rounding of a mapped point, far less than a voxel.
        let slack = 1e-9 * (1.0 + hull.min.abs().max(hull.max.abs()).max_element());
        Self {
            source,
            space,
            local_from_frame,
            local_bounds,
            frame_bounds: hull.expand(DVec3::splat(slack)),
        }
    }

    /// The leaf at `local`, a point of its box in its own frame.
    #[inline]
    pub fn sample_inside(&self, local: DVec3) -> Sample {
        match &self.source {
            Source::Volume(leaf) => leaf.admit(leaf.bricks.sample_index(local)),
            Source::Mask(mask) => mask.sample(local),
            Source::Primitive(placed) => placed.sample(local),
        }
    }
}

impl VolumeLeaf {
    /// Whether no value is kept out; NaN always is.
    pub fn admits_all(&self) -> bool {
        self.window == Interval::ALL && !self.bricks.has_missing()
    }

    /// The sample of an interpolated value: present only where the value lies in the leaf's window (NaN never does).
    #[inline]
    pub fn admit(&self, value: f32) -> Sample {
        if self.window.contains(value) {
            Sample::solid(value)
        } else {
            Sample::EMPTY
        }
    }
}

impl Tree {
    /// The most nodes that a tree may have once shared subtrees are written out.
    pub const MAX_STEPS: usize = 4_000_000;

    /// Flattens `model` for points of a lattice placed by `world_from_lattice`. Filters are as wide as its largest spacing asks.
    ///
    /// # Errors
    /// If shared subtrees multiply out to more than [`Self::MAX_STEPS`] nodes, or a transform cannot be undone.
    pub fn new(model: &Model, world_from_lattice: &DAffine3) -> Result<Self, TreeError> {
        let voxel_mm = affine::spacing(world_from_lattice).max_element();
        Self::graded(model, world_from_lattice, voxel_mm, None)
    }

    /// Flattens `model` for points of the world, with filters for voxels `voxel_mm` apart; 0 makes all surfaces crisp.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn in_world(model: &Model, voxel_mm: f64) -> Result<Self, TreeError> {
        Self::graded(model, &DAffine3::IDENTITY, voxel_mm, None)
    }

    /// Flattens `model` for points of a frame placed by `world_from_frame`, with filters for voxels `voxel_mm` apart that
    /// change to those of the next level as `grade` says.
    ///
    /// # Errors
    /// As [`Self::new`], and if a deformation cannot be tabulated.
    pub fn graded(
        model: &Model,
        world_from_frame: &DAffine3,
        voxel_mm: f64,
        grade: Option<Grade>,
    ) -> Result<Self, TreeError> {
        let mut tree = Self::outline(model, world_from_frame, voxel_mm, grade)?;
        for warp in &mut tree.warps {
            warp.tabulate()?;
        }
        Ok(tree)
    }

    /// [`Self::graded`] for boxes alone: what is deformed has its box, and no samples.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn outline(
        model: &Model,
        world_from_frame: &DAffine3,
        voxel_mm: f64,
        grade: Option<Grade>,
    ) -> Result<Self, TreeError> {
        if written_out(model) > Self::MAX_STEPS {
            return Err(TreeError::TooLarge);
        }
        if model.nodes().iter().any(is_singular) {
            return Err(TreeError::Singular);
        }
        if !model.ids().all(|id| model.is_well_typed(id)) {
            return Err(TreeError::Mixed);
        }
        let mut tree = Self {
            color_unit_mm: model
                .color_unit_mm()
                .filter(|_| model.kind_of_root() == Some(Kind::Color)),
            ..Self::default()
        };
        let sampling = Sampling {
            model,
            world_from_frame: *world_from_frame,
            voxel_mm,
            grade,
        };
        // A node waits on the stack twice: to have its children visited, then to be written behind them.
        let mut pending: Vec<Visit> = model
            .root()
            .map(|id| Visit::enter(id, *world_from_frame, None))
            .into_iter()
            .collect();
        while let Some(visit) = pending.pop() {
            if visit.children_done {
                tree.write(model.node(visit.id), &visit, &sampling)?;
            } else {
                let inside = tree.enter(model.node(visit.id), &visit, &sampling)?;
                visit.expand(model, inside, &mut pending);
            }
        }
        Ok(tree)
    }

    fn write(&mut self, node: &Node, visit: &Visit, sampling: &Sampling<'_>) -> Result<(), TreeError> {
        let node_from_frame = &visit.node_from_frame;
        match node {
            Node::Volume(leaf) => self.push_voxels(Source::Volume(leaf.clone()), &leaf.bricks, visit),
            Node::Mask(leaf) => self.push_voxels(Source::Mask(leaf.clone()), &leaf.bricks, visit),
            Node::Primitive(primitive) => self.write_primitive(primitive, visit, sampling),
            Node::Transform { .. } => {}
            Node::Deform { .. } => self.place_warp(visit.inside)?,
            Node::Transfer { map, .. } => {
                let index = self.maps.add(map.clone());
                self.steps.push(Step::Map(index));
            }
            Node::Cut { plane, .. } => self.push_cut(visit.space, FramePlane::from(plane).moved(node_from_frame)),
            Node::Classify { transfer, .. } => {
                let unit_mm = self.color_unit_mm.unwrap_or(transfer.unit_mm());
                let index = self.classifiers.add(Classifier::new(Arc::clone(transfer), unit_mm));
                self.steps.push(Step::Classify(index));
            }
            Node::Combine(Combine {
                op,
                rule,
                family,
                first,
                ..
            }) => {
                let index = self.operators.add(Operator {
                    op: *op,
                    rule: rule.clone(),
                    family: *family,
                });
                self.steps.push(match sampling.model.kind(*first) {
                    Kind::Value => Step::Combine(index),
                    Kind::Color => Step::Blend(index),
                });
            }
        }
        Ok(())
    }

    fn write_primitive(&mut self, primitive: &Primitive, visit: &Visit, sampling: &Sampling<'_>) {
        let world_from_node = sampling.world_from_frame * visit.node_from_frame.inverse();
        let mut placed = primitive.placed(&world_from_node, sampling.voxel_mm);
        if let Some(grade) = &sampling.grade {
            placed = placed.graded(grade);
        }
        let local_from_frame = placed.local_from_world * sampling.world_from_frame;
        let bounds = placed_bounds(&placed);
        let source = Source::Primitive(Box::new(placed));
        self.push_leaf(Leaf::new(source, visit.space, local_from_frame, bounds));
    }

    fn push_cut(&mut self, space: Space, plane: FramePlane) {
        let index = self.cuts.add((space, plane));
        self.steps.push(Step::Cut(index));
    }

    /// A leaf in the index space of its voxels.
    fn push_voxels(&mut self, source: Source, bricks: &Bricks, visit: &Visit) {
        let index_from_frame = bricks.world_from_index().inverse() * visit.node_from_frame;
        self.push_leaf(Leaf::new(source, visit.space, index_from_frame, bricks.index_bounds()));
    }

    fn push_leaf(&mut self, leaf: Leaf) {
        let index = self.leaves.add(leaf);
        self.steps.push(Step::Leaf(index));
    }

    /// The tree with what lies on the side of `planes` (world) that their normals point to taken away.
    pub fn cut_by(mut self, planes: &[Plane], world_from_frame: &DAffine3) -> Self {
        if !self.steps.is_empty() {
            for plane in planes {
                self.push_cut(None, FramePlane::from(plane).moved(world_from_frame));
            }
        }
        self
    }

    /// For each leaf, map, plane and operator the index of the same one in `other`.
    pub(super) fn parts_in(&self, other: &Self) -> [Vec<Option<u32>>; 5] {
        [
            self.leaves.places_in(&other.leaves),
            self.maps.places_in(&other.maps),
            self.cuts.places_in(&other.cuts),
            self.operators.places_in(&other.operators),
            self.classifiers.places_in(&other.classifiers),
        ]
    }

    /// The steps of the whole tree, in post-order.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Leaf `index` of a [`Step::Leaf`].
    pub fn leaf(&self, index: u32) -> &Leaf {
        &self.leaves.parts()[index as usize]
    }

    /// All leaves.
    pub fn leaves(&self) -> &[Leaf] {
        self.leaves.parts()
    }

    /// Map `index` of a [`Step::Map`].
    pub fn map(&self, index: u32) -> &ValueMap {
        &self.maps.parts()[index as usize]
    }

    /// Plane `index` of a [`Step::Cut`].
    pub fn cut(&self, index: u32) -> &FramePlane {
        &self.cuts.parts()[index as usize].1
    }

    /// The space that plane `index` stands in.
    pub fn cut_space(&self, index: u32) -> Space {
        self.cuts.parts()[index as usize].0
    }

    /// Operator `index` of a [`Step::Combine`].
    pub fn operator(&self, index: u32) -> &Operator {
        &self.operators.parts()[index as usize]
    }

    /// All operators.
    pub fn operators(&self) -> &[Operator] {
        self.operators.parts()
    }

    /// Whether any value is mapped.
    pub fn has_maps(&self) -> bool {
        !self.maps.parts().is_empty()
    }

    /// The model at point `p` of the frame: the truth. The value of a colour is its opacity.
    pub fn sample(&self, p: DVec3) -> Sample {
        self.color_sample(p).sample
    }

    /// The model at point `p` of the frame with its colour, black in a tree of values.
    pub fn color_sample(&self, p: DVec3) -> ColorSample {
        let mut stack = Vec::new();
        for &step in &self.steps {
            self.apply(step, p, &mut stack);
        }
        stack.pop().unwrap_or(ColorSample::EMPTY)
    }

    fn apply(&self, step: Step, p: DVec3, stack: &mut Vec<ColorSample>) {
        match step {
            Step::Leaf(i) | Step::LeafInside(i) => {
                let leaf = self.leaf(i);
                let local = affine::point(&leaf.local_from_frame, self.in_space(leaf.space, p));
                let inside = leaf.local_bounds.contains(local);
                stack.push(ColorSample::of_value(if inside {
                    leaf.sample_inside(local)
                } else {
                    Sample::EMPTY
                }));
            }
            Step::Map(i) => {
                let top = stack.last_mut().expect("a map has an operand");
                *top = ColorSample::of_value(self.map(i).sample(top.sample));
            }
            Step::Classify(i) => {
                let top = stack.last_mut().expect("a classifier has an operand");
                *top = self.classifier(i).apply(top.sample);
            }
            Step::Cut(i) => {
                let top = stack.last_mut().expect("a cut has an operand");
                if self.cut(i).distance(self.in_space(self.cut_space(i), p)) > 0.0 {
                    *top = ColorSample::EMPTY;
                }
            }
            Step::Combine(i) => {
                let second = stack.pop().expect("an operator has two operands");
                let first = stack.last_mut().expect("an operator has two operands");
                *first = ColorSample::of_value(self.operator(i).apply(first.sample, second.sample));
            }
            Step::Blend(i) => {
                let second = stack.pop().expect("an operator has two operands");
                let first = stack.last_mut().expect("an operator has two operands");
                *first = self.operator(i).blend(first, &second);
            }
        }
    }
}

/// How many nodes `model` has once each use of a shared one is written out.
fn written_out(model: &Model) -> usize {
    let mut sizes: Vec<usize> = Vec::with_capacity(model.nodes().len());
    for node in model.nodes() {
        let size = node
            .children()
            .fold(1usize, |sum, child| sum.saturating_add(sizes[child.index()]));
        sizes.push(size);
    }
    sizes.last().copied().unwrap_or(0)
}

fn is_singular(node: &Node) -> bool {
    match node {
        Node::Transform { parent_from_child, .. } => affine::invert(parent_from_child).is_none(),
        _ => false,
    }
}

/// A node on the way to being flattened.
pub(super) struct Visit {
    id: NodeId,
    pub node_from_frame: DAffine3,
    pub space: Space,
    /// The space of its children, once they are done.
    inside: Space,
    children_done: bool,
}

impl Visit {
    fn enter(id: NodeId, node_from_frame: DAffine3, space: Space) -> Self {
        Self {
            id,
            node_from_frame,
            space,
            inside: None,
            children_done: false,
        }
    }

    /// Puts the node back, to be written after its children, which are pushed so that the first is visited first.
    fn expand(self, model: &Model, inside: Space, pending: &mut Vec<Self>) {
        let node = model.node(self.id);
        let child_from_frame = match node {
            Node::Transform { parent_from_child, .. } => parent_from_child.inverse() * self.node_from_frame,
            _ => self.node_from_frame,
        };
        pending.push(Self {
            inside,
            children_done: true,
            ..self
        });
        let children: Vec<NodeId> = node.children().collect();
        for &child in children.iter().rev() {
            pending.push(Self::enter(child, child_from_frame, inside));
        }
    }
}
