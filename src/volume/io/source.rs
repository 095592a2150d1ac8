//! The bytes of a payload, wherever they lie: in one file or several, plain, compressed or as text.
//!
//! *Practice.* A declared size is a claim. It is held against the file's length (against the best ratio of the compression)
//! before anything is allocated, and never more is decompressed than was declared.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, BufRead, BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use bzip2::bufread::MultiBzDecoder;
use flate2::bufread::ZlibDecoder;

use super::error::{Problem, ReadError};
use super::gunzip::{GZIP_MAGIC, Gunzip, can_hold};
use super::stored::Stored;
use super::text::{Hexadecimal, NoNumber, Numbers};

/// Bytes of a file that are read at a time before they are decompressed.
const BUFFER: usize = 1 << 17;

/// How a payload is written down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Coding {
    /// As it is.
    Plain,
    /// By deflate, with the header of gzip or of zlib.
    Deflate,
    /// By bzip2.
    Bzip2,
    /// In hexadecimal digits.
    Hexadecimal,
    /// As numbers of this type.
    Numbers(Stored),
}

/// What comes before a payload, once it is decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Skip {
    /// So many bytes.
    Bytes(u64),
    /// Whatever there is but the payload, which ends the data.
    AllBefore,
}

/// Bytes of a payload that lie one after the other in a file.
#[derive(Clone, Debug)]
pub(super) struct Stretch {
    /// The file.
    pub path: PathBuf,
    /// Where in the file the data begins.
    pub start: u64,
    /// How it is written down.
    pub coding: Coding,
    /// What is left out of the decoded data.
    pub skip: Skip,
    /// How many bytes follow.
    pub bytes: u64,
}

/// Bzip2's best ratio: a block of 900 000 bytes, in which five stand for a run of 259, behind a header of ten.
const BZIP2_RATIO: u64 = 900_000 / 5 * 259 / 10;

impl Stretch {
    /// Whether the file can hold it.
    pub(super) fn check(&self) -> Result<(), ReadError> {
        let length = self.path.metadata().map_err(|e| ReadError::io(&self.path, e))?.len();
        let found = length.saturating_sub(self.start);
        let skipped = match self.skip {
            Skip::Bytes(bytes) => bytes,
            Skip::AllBefore => 0,
        };
        let expected = self.bytes.saturating_add(skipped);
        let implausible = || Problem::Implausible {
            expected,
            compressed: found,
        };
        let truncated = |expected, found| Problem::Truncated { expected, found };
        let problem = match self.coding {
            Coding::Plain => (found < expected).then(|| truncated(self.bytes, found.saturating_sub(skipped))),
            Coding::Deflate => (!can_hold(found, expected)).then(implausible),
            Coding::Bzip2 => (expected / BZIP2_RATIO > found).then(implausible),
            Coding::Hexadecimal => (found / 2 < expected).then(|| truncated(expected.saturating_mul(2), found)),
            Coding::Numbers(stored) => {
                // A number takes a digit and a separator, the last one only a digit.
                let least = (expected / stored.bytes() as u64).saturating_mul(2).saturating_sub(1);
                (found < least).then(|| truncated(least, found))
            }
        };
        problem.map_or(Ok(()), |problem| Err(ReadError::new(&self.path, problem)))
    }

    /// Its decoded bytes.
    fn open(&self) -> Result<Box<dyn Read + Send>, ReadError> {
        let io_error = |e| ReadError::io(&self.path, e);
        let mut file = File::open(&self.path).map_err(io_error)?;
        if self.coding == Coding::Plain {
            let skipped = match self.skip {
                Skip::Bytes(bytes) => self.start.saturating_add(bytes),
                Skip::AllBefore => file.metadata().map_err(io_error)?.len().saturating_sub(self.bytes),
            };
            file.seek(SeekFrom::Start(skipped)).map_err(io_error)?;
            return Ok(Box::new(file));
        }
        let skipped = match self.skip {
            Skip::Bytes(bytes) => bytes,
            Skip::AllBefore => self.count()?.saturating_sub(self.bytes),
        };
        let mut decoded = self.decoded(file)?;
        let passed = io::copy(&mut decoded.by_ref().take(skipped), &mut io::sink());
        match passed.map_err(|e| self.error(e, 0))? == skipped {
            true => Ok(decoded),
            false => Err(self.truncated(0)),
        }
    }

    /// How many bytes there are once they are decoded, which only a pass over all of them tells.
    fn count(&self) -> Result<u64, ReadError> {
        let file = File::open(&self.path).map_err(|e| ReadError::io(&self.path, e))?;
        let found = io::copy(&mut self.decoded(file)?, &mut io::sink()).map_err(|e| self.error(e, 0))?;
        match found < self.bytes {
            true => Err(self.truncated(found)),
            false => Ok(found),
        }
    }

    /// What the data decodes to.
    fn decoded(&self, mut file: File) -> Result<Box<dyn Read + Send>, ReadError> {
        let io_error = |e| ReadError::io(&self.path, e);
        file.seek(SeekFrom::Start(self.start)).map_err(io_error)?;
        let mut file = BufReader::with_capacity(BUFFER, file);
        Ok(match self.coding {
            Coding::Plain => Box::new(file),
            Coding::Deflate => match file.fill_buf().map_err(io_error)?.starts_with(&GZIP_MAGIC) {
                true => Box::new(Gunzip::new(file)),
                false => Box::new(ZlibDecoder::new(file)),
            },
            Coding::Bzip2 => Box::new(MultiBzDecoder::new(file)),
            Coding::Hexadecimal => Box::new(Hexadecimal(file)),
            Coding::Numbers(stored) => Box::new(Numbers::new(file, stored)),
        })
    }

    fn truncated(&self, found: u64) -> ReadError {
        let expected = self.bytes;
        ReadError::new(&self.path, Problem::Truncated { expected, found })
    }

    /// What `error` means, `found` bytes into the stretch.
    fn error(&self, error: io::Error, found: u64) -> ReadError {
        stream_error(&self.path, error, self.bytes, found)
    }
}

/// What `error` means of a stream of the file at `path`, in which `expected` bytes are declared, `found` bytes into it.
fn stream_error(path: &Path, error: io::Error, expected: u64, found: u64) -> ReadError {
    let problem = match error.kind() {
        ErrorKind::UnexpectedEof => Problem::Truncated { expected, found },
        ErrorKind::InvalidInput | ErrorKind::InvalidData => match error.downcast::<NoNumber>() {
            Ok(NoNumber(word)) => Problem::Text(word),
            Err(error) => Problem::Compressed(error),
        },
        _ => Problem::Io(error),
    };
    ReadError::new(path, problem)
}

/// Fills `bytes` from a stream of the file at `path`, in which `expected` bytes are declared, of which `before` came before.
pub(super) fn fill(
    path: &Path,
    stream: &mut dyn Read,
    bytes: &mut [u8],
    expected: u64,
    before: u64,
) -> Result<(), ReadError> {
    let mut filled = 0;
    while filled < bytes.len() {
        let found = before + filled as u64;
        match stream.read(&mut bytes[filled..]) {
            Ok(0) => return Err(ReadError::new(path, Problem::Truncated { expected, found })),
            Ok(n) => filled += n,
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Err(e) => return Err(stream_error(path, e, expected, found)),
        }
    }
    Ok(())
}

/// The `bytes` from `from` on, of what lies in `stretches` one after the other.
pub(super) fn section(stretches: &[Stretch], from: u64, bytes: u64) -> Vec<Stretch> {
    let end = from.saturating_add(bytes);
    let mut start = 0_u64;
    let mut parts = Vec::new();
    for stretch in stretches {
        let last = start.saturating_add(stretch.bytes);
        let (first, rest) = (from.clamp(start, last), end.clamp(start, last));
        if first < rest {
            parts.push(stretch.between(first - start, rest - start));
        }
        start = last;
    }
    parts
}

impl Stretch {
    /// Its bytes from `first` up to `end`.
    fn between(&self, first: u64, end: u64) -> Self {
        let skip = match self.skip {
            Skip::Bytes(bytes) => Skip::Bytes(bytes.saturating_add(first)),
            Skip::AllBefore => Skip::AllBefore,
        };
        let bytes = match self.skip {
            Skip::Bytes(_) => end - first,
            // What is skipped is counted from the end, so the end stays.
            Skip::AllBefore => self.bytes - first,
        };
        Self {
            skip,
            bytes,
            ..self.clone()
        }
    }
}

/// Where a file goes on after `lines` lines from byte `start` on.
pub(super) fn after_lines(path: &Path, start: u64, lines: u64) -> Result<u64, ReadError> {
    if lines == 0 {
        return Ok(start);
    }
    let io_error = |e| ReadError::io(path, e);
    let mut file = BufReader::new(File::open(path).map_err(io_error)?);
    let mut at = file.seek(SeekFrom::Start(start)).map_err(io_error)?;
    for _ in 0..lines {
        match file.skip_until(b'\n').map_err(io_error)? {
            0 => {
                let what = format!("it has less than {lines} lines to skip");
                return Err(ReadError::header(path, what));
            }
            bytes => at += bytes as u64,
        }
    }
    Ok(at)
}

/// Stretches that are read one after the other.
pub(super) struct Source {
    /// Those to come; the first may be open.
    stretches: VecDeque<Stretch>,
    open: Option<Box<dyn Read + Send>>,
    /// Bytes that were read of the first.
    done: u64,
}

impl Source {
    pub(super) fn new(stretches: Vec<Stretch>) -> Self {
        Self {
            stretches: stretches.into(),
            open: None,
            done: 0,
        }
    }

    /// Fills `bytes` with what comes next.
    pub(super) fn fill(&mut self, mut bytes: &mut [u8]) -> Result<(), ReadError> {
        while !bytes.is_empty() {
            let stretch = self.stretches.front().expect("no more is asked for than was declared");
            let left = usize::try_from(stretch.bytes - self.done).unwrap_or(usize::MAX);
            let (here, rest) = bytes.split_at_mut(left.min(bytes.len()));
            let stream = match &mut self.open {
                Some(stream) => stream,
                none => none.insert(stretch.open()?),
            };
            fill(&stretch.path, stream, here, stretch.bytes, self.done)?;
            self.done += here.len() as u64;
            if self.done == stretch.bytes {
                self.close()?;
            }
            bytes = rest;
        }
        Ok(())
    }

    /// Leaves the first stretch. At the end of compressed data its checksum is tested.
    fn close(&mut self) -> Result<(), ReadError> {
        let (stretch, stream) = (self.stretches.pop_front(), self.open.take());
        self.done = 0;
        match (stretch, stream) {
            (Some(stretch), Some(mut stream)) if matches!(stretch.coding, Coding::Deflate | Coding::Bzip2) => {
                let tested = io::copy(&mut stream.by_ref().take(1), &mut io::sink());
                tested.map(drop).map_err(|e| stretch.error(e, stretch.bytes))
            }
            _ => Ok(()),
        }
    }
}
