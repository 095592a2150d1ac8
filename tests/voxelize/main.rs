//! Volume-sampled primitives (WK94) against what they are defined to be.

mod cases;
mod convolution;
mod voxels;
