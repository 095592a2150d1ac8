//! A triangle mesh in memory.

use std::ops::Range;

use super::extract::ExtractError;
use crate::array::Array;

/// Triangles that share vertices. Positions are LPS millimetres.
///
/// A mesh from extraction is closed away from the lattice's border, wound counterclockwise seen from the side of lower values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Where the vertices are.
    pub positions: Array<[f32; 3]>,
    /// One unit normal a vertex, towards lower values; zero where the data has no gradient.
    pub normals: Array<[f32; 3]>,
    /// The data's value at each vertex, or empty.
    pub values: Vec<f32>,
    /// Red, green, blue and alpha of each vertex, not premultiplied, in sRGB; or empty.
    pub colors: Vec<[u8; 4]>,
    /// Three vertices a triangle.
    pub triangles: Array<[u32; 3]>,
    /// Runs of triangles that belong together, in their order and without gaps.
    pub parts: Vec<Part>,
}

/// A run of triangles of a [`Mesh`]: the surface of one isovalue, or a cap.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// What the triangles are labelled with in files that have a place for it.
    pub label: u32,
    /// The value whose surface this is; `None` for a cap.
    pub iso: Option<f64>,
    /// Which triangles of the mesh.
    pub triangles: Range<usize>,
}

impl Mesh {
    /// Adds the vertices and triangles of `other`; its parts get labels above those that are there.
    ///
    /// # Errors
    /// [`ExtractError::TooLarge`] if there are more vertices than `u32` counts; the mesh is then as it was.
    pub fn append(&mut self, mut other: Self) -> Result<(), ExtractError> {
        let too_large = |_| ExtractError::TooLarge { what: "vertices" };
        u32::try_from(self.positions.len() + other.positions.len()).map_err(too_large)?;
        let (vertices, triangles) = (self.positions.len() as u32, self.triangles.len());
        let labels = self.parts.iter().map(|part| part.label + 1).max().unwrap_or(0);
        self.positions.to_mut().extend(&other.positions);
        self.normals.to_mut().extend(&other.normals);
        self.values.append(&mut other.values);
        self.colors.append(&mut other.colors);
        let renumbered = other.triangles.iter().map(|t| t.map(|v| v + vertices));
        self.triangles.to_mut().extend(renumbered);
        self.parts.extend(other.parts.into_iter().map(|part| Part {
            label: part.label + labels,
            triangles: part.triangles.start + triangles..part.triangles.end + triangles,
            ..part
        }));
        Ok(())
    }

    /// Whether there is no triangle.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// The corners of triangle `n` (below `triangles.len()`).
    pub fn corners(&self, n: usize) -> [[f32; 3]; 3] {
        self.triangles[n].map(|v| self.positions[v as usize])
    }
}
