//! Splines against VTK's, tabulated inverses against splines, and which landmarks and deformations are refused.

mod files;
mod random;
mod refusals;
mod scenes;
mod spline;
mod tables;
