//! The Volumetric CSG tree: what it is made of, what it evaluates to, and where it can be (VCSG §2).

mod bounds;
mod combine;
mod lut;
mod mask;
mod node;
mod prune;
mod rule;
mod tree;

pub use combine::Operator;
pub use lut::{Lut, LutError};
pub use mask::{Admitted, MaskLeaf};
pub use node::{BooleanOp, Combine, Family, Model, Node, NodeId, ValueMap, ValueRule, VolumeLeaf};
pub use prune::{Boundary, Pruned};
pub use tree::{FramePlane, Leaf, Source, Step, Tree, TreeError};
