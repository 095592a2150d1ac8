//! The voxels in a file, once its header has told where and how they lie.
//!
//! *Practice.* A declared size is a claim. It is held against the file's length (against the best ratio of deflate for a
//! compressed file) before anything is allocated, and a compressed payload grows chunk by chunk with what really comes, never
//! beyond the declared size.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek};
use std::path::Path;
use std::str::FromStr;

use bytemuck::Pod;

use super::error::{Problem, ReadError};
use super::gunzip::{Gunzip, can_hold};
use crate::volume::grid::Voxels;
use crate::volume::voxel::VoxelType;

/// How scalars lie in a file. The 64-bit integers, for which [`Voxels`] has no type, become `f64`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stored {
    /// As the type.
    Voxel(VoxelType),
    /// Signed 64 bit.
    I64,
    /// Unsigned 64 bit.
    U64,
}

impl Stored {
    /// The type that they are kept in.
    pub(super) fn voxel(self) -> VoxelType {
        match self {
            Self::Voxel(voxel) => voxel,
            Self::I64 | Self::U64 => VoxelType::F64,
        }
    }

    pub(super) fn bytes(self) -> usize {
        match self {
            Self::Voxel(voxel) => voxel.bytes(),
            Self::I64 | Self::U64 => 8,
        }
    }
}

/// Byte order of the scalars in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ByteOrder {
    /// Least significant byte first.
    Little,
    /// Most significant byte first.
    Big,
}

impl ByteOrder {
    /// This machine's.
    pub const NATIVE: Self = if cfg!(target_endian = "little") {
        Self::Little
    } else {
        Self::Big
    };
}

/// What a header declares of its payload.
pub(super) struct Payload<'a> {
    /// The file that holds it, for messages.
    pub path: &'a Path,
    /// The scalars' type in the file.
    pub stored: Stored,
    /// The scalars' byte order in the file.
    pub order: ByteOrder,
    /// How many scalars.
    pub count: usize,
}

/// Bytes read at a time: a multiple of every scalar's size.
const CHUNK: usize = 1 << 22;

/// Evaluates `$body` with `$T` as the Rust type of `$stored`, as [`Voxels`].
macro_rules! voxels {
    ($stored:expr, $T:ident => $body:expr) => {
        voxels!(@ $stored, $T, $body, U8 u8, I8 i8, U16 u16, I16 i16, U32 u32, I32 i32, F32 f32, F64 f64)
    };
    (@ $stored:expr, $T:ident, $body:expr, $($tag:ident $scalar:ident),*) => {
        match $stored {
            $(Stored::Voxel($crate::volume::VoxelType::$tag) => {
                type $T = $scalar;
                Voxels::$tag($body)
            })*
            Stored::I64 => {
                type $T = i64;
                Voxels::F64($body.into_iter().map(|v| v as f64).collect())
            }
            Stored::U64 => {
                type $T = u64;
                Voxels::F64($body.into_iter().map(|v| v as f64).collect())
            }
        }
    };
}

pub(super) use voxels;

impl Payload<'_> {
    /// Bytes of the decoded payload.
    pub(super) fn bytes(&self) -> u64 {
        (self.count as u64).saturating_mul(self.stored.bytes() as u64)
    }

    /// The payload from `file`'s position on.
    pub(super) fn read_raw(&self, file: &mut BufReader<File>) -> Result<Voxels, ReadError> {
        let found = remaining(file).map_err(|e| ReadError::io(self.path, e))?;
        self.check(found)?;
        self.decode(file, self.count)
    }

    /// The payload of the gzip stream at `file`'s position, `skip` decompressed bytes into it.
    pub(super) fn read_gzip(&self, file: &mut BufReader<File>, skip: u64) -> Result<Voxels, ReadError> {
        let compressed = remaining(file).map_err(|e| ReadError::io(self.path, e))?;
        self.check_gzip(compressed, skip)?;
        self.decode_gzip(&mut Gunzip::new(file), skip)
    }

    /// The payload of a gzip stream, `skip` decompressed bytes into it. At the stream's end its checksum is tested.
    pub(super) fn decode_gzip<R: BufRead>(&self, stream: &mut Gunzip<R>, skip: u64) -> Result<Voxels, ReadError> {
        self.skip(stream, skip)?;
        let voxels = self.decode(stream, 0)?;
        io::copy(&mut stream.take(1), &mut io::sink()).map_err(|e| self.stream_error(e, self.bytes()))?;
        Ok(voxels)
    }

    /// The payload as numbers separated by white space or commas.
    pub(super) fn read_text(&self, file: &mut BufReader<File>) -> Result<Voxels, ReadError> {
        let found = remaining(file).map_err(|e| ReadError::io(self.path, e))?;
        // A number takes a digit and a separator.
        if found.saturating_add(1) / 2 < self.count as u64 {
            let expected = self.count as u64 * 2 - 1;
            return Err(self.problem(Problem::Truncated { expected, found }));
        }
        let mut text = String::new();
        file.read_to_string(&mut text)
            .map_err(|e| ReadError::io(self.path, e))?;
        Ok(voxels!(self.stored, T => self.parse::<T>(&text)?))
    }

    /// Whether `found` bytes hold the payload.
    pub(super) fn check(&self, found: u64) -> Result<(), ReadError> {
        let expected = self.bytes();
        match found < expected {
            true => Err(self.problem(Problem::Truncated { expected, found })),
            false => Ok(()),
        }
    }

    /// Whether `compressed` bytes can hold the payload behind `skip` others.
    pub(super) fn check_gzip(&self, compressed: u64, skip: u64) -> Result<(), ReadError> {
        let expected = self.bytes().saturating_add(skip);
        match can_hold(compressed, expected) {
            true => Ok(()),
            false => Err(self.problem(Problem::Implausible { expected, compressed })),
        }
    }

    /// Reads past `bytes`.
    pub(super) fn skip(&self, stream: &mut impl Read, bytes: u64) -> Result<(), ReadError> {
        let skipped = io::copy(&mut stream.take(bytes), &mut io::sink());
        match skipped.map_err(|e| self.stream_error(e, 0))? == bytes {
            true => Ok(()),
            false => Err(self.truncated(0)),
        }
    }

    /// The next scalars of a stream of bytes. Room for `trusted` of them is made beforehand.
    pub(super) fn decode(&self, stream: &mut impl Read, trusted: usize) -> Result<Voxels, ReadError> {
        Ok(voxels!(self.stored, T => self.decode_as::<T>(stream, trusted)?))
    }

    fn decode_as<T: Pod>(&self, stream: &mut impl Read, trusted: usize) -> Result<Vec<T>, ReadError> {
        let memory = |_| self.problem(Problem::Memory(self.bytes()));
        let mut scalars: Vec<T> = Vec::new();
        scalars.try_reserve_exact(trusted).map_err(memory)?;
        while scalars.len() < self.count {
            let start = scalars.len();
            let chunk = (CHUNK / size_of::<T>()).min(self.count - start);
            scalars.try_reserve(chunk).map_err(memory)?;
            scalars.resize(start + chunk, T::zeroed());
            let bytes = bytemuck::cast_slice_mut(&mut scalars[start..]);
            self.fill(stream, bytes, (start * size_of::<T>()) as u64)?;
            if self.order != ByteOrder::NATIVE {
                bytes.chunks_exact_mut(size_of::<T>()).for_each(<[u8]>::reverse);
            }
        }
        Ok(scalars)
    }

    /// Fills `bytes`, which come after `before` others of the payload.
    fn fill(&self, stream: &mut impl Read, bytes: &mut [u8], before: u64) -> Result<(), ReadError> {
        let mut filled = 0;
        while filled < bytes.len() {
            let found = before + filled as u64;
            match stream.read(&mut bytes[filled..]) {
                Ok(0) => return Err(self.truncated(found)),
                Ok(n) => filled += n,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(self.stream_error(e, found)),
            }
        }
        Ok(())
    }

    fn parse<T: FromStr>(&self, text: &str) -> Result<Vec<T>, ReadError> {
        let mut scalars = Vec::with_capacity(self.count);
        for word in words(text).take(self.count) {
            let bad = |_| self.problem(Problem::Text(word.chars().take(40).collect()));
            scalars.push(word.parse().map_err(bad)?);
        }
        match scalars.len() == self.count {
            true => Ok(scalars),
            false => Err(ReadError::header(
                self.path,
                format!(
                    "the header declares {} voxels, the text has {}",
                    self.count,
                    scalars.len()
                ),
            )),
        }
    }

    fn truncated(&self, found: u64) -> ReadError {
        let expected = self.bytes();
        self.problem(Problem::Truncated { expected, found })
    }

    fn stream_error(&self, error: io::Error, found: u64) -> ReadError {
        match error.kind() {
            io::ErrorKind::UnexpectedEof => self.truncated(found),
            io::ErrorKind::InvalidInput | io::ErrorKind::InvalidData => self.problem(Problem::Compressed(error)),
            _ => self.problem(Problem::Io(error)),
        }
    }

    fn problem(&self, problem: Problem) -> ReadError {
        ReadError::new(self.path, problem)
    }
}

/// The words between white space and commas.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c.is_ascii_whitespace() || c == ',')
        .filter(|word| !word.is_empty())
}

/// The bytes from the file's position to its end.
pub(super) fn remaining(file: &mut BufReader<File>) -> io::Result<u64> {
    let length = file.get_ref().metadata()?.len();
    Ok(length.saturating_sub(file.stream_position()?))
}
