//! Volume-sampled primitives (WK94) against what they are defined to be.

mod accuracy;
mod cases;
mod convolution;
mod voxels;
