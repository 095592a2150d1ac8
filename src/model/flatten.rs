//! How a model becomes a tree: its nodes written as steps, in post-order, with all transforms on the way composed.

use std::sync::Arc;

use glam::DAffine3;

use super::bounds::placed_bounds;
use super::spaces::Space;
use super::{
    Classifier, Combine, FramePlane, Kind, Leaf, Model, Node, NodeId, Operator, Source, Step, Tree, TreeError,
};
use crate::math::{Plane, affine};
use crate::volume::Bricks;
use crate::voxelize::{Grade, Primitive};

/// Where and how finely a model is sampled.
pub(super) struct Sampling<'a> {
    pub model: &'a Model,
    pub world_from_frame: DAffine3,
    pub voxel_mm: f64,
    /// How filters change to those of the next level, if they do.
    pub grade: Option<Grade>,
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

    /// [`Self::new`] after an edit: what is deformed as it was in `before`, a tree for the same frame, keeps its table.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn after(before: &Self, model: &Model, world_from_lattice: &DAffine3) -> Result<Self, TreeError> {
        let voxel_mm = affine::spacing(world_from_lattice).max_element();
        let mut tree = Self::outline(model, world_from_lattice, voxel_mm, None)?;
        for warp in &mut tree.warps {
            // In whichever order deformations come, and whatever they stand in.
            match before.warps.iter().find(|known| known.is_like(warp)) {
                Some(known) => warp.table = Arc::clone(&known.table),
                None => warp.tabulate()?,
            }
        }
        Ok(tree)
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
