//! Volume files: one module a format.

mod budget;
mod caught;
mod components;
mod dicom;
mod error;
mod files;
mod format;
mod geometry;
mod gunzip;
mod lines;
mod metaimage;
mod metaimage_header;
mod metaimage_write;
mod nifti;
mod nifti_header;
mod nifti_place;
mod nifti_write;
mod nrrd;
mod nrrd_axes;
mod nrrd_data;
mod nrrd_header;
mod nrrd_place;
mod nrrd_write;
mod open;
mod part;
mod payload;
pub mod raw;
mod raw_guess;
mod scalars;
mod slices;
mod source;
mod stored;
mod text;
mod tiff;
mod volpack;
mod vti_write;
mod vtk;
mod write;
mod zarr;

use std::path::Path;

use serde::Serialize;

pub use self::budget::Budget;
pub use self::caught::is_caught;
pub use self::error::{Position, Problem, ReadError};
pub use self::format::{FORMATS, Format, open, open_all};
pub use self::nrrd_write::write_nrrd;
pub use self::open::{Declared, Opened, ReadOptions};
pub use self::stored::ByteOrder;
pub use self::write::{Encoding, VolumeBeside, WriteError, Writer, write, writer_of};
use super::grid::Grid;
use super::voxel::VoxelType;

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// The voxels.
    pub grid: Grid,
    /// The format's name.
    pub format: &'static str,
    /// How many volumes the file holds.
    pub frames: usize,
    /// Numbers a voxel in the file, of which the grid has one, or what they are together.
    pub components: usize,
}

/// A volume's description, in ITK's conventions: LPS, millimetres, values after slope and intercept.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumeInfo {
    /// The format's name.
    pub format: &'static str,
    /// Which of the file's volumes it is; empty where there is but one.
    pub name: String,
    /// Voxels along x, y, z.
    pub dims: [usize; 3],
    /// How many volumes in time the file holds; what follows is one's.
    pub frames: usize,
    /// Numbers a voxel.
    pub components: usize,
    /// The voxels' type.
    pub voxel: VoxelType,
    /// Millimetres between voxels.
    pub spacing: [f64; 3],
    /// The first voxel's centre.
    pub origin: [f64; 3],
    /// Row-major 3 × 3 matrix whose columns are the axes' unit vectors.
    pub direction: [f64; 9],
    /// Smallest finite value; NaN (null in JSON) without any.
    pub min: f64,
    /// Largest finite value.
    pub max: f64,
    /// Mean of the finite values.
    pub mean: f64,
    /// How many voxels are NaN or infinite.
    pub non_finite: usize,
    /// What a user should know of how it was read.
    pub notes: Vec<String>,
}

/// Reads the one volume in the file at `path`; its first bytes or its suffix tell the format.
///
/// # Errors
/// Whatever [`ReadError`] can say: what is wrong, where, and what the user can do.
pub fn read(path: &Path) -> Result<Volume, ReadError> {
    read_with(path, &ReadOptions::default())
}

/// Reads the volume that `options` name in the file or folder at `path`.
///
/// # Errors
/// As [`read`], and if it holds no such volume, or several.
pub fn read_with(path: &Path, options: &ReadOptions) -> Result<Volume, ReadError> {
    let opened = open(path, options)?;
    let Declared {
        format,
        frames,
        components,
        ..
    } = *opened.declared();
    Ok(Volume {
        grid: opened.grid()?,
        format,
        frames,
        components,
    })
}
