//! Frames: what a projector makes, how it becomes a file, and how two are compared.

pub mod compare;
mod encode;
mod frame;

pub use encode::{EncodeError, FileFormat, encode_exr, encode_png, save};
pub use frame::{Frame, FrameSizeError, Rgba};
