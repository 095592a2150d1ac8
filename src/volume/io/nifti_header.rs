//! The headers of NIfTI-1, NIfTI-2 and ANALYZE 7.5.
//!
//! Formats: nifti1.h (2004), nifti2.h (2011), and Mayo's dbh.h.

use std::path::Path;

use super::error::ReadError;
use super::stored::ByteOrder;

/// Which header it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// ANALYZE 7.5, always in two files.
    Analyze,
    /// NIfTI-1.
    One,
    /// NIfTI-2.
    Two,
}

/// A header's fields, in `f64` where they are floats.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub kind: Kind,
    pub order: ByteOrder,
    /// Whether voxels and header are in one file.
    pub is_single: bool,
    /// How many dimensions there are, and their sizes.
    pub dim: [i64; 8],
    pub datatype: i16,
    pub intent_code: i32,
    pub pixdim: [f64; 8],
    pub vox_offset: f64,
    pub slope: f64,
    pub intercept: f64,
    pub units: i32,
    pub qform_code: i32,
    pub sform_code: i32,
    pub quatern: [f64; 3],
    pub qoffset: [f64; 3],
    pub srow: [[f64; 4]; 3],
}

impl Header {
    /// Bytes of the longest.
    pub(super) const MAX_BYTES: u64 = 540;

    /// The header at the start of a file.
    pub(super) fn new(path: &Path, bytes: &[u8]) -> Result<Self, ReadError> {
        let first = |order| Fields { bytes, order }.i32(0);
        let found = [ByteOrder::Little, ByteOrder::Big]
            .into_iter()
            .find_map(|order| match first(order) {
                348 => Some((order, 348)),
                540 => Some((order, 540)),
                _ => None,
            });
        let Some((order, length)) = found.filter(|_| bytes.len() >= 4) else {
            let what = "it is no NIfTI or ANALYZE file: it does not start with the size of their headers";
            return Err(ReadError::header(path, what).byte(0));
        };
        if bytes.len() < length {
            let what = format!("it has {} bytes, its header takes {length}", bytes.len());
            return Err(ReadError::header(path, what));
        }
        let fields = Fields { bytes, order };
        let magic = if length == 348 { &bytes[344..348] } else { &bytes[4..8] };
        match (length, magic) {
            (348, b"n+1\0" | b"ni1\0") => Ok(fields.nifti_1(magic[1] == b'+')),
            (540, b"n+2\0" | b"ni2\0") => Ok(fields.nifti_2(magic[1] == b'+')),
            (348, _) if is_header_of_pair(path) => Ok(Self {
                kind: Kind::Analyze,
                slope: 0.0,
                units: 0,
                intent_code: 0,
                qform_code: 0,
                sform_code: 0,
                ..fields.nifti_1(false)
            }),
            _ => Err(ReadError::header(path, "it is not NIfTI: its magic letters are missing").byte(344)),
        }
    }

    /// Bytes of this one.
    pub(super) fn bytes(&self) -> u64 {
        if self.kind == Kind::Two { 540 } else { 348 }
    }
}

/// Whether the file is named as a header whose voxels are in another: only there ANALYZE, which has no magic letters, is expected.
fn is_header_of_pair(path: &Path) -> bool {
    let name = path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase();
    name.ends_with(".hdr") || name.ends_with(".hdr.gz")
}

/// Numbers at places of a header; beyond its end they are 0.
struct Fields<'a> {
    bytes: &'a [u8],
    order: ByteOrder,
}

impl Fields<'_> {
    fn at<const N: usize>(&self, at: usize) -> [u8; N] {
        let mut bytes = [0; N];
        if let Some(found) = self.bytes.get(at..at + N) {
            bytes.copy_from_slice(found);
        }
        if self.order == ByteOrder::Big {
            bytes.reverse();
        }
        bytes
    }

    fn i16(&self, at: usize) -> i16 {
        i16::from_le_bytes(self.at(at))
    }

    fn i32(&self, at: usize) -> i32 {
        i32::from_le_bytes(self.at(at))
    }

    fn i64(&self, at: usize) -> i64 {
        i64::from_le_bytes(self.at(at))
    }

    fn f32(&self, at: usize) -> f64 {
        f64::from(f32::from_le_bytes(self.at(at)))
    }

    fn f64(&self, at: usize) -> f64 {
        f64::from_le_bytes(self.at(at))
    }

    fn nifti_1(&self, is_single: bool) -> Header {
        let floats = |at: usize| move |n: usize| self.f32(at + 4 * n);
        Header {
            kind: Kind::One,
            order: self.order,
            is_single,
            dim: std::array::from_fn(|n| self.i16(40 + 2 * n).into()),
            datatype: self.i16(70),
            intent_code: self.i16(68).into(),
            pixdim: std::array::from_fn(floats(76)),
            vox_offset: self.f32(108),
            slope: self.f32(112),
            intercept: self.f32(116),
            units: self.bytes[123].into(),
            qform_code: self.i16(252).into(),
            sform_code: self.i16(254).into(),
            quatern: std::array::from_fn(floats(256)),
            qoffset: std::array::from_fn(floats(268)),
            srow: std::array::from_fn(|row| std::array::from_fn(floats(280 + 16 * row))),
        }
    }

    fn nifti_2(&self, is_single: bool) -> Header {
        let floats = |at: usize| move |n: usize| self.f64(at + 8 * n);
        Header {
            kind: Kind::Two,
            order: self.order,
            is_single,
            dim: std::array::from_fn(|n| self.i64(16 + 8 * n)),
            datatype: self.i16(12),
            intent_code: self.i32(504),
            pixdim: std::array::from_fn(floats(104)),
            vox_offset: self.i64(168) as f64,
            slope: self.f64(176),
            intercept: self.f64(184),
            units: self.i32(500),
            qform_code: self.i32(344),
            sform_code: self.i32(348),
            quatern: std::array::from_fn(floats(352)),
            qoffset: std::array::from_fn(floats(376)),
            srow: std::array::from_fn(|row| std::array::from_fn(floats(400 + 32 * row))),
        }
    }
}
