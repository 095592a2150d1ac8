//! Presets on real data and against the landmarks of tissues, and 3D Slicer's volume properties against VTK.

mod document;
mod landmarks;
mod pictures;
mod properties;
mod refusals;
