//! Raw voxels without a header: the caller says what they are.

use std::fs::File;
use std::io::{BufReader, Seek, SeekFrom};
use std::path::Path;

use glam::DAffine3;

use super::error::ReadError;
use super::format::Format;
use super::open::{Declared, Opened};
use super::payload::{ByteOrder, Payload, Stored};
use super::raw_guess;
use crate::volume::grid::{Voxels, voxel_count};
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

/// Raw files among the formats.
pub(super) const FORMAT: Format = Format {
    name: "raw",
    suffixes: &[".raw", ".bin", ".img"],
    reads: "voxels whose size, type and spacing the user says",
    recognises: |probe| !probe.is_folder && (probe.has_layout || probe.is_named(&FORMAT)),
    open: |path, options| match &options.raw {
        Some(layout) => Ok(vec![open(path, layout)?]),
        None => Err(ReadError::unsupported(path, "a raw file does not say what it holds").hint(raw_guess::hint(path))),
    },
};

/// Opens the raw voxels in the file at `path`.
fn open(path: &Path, layout: &RawLayout) -> Result<Opened, ReadError> {
    let declared = Declared {
        format: FORMAT.name,
        name: String::new(),
        dims: layout.dims,
        voxel: layout.voxel,
        world_from_index: layout.world_from_index,
        frames: 1,
        components: 1,
        notes: Vec::new(),
    };
    let (path, layout) = (path.to_owned(), *layout);
    Opened::at_once(path.clone(), declared, move || read(&path, &layout))
}

fn read(path: &Path, layout: &RawLayout) -> Result<Voxels, ReadError> {
    let io_error = |e| ReadError::io(path, e);
    let payload = Payload {
        path,
        stored: Stored::Voxel(layout.voxel),
        order: layout.order,
        count: voxel_count(layout.dims).map_err(|e| ReadError::new(path, e))?,
    };
    let mut file = BufReader::new(File::open(path).map_err(io_error)?);
    file.seek(SeekFrom::Start(layout.offset)).map_err(io_error)?;
    payload
        .read_raw(&mut file)
        .map_err(|e| e.hint("give the size, type and offset that the file has"))
}
