//! Writing NRRD with attached header.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::GzEncoder;
use glam::DVec3;
use thiserror::Error;

use super::payload::ByteOrder;
use crate::volume::grid::{Grid, Voxels};
use crate::volume::voxel::{VoxelType, for_type};

/// How the voxels are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// As they are in memory.
    Raw,
    /// Compressed.
    Gzip,
}

/// A volume that could not be written.
#[derive(Debug, Error)]
#[error("{}: cannot be written: {source} (check the folder, its permissions and the space left)", path.display())]
pub struct WriteError {
    /// The file.
    pub path: PathBuf,
    /// What the operating system says.
    pub source: io::Error,
}

/// Writes `grid` to `path` as NRRD. The file appears there only when it is complete.
///
/// # Errors
/// The operating system's, with the file's name.
pub fn write(path: &Path, grid: &Grid, encoding: Encoding) -> Result<(), WriteError> {
    NrrdBeside::write(path, grid, encoding)?.put()
}

/// A complete file beside the place that it is for; it disappears unless it is put there.
#[derive(Debug)]
pub struct NrrdBeside {
    beside: Beside,
    path: PathBuf,
}

impl NrrdBeside {
    /// Writes `grid` beside `path`.
    ///
    /// # Errors
    /// The operating system's, with the file's name.
    pub fn write(path: &Path, grid: &Grid, encoding: Encoding) -> Result<Self, WriteError> {
        let (beside, path) = (Beside::new(path), path.to_owned());
        match write_to(&beside.0, grid, encoding) {
            Ok(()) => Ok(Self { beside, path }),
            Err(source) => Err(WriteError { path, source }),
        }
    }

    /// Puts it in its place.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn put(self) -> Result<(), WriteError> {
        fs::rename(&self.beside.0, &self.path).map_err(|source| WriteError {
            path: self.path.clone(),
            source,
        })
    }
}

/// A file beside the one to write, removed when it goes out of use; after a rename it is no longer there.
#[derive(Debug)]
struct Beside(PathBuf);

impl Beside {
    fn new(path: &Path) -> Self {
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(format!(".{}.part", std::process::id()));
        Self(path.with_file_name(name))
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        // It fails when there is none, which is what is wanted.
        let _ = fs::remove_file(&self.0);
    }
}

fn write_to(path: &Path, grid: &Grid, encoding: Encoding) -> io::Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    file.write_all(header(grid, encoding).as_bytes())?;
    let bytes: &[u8] = for_type!(Voxels, grid.voxels(), v => bytemuck::cast_slice(v));
    match encoding {
        Encoding::Raw => file.write_all(bytes)?,
        Encoding::Gzip => {
            let mut gzip = GzEncoder::new(&mut file, Compression::fast());
            gzip.write_all(bytes)?;
            gzip.finish()?;
        }
    }
    file.into_inner()?.sync_all()
}

fn header(grid: &Grid, encoding: Encoding) -> String {
    let [nx, ny, nz] = grid.dims();
    let axes = grid.world_from_index().matrix3;
    let order = match ByteOrder::NATIVE {
        ByteOrder::Little => "little",
        ByteOrder::Big => "big",
    };
    let encoding = match encoding {
        Encoding::Raw => "raw",
        Encoding::Gzip => "gzip",
    };
    format!(
        "NRRD0004\ntype: {}\ndimension: 3\nspace: left-posterior-superior\nsizes: {nx} {ny} {nz}\n\
         space directions: {} {} {}\nkinds: domain domain domain\nendian: {order}\nencoding: {encoding}\n\
         space units: \"mm\" \"mm\" \"mm\"\nspace origin: {}\n\n",
        type_name(grid.voxel_type()),
        vector(axes.x_axis),
        vector(axes.y_axis),
        vector(axes.z_axis),
        vector(grid.world_from_index().translation),
    )
}

const fn type_name(voxel: VoxelType) -> &'static str {
    match voxel {
        VoxelType::U8 => "uint8",
        VoxelType::I8 => "int8",
        VoxelType::U16 => "uint16",
        VoxelType::I16 => "int16",
        VoxelType::U32 => "uint32",
        VoxelType::I32 => "int32",
        VoxelType::F32 => "float",
        VoxelType::F64 => "double",
    }
}

/// Rust prints the shortest digits that read back as the same number.
fn vector(v: DVec3) -> String {
    format!("({:?},{:?},{:?})", v.x, v.y, v.z)
}
