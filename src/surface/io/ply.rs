//! Binary little-endian PLY: what there is of normals, `value` and colours a vertex, `label` a face if there are several
//! parts.
//!
//! Format: G. Turk, The PLY Polygon File Format (1994). Its comment names the axes as 3D Slicer reads them.

use std::io::{self, Write};

use super::chunks::{append_vector, write_each};
use super::{Mesh, Part};

/// Writes a whole file.
pub fn write(out: &mut impl Write, mesh: &Mesh) -> io::Result<()> {
    out.write_all(header(mesh).as_bytes())?;
    write_each(out, 0..mesh.positions.len(), |bytes, v| append_vertex(bytes, mesh, v))?;
    mesh.parts.iter().try_for_each(|part| write_faces(out, mesh, part))
}

fn has_labels(mesh: &Mesh) -> bool {
    mesh.parts.len() > 1
}

fn header(mesh: &Mesh) -> String {
    let optional = |there: bool, properties: &'static str| if there { properties } else { "" };
    format!(
        "ply\nformat binary_little_endian 1.0\ncomment vcsg, positions in millimetres, SPACE=LPS\nelement vertex {}\n\
         property float x\nproperty float y\nproperty float z\n{}{}{}element face {}\n\
         property list uchar uint vertex_indices\n{}end_header\n",
        mesh.positions.len(),
        optional(
            !mesh.normals.is_empty(),
            "property float nx\nproperty float ny\nproperty float nz\n"
        ),
        optional(!mesh.values.is_empty(), "property float value\n"),
        optional(
            !mesh.colors.is_empty(),
            "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n"
        ),
        mesh.triangles.len(),
        optional(has_labels(mesh), "property uint label\n"),
    )
}

fn append_vertex(bytes: &mut Vec<u8>, mesh: &Mesh, vertex: usize) {
    append_vector(bytes, mesh.positions[vertex]);
    if let Some(normal) = mesh.normals.get(vertex) {
        append_vector(bytes, *normal);
    }
    if let Some(value) = mesh.values.get(vertex) {
        bytes.extend(value.to_le_bytes());
    }
    if let Some(color) = mesh.colors.get(vertex) {
        bytes.extend(color);
    }
}

fn write_faces(out: &mut impl Write, mesh: &Mesh, part: &Part) -> io::Result<()> {
    let label = part.label.to_le_bytes();
    let label: &[u8] = if has_labels(mesh) { &label } else { &[] };
    write_each(out, part.triangles.clone(), |bytes, triangle| {
        bytes.push(3);
        bytes.extend_from_slice(mesh.triangles[triangle].map(u32::to_le_bytes).as_flattened());
        bytes.extend_from_slice(label);
    })
}
