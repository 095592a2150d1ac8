//! Mesh files: one module a format. Of each the triangles are read and nothing else; polygons become fans.
//!
//! *Practice.* A count that a file declares is held against the bytes that are there before anything is made of it. Nothing in a
//! file is trusted further than that: what the triangles enclose is for [`TriangleSolid`](super::TriangleSolid) to check.

mod bytes;
mod error;
mod glb;
mod gltf;
mod obj;
mod ply;
mod ply_header;
mod stl;

use std::fs;
use std::path::Path;

use glam::DVec3;

use self::error::Fault;
pub use self::error::{MeshReadError, Problem};

/// Triangles as a file has them, in millimetres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Where the vertices are.
    pub positions: Vec<DVec3>,
    /// Three vertices a triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// Adds a vertex, whose number is returned.
    fn push(&mut self, position: DVec3) -> Result<u32, Fault> {
        let number = u32::try_from(self.positions.len()).map_err(|_| Fault::new("more than 2³² vertices"))?;
        self.positions.push(position);
        Ok(number)
    }

    /// Adds the triangles of a polygon.
    fn push_fan(&mut self, corners: &[u32]) {
        for pair in corners.windows(2).skip(1) {
            self.triangles.push([corners[0], pair[0], pair[1]]);
        }
    }

    /// The mesh with lengths that are `factor` as long.
    pub fn scaled(mut self, factor: f64) -> Self {
        self.positions.iter_mut().for_each(|p| *p *= factor);
        self
    }
}

type Reader = fn(&[u8]) -> Result<TriangleMesh, Fault>;

/// The formats, by the suffix that chooses them.
const FORMATS: [(&str, Reader); 4] = [
    ("ply", ply::read),
    ("stl", stl::read),
    ("obj", obj::read),
    ("glb", glb::read),
];

/// Reads `.ply`, `.stl`, `.obj` or `.glb`. A unit of the first three is taken for a millimetre; GLB is in metres with +Y up,
/// which is turned into millimetres in LPS.
///
/// # Errors
/// [`MeshReadError`] says what is wrong, in which file and where in it.
pub fn read(path: &Path) -> Result<TriangleMesh, MeshReadError> {
    let reader = reader(path)?;
    let bytes = fs::read(path).map_err(|error| MeshReadError::new(path, Fault::of(Problem::Io(error))))?;
    reader(&bytes).map_err(|fault| MeshReadError::new(path, fault))
}

/// Reads the bytes of a file called `path`, whose suffix says what they are.
///
/// # Errors
/// As [`read()`].
pub fn parse(path: &Path, bytes: &[u8]) -> Result<TriangleMesh, MeshReadError> {
    reader(path)?(bytes).map_err(|fault| MeshReadError::new(path, fault))
}

fn reader(path: &Path) -> Result<Reader, MeshReadError> {
    let suffix = path.extension().unwrap_or_default();
    let known = FORMATS.iter().find(|(name, _)| suffix.eq_ignore_ascii_case(name));
    let unknown = || MeshReadError::new(path, Fault::of(Problem::UnknownSuffix));
    known.map(|(_, reader)| *reader).ok_or_else(unknown)
}
