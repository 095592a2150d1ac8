//! Raw voxels without a header: the caller says what they are.

use std::path::Path;

use glam::DAffine3;

use super::budget::Budget;
use super::components::Components;
use super::error::ReadError;
use super::format::Format;
use super::nrrd_write;
use super::open::{Declared, Opened};
use super::payload::Payload;
use super::raw_guess;
use super::source::{Coding, Skip, Stretch};
use super::stored::{ByteOrder, Stored};
use super::write::Writer;
use crate::volume::grid::voxel_count;
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
        Some(layout) => Ok(vec![open(path, layout, options.budget)?]),
        None => Err(ReadError::unsupported(path, "a raw file does not say what it holds").hint(raw_guess::hint(path))),
    },
    writer: Some(Writer {
        suffixes: &[".raw"],
        writes: "the voxels as they are in memory, and a NRRD header (.nhdr) beside them that says what they are",
        files: nrrd_write::raw_files,
    }),
};

/// Opens the raw voxels in the file at `path`.
fn open(path: &Path, layout: &RawLayout, budget: Budget) -> Result<Opened, ReadError> {
    let payload = Payload {
        stored: Stored::Voxel(layout.voxel),
        order: layout.order,
        voxels: voxel_count(layout.dims).map_err(|e| ReadError::new(path, e))?,
        components: Components::SCALAR,
        rescaling: None,
    };
    let stretch = Stretch {
        path: path.to_owned(),
        start: layout.offset,
        coding: Coding::Plain,
        skip: Skip::Bytes(0),
        bytes: payload.bytes(),
    };
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
    let chunks = payload
        .chunks(path, &[stretch], 0, budget)
        .map_err(|e| e.hint("give the size, type and offset that the file has"))?;
    Opened::new(path.to_owned(), declared, chunks)
}
