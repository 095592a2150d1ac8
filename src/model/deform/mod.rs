//! Deformation by landmarks (VCSG §2.2): a smooth map that takes source landmarks to target landmarks, evaluated through its
//! inverse.
//!
//! *Theory.* A scattered-data interpolant of the landmarks' movements is a globally smooth morphing function φ. What is at P
//! after it is what was at φ⁻¹(P); for the density of a soft surface too, so a stretched surface is as much softer as it is
//! stretched.
//! *Changes from the paper.* φ⁻¹ is not interpolated in the target's blocks but in an octree of its own ([`Table`]), anchored in
//! the target's lattice: a sample's bits then do not depend on the block it is computed in. φ is proven to be one to one
//! within what is deformed before anything is drawn; boxes are conservative where the paper samples faces.
//! *Practice.* Normals come from the samples of the target, which are where φ put them, so they need no Jacobian.

mod bound;
mod build;
pub mod files;
mod fit;
mod invert;
mod landmarks;
mod morph;
mod radial;
mod spline;
mod table;
mod warp;

pub use landmarks::{Landmark, Smoothness, SplineError};
pub use morph::{Fold, Morph};
pub use spline::Spline;
pub use table::{Points, Region, Table};
pub(super) use warp::{Frame, Warp};
pub use warp::{WarpError, WarpReport};
