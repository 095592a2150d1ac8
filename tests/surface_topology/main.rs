//! The topologically correct marching cubes gives manifolds with the topology of the trilinear interpolant.

mod cells;
mod fields;
mod geometry;
mod lattices;
mod truth;
mod weld;
