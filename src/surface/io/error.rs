//! What a mesh file can be refused for.

use std::path::PathBuf;

use thiserror::Error;

use super::Format;
use crate::output::OutputError;

/// Why a mesh was not written. Nothing of the file is left behind.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MeshWriteError {
    /// The suffix names no mesh format.
    #[error("{}: no mesh format has this suffix (choose {})", path.display(), known_suffixes())]
    UnknownSuffix {
        /// The file.
        path: PathBuf,
    },
    /// The format's counters are too small.
    #[error("{found} {what} are too many for {format}, which holds {limit} (choose PLY or VTP, or a smaller mesh)")]
    TooMany {
        /// The format's name.
        format: &'static str,
        /// What is counted.
        what: &'static str,
        /// How many there are.
        found: u64,
        /// How many the format holds.
        limit: u64,
    },
    /// A number that the format cannot store.
    #[error(
        "vertex {vertex} has a {attribute} that is NaN or infinite, which {format} cannot store (choose PLY or VTP)"
    )]
    NotFinite {
        /// The format's name.
        format: &'static str,
        /// Whether it is the position or the normal.
        attribute: &'static str,
        /// Which vertex, from 0 on.
        vertex: usize,
    },
    /// The mesh contradicts itself.
    #[error("the mesh is inconsistent: {0}")]
    Inconsistent(#[from] Inconsistency),
    /// The file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// How a mesh contradicts itself.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum Inconsistency {
    /// An attribute that is neither empty nor of one entry a vertex.
    #[error("{found} {attribute} for {vertices} vertices")]
    Attribute {
        /// Which.
        attribute: &'static str,
        /// Its length.
        found: usize,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A corner that is no vertex.
    #[error("triangle {triangle} has vertex {vertex} of {vertices}")]
    Index {
        /// Which triangle, from 0 on.
        triangle: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A part that does not begin where the one before it ends, or ends before it begins.
    #[error("part {part} has triangles {start} to {end}, where triangle {expected} is next")]
    Part {
        /// Which part, from 0 on.
        part: usize,
        /// Its first triangle.
        start: usize,
        /// The triangle after its last.
        end: usize,
        /// Where it has to begin.
        expected: usize,
    },
    /// Triangles after the last part, or fewer than the parts have.
    #[error("the parts end at triangle {parts} of {triangles}")]
    Parts {
        /// The triangle after the last part's last.
        parts: usize,
        /// How many triangles there are.
        triangles: usize,
    },
}

/// `.ply, .stl, …`
fn known_suffixes() -> String {
    Format::ALL.map(|(name, _)| format!(".{name}")).join(", ")
}
