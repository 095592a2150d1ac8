//! From a target to a frame: cameras, transfer functions, lights, sampling planes, and the projectors that use them
//! (VCSG §3.3).

mod camera;
mod color;
mod light;
pub mod presets;
mod settings;
mod transfer;

pub use camera::{Camera, Lens, Projection, View};
pub use color::rgb_from_hex;
pub use light::{DepthCue, Light, Material, Shading};
pub use settings::{Mode, Settings};
pub use transfer::{ControlPoint, TransferError, TransferFunction, TransferTable};
