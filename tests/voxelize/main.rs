//! Volume-sampled primitives (WK94) against what they are defined to be.

mod algebra;
mod cases;
mod convolution;
mod poses;
mod voxels;
