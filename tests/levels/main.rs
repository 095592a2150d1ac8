//! The multiresolution hierarchy (WK94, figures 6 and 7): zones of depth, densities between levels, frames of several levels.

mod blend;
mod frames;
mod parts;
mod row;
mod trees;
mod zones;
