//! What a mesh file can be refused for.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::volume::io::Position;

/// Why a mesh file could not be read: what, and where.
#[derive(Debug)]
pub struct MeshReadError {
    /// The file.
    pub path: PathBuf,
    /// Where in the file, when a place is known.
    pub position: Option<Position>,
    /// What is wrong.
    pub problem: Problem,
}

/// What is wrong with a mesh file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Problem {
    /// The operating system refused.
    #[error("cannot be read: {0}")]
    Io(io::Error),
    /// The suffix names no mesh format.
    #[error("no mesh format has this suffix (choose .ply, .stl, .obj or .glb)")]
    UnknownSuffix,
    /// The file contradicts its format, or uses what is not read.
    #[error("{0}")]
    Format(String),
    /// The file ends too early.
    #[error("the file ends before {0}")]
    Truncated(String),
}

/// A problem and its place in a file that the reader does not know the name of.
#[derive(Debug)]
pub(super) struct Fault {
    pub position: Option<Position>,
    pub problem: Problem,
}

impl Fault {
    pub fn of(problem: Problem) -> Self {
        Self {
            position: None,
            problem,
        }
    }

    pub fn new(what: impl Into<String>) -> Self {
        Self::of(Problem::Format(what.into()))
    }

    pub fn truncated(before: impl Into<String>) -> Self {
        Self::of(Problem::Truncated(before.into()))
    }

    pub fn line(self, line: usize) -> Self {
        Self {
            position: Some(Position::Line(line)),
            ..self
        }
    }

    pub fn byte(self, byte: usize) -> Self {
        Self {
            position: Some(Position::Byte(byte as u64)),
            ..self
        }
    }

    /// The fault in a file that has `bytes` before the part that the place counts from.
    pub fn after(self, bytes: usize) -> Self {
        match self.position {
            Some(Position::Byte(byte)) => self.byte(bytes + byte as usize),
            _ => self,
        }
    }
}

impl MeshReadError {
    pub(super) fn new(path: &Path, fault: Fault) -> Self {
        Self {
            path: path.to_owned(),
            position: fault.position,
            problem: fault.problem,
        }
    }
}

impl fmt::Display for MeshReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        match self.position {
            Some(Position::Line(line)) => write!(f, ", line {line}")?,
            Some(Position::Byte(byte)) => write!(f, ", byte {byte}")?,
            None => {}
        }
        write!(f, ": {}", self.problem)
    }
}

impl std::error::Error for MeshReadError {}
