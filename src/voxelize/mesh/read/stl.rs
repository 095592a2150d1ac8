//! STL, binary and text: each triangle has corners of its own. The facets' normals are not read; the corners' order says the same.
//!
//! Format: 3D Systems, StereoLithography Interface Specification (1989).

use glam::DVec3;

use super::TriangleMesh;
use super::bytes::{self, Cursor};
use super::error::Fault;

/// What comes before the first triangle of a binary file: free text and a count.
const HEADER: usize = 84;

/// Bytes of a triangle: normal, corners, and two for attributes.
const TRIANGLE: usize = 50;

/// Reads a whole file. One that has the length that its count as binary demands is binary, whatever its text says.
pub fn read(file: &[u8]) -> Result<TriangleMesh, Fault> {
    let is_text = file.trim_ascii_start().starts_with(b"solid");
    match declared(file) {
        Some(bytes) if bytes == file.len() as u64 => read_binary(file),
        _ if is_text => read_text(file),
        Some(bytes) => {
            let what = format!("{bytes} bytes are declared, and the file has {}", file.len());
            Err(Fault::new(what).byte(HEADER - 4))
        }
        None => Err(Fault::truncated("the number of triangles").byte(file.len())),
    }
}

/// The length of a binary file, by its count.
fn declared(file: &[u8]) -> Option<u64> {
    let count = Cursor::new(file.get(HEADER - 4..)?).u32("the count").ok()?;
    Some(HEADER as u64 + TRIANGLE as u64 * u64::from(count))
}

fn read_binary(file: &[u8]) -> Result<TriangleMesh, Fault> {
    let mut mesh = TriangleMesh::default();
    let mut cursor = Cursor::new(file);
    cursor.take(HEADER, "the header")?;
    while cursor.left() > 0 {
        cursor.take(12, "a normal")?;
        let mut corner = || cursor.array("a triangle").map(bytes::vector);
        let corners = [corner()?, corner()?, corner()?];
        cursor.take(2, "a triangle")?;
        push(&mut mesh, corners)?;
    }
    Ok(mesh)
}

fn push(mesh: &mut TriangleMesh, corners: [DVec3; 3]) -> Result<(), Fault> {
    let [a, b, c] = corners.map(|corner| mesh.push(corner));
    mesh.triangles.push([a?, b?, c?]);
    Ok(())
}

/// Text: `solid`, facets of three lines `vertex x y z`, `endsolid`. There may be several solids.
fn read_text(file: &[u8]) -> Result<TriangleMesh, Fault> {
    let mut mesh = TriangleMesh::default();
    let mut corners: Vec<DVec3> = Vec::new();
    let (mut last, mut is_open) = (0, false);
    for (line, text) in bytes::lines(file) {
        let mut words = text.split_ascii_whitespace();
        let keyword = words.next().unwrap_or_default();
        match keyword {
            "solid" => is_open = true,
            "endsolid" => is_open = false,
            "vertex" => corners.push(vertex(words, line)?),
            "endfacet" => {
                let triangle = <[DVec3; 3]>::try_from(corners.as_slice())
                    .map_err(|_| Fault::new(format!("the facet has {} corners", corners.len())).line(line))?;
                push(&mut mesh, triangle)?;
                corners.clear();
            }
            "" | "facet" | "outer" | "endloop" => {}
            _ => return Err(Fault::new(format!("`{}` is not of STL", bytes::shortened(keyword))).line(line)),
        }
        last = line;
    }
    if is_open || !corners.is_empty() {
        return Err(Fault::truncated("`endsolid`").line(last));
    }
    Ok(mesh)
}

fn vertex<'a>(mut words: impl Iterator<Item = &'a str>, line: usize) -> Result<DVec3, Fault> {
    let mut coordinate = || match words.next() {
        Some(word) => bytes::number(word, line),
        None => Err(Fault::new("the vertex has less than three coordinates").line(line)),
    };
    Ok(DVec3::new(coordinate()?, coordinate()?, coordinate()?))
}
