//! Wavefront OBJ: `v`, `vn`, `f a//a`, and a group a part. Colours follow the position, as `v x y z r g b`, which is
//! not in the specification and widely read. Numbers have the fewest digits that read back as the same `f32`.
//!
//! Format: Wavefront, Advanced Visualizer manual, appendix B1 (1993).

use std::io::{self, Write};

use serde::Serialize;

use super::chunks::write_each;
use super::{Mesh, Part};

/// Writes a whole file.
pub fn write(out: &mut impl Write, mesh: &Mesh) -> io::Result<()> {
    out.write_all(b"# vcsg, positions in millimetres, SPACE=LPS\n")?;
    write_each(out, 0..mesh.positions.len(), |text, v| append_vertex(text, mesh, v))?;
    write_each(out, 0..mesh.normals.len(), |text, v| {
        append_line(text, "vn", &mesh.normals[v]);
    })?;
    mesh.parts.iter().try_for_each(|part| write_group(out, mesh, part))
}

fn append_vertex(text: &mut Vec<u8>, mesh: &Mesh, vertex: usize) {
    let [x, y, z] = mesh.positions[vertex];
    match mesh.colors.get(vertex) {
        None => append_line(text, "v", &[x, y, z]),
        Some(color) => {
            let [r, g, b, _] = color.map(fraction);
            append_line(text, "v", &[x, y, z, r, g, b]);
        }
    }
}

/// `code` / 255 with four digits, rounded up: a reader that cuts off what follows the point of 255 times it gets `code`
/// back, as does one that rounds.
fn fraction(code: u8) -> f32 {
    let digits = (u32::from(code) * 10_000).div_ceil(255);
    digits as f32 / 10_000.0
}

fn append_line(text: &mut Vec<u8>, keyword: &str, numbers: &[f32]) {
    text.extend_from_slice(keyword.as_bytes());
    for number in numbers {
        text.push(b' ');
        append(text, number);
    }
    text.push(b'\n');
}

fn write_group(out: &mut impl Write, mesh: &Mesh, part: &Part) -> io::Result<()> {
    writeln!(out, "g label_{}", part.label)?;
    write_each(out, part.triangles.clone(), |text, triangle| {
        text.push(b'f');
        for vertex in mesh.triangles[triangle] {
            // Vertices are counted from 1.
            let number = u64::from(vertex) + 1;
            text.push(b' ');
            append(text, &number);
            if !mesh.normals.is_empty() {
                text.extend_from_slice(b"//");
                append(text, &number);
            }
        }
        text.push(b'\n');
    })
}

/// Appends a number's fewest digits; JSON's way to write it is OBJ's too, and faster than `Display`.
fn append(text: &mut Vec<u8>, number: &impl Serialize) {
    // Memory takes whatever is written to it.
    let _ = serde_json::to_writer(text, number);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_color_comes_back_cut_off_or_rounded() {
        for code in 0..=u8::MAX {
            let read = 255.0 * fraction(code);
            assert_eq!((read as u8, read.round() as u8), (code, code));
        }
        assert_eq!([0, 255].map(fraction), [0.0, 1.0]);
    }
}
