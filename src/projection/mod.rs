//! From a target to a frame: cameras, transfer functions, lights, sampling planes, and the projectors that use them
//! (VCSG §3.3).

pub mod bands;
mod camera;
mod color;
pub mod composite;
mod halving;
pub mod levels;
mod light;
mod planes;
pub mod presets;
mod projector;
pub mod raycast;
pub mod reference;
mod settings;
mod shade;
mod slices;
mod table;
mod template;
pub mod trace;
mod visibility;
pub mod volume_property;

pub use crate::model::{ControlPoint, TransferError, TransferFunction};
pub use camera::{Camera, Lens, Projection, View};
pub use color::rgb_from_hex;
pub use halving::VisibleBox;
pub use light::{DepthCue, Light, Material, Shading};
pub use planes::{Planes, eye_from_lattice};
pub use projector::{FrameSpec, ProjectError, Projector};
pub use reference::Reference;
pub use settings::{Mode, Settings};
pub use shade::{EMPTY_BELOW, SoftNormals};
pub use slices::{Slice, SliceBox, SlicePlan};
pub use table::TransferTable;
pub use template::{MAX_SEGMENTS, MAX_VERTICES, MovingVertex, Segment, Template};
pub use visibility::{DrawCost, Visibility, VisibleValues};
