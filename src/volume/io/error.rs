//! What a file can be refused for.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::volume::bricks::BuildError;
use crate::volume::grid::GridError;

/// Why a volume file could not be read: what, where, and what the user can do.
#[derive(Debug)]
pub struct ReadError {
    /// The file, which for a detached header may be its data file.
    pub path: PathBuf,
    /// Where in the file, when a place is known.
    pub position: Option<Position>,
    /// What is wrong.
    pub problem: Problem,
    /// What the user can do.
    pub hint: String,
}

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Position {
    /// A line, from 1 on.
    Line(usize),
    /// A byte, from 0 on.
    Byte(u64),
}

/// What is wrong with a volume file.
#[derive(Debug, Error)]
pub enum Problem {
    /// The operating system refused.
    #[error("cannot be read: {0}")]
    Io(io::Error),
    /// A format, or a variant of one, that is not read.
    #[error("{0}")]
    Unsupported(String),
    /// The header says something impossible, or lacks something.
    #[error("{0}")]
    Header(String),
    /// Less data than the header declares.
    #[error("the header declares {expected} bytes of data, the file has {found}")]
    Truncated {
        /// Declared bytes.
        expected: u64,
        /// Bytes there are.
        found: u64,
    },
    /// More data than so small a compressed file can hold.
    #[error("the header declares {expected} bytes of data, more than {compressed} compressed bytes can hold")]
    Implausible {
        /// Declared bytes.
        expected: u64,
        /// Bytes of the file.
        compressed: u64,
    },
    /// Compressed data that cannot be decompressed.
    #[error("the compressed data is damaged: {0}")]
    Compressed(io::Error),
    /// A voxel in text that is not a number of the declared type.
    #[error("`{0}` is not a voxel of the declared type")]
    Text(String),
    /// The data does not fit the machine.
    #[error("there is no memory for {0} bytes of data")]
    Memory(u64),
    /// The data fits the machine, but not what of it may be taken.
    #[error("it takes {} MiB of memory, and {} MiB are what reading may take", mebibytes(.bytes), mebibytes(.budget))]
    Budget {
        /// Bytes that it takes, at least.
        bytes: u64,
        /// Bytes that it may take.
        budget: u64,
    },
    /// The header describes an impossible grid.
    #[error(transparent)]
    Grid(#[from] GridError),
}

/// Whole mebibytes, rounded up.
fn mebibytes(bytes: &u64) -> u64 {
    bytes.div_ceil(1 << 20)
}

impl From<BuildError> for Problem {
    fn from(error: BuildError) -> Self {
        match error {
            BuildError::Grid(error) => Self::Grid(error),
            BuildError::Budget { bytes, budget } => Self::Budget { bytes, budget },
        }
    }
}

impl Problem {
    /// What helps when the place that found the problem knows nothing better.
    fn hint(&self) -> &'static str {
        match self {
            Self::Io(_) => "check the file's name and permissions",
            Self::Unsupported(_) => "convert it to NRRD or NIfTI-1 with one number a voxel",
            Self::Header(_) => "correct the header, or export the volume again",
            Self::Truncated { .. } | Self::Implausible { .. } => {
                "the file is incomplete or its header is wrong: copy or export it again"
            }
            Self::Compressed(_) => "copy or export the file again; `gzip -t` tests it",
            Self::Text(_) => "correct the value, or the type that the header gives",
            Self::Memory(_) => "crop or downsample the volume first",
            Self::Budget { .. } => "allow more with --read-budget-mib, or crop or downsample the volume first",
            Self::Grid(_) => "correct the sizes and axes in the header, or export the volume again",
        }
    }
}

impl ReadError {
    pub(super) fn new(path: &Path, problem: impl Into<Problem>) -> Self {
        let problem = problem.into();
        Self {
            path: path.to_owned(),
            position: None,
            hint: problem.hint().to_owned(),
            problem,
        }
    }

    pub(super) fn header(path: &Path, what: impl Into<String>) -> Self {
        Self::new(path, Problem::Header(what.into()))
    }

    pub(super) fn unsupported(path: &Path, what: impl Into<String>) -> Self {
        Self::new(path, Problem::Unsupported(what.into()))
    }

    pub(super) fn io(path: &Path, error: io::Error) -> Self {
        Self::new(path, Problem::Io(error))
    }

    pub(super) fn line(self, line: usize) -> Self {
        Self {
            position: Some(Position::Line(line)),
            ..self
        }
    }

    pub(super) fn byte(self, byte: u64) -> Self {
        Self {
            position: Some(Position::Byte(byte)),
            ..self
        }
    }

    pub(super) fn hint(self, hint: impl Into<String>) -> Self {
        Self {
            hint: hint.into(),
            ..self
        }
    }
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        match self.position {
            Some(Position::Line(line)) => write!(f, ", line {line}")?,
            Some(Position::Byte(byte)) => write!(f, ", byte {byte}")?,
            None => {}
        }
        write!(f, ": {} ({})", self.problem, self.hint)
    }
}

impl std::error::Error for ReadError {}
