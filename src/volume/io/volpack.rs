//! VolPack's density files (.den): the classic volumes of shear-warp rendering.
//!
//! Format: VolPack 1.0's denfile.c: a version of 16 bits, 1, in the writer's byte order; smallest and largest index and length of
//! the volume scanned, of the part extracted and of the part that is here, three of 16 bits each; a count of warps; the number of
//! voxels in 32 bits; then the voxels, a byte each, x fastest.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use glam::DAffine3;

use super::components::Components;
use super::error::ReadError;
use super::format::Format;
use super::open::{Declared, Opened, ReadOptions};
use super::payload::Payload;
use super::source::{Coding, Skip, Stretch};
use super::stored::{ByteOrder, Stored};
use crate::volume::grid::voxel_count;
use crate::volume::voxel::VoxelType;

/// Bytes of the header.
const HEADER_BYTES: usize = 62;

/// Where the lengths of the part that is here are.
const LENGTHS: usize = 50;

/// Where the number of voxels is.
const COUNT: usize = 58;

/// VolPack's files among the formats.
pub(super) const FORMAT: Format = Format {
    name: "VolPack",
    suffixes: &[".den"],
    reads: "densities of 8 bits",
    recognises: |probe| !probe.is_folder && !probe.has_layout && probe.is_named(&FORMAT),
    open: |path, options| Ok(vec![open(path, options)?]),
    writer: None,
};

fn open(path: &Path, options: &ReadOptions) -> Result<Opened, ReadError> {
    let io_error = |e| ReadError::io(path, e);
    let mut file = BufReader::new(File::open(path).map_err(io_error)?);
    let mut header = Vec::new();
    (file.by_ref().take(HEADER_BYTES as u64).read_to_end(&mut header)).map_err(io_error)?;
    let order = match header[..] {
        [1, 0, ..] => ByteOrder::Little,
        [0, 1, ..] => ByteOrder::Big,
        _ => return Err(ReadError::header(path, "it is no density file: its version is not 1").byte(0)),
    };
    if header.len() < HEADER_BYTES {
        let what = format!("it has {} bytes, a header takes {HEADER_BYTES}", header.len());
        return Err(ReadError::header(path, what));
    }
    let number = |at: usize, bytes: usize| {
        let shifted = |sum: usize, byte: &u8| sum << 8 | usize::from(*byte);
        match order {
            ByteOrder::Little => header[at..at + bytes].iter().rev().fold(0, shifted),
            ByteOrder::Big => header[at..at + bytes].iter().fold(0, shifted),
        }
    };
    let dims: [usize; 3] = std::array::from_fn(|axis| number(LENGTHS + 2 * axis, 2));
    let count = voxel_count(dims).map_err(|e| ReadError::new(path, e).byte(LENGTHS as u64))?;
    if number(COUNT, 4) != count {
        let what = format!(
            "its size {dims:?} and its number of voxels, {}, differ",
            number(COUNT, 4)
        );
        return Err(ReadError::header(path, what).byte(COUNT as u64));
    }
    let payload = Payload {
        stored: Stored::Voxel(VoxelType::U8),
        order,
        voxels: count,
        components: Components::SCALAR,
        rescaling: None,
    };
    let stretch = Stretch {
        path: path.to_owned(),
        start: HEADER_BYTES as u64,
        coding: Coding::Plain,
        skip: Skip::Bytes(0),
        bytes: payload.bytes(),
    };
    let declared = Declared {
        format: FORMAT.name,
        name: String::new(),
        dims,
        voxel: VoxelType::U8,
        world_from_index: DAffine3::IDENTITY,
        frames: 1,
        components: 1,
        notes: vec!["the file gives no spacing: it is taken to be 1 mm".to_owned()],
    };
    Opened::new(
        path.to_owned(),
        declared,
        payload.chunks(path, &[stretch], 0, options.budget)?,
    )
}
