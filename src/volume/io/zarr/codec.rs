//! How a chunk's elements become the bytes of its file, and back.
//!
//! *Practice.* How many bytes a chunk has is known before it is decoded, so no decoder makes more: what expands to more than it may
//! is damaged, whatever its own header says.

use std::io::{self, Read};

use bzip2::read::MultiBzDecoder;
use flate2::read::{GzDecoder, ZlibDecoder};
use serde_json::Value;

use super::blosc;
use super::json::{Document, Named};
use crate::volume::io::error::ReadError;
use crate::volume::io::stored::ByteOrder;

/// The codecs of chunks.
#[derive(Debug)]
pub(super) struct Chain {
    /// The array's axes as they are stored, the fastest last.
    pub axes: Vec<usize>,
    /// The stored elements' byte order.
    pub order: ByteOrder,
    /// What the elements' bytes go through, in the order of writing.
    pub codecs: Vec<Codec>,
}

/// What bytes go through on their way to a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Codec {
    /// Deflate in a gzip member.
    Gzip,
    /// Deflate with zlib's header.
    Zlib,
    /// Bzip2.
    Bzip2,
    /// Zstandard.
    Zstd,
    /// An LZ4 block behind its length, as numcodecs writes it.
    Lz4,
    /// Blosc, version 1.
    Blosc,
    /// A CRC-32C behind the bytes.
    Crc32c,
    /// The first bytes of all elements of so many, then all second ones, …
    Shuffle(usize),
    /// Integers of so many bytes in this order, each less the one before it.
    Delta(usize, ByteOrder),
}

impl Chain {
    /// The chain of version 3 that `codecs` name, of chunks of so many `axes`.
    pub fn new(document: &Document, codecs: &[Named], axes: usize) -> Result<Self, ReadError> {
        let mut chain = Self {
            axes: (0..axes).collect(),
            order: ByteOrder::NATIVE,
            codecs: Vec::new(),
        };
        let mut are_bytes = false;
        for codec in codecs {
            match (codec.name.as_str(), Codec::named(&codec.name)) {
                ("transpose", _) if !are_bytes => chain.transpose(document, &codec.configuration)?,
                ("bytes" | "endian", _) if !are_bytes => {
                    chain.order = byte_order(document, &codec.configuration)?;
                    are_bytes = true;
                }
                (_, Some(known)) if are_bytes => chain.codecs.push(known),
                (name, _) => return Err(document.unsupported(format!("the codec `{name}` at its place"))),
            }
        }
        match are_bytes {
            true => Ok(chain),
            false => Err(document.wrong("its codecs do not say how elements become bytes")),
        }
    }

    fn transpose(&mut self, document: &Document, configuration: &Value) -> Result<(), ReadError> {
        let wrong = || document.wrong("the `order` of a transpose is no permutation of the axes");
        let order = configuration.get("order").and_then(Value::as_array).ok_or_else(wrong)?;
        let axis = |n: &Value| self.axes.get(usize::try_from(n.as_u64()?).ok()?).copied();
        let axes: Vec<usize> = order.iter().map(axis).collect::<Option<_>>().ok_or_else(wrong)?;
        let all_are_there = (0..self.axes.len()).all(|axis| axes.contains(&axis));
        if axes.len() != self.axes.len() || !all_are_there {
            return Err(wrong());
        }
        self.axes = axes;
        Ok(())
    }

    /// Whether axes are stored in their order.
    pub fn is_in_order(&self) -> bool {
        self.axes.is_sorted()
    }

    /// How many elements lie between neighbours along each axis of a stored chunk.
    pub fn strides(&self, chunk: &[usize]) -> Vec<usize> {
        let mut strides = vec![0; chunk.len()];
        let mut stride = 1;
        for &axis in self.axes.iter().rev() {
            strides[axis] = stride;
            stride *= chunk[axis];
        }
        strides
    }

    /// The `expected` bytes of a chunk's elements, of those in its file.
    pub fn decode(&self, mut bytes: Vec<u8>, expected: usize) -> io::Result<Vec<u8>> {
        for (before, codec) in self.codecs.iter().enumerate().rev() {
            // What is compressed twice, or has a checksum behind it, can be a little longer in between.
            let most = expected + before * (expected / 8 + (1 << 12));
            bytes = codec.decode(bytes, most)?;
        }
        match bytes.len() == expected {
            true => Ok(bytes),
            false => Err(damaged(format!("{} bytes are where {expected} should be", bytes.len()))),
        }
    }
}

fn byte_order(document: &Document, configuration: &Value) -> Result<ByteOrder, ReadError> {
    match configuration.get("endian").and_then(Value::as_str) {
        Some("little") => Ok(ByteOrder::Little),
        Some("big") => Ok(ByteOrder::Big),
        None => Ok(ByteOrder::NATIVE),
        Some(other) => Err(document.wrong(format!("`endian` is `{other}`, not little or big"))),
    }
}

impl Codec {
    /// The codec of a name that both versions use.
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "gzip" => Self::Gzip,
            "zstd" => Self::Zstd,
            "blosc" => Self::Blosc,
            "crc32c" => Self::Crc32c,
            "numcodecs.bz2" => Self::Bzip2,
            "numcodecs.zlib" => Self::Zlib,
            "numcodecs.lz4" => Self::Lz4,
            _ => return None,
        })
    }

    /// At most `most` bytes, of those that were written.
    fn decode(self, bytes: Vec<u8>, most: usize) -> io::Result<Vec<u8>> {
        match self {
            Self::Gzip => read_to(GzDecoder::new(&*bytes), most),
            Self::Zlib => read_to(ZlibDecoder::new(&*bytes), most),
            Self::Bzip2 => read_to(MultiBzDecoder::new(&*bytes), most),
            Self::Zstd => zstd::bulk::decompress(&bytes, most),
            Self::Lz4 => lz4(&bytes, most),
            Self::Blosc => blosc::decode(&bytes, most),
            Self::Crc32c => checked(bytes),
            Self::Shuffle(size) => Ok(unshuffled(&bytes, size)),
            Self::Delta(size, order) => Ok(summed(bytes, size, order)),
        }
    }
}

/// All of a stream, which has at most `most` bytes.
fn read_to(stream: impl Read, most: usize) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    stream.take(most as u64 + 1).read_to_end(&mut bytes)?;
    match bytes.len() <= most {
        true => Ok(bytes),
        false => Err(damaged(format!("it holds more than {most} bytes"))),
    }
}

/// An LZ4 block behind its decompressed length.
fn lz4(bytes: &[u8], most: usize) -> io::Result<Vec<u8>> {
    let (length, block) = bytes
        .split_first_chunk()
        .ok_or_else(|| damaged("its length is missing"))?;
    let length = u32::from_le_bytes(*length) as usize;
    if length > most {
        return Err(damaged(format!(
            "it says that it holds {length} bytes, and may hold {most}"
        )));
    }
    lz4_flex::block::decompress(block, length).map_err(|e| damaged(e.to_string()))
}

/// Bytes without the checksum behind them, which they have.
fn checked(mut bytes: Vec<u8>) -> io::Result<Vec<u8>> {
    let (data, sum) = bytes
        .split_last_chunk()
        .ok_or_else(|| damaged("its checksum is missing"))?;
    if crc32c::crc32c(data) != u32::from_le_bytes(*sum) {
        return Err(damaged("its checksum is another"));
    }
    bytes.truncate(bytes.len() - size_of::<u32>());
    Ok(bytes)
}

/// The bytes of elements of `size`, element after element. Bytes that make no whole element stay at the end.
fn unshuffled(bytes: &[u8], size: usize) -> Vec<u8> {
    let count = bytes.len() / size;
    let (planes, rest) = bytes.split_at(count * size);
    let elements = (0..count).flat_map(|i| (0..size).map(move |byte| planes[byte * count + i]));
    elements.chain(rest.iter().copied()).collect()
}

/// The integers of `size` bytes whose differences `bytes` are.
fn summed(mut bytes: Vec<u8>, size: usize, order: ByteOrder) -> Vec<u8> {
    let mut sum = 0_u64;
    for element in bytes.chunks_exact_mut(size) {
        let shifted = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        let difference = match order {
            ByteOrder::Little => element.iter().rev().fold(0, shifted),
            ByteOrder::Big => element.iter().fold(0, shifted),
        };
        sum = sum.wrapping_add(difference);
        match order {
            ByteOrder::Little => element.copy_from_slice(&sum.to_le_bytes()[..size]),
            ByteOrder::Big => element.copy_from_slice(&sum.to_be_bytes()[8 - size..]),
        }
    }
    bytes
}

/// The error for compressed bytes that are wrong.
pub(super) fn damaged(what: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_are_undone() {
        assert_eq!(unshuffled(&[1, 3, 5, 2, 4, 6, 7], 2), [1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(summed(vec![255, 0, 2, 0, 9], 2, ByteOrder::Little), [255, 0, 1, 1, 9]);
        assert_eq!(summed(vec![0, 255, 0, 2], 2, ByteOrder::Big), [0, 255, 1, 1]);
        assert_eq!(summed(vec![1, 255, 255], 1, ByteOrder::Big), [1, 0, 255]);
    }
}
