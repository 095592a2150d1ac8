//! What every writer relies on.

use rayon::prelude::*;

use super::{Inconsistency, Mesh, MeshWriteError};

/// Whether attributes, corners and parts of `mesh` fit each other.
pub fn consistent(mesh: &Mesh) -> Result<(), Inconsistency> {
    attribute("normals", mesh.normals.len(), mesh)?;
    attribute("values", mesh.values.len(), mesh)?;
    attribute("colors", mesh.colors.len(), mesh)?;
    corners(mesh)?;
    parts(mesh)
}

fn attribute(attribute: &'static str, found: usize, mesh: &Mesh) -> Result<(), Inconsistency> {
    let vertices = mesh.positions.len();
    if found == 0 || found == vertices {
        return Ok(());
    }
    Err(Inconsistency::Attribute {
        attribute,
        found,
        vertices,
    })
}

fn corners(mesh: &Mesh) -> Result<(), Inconsistency> {
    let vertices = mesh.positions.len();
    let outside = |vertex: u32| vertex as usize >= vertices;
    let found = mesh
        .triangles
        .par_iter()
        .position_first(|t| t.iter().any(|v| outside(*v)));
    let Some(triangle) = found else { return Ok(()) };
    let [a, b, c] = mesh.triangles[triangle];
    Err(Inconsistency::Index {
        triangle,
        vertex: a.max(b).max(c),
        vertices,
    })
}

fn parts(mesh: &Mesh) -> Result<(), Inconsistency> {
    let (mut expected, triangles) = (0, mesh.triangles.len());
    for (part, found) in mesh.parts.iter().enumerate() {
        let (start, end) = (found.triangles.start, found.triangles.end);
        if start != expected || end < start {
            return Err(Inconsistency::Part {
                part,
                start,
                end,
                expected,
            });
        }
        expected = end;
    }
    if expected == triangles {
        return Ok(());
    }
    Err(Inconsistency::Parts {
        parts: expected,
        triangles,
    })
}

/// Whether every position and normal is a number, for a format that has no others.
pub fn finite(mesh: &Mesh, format: &'static str) -> Result<(), MeshWriteError> {
    all_finite(&mesh.positions, "position", format)?;
    all_finite(&mesh.normals, "normal", format)
}

fn all_finite(vectors: &[[f32; 3]], attribute: &'static str, format: &'static str) -> Result<(), MeshWriteError> {
    let found = vectors.par_iter().position_first(|v| v.iter().any(|x| !x.is_finite()));
    match found {
        None => Ok(()),
        Some(vertex) => Err(MeshWriteError::NotFinite {
            format,
            attribute,
            vertex,
        }),
    }
}

/// Whether `found` of `what` are at most the `limit` of `format`.
pub fn within(found: u64, what: &'static str, limit: u64, format: &'static str) -> Result<(), MeshWriteError> {
    if found <= limit {
        return Ok(());
    }
    Err(MeshWriteError::TooMany {
        format,
        what,
        found,
        limit,
    })
}

#[cfg(test)]
mod tests {
    use super::super::Part;
    use super::*;

    /// Two triangles of four vertices, a part each.
    fn square() -> Mesh {
        let part = |n: u32, triangles| Part {
            label: n,
            iso: None,
            triangles,
        };
        Mesh {
            positions: vec![[0.0; 3]; 4].into(),
            triangles: vec![[0, 1, 2], [2, 1, 3]].into(),
            parts: vec![part(0, 0..1), part(1, 1..2)],
            ..Mesh::default()
        }
    }

    fn refusal(change: impl FnOnce(&mut Mesh)) -> String {
        let mut mesh = square();
        assert_eq!(consistent(&mesh), Ok(()));
        change(&mut mesh);
        consistent(&mesh).expect_err("a contradiction").to_string()
    }

    #[test]
    fn contradictions_are_named() {
        assert_eq!(
            refusal(|m| m.normals = vec![[0.0; 3]; 3].into()),
            "3 normals for 4 vertices"
        );
        assert_eq!(refusal(|m| m.values = vec![0.0; 5]), "5 values for 4 vertices");
        assert_eq!(refusal(|m| m.colors = vec![[0; 4]]), "1 colors for 4 vertices");
        assert_eq!(refusal(|m| m.triangles[1][0] = 4), "triangle 1 has vertex 4 of 4");
    }

    #[test]
    fn parts_tile_the_triangles() {
        let gap = "part 1 has triangles 2 to 2, where triangle 1 is next";
        assert_eq!(refusal(|m| m.parts[1].triangles = 2..2), gap);
        let overlap = "part 1 has triangles 0 to 2, where triangle 1 is next";
        assert_eq!(refusal(|m| m.parts[1].triangles.start = 0), overlap);
        assert_eq!(refusal(|m| m.parts.truncate(1)), "the parts end at triangle 1 of 2");
        assert_eq!(
            refusal(|m| m.parts[1].triangles.end = 3),
            "the parts end at triangle 3 of 2"
        );
    }

    #[test]
    fn a_limit_is_the_last_that_fits() {
        assert!(within(5, "triangles", 5, "X").is_ok());
        let error = within(6, "triangles", 5, "X").expect_err("one too many");
        assert!(
            error.to_string().starts_with("6 triangles are too many for X"),
            "{error}"
        );
    }
}
