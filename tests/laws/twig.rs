//! Trees that random edits are made on.

use glam::DVec3;
use vcsg::model::{Combine, Model, Node, NodeId, Operator};
use vcsg::voxelize::{Primitive, Solid};

/// A tree that can be edited: each node with its children, whatever the node itself says of them.
#[derive(Clone)]
pub struct Twig {
    pub node: Node,
    pub children: Vec<Twig>,
}

impl Twig {
    pub fn of(model: &Model, id: NodeId) -> Self {
        let node = model.node(id).clone();
        let children = node.children().map(|child| Self::of(model, child)).collect();
        Self { node, children }
    }

    pub fn leaf(primitive: &Primitive) -> Self {
        Self {
            node: Node::Primitive(primitive.clone()),
            children: vec![],
        }
    }

    fn push_to(&self, model: &mut Model) -> NodeId {
        let ids: Vec<NodeId> = self.children.iter().map(|child| child.push_to(model)).collect();
        let place = |child| self.node.children().position(|c| c == child).unwrap_or(0);
        // Two operands may say that they are one node, so the second is set apart.
        let mut node = self.node.with_children(|child| ids[place(child)]);
        if let Node::Combine(c) = &mut node {
            (c.first, c.second) = (ids[0], ids[1]);
        }
        model.push(node)
    }

    pub fn model(&self) -> Model {
        let mut model = Model::default();
        self.push_to(&mut model);
        model
    }

    pub fn len(&self) -> usize {
        1 + self.children.iter().map(Self::len).sum::<usize>()
    }

    /// The `n`th node, parents first.
    pub fn nth(&mut self, n: usize) -> &mut Self {
        if n == 0 {
            return self;
        }
        let mut before = 1;
        for child in &mut self.children {
            let len = child.len();
            if n < before + len {
                return child.nth(n - before);
            }
            before += len;
        }
        unreachable!("fewer nodes than {n}")
    }

    pub fn combined(operator: Operator, first: Self, second: Self) -> Self {
        // Children stand beside the node; which ids it says does not matter.
        let mut model = Model::default();
        let id = model.push(second.node.with_children(|child| child).leafless());
        let Operator { op, rule, family } = operator;
        let node = Node::Combine(Combine {
            op,
            rule,
            family,
            first: id,
            second: id,
        });
        Self {
            node,
            children: vec![first, second],
        }
    }
}

/// A stand-in that can be pushed into an empty model.
pub trait Leafless {
    fn leafless(self) -> Node;
}

impl Leafless for Node {
    fn leafless(self) -> Node {
        let solid = Solid::Sphere {
            center: DVec3::ZERO,
            radius: 1.0,
        };
        Node::Primitive(Primitive::crisp(solid, 0.0))
    }
}
