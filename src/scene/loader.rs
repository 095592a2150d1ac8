//! How a scene gets its volumes.

use std::path::PathBuf;
use std::sync::Arc;

use crate::volume::Bricks;

/// What a headerless file holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawLayout {
    /// Voxels along x, y, z; x is fastest.
    pub dims: [usize; 3],
    /// How a voxel is stored.
    pub voxel: RawVoxel,
    /// Distance between voxel centres along x, y, z, millimetres.
    pub spacing_mm: [f64; 3],
    /// Whether the most significant byte comes first.
    pub big_endian: bool,
}

/// The type of a voxel in a headerless file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RawVoxel {
    /// Unsigned 8 bit.
    U8,
    /// Signed 8 bit.
    I8,
    /// Unsigned 16 bit.
    U16,
    /// Signed 16 bit.
    I16,
    /// Unsigned 32 bit.
    U32,
    /// Signed 32 bit.
    I32,
    /// Single precision.
    F32,
    /// Double precision.
    F64,
}

/// A volume that a scene asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeRequest {
    /// The file.
    pub path: PathBuf,
    /// What it holds, when it has no header of its own.
    pub raw: Option<RawLayout>,
}

/// Reads volumes for a scene. A scene asks for each request once, however many nodes use it.
pub trait VolumeLoader {
    /// The volume that `request` names.
    ///
    /// # Errors
    /// Why it cannot be had, in words for the user; the path is added by the caller.
    fn load(&mut self, request: &VolumeRequest) -> Result<Arc<Bricks>, String>;
}

/// A loader for scenes of primitives: it has no volume.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoVolumes;

impl VolumeLoader for NoVolumes {
    fn load(&mut self, _: &VolumeRequest) -> Result<Arc<Bricks>, String> {
        Err("volumes are not available here".into())
    }
}
