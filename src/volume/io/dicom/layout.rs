//! How a file's pixels are laid out, and their bits made stored values.

use std::path::Path;

use dicom_dictionary_std::tags;

use super::dataset::Dataset;
use super::source::printable;
use crate::volume::io::error::ReadError;
use crate::volume::io::stored::ByteOrder;

/// The most samples a frame may have: more than any detector's, and what a gibibyte of stored values holds.
const MAX_SAMPLES: usize = 1 << 27;

/// What the samples of a pixel are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Colour {
    /// One value.
    Gray,
    /// An index into the file's palette.
    Palette,
    /// Red, green, blue.
    Rgb,
    /// Luma and two chromas.
    Ybr,
    /// The same, with a chroma of each kind for two pixels, uncompressed.
    Ybr422,
}

/// The pixels' layout.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    /// Pixels along y.
    pub rows: usize,
    /// Pixels along x.
    pub columns: usize,
    /// Samples a pixel.
    pub samples: usize,
    /// Bits that a sample takes.
    pub allocated: u32,
    /// Bits of it that count.
    pub stored: u32,
    /// The highest of those.
    pub high: u32,
    /// Whether they are a two's complement.
    pub signed: bool,
    /// Whether all of a frame's samples of one kind come before the next kind's.
    pub planar: bool,
    /// What the samples are.
    pub colour: Colour,
    /// Whether the smallest value is the brightest (MONOCHROME1).
    pub is_inverse: bool,
    /// The byte order of uncompressed samples.
    pub order: ByteOrder,
}

impl Layout {
    /// What `dataset` says.
    pub(super) fn new(path: &Path, dataset: &Dataset, order: ByteOrder) -> Result<Self, ReadError> {
        let whole = |tag, missing: f64| dataset.number(tag).unwrap_or(missing).max(0.0) as usize;
        let samples = whole(tags::SAMPLES_PER_PIXEL, 1.0);
        let allocated = whole(tags::BITS_ALLOCATED, 16.0) as u32;
        let stored = (whole(tags::BITS_STORED, f64::from(allocated)) as u32).clamp(1, allocated.max(1));
        let high = whole(tags::HIGH_BIT, f64::from(stored) - 1.0) as u32;
        let layout = Self {
            rows: whole(tags::ROWS, 0.0),
            columns: whole(tags::COLUMNS, 0.0),
            samples,
            allocated,
            stored,
            // A high bit that leaves no room for the others is a mistake, and they are the lowest.
            high: if (stored..=allocated).contains(&(high + 1)) {
                high
            } else {
                stored - 1
            },
            signed: whole(tags::PIXEL_REPRESENTATION, 0.0) == 1,
            planar: samples > 1 && whole(tags::PLANAR_CONFIGURATION, 0.0) == 1,
            colour: colour(path, dataset, samples)?,
            is_inverse: samples == 1
                && dataset.text(tags::PHOTOMETRIC_INTERPRETATION).as_deref() == Some("MONOCHROME1"),
            order,
        };
        layout.check(path).map(|()| layout)
    }

    fn check(&self, path: &Path) -> Result<(), ReadError> {
        let Self { rows, columns, .. } = *self;
        if rows == 0 || columns == 0 {
            return Err(ReadError::header(
                path,
                format!("its image has {columns} columns and {rows} rows"),
            ));
        }
        if !matches!(self.allocated, 1 | 8 | 16 | 32) {
            let what = format!("samples of {} bits are not read", self.allocated);
            return Err(ReadError::unsupported(path, what).hint("convert it to 8, 16 or 32 bits a sample"));
        }
        match self
            .pixels()
            .checked_mul(self.samples)
            .is_some_and(|n| n <= MAX_SAMPLES)
        {
            true => Ok(()),
            false => Err(ReadError::header(
                path,
                format!("an image of {columns} x {rows} pixels is not believed"),
            )),
        }
    }

    /// Pixels of a frame.
    pub(super) fn pixels(&self) -> usize {
        self.rows * self.columns
    }

    /// Samples of an uncompressed frame.
    pub(super) fn native_samples(&self) -> usize {
        match self.colour {
            Colour::Ybr422 => self.rows * self.columns.div_ceil(2) * 4,
            _ => self.pixels() * self.samples,
        }
    }

    /// Numbers that a voxel has in the file, as a user would count them.
    pub(super) fn components(&self) -> usize {
        if self.colour == Colour::Gray { 1 } else { 3 }
    }

    /// The smallest and the largest value that can be stored.
    pub(super) fn range(&self) -> [i64; 2] {
        let size = 1i64 << self.stored;
        match self.signed {
            true => [-size / 2, size / 2 - 1],
            false => [0, size - 1],
        }
    }

    /// What is as bright as a value of an inverse image: the largest for the smallest.
    pub(super) fn turned(&self, value: i64) -> i64 {
        let [least, most] = self.range();
        least + most - value
    }

    /// The stored value in a sample: without the bits above and below, which overlays may be in, and with its sign. `shift` is
    /// how far up it is.
    pub(super) fn value(&self, sample: i64, shift: u32) -> i64 {
        let unused = 64 - self.stored;
        let up = sample >> shift << unused;
        match self.signed {
            true => up >> unused,
            false => (up as u64 >> unused) as i64,
        }
    }

    /// How far up in an allocated sample its value is.
    pub(super) fn shift(&self) -> u32 {
        self.high + 1 - self.stored
    }

    /// Whether samples of a byte or less are swapped in pairs, since `words` are in big endian.
    pub(super) fn swaps(&self, words: bool) -> bool {
        words && self.order == ByteOrder::Big && self.allocated <= 8
    }

    /// The stored values in the bytes of an uncompressed frame that starts `skip` bits into them.
    pub(super) fn native(&self, bytes: &[u8], skip: usize) -> Vec<i64> {
        let shift = self.shift();
        let big = self.order == ByteOrder::Big;
        match self.allocated {
            1 => {
                let bit = |i: usize| i64::from(bytes.get(i / 8).copied().unwrap_or(0) >> (i % 8) & 1);
                (skip..skip + self.native_samples()).map(bit).collect()
            }
            8 => {
                let own = bytes.iter().skip(skip / 8).take(self.native_samples());
                own.map(|&b| self.value(i64::from(b), shift)).collect()
            }
            16 => {
                let number = |b: &[u8]| {
                    if big {
                        u16::from_be_bytes([b[0], b[1]])
                    } else {
                        u16::from_le_bytes([b[0], b[1]])
                    }
                };
                bytes
                    .chunks_exact(2)
                    .map(|b| self.value(i64::from(number(b)), shift))
                    .collect()
            }
            _ => {
                let number = |b: &[u8]| {
                    let b = [b[0], b[1], b[2], b[3]];
                    if big {
                        u32::from_be_bytes(b)
                    } else {
                        u32::from_le_bytes(b)
                    }
                };
                bytes
                    .chunks_exact(4)
                    .map(|b| self.value(i64::from(number(b)), shift))
                    .collect()
            }
        }
    }
}

fn colour(path: &Path, dataset: &Dataset, samples: usize) -> Result<Colour, ReadError> {
    let name = dataset.text(tags::PHOTOMETRIC_INTERPRETATION).unwrap_or_default();
    match (name.as_str(), samples) {
        ("PALETTE COLOR", 1) => Ok(Colour::Palette),
        (_, 1) => Ok(Colour::Gray),
        ("YBR_FULL" | "YBR_PARTIAL_420", 3) => Ok(Colour::Ybr),
        ("YBR_FULL_422" | "YBR_PARTIAL_422", 3) => Ok(Colour::Ybr422),
        (_, 3) => Ok(Colour::Rgb),
        _ => {
            let what = format!(
                "pixels of {samples} samples that are `{}` are not read",
                printable(&name)
            );
            Err(ReadError::unsupported(path, what).hint("convert it to one value a pixel, or to RGB"))
        }
    }
}
