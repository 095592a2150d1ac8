//! NIfTI-1, NIfTI-2 and ANALYZE 7.5, in one file (.nii) or two (.hdr and .img), plain or gzip.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use super::budget::Budget;
use super::components::{Components, Rule};
use super::error::ReadError;
use super::format::Format;
use super::gunzip::{GZIP_MAGIC, Gunzip};
use super::nifti_header::{Header, Kind};
use super::nifti_place::world_from_index;
use super::nifti_write;
use super::open::{Chunks, Declared, Opened, ReadOptions};
use super::payload::{Payload, chosen_frame};
use super::source::{Coding, Skip, Stretch, section};
use super::stored::Stored;
use crate::volume::grid::voxel_count;
use crate::volume::voxel::VoxelType;

/// Intents whose fifth axis counts components: matrices, vectors, point sets, triangles, quaternions and colours.
const COMPONENT_INTENTS: [i32; 9] = [1004, 1005, 1006, 1007, 1008, 1009, 1010, 2003, 2004];

/// Those of colours.
const COLOUR_INTENTS: [i32; 2] = [2003, 2004];

/// The farthest place where voxels may start.
const MAX_OFFSET: f64 = 1e9;

/// NIfTI among the formats.
pub(super) const FORMAT: Format = Format {
    name: "NIfTI",
    suffixes: &[".nii", ".nii.gz", ".hdr", ".hdr.gz", ".img", ".img.gz"],
    reads: "NIfTI-1, NIfTI-2 and ANALYZE 7.5, plain and gzip; slope and intercept; sform, else qform; components; frames",
    recognises: |probe| {
        let has_magic = probe.start.get(344..348) == Some(b"n+1\0") || probe.start.get(4..8) == Some(b"n+2\0");
        !probe.is_folder && !probe.has_layout && (has_magic || probe.is_named(&FORMAT))
    },
    open: |path, options| Ok(vec![open(path, options)?]),
    writer: Some(nifti_write::WRITER),
};

/// Opens the file at `path`. Of a pair either file may be named.
fn open(path: &Path, options: &ReadOptions) -> Result<Opened, ReadError> {
    let header_path = partner(path, "img", "hdr").unwrap_or_else(|| path.to_owned());
    let header = read_header(&header_path)?;
    let shape = Shape::new(&header_path, &header)?;
    let frame = chosen_frame(path, shape.frames, options)?;
    let scalars = Scalars::new(&header_path, &header)?;
    let components = components(&header_path, &header, &scalars, &shape, options)?;
    let payload = Payload {
        stored: scalars.stored,
        order: header.order,
        voxels: voxel_count(shape.dims).map_err(|e| ReadError::new(&header_path, e))?,
        components,
        rescaling: rescaling(&header, &scalars),
    };
    let declared = Declared {
        format: format_name(header.kind),
        name: String::new(),
        dims: shape.dims,
        voxel: payload.voxel(),
        world_from_index: world_from_index(&header),
        frames: shape.frames,
        components: components.count(),
        notes: components.note(payload.stored).into_iter().collect(),
    };
    let all = stretch(
        &header_path,
        &header,
        payload.bytes().saturating_mul(shape.frames as u64),
    )?;
    let chunks = chunks(payload, &header_path, all, &shape, frame, options.budget)?;
    Opened::new(header_path, declared, chunks)
}

const fn format_name(kind: Kind) -> &'static str {
    match kind {
        Kind::Analyze => "ANALYZE 7.5",
        Kind::One => "NIfTI-1",
        Kind::Two => "NIfTI-2",
    }
}

/// The file beside `path` with the suffix `to` for `from`, plain or gzip; `None` when there is none.
fn partner(path: &Path, from: &str, to: &str) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let plain = name.strip_suffix(".gz").unwrap_or(name);
    let stem = plain.strip_suffix(from)?.strip_suffix('.')?;
    [format!("{stem}.{to}"), format!("{stem}.{to}.gz")]
        .map(|name| path.with_file_name(name))
        .into_iter()
        .find(|path| path.exists())
}

fn read_header(path: &Path) -> Result<Header, ReadError> {
    let io_error = |e| ReadError::io(path, e);
    let mut file = BufReader::new(File::open(path).map_err(io_error)?);
    let is_gzip = file.fill_buf().map_err(io_error)?.starts_with(&GZIP_MAGIC);
    let mut bytes = Vec::new();
    let read = match is_gzip {
        true => Gunzip::new(file).take(Header::MAX_BYTES).read_to_end(&mut bytes),
        false => file.take(Header::MAX_BYTES).read_to_end(&mut bytes),
    };
    match (read, bytes.len()) {
        // Whether a stream that breaks off later holds the header, the header tells.
        (Err(error), 0) => Err(io_error(error)),
        _ => Header::new(path, &bytes),
    }
}

/// The sizes, checked.
struct Shape {
    dims: [usize; 3],
    frames: usize,
    /// Components along the fifth axis.
    components: usize,
}

impl Shape {
    fn new(path: &Path, header: &Header) -> Result<Self, ReadError> {
        let at = if header.kind == Kind::Two { 16 } else { 40 };
        let bad = |what: String| ReadError::header(path, what).byte(at);
        let count = usize::try_from(header.dim[0]).ok().filter(|n| (1..=7).contains(n));
        let count = count.ok_or_else(|| bad(format!("a volume cannot have {} dimensions", header.dim[0])))?;
        let mut sizes = [1; 7];
        for (size, n) in sizes.iter_mut().zip(&header.dim[1..=count]) {
            let known = usize::try_from(*n).ok().filter(|n| *n > 0);
            *size = known.ok_or_else(|| bad(format!("a volume cannot have {n} voxels along an axis")))?;
        }
        let product = |sizes: &[usize]| sizes.iter().fold(1, |n: usize, size| n.saturating_mul(*size));
        let components = match COMPONENT_INTENTS.contains(&header.intent_code) {
            true => product(&sizes[4..]),
            false => 1,
        };
        Ok(Self {
            dims: [sizes[0], sizes[1], sizes[2]],
            frames: if components == 1 {
                product(&sizes[3..])
            } else {
                sizes[3]
            },
            components,
        })
    }
}

/// What a data type says of the numbers of a voxel that lie together.
struct Scalars {
    stored: Stored,
    count: usize,
    rule: Rule,
}

impl Scalars {
    fn new(path: &Path, header: &Header) -> Result<Self, ReadError> {
        let several = |voxel, count, rule| Self {
            stored: Stored::Voxel(voxel),
            count,
            rule,
        };
        let one = |stored| Self {
            stored,
            count: 1,
            rule: Rule::Component(0),
        };
        let at = if header.kind == Kind::Two { 12 } else { 70 };
        let name = match header.datatype {
            2 => return Ok(one(Stored::Voxel(VoxelType::U8))),
            4 => return Ok(one(Stored::Voxel(VoxelType::I16))),
            8 => return Ok(one(Stored::Voxel(VoxelType::I32))),
            16 => return Ok(one(Stored::Voxel(VoxelType::F32))),
            64 => return Ok(one(Stored::Voxel(VoxelType::F64))),
            256 => return Ok(one(Stored::Voxel(VoxelType::I8))),
            512 => return Ok(one(Stored::Voxel(VoxelType::U16))),
            768 => return Ok(one(Stored::Voxel(VoxelType::U32))),
            1024 => return Ok(one(Stored::I64)),
            1280 => return Ok(one(Stored::U64)),
            32 => return Ok(several(VoxelType::F32, 2, Rule::Length)),
            1792 => return Ok(several(VoxelType::F64, 2, Rule::Length)),
            128 => return Ok(several(VoxelType::U8, 3, Rule::Luminance)),
            2304 => return Ok(several(VoxelType::U8, 4, Rule::Luminance)),
            1 => "single bits",
            1536 => "128-bit floats",
            2048 => "complex numbers of 128-bit floats",
            code => {
                let what = format!("{code} is no data type of NIfTI");
                return Err(ReadError::header(path, what).byte(at));
            }
        };
        Err(ReadError::unsupported(path, format!("voxels that are {name} are not read")).byte(at))
    }
}

/// The components of a data type lie together; those along the fifth axis in runs of a volume.
fn components(
    path: &Path,
    header: &Header,
    scalars: &Scalars,
    shape: &Shape,
    options: &ReadOptions,
) -> Result<Components, ReadError> {
    match (scalars.count, shape.components) {
        (count, 1) => Ok(Components::new(path, count, options.component)?.as_rule(scalars.rule)),
        (1, count) => {
            let usual = match COLOUR_INTENTS.contains(&header.intent_code) && count >= 3 {
                true => Rule::Luminance,
                false => Rule::Length,
            };
            let run = voxel_count(shape.dims).map_err(|e| ReadError::new(path, e))?;
            Ok(Components::new(path, count, options.component)?
                .as_rule(usual)
                .in_runs(run))
        }
        (inner, outer) => {
            let what = format!("{outer} components of {inner} numbers each are not read");
            Err(ReadError::unsupported(path, what).byte(50))
        }
    }
}

/// The header's slope and intercept, where they change anything: as in nibabel, a slope of 0 or none says that there are none, and
/// colours have none.
fn rescaling(header: &Header, scalars: &Scalars) -> Option<[f64; 2]> {
    let (slope, intercept) = (header.slope, header.intercept);
    let is_said = slope != 0.0 && slope.is_finite() && intercept.is_finite();
    let is_colour = scalars.rule == Rule::Luminance;
    (is_said && !is_colour && (slope, intercept) != (1.0, 0.0)).then_some([slope, intercept])
}

/// Where `bytes` of voxels lie.
fn stretch(header_path: &Path, header: &Header, bytes: u64) -> Result<Stretch, ReadError> {
    let offset = offset(header_path, header)?;
    let path = match header.is_single {
        true => header_path.to_owned(),
        false => partner(header_path, "hdr", "img").ok_or_else(|| {
            ReadError::header(header_path, "its voxels' .img file is missing")
                .hint("put the .img file of the same name beside it")
        })?,
    };
    let io_error = |e| ReadError::io(&path, e);
    let mut file = BufReader::new(File::open(&path).map_err(io_error)?);
    let coding = match file.fill_buf().map_err(io_error)?.starts_with(&GZIP_MAGIC) {
        true => Coding::Deflate,
        false => Coding::Plain,
    };
    Ok(Stretch {
        path,
        start: 0,
        coding,
        skip: Skip::Bytes(offset),
        bytes,
    })
}

/// Where the voxels start: in a single file behind the header and four bytes more, unless it says otherwise.
fn offset(path: &Path, header: &Header) -> Result<u64, ReadError> {
    let length = header.bytes();
    match (header.is_single, header.vox_offset) {
        (true, 0.0) => Ok(length + 4),
        (true, offset) if (0.0..=MAX_OFFSET).contains(&offset) => Ok((offset as u64).max(length)),
        (false, offset) if (0.0..=MAX_OFFSET).contains(&offset) => Ok(offset as u64),
        (_, offset) => {
            let at = if header.kind == Kind::Two { 168 } else { 108 };
            Err(ReadError::header(path, format!("the voxels cannot start at byte {offset}")).byte(at))
        }
    }
}

/// The voxels of a frame. Of components along the fifth axis each has all its frames before the next.
fn chunks(
    payload: Payload,
    path: &Path,
    all: Stretch,
    shape: &Shape,
    frame: usize,
    budget: Budget,
) -> Result<Chunks, ReadError> {
    if shape.components == 1 || shape.frames == 1 {
        return payload.chunks(path, &[all], frame, budget);
    }
    let run = payload.bytes() / shape.components as u64;
    let all = [all];
    let run_of = |component: usize| {
        let before = component.saturating_mul(shape.frames).saturating_add(frame);
        section(&all, run.saturating_mul(before as u64), run)
    };
    let Some(component) = payload.components.chosen() else {
        let own = (0..shape.components).flat_map(run_of).collect();
        return payload.chunks_in(path, &all, own, budget);
    };
    let alone = Payload {
        components: Components::SCALAR,
        ..payload
    };
    alone.chunks_in(path, &all, run_of(component), budget)
}
