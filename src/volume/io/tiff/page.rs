//! What a page's pixels are, and pixels as numbers.

use std::path::Path;

use tiff::ColorType;
use tiff::decoder::DecodingResult;
use tiff::tags::SampleFormat;

use crate::volume::grid::Voxels;
use crate::volume::io::components::Components;
use crate::volume::io::error::ReadError;
use crate::volume::io::stored::Stored;
use crate::volume::voxel::{Voxel, VoxelType, map_type};

/// What the samples of a pixel are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A value, or several that belong to no colour.
    Values,
    /// Red, green and blue, and maybe an opacity.
    Rgb,
    /// Luminance and two differences of colours, as JPEG has them.
    YCbCr,
}

/// What pages that make one stack have in common.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    /// Pixels along x and y.
    pub dims: [usize; 2],
    pub stored: Stored,
    /// Bits of a sample.
    pub bits: u8,
    /// Samples a pixel.
    pub samples: usize,
    /// Whether all pixels' first samples come first, then all second ones.
    pub is_planar: bool,
    pub kind: Kind,
}

impl Layout {
    /// Of a page of these `dims`, whose samples are `format`.
    pub(super) fn new(
        dims: (u32, u32),
        color: ColorType,
        format: &SampleFormat,
        is_planar: bool,
    ) -> Result<Self, String> {
        let (kind, samples) = match color {
            ColorType::Gray(_) => (Kind::Values, 1),
            ColorType::Multiband { num_samples, .. } => (Kind::Values, usize::from(num_samples)),
            ColorType::RGB(_) => (Kind::Rgb, 3),
            ColorType::RGBA(_) => (Kind::Rgb, 4),
            ColorType::YCbCr(8) => (Kind::YCbCr, 3),
            other => return Err(format!("pixels of {other:?} are not read")),
        };
        let bits = color.bit_depth();
        let stored = match (format, bits) {
            (SampleFormat::Uint | SampleFormat::Void, 1..=8) => Stored::Voxel(VoxelType::U8),
            (SampleFormat::Uint | SampleFormat::Void, 16) => Stored::Voxel(VoxelType::U16),
            (SampleFormat::Uint | SampleFormat::Void, 32) => Stored::Voxel(VoxelType::U32),
            (SampleFormat::Uint | SampleFormat::Void, 64) => Stored::U64,
            (SampleFormat::Int, 8) => Stored::Voxel(VoxelType::I8),
            (SampleFormat::Int, 16) => Stored::Voxel(VoxelType::I16),
            (SampleFormat::Int, 32) => Stored::Voxel(VoxelType::I32),
            (SampleFormat::Int, 64) => Stored::I64,
            (SampleFormat::IEEEFP, 16 | 32) => Stored::Voxel(VoxelType::F32),
            (SampleFormat::IEEEFP, 64) => Stored::Voxel(VoxelType::F64),
            (format, bits) => return Err(format!("samples of {bits} bits that are {format:?} are not read")),
        };
        Ok(Self {
            dims: [dims.0 as usize, dims.1 as usize],
            stored,
            bits,
            samples,
            is_planar,
            kind,
        })
    }

    /// Pixels of a page.
    pub(super) fn pixels(&self) -> usize {
        self.dims[0].saturating_mul(self.dims[1])
    }

    /// Bytes of a page, decompressed.
    pub(super) fn bytes(&self) -> u64 {
        let row = (self.dims[0] as u64).saturating_mul(u64::from(self.bits) * self.samples as u64);
        row.div_ceil(8).saturating_mul(self.dims[1] as u64)
    }

    /// Which number of a pixel is read: `chosen`, or a colour's luminance, or of other samples, which are channels, the first.
    pub(super) fn components(&self, path: &Path, chosen: Option<usize>) -> Result<Components, ReadError> {
        let first = (self.kind == Kind::Values).then_some(0);
        Components::new(path, self.samples, chosen.or(first))
    }

    /// The numbers of a page, pixel after pixel.
    pub(super) fn numbers(&self, page: DecodingResult) -> Voxels {
        let voxels = match page {
            DecodingResult::U8(v) if self.bits < 8 => Voxels::U8(unpacked(
                &v,
                self.bits,
                self.dims[0] * if self.is_planar { 1 } else { self.samples },
            )),
            DecodingResult::U8(v) => Voxels::U8(v),
            DecodingResult::I8(v) => Voxels::I8(v),
            DecodingResult::U16(v) => Voxels::U16(v),
            DecodingResult::I16(v) => Voxels::I16(v),
            DecodingResult::U32(v) => Voxels::U32(v),
            DecodingResult::I32(v) => Voxels::I32(v),
            DecodingResult::U64(v) => Voxels::F64(v.into_iter().map(|v| v as f64).collect()),
            DecodingResult::I64(v) => Voxels::F64(v.into_iter().map(|v| v as f64).collect()),
            DecodingResult::F16(v) => Voxels::F32(v.into_iter().map(f32::from).collect()),
            DecodingResult::F32(v) => Voxels::F32(v),
            DecodingResult::F64(v) => Voxels::F64(v),
        };
        let voxels = match self.is_planar && self.samples > 1 {
            true => map_type!(Voxels, voxels, Voxels, v => interleaved(&v, self.samples)),
            false => voxels,
        };
        match (self.kind, voxels) {
            (Kind::YCbCr, Voxels::U8(v)) => Voxels::U8(v.as_chunks().0.iter().flat_map(|pixel| rgb(*pixel)).collect()),
            (_, voxels) => voxels,
        }
    }
}

/// The numbers of `bits` each in rows of `width`, which begin at bytes.
fn unpacked(bytes: &[u8], bits: u8, width: usize) -> Vec<u8> {
    let mask = u8::MAX >> (8 - bits);
    let row_bytes = (width * usize::from(bits)).div_ceil(8);
    let number = |row: &[u8], i: usize| {
        let bit = i * usize::from(bits);
        let pair = u16::from(row[bit / 8]) << 8 | u16::from(row.get(bit / 8 + 1).copied().unwrap_or(0));
        (pair >> (16 - bit % 8 - usize::from(bits))) as u8 & mask
    };
    let rows = bytes.chunks_exact(row_bytes.max(1));
    rows.flat_map(|row| (0..width).map(move |i| number(row, i))).collect()
}

/// The planes' numbers, pixel after pixel.
fn interleaved<T: Voxel>(planes: &[T], count: usize) -> Vec<T> {
    let pixels = planes.len() / count;
    (0..pixels)
        .flat_map(|i| (0..count).map(move |plane| planes[plane * pixels + i]))
        .collect()
}

/// JFIF's colours: those of ITU-R BT.601, in the full range.
fn rgb([y, cb, cr]: [u8; 3]) -> [u8; 3] {
    let [y, cb, cr] = [f64::from(y), f64::from(cb) - 128.0, f64::from(cr) - 128.0];
    [y + 1.402 * cr, y - 0.344_136 * cb - 0.714_136 * cr, y + 1.772 * cb].map(u8::nearest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_few_bits_are_unpacked() {
        assert_eq!(unpacked(&[0b1010_0000, 0b1100_0000], 1, 3), [1, 0, 1, 1, 1, 0]);
        assert_eq!(unpacked(&[0x12, 0x30], 4, 3), [1, 2, 3]);
        assert_eq!(unpacked(&[0b0000_0100, 0b0010_0000], 6, 2), [1, 2]);
    }

    #[test]
    fn planes_are_interleaved() {
        assert_eq!(interleaved(&[1_u8, 2, 3, 4, 5, 6], 3), [1, 3, 5, 2, 4, 6]);
    }
}
