//! NIfTI-1, in one file (.nii) or two (.hdr and .img), plain or gzip.
//!
//! Format: the NIfTI-1 data format (nifti1.h, 2004). The header's fields are read by the `nifti` crate; sizes, transforms and
//! voxels are taken from them here, since a header may claim anything.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use glam::{DAffine3, DQuat, DVec3};
use nifti::NiftiHeader;

use super::error::ReadError;
use super::format::Format;
use super::geometry::{LPS_FROM_RAS, from_axes};
use super::gunzip::{GZIP_MAGIC, Gunzip};
use super::open::{Declared, Opened, ReadOptions};
use super::payload::{ByteOrder, Payload, Stored, remaining};
use crate::math::affine;
use crate::volume::grid::{Voxels, voxel_count};
use crate::volume::voxel::{Voxel, VoxelType, for_type};

/// Bytes of the header.
const HEADER_BYTES: u64 = 348;

/// Where the voxels of a single file start when its header does not say.
const DEFAULT_OFFSET: u64 = 352;

/// Intents whose fifth axis counts components: matrices, vectors, point sets, triangles, quaternions and colours.
const COMPONENT_INTENTS: [i16; 9] = [1004, 1005, 1006, 1007, 1008, 1009, 1010, 2003, 2004];

/// NIfTI-1 among the formats.
pub(super) const FORMAT: Format = Format {
    name: "NIfTI-1",
    suffixes: &[".nii", ".nii.gz", ".hdr", ".hdr.gz", ".img", ".img.gz"],
    reads: ".nii and .hdr with .img, plain and gzip; slope and intercept; sform, else qform",
    recognises: |probe| !probe.is_folder && !probe.has_layout && probe.is_named(&FORMAT),
    open: |path, options| Ok(vec![open(path, options)?]),
};

/// Opens the NIfTI-1 file at `path`. Of a pair either file may be named.
fn open(path: &Path, _options: &ReadOptions) -> Result<Opened, ReadError> {
    let header_path = partner(path, "img", "hdr").unwrap_or_else(|| path.to_owned());
    let header = read_header(&header_path)?;
    let fields = Fields::new(&header_path, &header)?;
    let declared = Declared {
        format: FORMAT.name,
        name: String::new(),
        dims: fields.dims,
        voxel: match (rescaling(&header), fields.stored.voxel()) {
            (None, voxel) => voxel,
            (Some(_), VoxelType::F64) => VoxelType::F64,
            (Some(_), _) => VoxelType::F32,
        },
        world_from_index: fields.world_from_index,
        frames: fields.frames,
        components: 1,
        notes: Vec::new(),
    };
    let (data, offset) = match &header.magic {
        b"n+1\0" => (header_path.clone(), fields.offset.max(HEADER_BYTES)),
        _ => {
            let data = partner(&header_path, "hdr", "img").ok_or_else(|| {
                ReadError::header(&header_path, "its voxels' .img file is missing")
                    .hint("put the .img file of the same name beside it")
            })?;
            (data, fields.offset)
        }
    };
    Opened::at_once(header_path, declared, move || {
        let voxels = fields.read_voxels(&data, offset)?;
        Ok(match rescaling(&header) {
            Some(by) => rescaled(voxels, by),
            None => voxels,
        })
    })
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

fn read_header(path: &Path) -> Result<NiftiHeader, ReadError> {
    let mut bytes = Vec::new();
    let stream = Stream::open(path)?;
    (stream.take(HEADER_BYTES).read_to_end(&mut bytes)).map_err(|e| ReadError::io(path, e))?;
    if bytes.len() as u64 != HEADER_BYTES {
        let what = format!("it has {} bytes, a NIfTI-1 header takes {HEADER_BYTES}", bytes.len());
        return Err(ReadError::header(path, what));
    }
    NiftiHeader::from_reader(&*bytes).map_err(|e| ReadError::header(path, format!("it is not NIfTI-1: {e}")).byte(0))
}

/// A file's bytes, decompressed if need be.
enum Stream {
    Plain(BufReader<File>),
    Gzip(Gunzip<BufReader<File>>),
}

impl Stream {
    fn open(path: &Path) -> Result<Self, ReadError> {
        let file = File::open(path).map_err(|e| ReadError::io(path, e))?;
        let mut file = BufReader::new(file);
        let start = file.fill_buf().map_err(|e| ReadError::io(path, e))?;
        Ok(match start.starts_with(&GZIP_MAGIC) {
            true => Self::Gzip(Gunzip::new(file)),
            false => Self::Plain(file),
        })
    }
}

impl Read for Stream {
    fn read(&mut self, buf: &mut [u8]) -> std::io::Result<usize> {
        match self {
            Self::Plain(file) => file.read(buf),
            Self::Gzip(stream) => stream.read(buf),
        }
    }
}

/// What the header says of the voxels, checked.
struct Fields {
    dims: [usize; 3],
    frames: usize,
    stored: Stored,
    order: ByteOrder,
    offset: u64,
    world_from_index: DAffine3,
}

impl Fields {
    fn new(path: &Path, header: &NiftiHeader) -> Result<Self, ReadError> {
        let sizes = header
            .dim()
            .map_err(|e| ReadError::header(path, e.to_string()).byte(40))?;
        let size = |axis: usize| sizes.get(axis).map_or(1, |&n| usize::from(n));
        if size(4) > 1 && COMPONENT_INTENTS.contains(&header.intent_code) {
            let what = format!("voxels of {} components are not read", size(4));
            return Err(ReadError::unsupported(path, what).byte(50));
        }
        Ok(Self {
            dims: [size(0), size(1), size(2)],
            frames: (3..7).fold(1, |n: usize, axis| n.saturating_mul(size(axis))),
            stored: stored(path, header)?,
            order: match header.endianness {
                nifti::Endianness::Little => ByteOrder::Little,
                nifti::Endianness::Big => ByteOrder::Big,
            },
            offset: offset(path, header)?,
            world_from_index: world_from_index(header),
        })
    }

    /// The first frame of the voxels in `path` from byte `offset` on.
    fn read_voxels(&self, path: &Path, offset: u64) -> Result<Voxels, ReadError> {
        let payload = Payload {
            path,
            stored: self.stored,
            order: self.order,
            count: voxel_count(self.dims).map_err(|e| ReadError::new(path, e))?,
        };
        let io_error = |e| ReadError::io(path, e);
        match Stream::open(path)? {
            Stream::Plain(mut file) => {
                let found = remaining(&mut file).map_err(io_error)?;
                self.check_frames(&payload, found.saturating_sub(offset))?;
                payload.skip(&mut file, offset)?;
                payload.read_raw(&mut file)
            }
            Stream::Gzip(mut stream) => {
                let compressed = File::open(path).and_then(|f| f.metadata()).map_err(io_error)?;
                payload.check_gzip(compressed.len(), offset)?;
                payload.decode_gzip(&mut stream, offset)
            }
        }
    }

    /// Whether `found` bytes hold all frames: a series cut off is not taken for whole.
    fn check_frames(&self, payload: &Payload, found: u64) -> Result<(), ReadError> {
        let count = payload.count.saturating_mul(self.frames);
        Payload { count, ..*payload }.check(found)
    }
}

fn stored(path: &Path, header: &NiftiHeader) -> Result<Stored, ReadError> {
    let name = match header.datatype {
        2 => return Ok(Stored::Voxel(VoxelType::U8)),
        4 => return Ok(Stored::Voxel(VoxelType::I16)),
        8 => return Ok(Stored::Voxel(VoxelType::I32)),
        16 => return Ok(Stored::Voxel(VoxelType::F32)),
        64 => return Ok(Stored::Voxel(VoxelType::F64)),
        256 => return Ok(Stored::Voxel(VoxelType::I8)),
        512 => return Ok(Stored::Voxel(VoxelType::U16)),
        768 => return Ok(Stored::Voxel(VoxelType::U32)),
        1024 => return Ok(Stored::I64),
        1280 => return Ok(Stored::U64),
        1 => "single bits",
        32 | 1792 | 2048 => "complex numbers",
        128 => "RGB colours",
        2304 => "RGBA colours",
        1536 => "128-bit floats",
        code => {
            let what = format!("{code} is no NIfTI-1 data type");
            return Err(ReadError::header(path, what).byte(70));
        }
    };
    Err(ReadError::unsupported(path, format!("voxels that are {name} are not read")).byte(70))
}

/// Where the voxels start.
fn offset(path: &Path, header: &NiftiHeader) -> Result<u64, ReadError> {
    let offset = header.vox_offset;
    match (&header.magic, offset) {
        (b"n+1\0", 0.0) => Ok(DEFAULT_OFFSET),
        (_, offset) if (0.0..=1e9).contains(&offset) => Ok(offset as u64),
        _ => Err(ReadError::header(path, format!("the voxels cannot start at byte {offset}")).byte(108)),
    }
}

/// The sform when it is set and can be inverted, else the qform when it is set. With neither nothing is known of the
/// anatomy, and the index axes are taken as they are.
fn world_from_index(header: &NiftiHeader) -> DAffine3 {
    let millimetres = millimetres(header);
    let lps_from_ras = DAffine3::from_scale(LPS_FROM_RAS * millimetres);
    if let Some(ras_from_index) = sform(header) {
        return lps_from_ras * ras_from_index;
    }
    match header.qform_code > 0 {
        true => lps_from_ras * qform(header),
        false => DAffine3::from_scale(spacing(header) * millimetres),
    }
}

/// Millimetres in the header's unit of length.
fn millimetres(header: &NiftiHeader) -> f64 {
    match header.xyzt_units & 7 {
        1 => 1e3,
        3 => 1e-3,
        _ => 1.0,
    }
}

/// Method 3 of nifti1.h, when it is set and can be inverted. A third column of zeros, as images of one slice have, becomes
/// the others' normal.
fn sform(header: &NiftiHeader) -> Option<DAffine3> {
    let rows = [header.srow_x, header.srow_y, header.srow_z].map(|row| row.map(f64::from));
    let column = |a: usize| DVec3::new(rows[0][a], rows[1][a], rows[2][a]);
    let slices = Some(column(2)).filter(|c| *c != DVec3::ZERO);
    let map = from_axes([Some(column(0)), Some(column(1)), slices], column(3));
    (header.sform_code > 0 && affine::invert(&map).is_some()).then_some(map)
}

/// Method 2 of nifti1.h.
fn qform(header: &NiftiHeader) -> DAffine3 {
    let [b, c, d] = [header.quatern_b, header.quatern_c, header.quatern_d].map(f64::from);
    let square = 1.0 - (b * b + c * c + d * d);
    let rotation = DQuat::from_xyzw(b, c, d, square.max(0.0).sqrt());
    let mirror = if header.pixdim[0] < 0.0 { -1.0 } else { 1.0 };
    let origin = [header.quatern_x, header.quatern_y, header.quatern_z].map(f64::from);
    DAffine3::from_scale_rotation_translation(
        spacing(header) * DVec3::new(1.0, 1.0, mirror),
        rotation.normalize(),
        DVec3::from_array(origin),
    )
}

/// The voxels' sizes; 1 for those that are none.
fn spacing(header: &NiftiHeader) -> DVec3 {
    let size = |v: f32| f64::from(if v.is_normal() { v.abs() } else { 1.0 });
    DVec3::new(size(header.pixdim[1]), size(header.pixdim[2]), size(header.pixdim[3]))
}

/// The header's slope and intercept, where they change anything.
fn rescaling(header: &NiftiHeader) -> Option<[f64; 2]> {
    let [slope, intercept] = [header.scl_slope, header.scl_inter].map(f64::from);
    let said = slope != 0.0 && slope.is_finite() && intercept.is_finite();
    (said && (slope, intercept) != (1.0, 0.0)).then_some([slope, intercept])
}

/// The voxels after slope and intercept, as `f32` unless they are `f64`.
fn rescaled(voxels: Voxels, [slope, intercept]: [f64; 2]) -> Voxels {
    match voxels {
        Voxels::F64(v) => Voxels::F64(v.into_iter().map(|v| v * slope + intercept).collect()),
        voxels => Voxels::F32(for_type!(Voxels, voxels, v => {
            v.into_iter().map(|v| (v.to_f64() * slope + intercept) as f32).collect()
        })),
    }
}
