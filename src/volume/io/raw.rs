//! Raw voxels without a header: the caller says what they are.

use std::fs::File;
use std::io::{BufReader, Seek, SeekFrom};
use std::path::Path;

use glam::DAffine3;

use super::Volume;
use super::error::ReadError;
use super::payload::{ByteOrder, Payload, Stored};
use crate::volume::grid::{Grid, voxel_count};
use crate::volume::voxel::VoxelType;

/// What a file of raw voxels does not say itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawLayout {
    /// Voxels along x (fastest), y, z.
    pub dims: [usize; 3],
    /// The voxels' type.
    pub voxel: VoxelType,
    /// The voxels' byte order.
    pub order: ByteOrder,
    /// Bytes before the first voxel.
    pub offset: u64,
    /// World LPS millimetres of a voxel's index.
    pub world_from_index: DAffine3,
}

/// Reads the raw voxels in the file at `path`.
///
/// # Errors
/// Whatever [`ReadError`] can say; among it that the file is too short for the layout.
pub fn read(path: &Path, layout: &RawLayout) -> Result<Volume, ReadError> {
    let io_error = |e| ReadError::io(path, e);
    let payload = Payload {
        path,
        stored: Stored::Voxel(layout.voxel),
        order: layout.order,
        count: voxel_count(layout.dims).map_err(|e| ReadError::new(path, e))?,
    };
    let mut file = BufReader::new(File::open(path).map_err(io_error)?);
    file.seek(SeekFrom::Start(layout.offset)).map_err(io_error)?;
    let voxels = payload
        .read_raw(&mut file)
        .map_err(|e| e.hint("give the size, type and offset that the file has"))?;
    let grid = Grid::new(layout.dims, layout.world_from_index, voxels).map_err(|e| ReadError::new(path, e))?;
    Ok(Volume {
        grid,
        format: "raw",
        frames: 1,
        components: 1,
    })
}
