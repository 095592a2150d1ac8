//! MetaImage, in one file (.mha) or with its voxels in others (.mhd).
//!
//! Format: MetaIO's documentation, and where it is silent what ITK's reader does. `TransformMatrix` has the axes' directions one
//! after the other: it is the transpose of what ITK calls the direction.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use glam::{DAffine3, DVec3};

use super::components::Components;
use super::error::ReadError;
use super::files;
use super::format::Format;
use super::geometry::{from_axes, millimetres};
use super::metaimage_header::Header;
use super::metaimage_write;
use super::open::{Declared, Opened, ReadOptions};
use super::payload::{Payload, chosen_frame};
use super::source::{Coding, Skip, Stretch};
use super::stored::{ByteOrder, Stored};
use crate::volume::grid::voxel_count;
use crate::volume::voxel::VoxelType;

/// The most dimensions.
const MAX_DIMENSIONS: usize = 10;

/// MetaImage among the formats.
pub(super) const FORMAT: Format = Format {
    name: "MetaImage",
    suffixes: &[".mha", ".mhd"],
    reads: "one file or many, by list or pattern; raw, zlib and text; components; frames",
    recognises: |probe| probe.start.starts_with(b"ObjectType = Image") || probe.is_named(&FORMAT),
    open: |path, options| Ok(vec![open(path, options)?]),
    writer: Some(metaimage_write::WRITER),
};

/// Opens the MetaImage at `path`.
fn open(path: &Path, options: &ReadOptions) -> Result<Opened, ReadError> {
    let file = File::open(path).map_err(|e| ReadError::io(path, e))?;
    let header = Header::read(path, BufReader::new(file))?;
    let sizes = sizes(&header)?;
    let size = |axis: usize| sizes.get(axis).copied().unwrap_or(1);
    let dims = [size(0), size(1), size(2)];
    let frames = (3..sizes.len()).fold(1, |n: usize, axis| n.saturating_mul(size(axis)));
    let frame = chosen_frame(path, frames, options)?;
    let components = components(path, &header, options)?;
    let payload = Payload {
        stored: stored(&header)?,
        order: byte_order(&header),
        voxels: voxel_count(dims).map_err(|e| ReadError::new(path, e))?,
        components,
        rescaling: None,
    };
    let declared = Declared {
        format: FORMAT.name,
        name: String::new(),
        dims,
        voxel: payload.voxel(),
        world_from_index: world_from_index(&header, sizes.len())?,
        frames,
        components: components.count(),
        notes: components.note(payload.stored).into_iter().collect(),
    };
    let stretches = stretches(path, &header, &payload, &sizes)?;
    Opened::new(
        path.to_owned(),
        declared,
        payload.chunks(path, &stretches, frame, options.budget)?,
    )
}

/// Voxels along each axis.
fn sizes(header: &Header) -> Result<Vec<usize>, ReadError> {
    let count = header.number("NDims")?.unwrap_or(0);
    if !(1..=MAX_DIMENSIONS).contains(&count) {
        return Err(header.bad("NDims", "the header does not say how many dimensions it has (`NDims`)"));
    }
    let sizes: Option<Vec<usize>> = header.numbers(&["DimSize"], count)?;
    match sizes {
        Some(sizes) if sizes.contains(&0) => Err(header.bad("DimSize", "an axis cannot have no voxels")),
        Some(sizes) => Ok(sizes),
        None => Err(header.bad("DimSize", "the header has no `DimSize`")),
    }
}

fn components(path: &Path, header: &Header, options: &ReadOptions) -> Result<Components, ReadError> {
    let count = header.number("ElementNumberOfChannels")?.unwrap_or(1);
    if count == 0 {
        let what = "a voxel cannot have no components";
        return Err(header.bad("ElementNumberOfChannels", what));
    }
    Components::new(path, count, options.component)
}

/// The scalars' type. A long is of 32 bits, as MetaIO has it.
fn stored(header: &Header) -> Result<Stored, ReadError> {
    let name = header.get("ElementType").unwrap_or_default();
    let scalar = name.strip_suffix("_ARRAY").unwrap_or(name);
    Ok(match scalar {
        "MET_CHAR" => Stored::Voxel(VoxelType::I8),
        "MET_UCHAR" => Stored::Voxel(VoxelType::U8),
        "MET_SHORT" => Stored::Voxel(VoxelType::I16),
        "MET_USHORT" => Stored::Voxel(VoxelType::U16),
        "MET_INT" | "MET_LONG" => Stored::Voxel(VoxelType::I32),
        "MET_UINT" | "MET_ULONG" => Stored::Voxel(VoxelType::U32),
        "MET_LONG_LONG" => Stored::I64,
        "MET_ULONG_LONG" => Stored::U64,
        "MET_FLOAT" => Stored::Voxel(VoxelType::F32),
        "MET_DOUBLE" => Stored::Voxel(VoxelType::F64),
        _ => return Err(header.bad("ElementType", format!("`{name}` is no type of voxels"))),
    })
}

fn is_text(header: &Header) -> bool {
    header.get("BinaryData").is_some() && !header.is_true("BinaryData")
}

fn byte_order(header: &Header) -> ByteOrder {
    let keys = ["BinaryDataByteOrderMSB", "ElementByteOrderMSB"];
    match keys.iter().any(|key| header.is_true(key)) {
        _ if is_text(header) => ByteOrder::NATIVE,
        true => ByteOrder::Big,
        false => ByteOrder::Little,
    }
}

/// Where the header puts the voxels, of which the axes beyond the third are left out.
fn world_from_index(header: &Header, dimensions: usize) -> Result<DAffine3, ReadError> {
    let spacing: Option<Vec<f64>> = header.numbers(&["ElementSpacing", "ElementSize"], dimensions)?;
    let origin: Option<Vec<f64>> = header.numbers(&["Offset", "Position", "Origin"], dimensions)?;
    let keys = ["TransformMatrix", "Orientation", "Rotation"];
    let matrix: Option<Vec<f64>> = header.numbers(&keys, dimensions * dimensions)?;
    let entry = |axis: usize, along: usize| match &matrix {
        Some(matrix) if axis.max(along) < dimensions => matrix[axis * dimensions + along],
        _ => f64::from(u8::from(axis == along)),
    };
    let at = |numbers: &Option<Vec<f64>>, axis: usize| numbers.as_ref().and_then(|n| n.get(axis)).copied();
    let column = |axis: usize| {
        let size = at(&spacing, axis).filter(|size| *size != 0.0).unwrap_or(1.0);
        let direction = DVec3::new(entry(axis, 0), entry(axis, 1), entry(axis, 2));
        (axis < dimensions).then_some(direction * size)
    };
    let origin = DVec3::from_array(std::array::from_fn(|axis| at(&origin, axis).unwrap_or(0.0)));
    let scale = millimetres(header.get("DistanceUnits").unwrap_or("mm"));
    Ok(DAffine3::from_scale(DVec3::splat(scale)) * from_axes(std::array::from_fn(column), origin))
}

/// Where the voxels lie.
fn stretches(path: &Path, header: &Header, payload: &Payload, sizes: &[usize]) -> Result<Vec<Stretch>, ReadError> {
    let frames = (3..sizes.len()).fold(1, |n: u64, axis| n.saturating_mul(sizes[axis] as u64));
    let bytes = payload.bytes().saturating_mul(frames);
    let files = data_files(path, header)?;
    let count = files.len() as u64;
    if count == 0 || !bytes.is_multiple_of(count) {
        let what = format!("{bytes} bytes of voxels cannot be spread evenly over {count} files");
        return Err(ReadError::header(path, what));
    }
    let coding = match (is_text(header), header.is_true("CompressedData")) {
        (true, _) => Coding::Numbers(payload.stored),
        (false, true) => Coding::Deflate,
        (false, false) => Coding::Plain,
    };
    let local = if header.data == "LOCAL" { header.end } else { 0 };
    let (start, skip) = match header.number("HeaderSize")?.unwrap_or(0_i64) {
        // The text of its own header cannot be voxels.
        size @ 0.. => (local.max(size as u64), Skip::Bytes(0)),
        -1 => (local, Skip::AllBefore),
        size => return Err(header.bad("HeaderSize", format!("a header cannot have {size} bytes"))),
    };
    let stretch = |path: PathBuf| {
        if !path.is_file() {
            let what = "the data file that the header names is not there";
            return Err(ReadError::header(&path, what).hint("the header's `ElementDataFile` names it: put it there"));
        }
        Ok(Stretch {
            path,
            start,
            coding,
            skip,
            bytes: bytes / count,
        })
    };
    files.into_iter().map(stretch).collect()
}

/// The files that hold the voxels, one after the other.
fn data_files(path: &Path, header: &Header) -> Result<Vec<PathBuf>, ReadError> {
    let folder = path.with_file_name("");
    let words: Vec<&str> = header.data.split_ascii_whitespace().collect();
    let names = match words[..] {
        ["LOCAL"] => return Ok(vec![path.to_owned()]),
        ["LIST", ..] => header.list.clone(),
        [pattern, ref range @ ..] if pattern.contains('%') => {
            let numbers: Option<Vec<i64>> = range.iter().map(|word| word.parse().ok()).collect();
            let names = match numbers.as_deref() {
                Some([first, last]) => files::numbered(pattern, *first, *last, 1),
                Some([first, last, step]) => files::numbered(pattern, *first, *last, *step),
                _ => None,
            };
            let what = || format!("`{}` is no pattern of file names and its numbers", header.data);
            names.ok_or_else(|| ReadError::header(path, what()))?
        }
        _ => vec![header.data.clone()],
    };
    Ok(names.iter().map(|name| folder.join(name)).collect())
}
