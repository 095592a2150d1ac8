//! Splines against VTK's, tabulated inverses against splines, and which landmarks and deformations are refused.

mod random;
mod refusals;
mod spline;
mod tables;
