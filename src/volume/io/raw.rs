//! Raw voxels without a header: the caller says what they are.

use std::fs::File;
use std::io::{BufReader, Seek, SeekFrom};
use std::path::Path;

use glam::DAffine3;

use super::error::ReadError;
use super::format::Format;
use super::open::{Declared, Opened};
use super::payload::{ByteOrder, Payload, Stored, remaining};
use crate::volume::grid::voxel_count;
use crate::volume::voxel::VoxelType;

/// Bytes of the voxels that are handed over at a time.
const CHUNK: usize = 1 << 22;

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
        None => Err(ReadError::unsupported(path, "a raw file does not say what it holds")
            .hint("give its size, voxel type and spacing, or write a NRRD header (.nhdr) beside it")),
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
    let mut left = voxel_count(layout.dims).map_err(|e| ReadError::new(path, e))?;
    let mut file = data(path, layout, left)?;
    let (of, layout) = (path.to_owned(), *layout);
    let chunks = std::iter::from_fn(move || {
        let count = left.min(CHUNK / layout.voxel.bytes());
        left -= count;
        (count > 0).then(|| payload(&of, &layout, count).decode(&mut file, count))
    });
    Opened::new(path.to_owned(), declared, Box::new(chunks))
}

/// The file, where the voxels begin, if it is long enough for all.
fn data(path: &Path, layout: &RawLayout, count: usize) -> Result<BufReader<File>, ReadError> {
    let io_error = |e| ReadError::io(path, e);
    let mut file = BufReader::new(File::open(path).map_err(io_error)?);
    file.seek(SeekFrom::Start(layout.offset)).map_err(io_error)?;
    let found = remaining(&mut file).map_err(io_error)?;
    payload(path, layout, count)
        .check(found)
        .map_err(|e| e.hint("give the size, type and offset that the file has"))?;
    Ok(file)
}

/// Some of the voxels.
fn payload<'a>(path: &'a Path, layout: &RawLayout, count: usize) -> Payload<'a> {
    Payload {
        path,
        stored: Stored::Voxel(layout.voxel),
        order: layout.order,
        count,
    }
}
