//! From a target to a frame: cameras, transfer functions, lights, sampling planes, and the projectors that use them
//! (VCSG §3.3).

pub mod bands;
mod camera;
mod color;
pub mod composite;
pub mod levels;
mod light;
mod open;
mod planes;
pub mod presets;
mod projector;
pub mod raycast;
pub mod reference;
mod settings;
mod shade;
mod shown;
mod slices;
mod slopes;
mod split;
mod table;
mod template;
pub mod trace;
mod visibility;
pub mod volume_property;
mod zones;

pub use crate::model::{ControlPoint, TransferError, TransferFunction};
pub use camera::{Camera, Lens, Projection, View};
pub use color::rgb_from_hex;
pub use light::{DepthCue, Light, Material, Shading};
pub use open::{BoxView, OpenTiles, Remaining};
pub use planes::{Planes, eye_from_lattice};
pub use projector::{FrameSpec, ProjectError, Projector};
pub use reference::Reference;
pub use settings::{Mode, Settings};
pub use shade::{EMPTY_BELOW, SoftNormals};
pub use shown::ShownCells;
pub use slices::{Planner, Slice, SliceBox, SlicePlan};
pub use slopes::{Slopes, half_differences};
pub use split::VisibleBox;
pub use table::TransferTable;
pub use template::{MAX_SEGMENTS, MAX_VERTICES, MovingVertex, Segment, Template};
pub use visibility::{DrawCost, Visibility, VisibleValues};
pub use zones::{DrawLevelsError, LevelsFrame, LevelsSpec, ZoneDrawn, ZonePicture};
