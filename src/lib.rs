//! vcsg: model with volumes, see the result at once, and prove the picture is right.

#![warn(missing_docs)]

pub mod math;
pub mod model;
pub mod projection;
pub mod scene;
pub mod volume;
