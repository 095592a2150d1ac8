//! Scalars that come one after another, in binary or in text, any number at a time.

use std::io::{self, BufRead, Read};
use std::path::PathBuf;
use std::str::FromStr;

use super::components::Components;
use super::error::{Problem, ReadError};
use super::open::Chunks;
use super::source::fill;
use super::stored::{ByteOrder, Stored, decode, voxels};
use crate::volume::grid::Voxels;
use crate::volume::voxel::Voxel;

/// Voxels handed over at a time.
const CHUNK_VOXELS: usize = 1 << 20;

/// Bytes of the longest number in text that is believed.
const LONGEST_WORD: usize = 64;

/// What is still to come of an array.
pub(super) struct Scalars {
    path: PathBuf,
    stored: Stored,
    source: Source,
    /// How many the array has.
    count: usize,
    /// How many of them have come.
    done: usize,
}

/// Where they come from.
pub(super) enum Source {
    /// Bytes in this order.
    Binary(Box<dyn Read + Send>, ByteOrder),
    /// Numbers between white space.
    Text(Words),
    /// Numbers from 0 to 1 between white space, of bytes from 0 to 255.
    Fractions(Words),
}

impl Scalars {
    /// The `count` scalars of type `stored` in `source`, which the file at `path` holds.
    pub(super) fn new(path: PathBuf, stored: Stored, count: usize, source: Source) -> Self {
        Self {
            path,
            stored,
            source,
            count,
            done: 0,
        }
    }

    /// The next `count`, of those that are still to come.
    pub(super) fn next(&mut self, count: usize) -> Result<Voxels, ReadError> {
        let voxels = match &mut self.source {
            Source::Binary(bytes, order) => {
                let expected = (count * self.stored.bytes()) as u64;
                let mut before = 0;
                decode(&self.path, self.stored, *order, count, |part| {
                    fill(&self.path, bytes, part, expected, before)?;
                    before += part.len() as u64;
                    Ok(())
                })
            }
            Source::Fractions(words) => {
                (numbers::<f32>(words, count).map(bytes)).map_err(|e| ReadError::new(&self.path, e))
            }
            Source::Text(words) => parse(words, self.stored, count).map_err(|e| ReadError::new(&self.path, e)),
        };
        let voxels = voxels.map_err(|e| self.of_whole(e))?;
        self.done += count;
        Ok(voxels)
    }

    /// The error of a part as one of the whole array.
    fn of_whole(&self, mut error: ReadError) -> ReadError {
        if let Problem::Truncated { expected, found } = &mut error.problem {
            let size = self.stored.bytes() as u64;
            *expected = self.count as u64 * size;
            *found += self.done as u64 * size;
        }
        error
    }

    /// All of them, as voxels of so many `components`.
    pub(super) fn chunks(mut self, components: Components) -> Chunks {
        let voxels = self.count / components.count();
        let starts = (0..voxels).step_by(CHUNK_VOXELS);
        Box::new(starts.map(move |start| {
            let here = CHUNK_VOXELS.min(voxels - start);
            Ok(components.one(self.next(here * components.count())?))
        }))
    }
}

/// The words of a text, between white space and commas.
pub(super) struct Words {
    text: Box<dyn BufRead + Send>,
    word: Vec<u8>,
}

impl Words {
    pub(super) fn new(text: Box<dyn BufRead + Send>) -> Self {
        Self { text, word: Vec::new() }
    }

    /// The next word, cut off where it is longer than any number; empty at the end.
    fn next(&mut self) -> io::Result<&[u8]> {
        self.word.clear();
        loop {
            let bytes = self.text.fill_buf()?;
            let skip = match self.word.is_empty() {
                true => bytes.iter().take_while(|b| is_separator(**b)).count(),
                false => 0,
            };
            let length = bytes[skip..].iter().take_while(|b| !is_separator(**b)).count();
            let ends = bytes.is_empty() || skip + length < bytes.len();
            let room = LONGEST_WORD - self.word.len();
            self.word.extend_from_slice(&bytes[skip..skip + length.min(room)]);
            self.text.consume(skip + length);
            if ends || self.word.len() == LONGEST_WORD {
                return Ok(&self.word);
            }
        }
    }
}

fn is_separator(byte: u8) -> bool {
    byte.is_ascii_whitespace() || byte == b','
}

fn bytes(fractions: Vec<f32>) -> Voxels {
    Voxels::U8(
        fractions
            .into_iter()
            .map(|v| u8::nearest(f64::from(v) * 255.0))
            .collect(),
    )
}

fn parse(words: &mut Words, stored: Stored, count: usize) -> Result<Voxels, Problem> {
    Ok(voxels!(stored, T => numbers::<T>(words, count)?))
}

fn numbers<T: FromStr>(words: &mut Words, count: usize) -> Result<Vec<T>, Problem> {
    let mut numbers = Vec::new();
    for found in 0..count {
        let word = words.next().map_err(Problem::Io)?;
        if word.is_empty() {
            let what = format!("{count} numbers are declared where the text has {found}");
            return Err(Problem::Header(what));
        }
        let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        let bad = || Problem::Text(String::from_utf8_lossy(word).into_owned());
        numbers.push(number.ok_or_else(bad)?);
    }
    Ok(numbers)
}
