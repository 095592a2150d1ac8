//! Volume files: one module a format.

mod error;
mod geometry;
mod gunzip;
pub mod nifti;
pub mod nrrd;
mod nrrd_header;
mod nrrd_write;
mod payload;
pub mod raw;

use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde::Serialize;

pub use self::error::{Position, Problem, ReadError};
pub use self::nrrd_write::{Encoding, NrrdBeside, WriteError, write as write_nrrd};
pub use self::payload::ByteOrder;
use super::grid::Grid;
use super::voxel::VoxelType;
use crate::math::affine;

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// The voxels; of a series, the first frame's.
    pub grid: Grid,
    /// The format's name.
    pub format: &'static str,
    /// How many volumes the file holds.
    pub frames: usize,
    /// Numbers a voxel; the readers take one.
    pub components: usize,
}

/// A volume's description, in ITK's conventions: LPS, millimetres, values after slope and intercept.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumeInfo {
    /// The format's name.
    pub format: &'static str,
    /// Voxels along x, y, z.
    pub dims: [usize; 3],
    /// How many volumes the file holds; what follows is the first one's.
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
}

impl Volume {
    /// Its description.
    pub fn info(&self) -> VolumeInfo {
        let world_from_index = self.grid.world_from_index();
        let spacing = affine::spacing(world_from_index);
        let axes = world_from_index.matrix3.transpose();
        let stats = self.grid.stats();
        let rows = [axes.x_axis, axes.y_axis, axes.z_axis].map(|row| (row / spacing).to_array());
        VolumeInfo {
            format: self.format,
            dims: self.grid.dims(),
            frames: self.frames,
            components: self.components,
            voxel: self.grid.voxel_type(),
            spacing: spacing.to_array(),
            origin: world_from_index.translation.to_array(),
            direction: std::array::from_fn(|i| rows[i / 3][i % 3]),
            min: stats.min,
            max: stats.max,
            mean: stats.mean,
            non_finite: stats.non_finite,
        }
    }
}

/// Suffixes of volume formats that are known, and not read.
const NOT_READ: [(&str, &str); 11] = [
    (".mha", "MetaImage"),
    (".mhd", "MetaImage"),
    (".dcm", "DICOM"),
    (".vti", "VTK XML"),
    (".vtk", "VTK legacy"),
    (".tif", "TIFF"),
    (".tiff", "TIFF"),
    (".zarr", "Zarr"),
    (".h5", "HDF5"),
    (".npy", "NumPy"),
    (".npz", "NumPy"),
];

/// Suffixes of NIfTI-1 files.
const NIFTI: [&str; 6] = [".nii", ".nii.gz", ".hdr", ".hdr.gz", ".img", ".img.gz"];

/// Reads the volume file at `path`; its first bytes or its suffix tell the format.
///
/// # Errors
/// Whatever [`ReadError`] can say: what is wrong, where, and what the user can do.
pub fn read(path: &Path) -> Result<Volume, ReadError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let name = name.to_ascii_lowercase();
    if path.is_dir() {
        return Err(ReadError::unsupported(path, "folders of slices are not supported yet"));
    }
    let start = first_bytes(path).map_err(|e| ReadError::io(path, e))?;
    if start.starts_with(b"NRRD") || name.ends_with(".nrrd") || name.ends_with(".nhdr") {
        return nrrd::read(path);
    }
    if NIFTI.iter().any(|suffix| name.ends_with(suffix)) {
        return nifti::read(path);
    }
    Err(unknown(path, &name))
}

fn first_bytes(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut start = Vec::new();
    File::open(path)?.take(8).read_to_end(&mut start)?;
    Ok(start)
}

/// The error for a file of another format.
fn unknown(path: &Path, name: &str) -> ReadError {
    let known = NOT_READ.iter().find(|(suffix, _)| name.ends_with(suffix));
    match known {
        Some((_, format)) => ReadError::unsupported(path, format!("{format} files are not supported yet")),
        None if name.ends_with(".raw") => ReadError::unsupported(path, "a raw file does not say what it holds")
            .hint("give its size, voxel type and spacing, or write a NRRD header (.nhdr) beside it"),
        None => ReadError::unsupported(path, "it is no volume file that is known"),
    }
}
