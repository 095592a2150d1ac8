//! The Volumetric CSG tree: what it is made of, what it evaluates to, and where it can be (VCSG §2).

mod node;

pub use node::{
    BooleanOp, Combine, Family, Model, Node, NodeId, Plane, Shape, ValueMap, ValueRule, VolumeLeaf,
};
