//! Boxes, intervals and affine maps: the arithmetic that every later module shares.
//!
//! Positions are `f64`, values are `f32`. A transform is named destination-from-source (`world_from_index`), so that a
//! product can be checked by reading it.

mod aabb;
pub mod affine;
mod interval;
mod plane;
pub mod quadrature;
mod viewpoint;

pub use aabb::{Aabb, Overlap};
pub use interval::Interval;
pub use plane::{Plane, linear};
pub use viewpoint::Viewpoint;
