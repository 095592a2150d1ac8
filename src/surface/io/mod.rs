//! Mesh files: one module a format. Which carries what: docs/CONVENTIONS.md, Mesh files.
//!
//! Positions are stored as they are, LPS millimetres; GLB, whose unit and axes are fixed, says so in its node's matrix.
//! Triangles and vertices keep their order, so that a file is the same bytes whatever the number of threads.
//! PLY, STL and VTP store NaN and infinite positions as they are; OBJ and GLB, which have none, are refused.

mod check;
mod chunks;
mod error;
mod glb;
mod obj;
mod ply;
mod stl;
mod vtp;

use std::io;
use std::path::Path;

pub use self::error::{Inconsistency, MeshWriteError};
use super::mesh::{Mesh, Part};
use crate::output;

/// The formats, by the suffix that chooses them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Ply,
    Stl,
    Obj,
    Glb,
    Vtp,
}

impl Format {
    const ALL: [(&'static str, Self); 5] = [
        ("ply", Self::Ply),
        ("stl", Self::Stl),
        ("obj", Self::Obj),
        ("glb", Self::Glb),
        ("vtp", Self::Vtp),
    ];

    fn of(path: &Path) -> Result<Self, MeshWriteError> {
        let suffix = path.extension().unwrap_or_default();
        let known = Self::ALL.iter().find(|(name, _)| suffix.eq_ignore_ascii_case(name));
        known
            .map(|(_, format)| *format)
            .ok_or_else(|| MeshWriteError::UnknownSuffix { path: path.to_owned() })
    }

    /// Whether what the mesh holds has a place in the format.
    fn check(self, mesh: &Mesh) -> Result<(), MeshWriteError> {
        match self {
            Self::Ply | Self::Vtp => Ok(()),
            Self::Stl => stl::check(mesh),
            Self::Obj => check::finite(mesh, "OBJ"),
            Self::Glb => glb::check(mesh),
        }
    }

    fn write(self, out: &mut impl io::Write, mesh: &Mesh) -> io::Result<()> {
        match self {
            Self::Ply => ply::write(out, mesh),
            Self::Stl => stl::write(out, mesh),
            Self::Obj => obj::write(out, mesh),
            Self::Glb => glb::write(out, mesh),
            Self::Vtp => vtp::write(out, mesh),
        }
    }
}

/// Whether [`write_mesh`] knows the suffix of `path`; to be asked before a mesh is made.
///
/// # Errors
/// [`MeshWriteError::UnknownSuffix`], which lists the known ones.
pub fn check_suffix(path: &Path) -> Result<(), MeshWriteError> {
    Format::of(path).map(|_| ())
}

/// Writes `mesh` to `path`, whole or not at all, in the format that the suffix says: `.ply`, `.stl`, `.obj`, `.glb` or
/// `.vtp`, in either case. Normals, values and colours may be empty and are left out then; a mesh without triangles is
/// a valid file.
///
/// # Errors
/// [`MeshWriteError`]: an unknown suffix, a mesh that contradicts itself, more than the format holds, a position that it
/// cannot hold, or a file that cannot be written.
pub fn write_mesh(path: &Path, mesh: &Mesh) -> Result<(), MeshWriteError> {
    let format = Format::of(path)?;
    check::consistent(mesh)?;
    format.check(mesh)?;
    output::write_whole(path, |out| format.write(out, mesh))?;
    Ok(())
}
