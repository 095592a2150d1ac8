//! Payloads in characters: numbers, and bytes as hexadecimal digits.

use std::fmt;
use std::io::{self, BufRead, ErrorKind, Read};

use bytemuck::Pod;

use super::stored::{Stored, for_stored};

/// The most characters of a number.
const MAX_WORD: usize = 1024;

/// A word that is no number of the declared type.
#[derive(Debug)]
pub(super) struct NoNumber(pub String);

impl fmt::Display for NoNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` is no number of the type", self.0)
    }
}

impl std::error::Error for NoNumber {}

/// The bytes, in this machine's order, of numbers separated by white space or commas.
pub(super) struct Numbers<R> {
    reader: R,
    stored: Stored,
    /// The bytes of one number.
    number: [u8; 8],
    /// Which of them are still to be read.
    left: std::ops::Range<usize>,
}

impl<R: BufRead> Numbers<R> {
    pub(super) fn new(reader: R, stored: Stored) -> Self {
        Self {
            reader,
            stored,
            number: [0; 8],
            left: 0..0,
        }
    }

    /// Makes the next word the number; `false` at the end.
    fn advance(&mut self) -> io::Result<bool> {
        let word = next_word(&mut self.reader)?;
        if word.is_empty() {
            return Ok(false);
        }
        self.left = 0..self.stored.bytes();
        let parsed = for_stored!(self.stored, T => parse::<T>(&word, &mut self.number));
        parsed.ok_or_else(|| {
            let start = String::from_utf8_lossy(&word).chars().take(40).collect();
            io::Error::new(ErrorKind::InvalidData, NoNumber(start))
        })?;
        Ok(true)
    }
}

impl<R: BufRead> Read for Numbers<R> {
    fn read(&mut self, buf: &mut [u8]) -> io::Result<usize> {
        let mut filled = 0;
        while filled < buf.len() {
            if self.left.is_empty() && !self.advance()? {
                break;
            }
            let n = self.left.len().min(buf.len() - filled);
            buf[filled..][..n].copy_from_slice(&self.number[self.left.start..][..n]);
            self.left.start += n;
            filled += n;
        }
        Ok(filled)
    }
}

/// Puts the bytes of the number that `word` says at the start of `number`.
fn parse<T: Pod + std::str::FromStr>(word: &[u8], number: &mut [u8; 8]) -> Option<()> {
    let value: T = str::from_utf8(word).ok()?.parse().ok()?;
    number[..size_of::<T>()].copy_from_slice(bytemuck::bytes_of(&value));
    Some(())
}

/// The next word; empty at the end. Of one that is too long, its start.
fn next_word(reader: &mut impl BufRead) -> io::Result<Vec<u8>> {
    let separates = |byte: &u8| byte.is_ascii_whitespace() || *byte == b',';
    let mut word = Vec::new();
    loop {
        let bytes = reader.fill_buf()?;
        if bytes.is_empty() || word.len() > MAX_WORD {
            return Ok(word);
        }
        let skipped = match word.is_empty() {
            true => bytes.iter().take_while(|b| separates(b)).count(),
            false => 0,
        };
        let taken = bytes[skipped..].iter().take_while(|b| !separates(b)).count();
        word.extend(&bytes[skipped..][..taken]);
        let ended = skipped + taken < bytes.len();
        reader.consume(skipped + taken);
        if ended {
            return Ok(word);
        }
    }
}

/// Bytes of two hexadecimal digits each; white space between digits is ignored.
pub(super) struct Hexadecimal<R>(pub R);

impl<R: BufRead> Hexadecimal<R> {
    /// The next digit's value; `None` at the end.
    fn digit(&mut self) -> io::Result<Option<u8>> {
        loop {
            let Some(&byte) = self.0.fill_buf()?.first() else {
                return Ok(None);
            };
            self.0.consume(1);
            match char::from(byte).to_digit(16) {
                Some(digit) => return Ok(Some(digit as u8)),
                None if byte.is_ascii_whitespace() => {}
                None => {
                    let character = char::from(byte).to_string();
                    return Err(io::Error::new(ErrorKind::InvalidData, NoNumber(character)));
                }
            }
        }
    }
}

impl<R: BufRead> Read for Hexadecimal<R> {
    fn read(&mut self, buf: &mut [u8]) -> io::Result<usize> {
        for (n, byte) in buf.iter_mut().enumerate() {
            match (self.digit()?, self.digit()?) {
                (Some(high), Some(low)) => *byte = high << 4 | low,
                _ => return Ok(n),
            }
        }
        Ok(buf.len())
    }
}

#[cfg(test)]
mod tests {
    use std::io::BufReader;

    use super::*;
    use crate::volume::VoxelType;

    /// All bytes of `text`, read through buffers of `room` bytes.
    fn numbers(text: &str, stored: Stored, room: usize) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        Numbers::new(BufReader::with_capacity(room, text.as_bytes()), stored).read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    #[test]
    fn numbers_are_the_same_through_any_buffer() {
        for room in 1..9 {
            let bytes = numbers(" 1,-2\n\t300 ", Stored::Voxel(VoxelType::I16), room).unwrap();
            let values: Vec<i16> = bytemuck::pod_collect_to_vec(&bytes);
            assert_eq!(values, [1, -2, 300]);
        }
        assert!(numbers("1 two", Stored::I64, 64).is_err());
        assert!(numbers("256", Stored::Voxel(VoxelType::U8), 64).is_err());
        assert!(numbers(&"1".repeat(1 << 20), Stored::Voxel(VoxelType::U8), 64).is_err());
    }

    #[test]
    fn hexadecimal_digits_are_bytes() {
        let mut bytes = Vec::new();
        Hexadecimal(b"0f A0\nf".as_slice()).read_to_end(&mut bytes).unwrap();
        assert_eq!(bytes, [0x0f, 0xa0]);
        assert!(Hexadecimal(b"xy".as_slice()).read_to_end(&mut bytes).is_err());
    }
}
