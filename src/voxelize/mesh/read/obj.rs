//! Wavefront OBJ: positions and polygons; all else is passed over.
//!
//! Format: Wavefront, Advanced Visualizer manual, appendix B1 (1993). A vertex counts from 1, or back from the last with a minus.

use glam::DVec3;

use super::TriangleMesh;
use super::bytes;
use super::error::Fault;

/// Reads a whole file.
pub fn read(file: &[u8]) -> Result<TriangleMesh, Fault> {
    let mut mesh = TriangleMesh::default();
    let mut corners = Vec::new();
    // A backslash at the end of a line continues it on the next.
    let mut is_continued = false;
    let mut in_face = false;
    for (line, text) in bytes::lines(file) {
        let text = text.split('#').next().unwrap_or_default().trim_end();
        let (text, continues) = text.strip_suffix('\\').map_or((text, false), |text| (text, true));
        let mut words = text.split_ascii_whitespace();
        if !is_continued {
            in_face = false;
            match words.next() {
                Some("v") => drop(mesh.push(position(&mut words, line)?)?),
                Some("f") => in_face = true,
                _ => {}
            }
        }
        if in_face {
            for word in words {
                corners.push(corner(word, mesh.positions.len(), line)?);
            }
            if !continues {
                push_face(&mut mesh, &mut corners, line)?;
            }
        }
        is_continued = continues;
    }
    if is_continued && in_face {
        return Err(Fault::truncated("the line that a face goes on in"));
    }
    Ok(mesh)
}

/// `x y z`; a weight or a colour may follow.
fn position<'a>(words: &mut impl Iterator<Item = &'a str>, line: usize) -> Result<DVec3, Fault> {
    let mut coordinate = || match words.next() {
        Some(word) => bytes::number(word, line),
        None => Err(Fault::new("the vertex has less than three coordinates").line(line)),
    };
    Ok(DVec3::new(coordinate()?, coordinate()?, coordinate()?))
}

/// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
fn corner(word: &str, vertices: usize, line: usize) -> Result<u32, Fault> {
    let bad = |what: &str| Fault::new(format!("`{}` {what}", bytes::shortened(word))).line(line);
    let vertex = word.split('/').next().unwrap_or_default();
    let number: i64 = vertex.parse().map_err(|_| bad("is not a corner of a face"))?;
    let index = match number {
        1.. => number - 1,
        0 => return Err(bad("is no vertex: they count from 1")),
        _ => vertices as i64 + number,
    };
    u32::try_from(index).map_err(|_| bad("is no vertex"))
}

fn push_face(mesh: &mut TriangleMesh, corners: &mut Vec<u32>, line: usize) -> Result<(), Fault> {
    if corners.len() < 3 {
        return Err(Fault::new("the face has less than three corners").line(line));
    }
    mesh.push_fan(corners);
    corners.clear();
    Ok(())
}
