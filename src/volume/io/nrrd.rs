//! NRRD, with attached or detached header, raw, gzip or text.
//!
//! Format: teem's "Definition of NRRD File Format" (NRRD0001 to NRRD0005).

use std::fs::File;
use std::io::{self, BufRead, BufReader, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use glam::{DAffine3, DVec3};

use super::error::{Problem, ReadError};
use super::format::Format;
use super::geometry::{LPS_FROM_LAS, LPS_FROM_RAS, from_axes, millimetres};
use super::gunzip::Gunzip;
use super::nrrd_header::Header;
use super::open::{Declared, Opened, ReadOptions};
use super::payload::{ByteOrder, Payload, Stored, remaining};
use crate::volume::grid::{Voxels, voxel_count};
use crate::volume::voxel::VoxelType;

/// Kinds of axes along which voxels follow each other in space; other kinds are components or frames.
const SPATIAL_KINDS: [&str; 4] = ["domain", "space", "???", "none"];

/// Kinds of a slowest axis that counts volumes.
const FRAME_KINDS: [&str; 6] = ["time", "list", "domain", "space", "???", "none"];

/// NRRD among the formats.
pub(super) const FORMAT: Format = Format {
    name: "NRRD",
    suffixes: &[".nrrd", ".nhdr"],
    reads: "attached and detached headers; raw, gzip and text",
    recognises: |probe| probe.start.starts_with(b"NRRD") || probe.is_named(&FORMAT),
    open: |path, options| Ok(vec![open(path, options)?]),
};

/// Opens the NRRD file, or the detached header, at `path`.
fn open(path: &Path, _options: &ReadOptions) -> Result<Opened, ReadError> {
    let file = File::open(path).map_err(|e| ReadError::io(path, e))?;
    let mut file = BufReader::new(file);
    let header = Header::read(path, &mut file)?;
    let axes = Axes::new(path, &header)?;
    let count = voxel_count(axes.dims).map_err(|e| ReadError::new(path, e))?;
    let declared = Declared {
        format: FORMAT.name,
        name: String::new(),
        dims: axes.dims,
        voxel: stored(&header)?.voxel(),
        world_from_index: world_from_index(path, &header, &axes)?,
        frames: axes.frames,
        components: 1,
        notes: Vec::new(),
    };
    let (data, mut file) = match data_file(path, &header)? {
        None => (path.to_owned(), file),
        Some(data) => {
            let file = File::open(&data)
                .map_err(|e| ReadError::io(&data, e).hint("the header's `data file` names it: put it there"))?;
            (data, BufReader::new(file))
        }
    };
    Opened::at_once(path.to_owned(), declared, move || {
        read_data(&data, &header, count, &mut file)
    })
}

/// Which of the array's axes are the volume's.
struct Axes {
    /// Voxels along the volume's axes; 1 for missing ones.
    dims: [usize; 3],
    /// The volume's axes among the array's.
    spatial: Vec<usize>,
    /// How many axes the array has.
    count: usize,
    /// How many volumes the slowest axis counts.
    frames: usize,
}

impl Axes {
    fn new(path: &Path, header: &Header) -> Result<Self, ReadError> {
        let field = header.need("sizes")?;
        let sizes: Vec<usize> = header.numbers("sizes")?.unwrap_or_default();
        if sizes.len() != header.number("dimension", sizes.len())? || sizes.is_empty() {
            let what = format!("`sizes` has {} numbers, `dimension` says another", sizes.len());
            return Err(ReadError::header(path, what).line(field.line));
        }
        let spatial = spatial_axes(header, sizes.len())?;
        let mut axes = Self {
            dims: [1; 3],
            count: sizes.len(),
            frames: 1,
            spatial,
        };
        for (dim, &axis) in axes.dims.iter_mut().zip(&axes.spatial) {
            *dim = sizes[axis];
        }
        axes.frames = frames(path, header, &sizes, &axes.spatial)?;
        Ok(axes)
    }
}

/// The array's axes that lie in space: those with a direction, or of a spatial kind; at most three.
fn spatial_axes(header: &Header, count: usize) -> Result<Vec<usize>, ReadError> {
    let kinds = header.words("kinds");
    let directions = header.vectors("spacedirections")?;
    let is_spatial = |axis: &usize| match &directions {
        Some(directions) => directions.get(*axis).is_some_and(Option::is_some),
        None => kinds
            .get(*axis)
            .is_none_or(|kind| SPATIAL_KINDS.contains(&kind.as_str())),
    };
    Ok((0..count).filter(is_spatial).take(3).collect())
}

/// The number of volumes along the one other axis, which has to be the slowest.
fn frames(path: &Path, header: &Header, sizes: &[usize], spatial: &[usize]) -> Result<usize, ReadError> {
    let kinds = header.words("kinds");
    let kind = |axis: usize| kinds.get(axis).map_or("none", String::as_str);
    let others = (0..sizes.len()).filter(|axis| !spatial.contains(axis));
    let others: Vec<usize> = others.filter(|&axis| sizes[axis] != 1).collect();
    let slowest = |axis: usize| sizes[axis + 1..].iter().all(|&n| n == 1);
    match others[..] {
        [] => Ok(1),
        [axis] if slowest(axis) && FRAME_KINDS.contains(&kind(axis)) => Ok(sizes[axis]),
        [axis, ..] => {
            let (size, kind) = (sizes[axis], kind(axis));
            let what = format!("voxels of {size} components (an axis of kind `{kind}`) are not read");
            Err(ReadError::unsupported(path, what))
        }
    }
}

/// Where the header puts the voxels in LPS millimetres.
fn world_from_index(path: &Path, header: &Header, axes: &Axes) -> Result<DAffine3, ReadError> {
    let (columns, origin) = match header.vectors("spacedirections")? {
        Some(directions) => {
            let origin = header.vectors("spaceorigin")?.unwrap_or_default();
            let origin = origin.first().copied().flatten();
            let column = |a: usize| directions.get(*axes.spatial.get(a)?).copied()?;
            (std::array::from_fn(column), origin.unwrap_or(DVec3::ZERO))
        }
        None => spacings(path, header, axes)?,
    };
    let scale = unit(header) * lps_from_space(path, header)?;
    Ok(DAffine3::from_scale(scale) * from_axes(columns, origin))
}

/// The axes and origin of a header without `space directions`.
fn spacings(path: &Path, header: &Header, axes: &Axes) -> Result<([Option<DVec3>; 3], DVec3), ReadError> {
    let number = |name: &str, missing: f64| {
        let numbers: Vec<f64> = header.numbers(name)?.unwrap_or_default();
        if !numbers.is_empty() && numbers.len() != axes.count {
            let what = format!("`{name}` has {} numbers for {} axes", numbers.len(), axes.count);
            return Err(ReadError::header(path, what));
        }
        let at = |a: usize| axes.spatial.get(a).and_then(|&axis| numbers.get(axis));
        let known = |v: &&f64| v.is_finite() && **v != 0.0;
        Ok(DVec3::from_array(std::array::from_fn(|a| {
            at(a).filter(known).copied().unwrap_or(missing)
        })))
    };
    let (spacing, origin) = (number("spacings", 1.0)?, number("axismins", 0.0)?);
    let columns = std::array::from_fn(|a| Some(DVec3::AXES[a] * spacing[a]));
    Ok((columns, origin))
}

/// Millimetres in the unit of the header's space.
fn unit(header: &Header) -> f64 {
    let units = header.words("spaceunits");
    units.first().map_or(1.0, |unit| millimetres(unit))
}

/// The signs that turn the header's space into LPS; spaces that name no anatomy stay as they are.
fn lps_from_space(path: &Path, header: &Header) -> Result<DVec3, ReadError> {
    let Some(field) = header.get("space") else {
        return Ok(DVec3::ONE);
    };
    match field.value.to_ascii_lowercase().trim_end_matches("-time") {
        "right-anterior-superior" | "ras" | "rast" => Ok(LPS_FROM_RAS),
        "left-anterior-superior" | "las" | "last" => Ok(LPS_FROM_LAS),
        "left-posterior-superior" | "lps" | "lpst" | "scanner-xyz" | "3d-right-handed" | "3d-left-handed" => {
            Ok(DVec3::ONE)
        }
        _ => Err(
            ReadError::unsupported(path, format!("the space `{}` is not known", field.value))
                .line(field.line)
                .hint("use left-posterior-superior, right-anterior-superior or left-anterior-superior"),
        ),
    }
}

/// The data file that a detached header names.
fn data_file(path: &Path, header: &Header) -> Result<Option<PathBuf>, ReadError> {
    let Some(field) = header.get("datafile") else {
        return Ok(None);
    };
    if field.value.starts_with("LIST") || field.value.contains('%') {
        return Err(ReadError::unsupported(path, "data in several files is not read")
            .line(field.line)
            .hint("join them first, as with `unu save`"));
    }
    Ok(Some(path.with_file_name("").join(&field.value)))
}

/// The voxels, from `file`'s position on.
fn read_data(path: &Path, header: &Header, count: usize, file: &mut BufReader<File>) -> Result<Voxels, ReadError> {
    let payload = Payload {
        path,
        stored: stored(header)?,
        order: byte_order(path, header)?,
        count,
    };
    skip_lines(path, header, file)?;
    let skip: i64 = header.number("byteskip", 0)?;
    let field = header.need("encoding")?;
    match (field.value.to_ascii_lowercase().as_str(), u64::try_from(skip)) {
        ("raw", Ok(skip)) => {
            seek(path, file, skip)?;
            payload.read_raw(file)
        }
        ("raw", Err(_)) if skip == -1 => {
            let found = remaining(file).map_err(|e| ReadError::io(path, e))?;
            payload.check(found)?;
            seek(path, file, found - payload.bytes())?;
            payload.read_raw(file)
        }
        ("gzip" | "gz", Ok(skip)) => payload.read_gzip(file, skip),
        ("gzip" | "gz", Err(_)) if skip == -1 => read_gzip_end(&payload, file),
        ("text" | "txt" | "ascii", Ok(0)) => payload.read_text(file),
        (_, Err(_)) if skip < -1 => Err(ReadError::header(path, "`byte skip` is below -1")),
        _ => Err(
            ReadError::unsupported(path, format!("the encoding `{}` is not read", field.value))
                .line(field.line)
                .hint("save it with the encoding raw or gzip"),
        ),
    }
}

/// The payload at the end of a gzip stream, whose length only a first pass tells.
fn read_gzip_end(payload: &Payload, file: &mut BufReader<File>) -> Result<Voxels, ReadError> {
    let io_error = |e| ReadError::io(payload.path, e);
    let compressed = remaining(file).map_err(io_error)?;
    payload.check_gzip(compressed, 0)?;
    let start = file.stream_position().map_err(io_error)?;
    let found = io::copy(&mut Gunzip::new(&mut *file), &mut io::sink())
        .map_err(|e| ReadError::new(payload.path, Problem::Compressed(e)))?;
    payload.check(found)?;
    file.seek(SeekFrom::Start(start)).map_err(io_error)?;
    payload.read_gzip(file, found - payload.bytes())
}

/// Moves on by `bytes`.
fn seek(path: &Path, file: &mut BufReader<File>, bytes: u64) -> Result<(), ReadError> {
    let start = file.stream_position().map_err(|e| ReadError::io(path, e))?;
    file.seek(SeekFrom::Start(start.saturating_add(bytes)))
        .map_err(|e| ReadError::io(path, e))?;
    Ok(())
}

/// Moves past the lines that `line skip` counts.
fn skip_lines(path: &Path, header: &Header, file: &mut BufReader<File>) -> Result<(), ReadError> {
    let lines: u64 = header.number("lineskip", 0)?;
    for _ in 0..lines {
        if file.skip_until(b'\n').map_err(|e| ReadError::io(path, e))? == 0 {
            return Err(ReadError::header(
                path,
                format!("it has less than {lines} lines to skip"),
            ));
        }
    }
    Ok(())
}

fn stored(header: &Header) -> Result<Stored, ReadError> {
    let field = header.need("type")?;
    Ok(match field.value.as_str() {
        "signed char" | "int8" | "int8_t" | "char" => Stored::Voxel(VoxelType::I8),
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Stored::Voxel(VoxelType::U8),
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => {
            Stored::Voxel(VoxelType::I16)
        }
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Stored::Voxel(VoxelType::U16),
        "int" | "signed int" | "int32" | "int32_t" => Stored::Voxel(VoxelType::I32),
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Stored::Voxel(VoxelType::U32),
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => Stored::I64,
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => Stored::U64,
        "float" => Stored::Voxel(VoxelType::F32),
        "double" => Stored::Voxel(VoxelType::F64),
        other => return Err(header.bad(field, other)),
    })
}

/// The data's byte order, which only scalars of several bytes in binary need.
fn byte_order(path: &Path, header: &Header) -> Result<ByteOrder, ReadError> {
    let Some(field) = header.get("endian") else {
        let text = header.need("encoding")?.value.to_ascii_lowercase();
        return match stored(header)?.bytes() == 1 || ["text", "txt", "ascii"].contains(&&*text) {
            true => Ok(ByteOrder::NATIVE),
            false => {
                Err(ReadError::header(path, "the header has no `endian`").hint("add the line `endian: little`, or big"))
            }
        };
    };
    match field.value.to_ascii_lowercase().as_str() {
        "little" => Ok(ByteOrder::Little),
        "big" => Ok(ByteOrder::Big),
        other => Err(header.bad(field, other)),
    }
}
