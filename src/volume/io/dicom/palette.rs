//! Colours that are not red, green and blue in the file: a palette's, and luma with chromas.

use std::path::Path;

use dicom_core::Tag;
use dicom_dictionary_std::tags;

use super::dataset::Dataset;
use super::layout::Layout;
use super::segments;
use crate::volume::io::error::ReadError;
use crate::volume::io::stored::ByteOrder;

/// Where the tables of red, green and blue are: entry by entry, or in segments.
const TABLES: [(Tag, Tag); 3] = [
    (
        tags::RED_PALETTE_COLOR_LOOKUP_TABLE_DATA,
        tags::SEGMENTED_RED_PALETTE_COLOR_LOOKUP_TABLE_DATA,
    ),
    (
        tags::GREEN_PALETTE_COLOR_LOOKUP_TABLE_DATA,
        tags::SEGMENTED_GREEN_PALETTE_COLOR_LOOKUP_TABLE_DATA,
    ),
    (
        tags::BLUE_PALETTE_COLOR_LOOKUP_TABLE_DATA,
        tags::SEGMENTED_BLUE_PALETTE_COLOR_LOOKUP_TABLE_DATA,
    ),
];

/// The colours that indices stand for, as 8 or 16 bits each.
#[derive(Debug)]
pub(super) struct Palette {
    /// The index of the first colour.
    first: i64,
    colours: Vec<[i64; 3]>,
    /// The largest value of a colour.
    pub most: i64,
}

impl Palette {
    /// The palette of `dataset` (PS3.3, C.7.6.3.1.5 and 6).
    pub(super) fn new(path: &Path, dataset: &Dataset) -> Result<Self, ReadError> {
        let missing = || ReadError::unsupported(path, "it has no palette that is read").hint("convert it to RGB");
        let descriptor = tags::RED_PALETTE_COLOR_LOOKUP_TABLE_DESCRIPTOR;
        let [entries, first, bits] = dataset.vector::<3>(descriptor).ok_or_else(missing)?;
        let count = if entries == 0.0 { 1 << 16 } else { entries as usize };
        let tables = TABLES.map(|(whole, segmented)| {
            let entries = dataset
                .bytes(whole)
                .and_then(|(bytes, order)| table(bytes, order, count));
            entries.or_else(|| {
                let (bytes, order) = dataset.bytes(segmented)?;
                segments::expanded(&words(bytes, order), count)
            })
        });
        let [Some(red), Some(green), Some(blue)] = tables else {
            return Err(missing());
        };
        // Indices of a byte get colours of a byte, as in GDCM: scanners fill the other half of 16 bits anyhow.
        let wide = bits > 8.0 && dataset.number(tags::BITS_ALLOCATED) != Some(8.0);
        let shift = if bits > 8.0 && !wide { 8 } else { 0 };
        Ok(Self {
            first: first as i64,
            colours: (0..count)
                .map(|i| [red[i], green[i], blue[i]].map(|v| v >> shift))
                .collect(),
            most: if wide { 65535 } else { 255 },
        })
    }

    /// The colours that `indices` stand for, one after another; those beyond an end are the end's.
    pub(super) fn colours(&self, indices: &[i64]) -> Vec<i64> {
        let last = self.colours.len() - 1;
        let colour = |&i: &i64| self.colours[((i - self.first).max(0) as usize).min(last)];
        indices.iter().flat_map(colour).collect()
    }
}

/// The entries of a table: a byte each where it has no more bytes than entries, else two.
fn table(bytes: &[u8], order: ByteOrder, count: usize) -> Option<Vec<i64>> {
    if bytes.len() >= 2 * count {
        return Some(words(&bytes[..2 * count], order).into_iter().map(i64::from).collect());
    }
    let entries = bytes.get(..count)?;
    Some(entries.iter().map(|&b| i64::from(b)).collect())
}

/// Bytes as words.
fn words(bytes: &[u8], order: ByteOrder) -> Vec<u16> {
    let (pairs, _) = bytes.as_chunks();
    let word = match order {
        ByteOrder::Little => u16::from_le_bytes,
        ByteOrder::Big => u16::from_be_bytes,
    };
    pairs.iter().map(|pair| word(*pair)).collect()
}

/// Luma and chromas of full range become red, green and blue (PS3.3, C.7.6.3.1.2), in place.
pub(super) fn make_rgb(values: &mut [i64], layout: &Layout) {
    let [_, most] = layout.range();
    let half = (most + 1) / 2;
    for pixel in values.chunks_exact_mut(3) {
        pixel.copy_from_slice(&rgb([pixel[0], pixel[1], pixel[2]], half, most));
    }
}

fn rgb(ybr: [i64; 3], half: i64, most: i64) -> [i64; 3] {
    let [y, b, r] = [ybr[0], ybr[1] - half, ybr[2] - half].map(|v| v as f64);
    [y + 1.402 * r, y - 0.344136 * b - 0.714136 * r, y + 1.772 * b].map(|v| (v.round() as i64).clamp(0, most))
}

/// The same of uncompressed pairs of pixels: two lumas and a chroma of each kind.
pub(super) fn rgb_of_422(values: &[i64], layout: &Layout) -> Vec<i64> {
    let [_, most] = layout.range();
    let half = (most + 1) / 2;
    let mut pixels = Vec::with_capacity(layout.pixels() * 3);
    for row in values.chunks_exact(layout.columns.div_ceil(2) * 4) {
        let lumas = row
            .chunks_exact(4)
            .flat_map(|q| [[q[0], q[2], q[3]], [q[1], q[2], q[3]]]);
        pixels.extend(lumas.take(layout.columns).flat_map(|ybr| rgb(ybr, half, most)));
    }
    pixels
}
