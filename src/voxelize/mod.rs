//! Volume-sampled primitives (WK94): geometry as density fields that are free of object-space aliasing.
//!
//! *Theory.* A primitive's density at a point is the convolution of its solid with a filter as wide as the lattice needs: 1 deep
//! inside, 0 well outside, between them near the surface.
//! *Changes from the paper.* WK94 looks densities up by feature, in tables by distance and size. Here balls, faces, edges and
//! vertices have closed forms, curved sides and
//! tips of cones a table each, and what none of them fits is integrated.
//! *Practice.* [`filter`] is the weight and its integrals; [`facet`] plane faces, [`curved`] curved ones, [`lines`] integration
//! over lines; [`Grade`] goes from one level's filter to the next; each kind of solid has a file; [`Solid`] is any of them and
//! [`Primitive`] what a model holds.

mod apex;
pub mod ball;
pub mod beams;
mod cubic;
pub mod curved;
pub mod facet;
pub mod filter;
mod grade;
pub mod lines;
pub mod mesh;
mod polyhedron;
mod primitive;
mod profile;
mod relief;
pub mod revolved;
mod screw;
mod solid;
mod thread;

pub use grade::{Footprint, Grade};
pub use mesh::{MeshError, MeshReadError, TriangleMesh, TriangleSolid};
pub use polyhedron::Polyhedron;
pub use primitive::{Placed, Primitive};
pub use profile::{Piece, Profile};
pub use relief::{Relief, RoundedBox, Waves};
pub use solid::{DistanceRange, NoInset, Solid};
pub use thread::Thread;
