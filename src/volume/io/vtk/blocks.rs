//! Compressed arrays: blocks, after a header of their sizes.
//!
//! *Practice.* A block's size is a claim, and so is the number of blocks. What is read grows with what is really there, and
//! decompression stops at the size that is declared.

use std::io::{self, Read};

use flate2::read::ZlibDecoder;
use lzma_rust2::XzReader;

use super::xml_header::{Compressor, Words};

/// Memory for LZMA's dictionary: that of its highest preset, 64 MiB, and what goes with it.
const LZMA_KIB: u32 = 66 << 10;

/// LZ4's best ratio: a byte of a match's length stands for 255.
const LZ4_RATIO: u64 = 255;

impl Compressor {
    /// More bytes than this for one are no compressor's: deflate, LZ4, and LZMA, whose cheapest match of 273 bytes takes a
    /// quarter of a bit.
    pub(super) fn best_ratio(self) -> u64 {
        match self {
            Self::Zlib => 1032,
            Self::Lz4 => LZ4_RATIO,
            Self::Lzma => 273 * 8 * 4,
        }
    }

    /// The first `size` bytes that `compressed` holds.
    fn decompress(self, compressed: &[u8], size: usize) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let limit = size as u64;
        match self {
            Self::Zlib => ZlibDecoder::new(compressed).take(limit).read_to_end(&mut bytes)?,
            Self::Lzma => XzReader::new_mem_limit(compressed, false, LZMA_KIB)
                .take(limit)
                .read_to_end(&mut bytes)?,
            Self::Lz4 => {
                if limit / LZ4_RATIO > compressed.len() as u64 {
                    return Err(damaged("a block is larger than its bytes can hold"));
                }
                bytes.resize(size, 0);
                let found = lz4_flex::block::decompress_into(compressed, &mut bytes).map_err(damaged)?;
                bytes.truncate(found);
                found
            }
        };
        match bytes.len() == size {
            true => Ok(bytes),
            false => Err(damaged("a block holds less than is declared")),
        }
    }
}

fn damaged(what: impl ToString) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what.to_string())
}

/// The decompressed bytes of an array.
pub(super) struct Blocks<R> {
    stream: R,
    compressor: Compressor,
    /// Of each block that is still to come, the last first: bytes compressed, and decompressed.
    sizes: Vec<(u64, u64)>,
    block: Vec<u8>,
    /// How many of `block` are read.
    done: usize,
}

impl<R: Read> Blocks<R> {
    /// The array at `stream`.
    pub(super) fn new(mut stream: R, words: Words, compressor: Compressor) -> io::Result<Self> {
        let [count, full, last] = words.read(&mut stream)?;
        let bytes = count
            .checked_mul(words.bytes() as u64)
            .ok_or_else(|| damaged("it has too many blocks"))?;
        let mut table = Vec::new();
        if stream.by_ref().take(bytes).read_to_end(&mut table)? as u64 != bytes {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let mut sizes: Vec<_> = words.all(&table).map(|compressed| (compressed, full)).collect();
        if let (Some(size), 1..) = (sizes.last_mut(), last) {
            size.1 = last;
        }
        sizes.reverse();
        Ok(Self {
            stream,
            compressor,
            sizes,
            block: Vec::new(),
            done: 0,
        })
    }

    /// How many bytes all blocks declare.
    pub(super) fn declared(&self) -> u64 {
        self.sizes
            .iter()
            .fold(0, |sum: u64, (_, size)| sum.saturating_add(*size))
    }

    fn next_block(&mut self) -> io::Result<()> {
        self.done = 0;
        self.block.clear();
        while self.block.is_empty() {
            let Some((compressed, size)) = self.sizes.pop() else {
                break;
            };
            let mut bytes = Vec::new();
            if self.stream.by_ref().take(compressed).read_to_end(&mut bytes)? as u64 != compressed {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            self.block = self.compressor.decompress(&bytes, size as usize)?;
        }
        Ok(())
    }
}

impl<R: Read> Read for Blocks<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.done == self.block.len() {
            self.next_block()?;
        }
        let n = into.len().min(self.block.len() - self.done);
        into[..n].copy_from_slice(&self.block[self.done..self.done + n]);
        self.done += n;
        Ok(n)
    }
}
