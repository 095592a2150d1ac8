//! The tree's nodes, stored flat with children before parents.
//!
//! *Theory.* A VCSG model is a tree: leaves are volumes, inner nodes are unary (transform, transfer, cut) and binary
//! (union, intersection, subtraction) operations (VCSG §2.1–2.3).
//! *Changes from the paper.* Leaves may also be geometric primitives (WK94), and every sample has a coverage beside its
//! value (design §3), so that crisp and soft objects obey the same rules.
//! *Practice.* Nodes live in one vector in post-order. Every pass over the tree is a loop, so neither a deep chain nor a
//! union of 100,000 parts can exhaust the call stack.

use std::sync::Arc;

use glam::DAffine3;

use super::deform::Morph;
use super::{Lut, MaskLeaf, TransferFunction};
use crate::math::{Interval, Plane};
use crate::volume::Bricks;
use crate::voxelize::Primitive;

/// The place of a node in its [`Model`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(u32);

impl NodeId {
    /// The index into [`Model::nodes`].
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A function of one value (VCSG §2.2, *transfering*).
#[derive(Clone, Debug, PartialEq)]
pub enum ValueMap {
    /// `scale · v + offset`.
    Linear {
        /// Factor.
        scale: f32,
        /// Summand.
        offset: f32,
    },
    /// `a · v² + b · v + c`.
    Quadratic {
        /// Coefficient of v².
        a: f32,
        /// Coefficient of v.
        b: f32,
        /// Constant.
        c: f32,
    },
    /// Linear interpolation between `(input, output)` points of strictly rising input, constant beyond both ends.
    Table(Arc<[(f32, f32)]>),
}

/// Which set operation a [`Combine`] node does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BooleanOp {
    /// Either.
    Union,
    /// Both.
    Intersection,
    /// The first without the second.
    Subtraction,
    /// VCSG's general subtraction: the first keeps its extent, and takes `u` where the second overlaps it.
    SubtractionWithRule,
}

/// How coverages combine (design §3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Family {
    /// `max`, `min`: A ∪ A = A.
    #[default]
    MinMax,
    /// `c₁+c₂−c₁c₂`, `c₁c₂`: continuous where soft regions meet (WK94).
    Product,
}

/// The binary mapping function `u(v₁, v₂)` of VCSG §2.3, used where both operands are present.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum ValueRule {
    /// v₁.
    #[default]
    First,
    /// v₂.
    Second,
    /// The larger.
    Max,
    /// The smaller.
    Min,
    /// v₁ + v₂.
    Sum,
    /// v₁ − v₂.
    Difference,
    /// v₁ · v₂.
    Product,
    /// (v₁ + v₂) / 2.
    Average,
    /// t·v₁ + (1−t)·v₂ with t in [0, 1].
    Blend(f32),
    /// v₁ + v₂ − v₁·v₂: WK94's union of densities, as values.
    AlgebraicSum,
    /// |v₁ − v₂|.
    AbsoluteDifference,
    /// v₁ / v₂, as IEEE 754 has it where v₂ is 0.
    Quotient,
    /// Looked up.
    Table(Arc<Lut>),
    /// Of colours (Porter and Duff): the first over the second. Of values, as of opacities, v₁ + v₂·(1−v₁).
    Over,
    /// Of colours: their sum, at most 1.
    Plus,
    /// Of colours: the first where the second is opaque.
    In,
    /// Of colours: the first where the second lets through.
    Out,
    /// Of colours: the first over the second, where the second is opaque.
    Atop,
    /// Of colours: each where the other lets through.
    Xor,
}

/// What a node's samples are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Numbers.
    Value,
    /// Colours with opacity.
    Color,
}

/// A volume as a leaf.
#[derive(Clone, Debug)]
pub struct VolumeLeaf {
    /// The data; shared by all leaves that use it.
    pub bricks: Arc<Bricks>,
    /// VCSG's S: the leaf exists only where its interpolated value lies in this window.
    pub window: Interval,
}

/// A binary node.
#[derive(Clone, Debug, PartialEq)]
pub struct Combine {
    /// The set operation.
    pub op: BooleanOp,
    /// What the value is where both operands are.
    pub rule: ValueRule,
    /// How coverages combine.
    pub family: Family,
    /// First operand.
    pub first: NodeId,
    /// Second operand.
    pub second: NodeId,
}

impl Combine {
    /// Whether values are those of the first operand, and only the second one's shape counts.
    pub fn uses_first_alone(&self) -> bool {
        match self.op {
            BooleanOp::Subtraction => true,
            BooleanOp::Intersection => self.rule == ValueRule::First,
            BooleanOp::Union | BooleanOp::SubtractionWithRule => false,
        }
    }
}

/// One node of the tree.
#[derive(Clone, Debug)]
pub enum Node {
    /// A scan.
    Volume(VolumeLeaf),
    /// Where the voxels of a mask say.
    Mask(MaskLeaf),
    /// A geometric primitive.
    Primitive(Primitive),
    /// The child moved by an invertible affine map, mirror and shear included.
    Transform {
        /// What is moved.
        child: NodeId,
        /// Where it goes.
        parent_from_child: DAffine3,
    },
    /// The child deformed (VCSG §2.2, *deformation*).
    Deform {
        /// What is deformed.
        child: NodeId,
        /// How.
        morph: Arc<Morph>,
        /// What samples may be displaced by where the morph is interpolated, in voxels of the target.
        error_voxels: f64,
    },
    /// The child with its values mapped.
    Transfer {
        /// Whose values.
        child: NodeId,
        /// The mapping.
        map: ValueMap,
    },
    /// The child with its values as colours: *classify then combine*.
    Classify {
        /// Whose values.
        child: NodeId,
        /// Values to colour and opacity.
        transfer: Arc<TransferFunction>,
    },
    /// The child on the kept side of a plane.
    Cut {
        /// What is cut.
        child: NodeId,
        /// The plane.
        plane: Plane,
    },
    /// Two children combined.
    Combine(Combine),
}

impl Node {
    /// The node's children, first operand first.
    pub fn children(&self) -> impl Iterator<Item = NodeId> {
        let (first, second) = match self {
            Self::Volume(_) | Self::Mask(_) | Self::Primitive(_) => (None, None),
            Self::Transform { child, .. }
            | Self::Deform { child, .. }
            | Self::Transfer { child, .. }
            | Self::Classify { child, .. }
            | Self::Cut { child, .. } => (Some(*child), None),
            Self::Combine(c) => (Some(c.first), Some(c.second)),
        };
        first.into_iter().chain(second)
    }

    /// The same node with each child replaced by what `new` gives for it.
    pub fn with_children(&self, new: impl Fn(NodeId) -> NodeId) -> Self {
        let mut node = self.clone();
        match &mut node {
            Self::Volume(_) | Self::Mask(_) | Self::Primitive(_) => {}
            Self::Transform { child, .. }
            | Self::Deform { child, .. }
            | Self::Transfer { child, .. }
            | Self::Classify { child, .. }
            | Self::Cut { child, .. } => *child = new(*child),
            Self::Combine(c) => (c.first, c.second) = (new(c.first), new(c.second)),
        }
        node
    }
}

/// A VCSG tree (or, where a node has two parents, a directed acyclic graph): nodes in post-order, the last one the root.
///
/// ```
/// use vcsg::model::{Model, Node};
/// use vcsg::voxelize::{Primitive, Solid};
/// use glam::DVec3;
///
/// let mut model = Model::default();
/// let solid = Solid::Sphere { center: DVec3::ZERO, radius: 10.0 };
/// let ball = model.push(Node::Primitive(Primitive::soft(solid, 100.0)));
/// assert_eq!(model.root(), Some(ball));
/// ```
#[derive(Clone, Debug, Default)]
pub struct Model {
    nodes: Vec<Node>,
    kinds: Vec<Kind>,
}

impl Model {
    /// Adds a node, which becomes the root.
    ///
    /// # Panics
    /// If a child is not yet in the model: children come before their parents.
    pub fn push(&mut self, node: Node) -> NodeId {
        let id = NodeId(u32::try_from(self.nodes.len()).expect("at most 2^32 nodes"));
        for child in node.children() {
            assert!(child < id, "child {child:?} must precede its parent {id:?}");
        }
        self.kinds.push(self.kind_of(&node));
        self.nodes.push(node);
        id
    }

    /// What `node`'s samples are: what its first child's are, unless it classifies.
    fn kind_of(&self, node: &Node) -> Kind {
        match node {
            Node::Classify { .. } => Kind::Color,
            _ => node.children().next().map_or(Kind::Value, |first| self.kind(first)),
        }
    }

    /// What the samples of the node at `id` are.
    pub fn kind(&self, id: NodeId) -> Kind {
        self.kinds[id.index()]
    }

    /// What the model's samples are; `None` when it is empty.
    pub fn kind_of_root(&self) -> Option<Kind> {
        self.root().map(|root| self.kind(root))
    }

    /// Whether the node at `id` is given what it can use: values where it maps or classifies them, and where it combines, values and
    /// values or colours and colours by a rule for them. Where only the shape of the second operand counts, it may be of either kind.
    pub fn is_well_typed(&self, id: NodeId) -> bool {
        match self.node(id) {
            Node::Transfer { child, .. } | Node::Classify { child, .. } => self.kind(*child) == Kind::Value,
            Node::Combine(c) => {
                let kind = self.kind(c.first);
                c.uses_first_alone() || (kind == self.kind(c.second) && c.rule.is_for(kind))
            }
            _ => true,
        }
    }

    /// The length that opacities of this model's colours hold for, millimetres: the shortest that a transfer function of a
    /// classifying node states; `None` where none does.
    pub fn color_unit_mm(&self) -> Option<f64> {
        let unit = |node: &Node| match node {
            Node::Classify { transfer, .. } => Some(transfer.unit_mm()),
            _ => None,
        };
        self.nodes.iter().filter_map(unit).reduce(f64::min)
    }

    /// Folds `operands` from the left with one operation: `((a op b) op c) …`; `None` when there are none.
    pub fn fold(
        &mut self,
        op: BooleanOp,
        rule: ValueRule,
        family: Family,
        operands: impl IntoIterator<Item = NodeId>,
    ) -> Option<NodeId> {
        operands.into_iter().reduce(|first, second| {
            self.push(Node::Combine(Combine {
                op,
                rule: rule.clone(),
                family,
                first,
                second,
            }))
        })
    }

    /// All nodes, children before parents.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The places of all nodes, children before parents.
    pub fn ids(&self) -> impl Iterator<Item = NodeId> {
        (0..self.nodes.len() as u32).map(NodeId)
    }

    /// The node at `id`.
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.index()]
    }

    /// The part of the model that `root` is made of, with nodes in the same order and `root` last.
    ///
    /// # Panics
    /// If `root` is not in the model.
    pub fn rooted_at(&self, root: NodeId) -> Self {
        let mut wanted = vec![false; root.index() + 1];
        wanted[root.index()] = true;
        for id in (0..wanted.len()).rev() {
            if wanted[id] {
                self.nodes[id].children().for_each(|child| wanted[child.index()] = true);
            }
        }
        let mut part = Self::default();
        let mut moved = vec![root; wanted.len()];
        for id in (0..wanted.len()).filter(|&id| wanted[id]) {
            moved[id] = part.push(self.nodes[id].with_children(|child| moved[child.index()]));
        }
        part
    }

    /// The union of several models: it is wherever any of them is.
    pub fn united(models: &[Self]) -> Self {
        let mut all = Self::default();
        let mut roots = Vec::new();
        for model in models {
            let before = all.nodes.len() as u32;
            for node in &model.nodes {
                all.push(node.with_children(|child| NodeId(child.0 + before)));
            }
            roots.extend(model.root().and(all.root()));
        }
        all.fold(BooleanOp::Union, ValueRule::First, Family::default(), roots);
        all
    }

    /// The node that the model is; `None` when it is empty.
    pub fn root(&self) -> Option<NodeId> {
        let last = self.nodes.len().checked_sub(1)?;
        Some(NodeId(last as u32))
    }
}
