//! Blosc, version 1: blocks of bytes, shuffled and compressed each by itself.
//!
//! Format: c-blosc's README_CHUNK_FORMAT, and the format of BloscLZ in its blosclz.c.

use std::io::{self, Read};
use std::ops::Range;

use flate2::read::ZlibDecoder;

use super::codec::damaged;

/// Bytes of the header.
const HEADER: usize = 16;

/// The most streams of a block.
const MAX_STREAMS: usize = 16;

/// The least bytes of one of several streams.
const MIN_STREAM: usize = 128;

/// What the header says.
struct Header {
    flags: u8,
    /// Bytes of an element.
    element: usize,
    /// Bytes in all.
    length: usize,
    /// Bytes of a block.
    block: usize,
}

/// Bits of the flags, below the three that name the compressor.
mod flag {
    /// The bytes of elements are sorted by their place in the element.
    pub const SHUFFLE: u8 = 1;
    /// Nothing is compressed.
    pub const COPIED: u8 = 2;
    /// The bits of elements are sorted by their place in the element.
    pub const BIT_SHUFFLE: u8 = 4;
    /// A block is one stream, not one for each byte of an element.
    pub const WHOLE: u8 = 16;
}

/// The bytes that are compressed in `bytes`, at most `most`.
pub(super) fn decode(bytes: &[u8], most: usize) -> io::Result<Vec<u8>> {
    let header = Header::new(bytes)?;
    if header.length > most {
        let length = header.length;
        return Err(damaged(format!(
            "it says that it holds {length} bytes, and may hold {most}"
        )));
    }
    if header.flags & flag::COPIED != 0 {
        let copied = bytes.get(HEADER..HEADER + header.length);
        return copied.map(<[u8]>::to_vec).ok_or_else(|| damaged("it ends too soon"));
    }
    let mut all = vec![0; header.length];
    for (n, out) in all.chunks_mut(header.block.max(1)).enumerate() {
        let start = number(bytes, HEADER + 4 * n)?;
        let block = bytes.get(start..).ok_or_else(|| damaged("a block is beyond its end"))?;
        header.decode_block(block, out)?;
    }
    Ok(all)
}

/// The number in 32 bits at byte `at`.
fn number(bytes: &[u8], at: usize) -> io::Result<usize> {
    let number = bytes.get(at..).and_then(<[u8]>::first_chunk);
    let number = number.ok_or_else(|| damaged("it ends too soon"))?;
    Ok(u32::from_le_bytes(*number) as usize)
}

impl Header {
    fn new(bytes: &[u8]) -> io::Result<Self> {
        if bytes.len() < HEADER {
            return Err(damaged("it has no header of Blosc"));
        }
        let header = Self {
            flags: bytes[2],
            element: usize::from(bytes[3]).max(1),
            length: number(bytes, 4)?,
            block: number(bytes, 8)?,
        };
        match header.length > 0 && header.block == 0 {
            true => Err(damaged("its blocks have no bytes")),
            false => Ok(header),
        }
    }

    /// Fills `out` with what is compressed at the start of `block`.
    fn decode_block(&self, block: &[u8], out: &mut [u8]) -> io::Result<()> {
        // The last block is one stream if it is shorter, and so are blocks of large or few elements.
        let may_split = self.element <= MAX_STREAMS && self.block / self.element >= MIN_STREAM;
        let is_split = self.flags & flag::WHOLE == 0 && may_split && out.len() == self.block;
        let streams = if is_split { self.element } else { 1 };
        let length = out.len() / streams;
        let mut at = 0;
        for out in out.chunks_mut(length.max(1)).take(streams) {
            let compressed = number(block, at)?;
            at += 4;
            let stream = block.get(at..).and_then(|rest| rest.get(..compressed));
            self.decode_stream(stream.ok_or_else(|| damaged("a stream is beyond its end"))?, out)?;
            at += compressed;
        }
        if self.flags & flag::SHUFFLE != 0 && self.element > 1 {
            unshuffle(out, self.element);
        } else if self.flags & flag::BIT_SHUFFLE != 0 {
            unshuffle_bits(out, self.element);
        }
        Ok(())
    }

    /// Fills `out` with what `stream` holds; of the same length it is not compressed.
    fn decode_stream(&self, stream: &[u8], out: &mut [u8]) -> io::Result<()> {
        if stream.len() == out.len() {
            out.copy_from_slice(stream);
            return Ok(());
        }
        let length = match self.flags >> 5 {
            0 => blosclz(stream, out).ok_or_else(|| damaged("its BloscLZ is wrong"))?,
            1 => lz4_flex::block::decompress_into(stream, out).map_err(|e| damaged(e.to_string()))?,
            3 => {
                ZlibDecoder::new(stream).read_exact(out)?;
                out.len()
            }
            4 => zstd::bulk::decompress_to_buffer(stream, out)?,
            2 => return Err(damaged("it is compressed by Snappy, which is not read")),
            n => {
                return Err(damaged(format!(
                    "it is compressed by a way numbered {n}, which is not read"
                )));
            }
        };
        match length == out.len() {
            true => Ok(()),
            false => Err(damaged("a stream holds less than its block")),
        }
    }
}

/// Puts the bytes of elements of `size` together again, of which first all first ones came, then all second ones.
fn unshuffle(bytes: &mut [u8], size: usize) {
    let count = bytes.len() / size;
    let shuffled = bytes[..count * size].to_vec();
    for (place, plane) in shuffled.chunks(count.max(1)).enumerate() {
        for (element, byte) in plane.iter().enumerate() {
            bytes[element * size + place] = *byte;
        }
    }
}

/// Puts the bits of elements of `size` bytes together again, of which first all first ones came, and so on. They were taken apart
/// only where the elements are a multiple of eight.
fn unshuffle_bits(bytes: &mut [u8], size: usize) {
    let count = bytes.len() / size;
    if !count.is_multiple_of(8) {
        return;
    }
    let shuffled = bytes[..count * size].to_vec();
    bytes[..count * size].fill(0);
    for (bit, plane) in shuffled.chunks((count / 8).max(1)).enumerate() {
        for (eight, bits) in plane.iter().enumerate() {
            for n in 0..8 {
                let element = eight * 8 + n;
                bytes[element * size + bit / 8] |= (bits >> n & 1) << (bit % 8);
            }
        }
    }
}

/// The farthest that a short match reaches back.
const NEAR: usize = 8191;

/// Fills `out` with what a BloscLZ stream holds, and says how much that is; `None` where the stream is wrong.
fn blosclz(stream: &[u8], out: &mut [u8]) -> Option<usize> {
    let mut bytes = stream.iter().copied();
    let mut length = 0;
    // The first token is of literals, whatever its upper bits are.
    let mut token = usize::from(bytes.next()? & 31);
    loop {
        length = match token < 32 {
            true => {
                let literals = out.get_mut(length..length + token + 1)?;
                literals.iter_mut().try_for_each(|place| {
                    *place = bytes.next()?;
                    Some(())
                })?;
                length + token + 1
            }
            false => copy_match(out, length, blosclz_match(token, &mut bytes)?)?,
        };
        match bytes.next() {
            Some(next) => token = usize::from(next),
            None => return Some(length),
        }
    }
}

/// How far back a match lies and how long it is, as the token and what follows it say.
fn blosclz_match(token: usize, bytes: &mut impl Iterator<Item = u8>) -> Option<(usize, usize)> {
    let mut length = (token >> 5) + 2;
    if token >> 5 == 7 {
        loop {
            let more = bytes.next()?;
            length += usize::from(more);
            if more != 255 {
                break;
            }
        }
    }
    let (high, low) = (token & 31, usize::from(bytes.next()?));
    let back = match (high, low) {
        (31, 255) => NEAR + (usize::from(bytes.next()?) << 8) + usize::from(bytes.next()?),
        _ => (high << 8) + low,
    };
    Some((back + 1, length))
}

/// Repeats what lies `back` bytes before `at`; where it ends.
fn copy_match(out: &mut [u8], at: usize, (back, length): (usize, usize)) -> Option<usize> {
    let from: Range<usize> = at.checked_sub(back)?..at;
    out.get(at..at.checked_add(length)?)?;
    for n in 0..length {
        out[at + n] = out[from.start + n];
    }
    Some(at + length)
}
