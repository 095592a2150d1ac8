//! The Volumetric CSG tree: what it is made of, what it evaluates to, and where it can be (VCSG §2).

mod bounds;
mod combine;
pub mod deform;
mod node;
mod prune;
mod spaces;
mod tree;

pub use combine::Operator;
pub use node::{BooleanOp, Combine, Family, Model, Node, NodeId, ValueMap, ValueRule, VolumeLeaf};
pub use prune::{Boundary, Pruned};
pub use spaces::Space;
pub use tree::{FramePlane, Leaf, Source, Step, Tree, TreeError};
