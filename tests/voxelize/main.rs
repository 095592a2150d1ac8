//! Volume-sampled primitives (WK94) against what they are defined to be.

mod accuracy;
mod algebra;
mod cases;
mod convolution;
mod mesh_files;
mod mesh_scene;
mod mesh_shapes;
mod mesh_solid;
mod poses;
mod voxels;
