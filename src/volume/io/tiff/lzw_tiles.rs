//! Tiles compressed by LZW, put together to a page.
//!
//! *Practice.* The `tiff` crate (0.11.3) reads a tile that the page's edge cuts row by row, and takes a row that comes of codes in
//! hand, without another byte of the file, for the end of the data. So tiles are decompressed here, each as a whole, by the crate
//! that `tiff` has it done by.

use std::io::{self, ErrorKind, Read, Seek, SeekFrom};

use half::f16;
use tiff::TiffError;
use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::{ByteOrder, CompressionMethod, Predictor, Tag};
use weezl::BitOrder;
use weezl::decode::Configuration;

use super::page::Layout;
use crate::volume::io::stored::{ByteOrder as Order, Stored};
use crate::volume::voxel::VoxelType;

/// The most bytes that a code stands for: there are no more codes.
const MOST_OF_A_CODE: u64 = 4096;

/// The tiles of a page.
pub(super) struct LzwTiles {
    /// Pixels of each along x and y.
    size: [usize; 2],
    /// Where in the file each begins, and its bytes.
    places: Vec<(u64, u64)>,
    predictor: Predictor,
    order: Order,
}

impl LzwTiles {
    /// Those of the page in hand; `None` if that is no page of such tiles, or if its numbers are parts of bytes.
    pub(super) fn of<R: Read + Seek>(decoder: &mut Decoder<R>, layout: &Layout) -> Result<Option<Self>, TiffError> {
        let compression: Option<u16> = decoder.find_tag_unsigned(Tag::Compression)?;
        let size = [
            decoder.find_tag_unsigned(Tag::TileWidth)?,
            decoder.find_tag_unsigned(Tag::TileLength)?,
        ];
        let ([Some(width), Some(height)], Some(method)) = (size, compression) else {
            return Ok(None);
        };
        let is_whole = layout.bits.is_multiple_of(8);
        if method != CompressionMethod::LZW.to_u16() || !is_whole || width == 0 || height == 0 {
            return Ok(None);
        }
        let offsets: Vec<u64> = decoder.find_tag_unsigned_vec(Tag::TileOffsets)?.unwrap_or_default();
        let bytes: Vec<u64> = decoder.find_tag_unsigned_vec(Tag::TileByteCounts)?.unwrap_or_default();
        let predictor: Option<u16> = decoder.find_tag_unsigned(Tag::Predictor)?;
        Ok(Some(Self {
            size: [width, height],
            places: offsets.into_iter().zip(bytes).collect(),
            predictor: predictor.and_then(Predictor::from_u16).unwrap_or(Predictor::None),
            order: match decoder.byte_order() {
                ByteOrder::LittleEndian => Order::Little,
                ByteOrder::BigEndian => Order::Big,
            },
        }))
    }

    /// The page's numbers as they are stored: planes one after the other, if it has them.
    pub(super) fn read(&self, file: &mut (impl Read + Seek), layout: &Layout) -> io::Result<DecodingResult> {
        let (planes, samples) = if layout.is_planar {
            (layout.samples, 1)
        } else {
            (1, layout.samples)
        };
        let pixel = samples * number_bytes(layout);
        let [columns, rows] = layout.dims;
        let [width, height] = self.size;
        let [across, down] = [columns.div_ceil(width), rows.div_ceil(height)];
        if self.places.len() < across * down * planes {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        let mut page = vec![0; planes * rows * columns * pixel];
        for (n, place) in self.places.iter().take(across * down * planes).enumerate() {
            let tile = self.tile(file, *place, samples, layout)?;
            let (x, y, plane) = (n % across * width, n / across % down * height, n / (across * down));
            let shown = (columns - x).min(width) * pixel;
            for (row, from) in tile.chunks_exact(width * pixel).take(rows - y).enumerate() {
                let to = ((plane * rows + y + row) * columns + x) * pixel;
                page[to..to + shown].copy_from_slice(&from[..shown]);
            }
        }
        Ok(numbers(page, layout))
    }

    /// A tile's bytes, decompressed and in the machine's order.
    fn tile(
        &self,
        file: &mut (impl Read + Seek),
        (offset, bytes): (u64, u64),
        samples: usize,
        layout: &Layout,
    ) -> io::Result<Vec<u8>> {
        file.seek(SeekFrom::Start(offset))?;
        let mut compressed = Vec::new();
        file.take(bytes).read_to_end(&mut compressed)?;
        let [width, height] = self.size;
        let count = width
            .checked_mul(height)
            .and_then(|n| n.checked_mul(samples * number_bytes(layout)));
        // Codes have nine bits at least.
        let most = compressed.len() as u64 * 8 / 9 * MOST_OF_A_CODE;
        let count = count
            .filter(|count| *count as u64 <= most)
            .ok_or(ErrorKind::UnexpectedEof)?;
        let mut tile = decompressed(&compressed, count)?;
        let size = number_bytes(layout);
        for row in tile.chunks_exact_mut(width * samples * size) {
            match self.predictor {
                Predictor::FloatingPoint => from_byte_planes(row, samples, size),
                predictor => {
                    if self.order == Order::Big {
                        row.chunks_exact_mut(size).for_each(<[u8]>::reverse);
                    }
                    if predictor == Predictor::Horizontal {
                        sum_up(row, samples, size);
                    }
                }
            }
            if Order::NATIVE == Order::Big {
                row.chunks_exact_mut(size).for_each(<[u8]>::reverse);
            }
        }
        Ok(tile)
    }
}

/// The first `count` bytes that `compressed` holds.
fn decompressed(compressed: &[u8], count: usize) -> io::Result<Vec<u8>> {
    let mut decoder = Configuration::with_tiff_size_switch(BitOrder::Msb, 8)
        .with_yield_on_full_buffer(true)
        .build();
    let mut bytes = vec![0; count];
    let (mut read, mut done) = (0, 0);
    while done < count {
        let result = decoder.decode_bytes(&compressed[read..], &mut bytes[done..]);
        read += result.consumed_in;
        done += result.consumed_out;
        result.status.map_err(|e| io::Error::new(ErrorKind::InvalidData, e))?;
        if result.consumed_in == 0 && result.consumed_out == 0 {
            return Err(ErrorKind::UnexpectedEof.into());
        }
    }
    Ok(bytes)
}

/// Numbers of `size` bytes, the lowest first, for their differences from those a pixel of `samples` before.
fn sum_up(row: &mut [u8], samples: usize, size: usize) {
    for at in (samples * size..row.len()).step_by(size) {
        let number = |at: usize| (0..size).rev().fold(0_u64, |sum, i| sum << 8 | u64::from(row[at + i]));
        let sum = number(at).wrapping_add(number(at - samples * size));
        row[at..at + size].copy_from_slice(&sum.to_le_bytes()[..size]);
    }
}

/// Numbers, the lowest byte first, for the differences of their bytes, of which those of each rank are together, the highest first.
fn from_byte_planes(row: &mut [u8], samples: usize, size: usize) {
    for at in samples..row.len() {
        row[at] = row[at].wrapping_add(row[at - samples]);
    }
    let planes = row.to_vec();
    let count = row.len() / size;
    for (n, number) in row.chunks_exact_mut(size).enumerate() {
        for (rank, byte) in number.iter_mut().rev().enumerate() {
            *byte = planes[rank * count + n];
        }
    }
}

/// Bytes of a number in the file.
fn number_bytes(layout: &Layout) -> usize {
    usize::from(layout.bits) / 8
}

/// Bytes as numbers of their type.
fn numbers(bytes: Vec<u8>, layout: &Layout) -> DecodingResult {
    use bytemuck::pod_collect_to_vec as cast;
    match layout.stored {
        Stored::Voxel(VoxelType::U8) => DecodingResult::U8(bytes),
        Stored::Voxel(VoxelType::I8) => DecodingResult::I8(cast(&bytes)),
        Stored::Voxel(VoxelType::U16) => DecodingResult::U16(cast(&bytes)),
        Stored::Voxel(VoxelType::I16) => DecodingResult::I16(cast(&bytes)),
        Stored::Voxel(VoxelType::U32) => DecodingResult::U32(cast(&bytes)),
        Stored::Voxel(VoxelType::I32) => DecodingResult::I32(cast(&bytes)),
        Stored::Voxel(VoxelType::F32) if layout.bits == 16 => {
            let halves: Vec<u16> = cast(&bytes);
            DecodingResult::F16(halves.into_iter().map(f16::from_bits).collect())
        }
        Stored::Voxel(VoxelType::F32) => DecodingResult::F32(cast(&bytes)),
        Stored::Voxel(VoxelType::F64) => DecodingResult::F64(cast(&bytes)),
        Stored::I64 => DecodingResult::I64(cast(&bytes)),
        Stored::U64 => DecodingResult::U64(cast(&bytes)),
    }
}
