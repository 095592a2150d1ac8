//! The bytes of a file, read from front to back.

use super::error::Fault;

/// What is left of a file, and how much came before it.
pub(super) struct Cursor<'a> {
    rest: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes, at: 0 }
    }

    /// How many bytes have been read.
    pub fn at(&self) -> usize {
        self.at
    }

    /// How many are left.
    pub fn left(&self) -> usize {
        self.rest.len()
    }

    /// The next `count` bytes, part of `what`.
    pub fn take(&mut self, count: usize, what: &str) -> Result<&'a [u8], Fault> {
        let Some((taken, rest)) = self.rest.split_at_checked(count) else {
            return Err(Fault::truncated(format!("the end of {what}")).byte(self.at));
        };
        self.rest = rest;
        self.at += count;
        Ok(taken)
    }

    /// The next `N` bytes, part of `what`.
    pub fn array<const N: usize>(&mut self, what: &str) -> Result<[u8; N], Fault> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N, what)?);
        Ok(array)
    }

    pub fn u32(&mut self, what: &str) -> Result<u32, Fault> {
        self.array(what).map(u32::from_le_bytes)
    }
}

/// Three little-endian numbers.
pub(super) fn vector(bytes: [u8; 12]) -> glam::DVec3 {
    let number = |n: usize| f64::from(f32::from_le_bytes([bytes[n], bytes[n + 1], bytes[n + 2], bytes[n + 3]]));
    glam::DVec3::new(number(0), number(4), number(8))
}

/// The words of a file of text, each with its line from 1 on.
pub(super) fn words(text: &[u8]) -> impl Iterator<Item = (usize, &str)> {
    lines(text).flat_map(|(number, line)| line.split_ascii_whitespace().map(move |word| (number, word)))
}

/// The lines of a file of text, from 1 on. A line that is not UTF-8 is empty: what it should have held is missed.
pub(super) fn lines(text: &[u8]) -> impl Iterator<Item = (usize, &str)> {
    let line = |(n, line)| (n + 1, std::str::from_utf8(line).unwrap_or_default());
    text.split(|byte| *byte == b'\n').enumerate().map(line)
}

/// A number in text.
pub(super) fn number(word: &str, line: usize) -> Result<f64, Fault> {
    word.parse()
        .map_err(|_| Fault::new(format!("`{}` is not a number", shortened(word))).line(line))
}

/// A word as it is quoted.
pub(super) fn shortened(word: &str) -> String {
    word.chars().take(40).collect()
}
