//! The Volumetric CSG tree: what it is made of, what it evaluates to, and where it can be (VCSG §2).

mod bounds;
mod changes;
mod color;
mod combine;
pub mod deform;
mod flatten;
mod lut;
mod mask;
mod node;
mod pool;
mod prune;
mod rule;
mod spaces;
mod transfer;
mod tree;

pub use changes::Changes;
pub use color::{Classifier, ColorSample};
pub use combine::Operator;
pub use lut::{Lut, LutError};
pub use mask::{Admitted, MaskLeaf};
pub use node::{BooleanOp, Combine, Family, Kind, Model, Node, NodeId, ValueMap, ValueRule, VolumeLeaf};
pub use prune::{Boundary, Pruned};
pub use spaces::Space;
pub use transfer::{ControlPoint, TransferError, TransferFunction};
pub use tree::{FramePlane, Leaf, Source, Step, Tree, TreeError};
