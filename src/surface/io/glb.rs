//! Binary glTF 2.0: a node with one mesh, a primitive a part, all on the same accessors.
//!
//! Format: Khronos, glTF 2.0 specification (2021). glTF is in metres with +Y up and +Z to the front: the node's matrix turns
//! millimetres in LPS into that. glTF's vertex colours are linear: sRGB's 8 bits are told apart in linear 16 bits, not in
//! linear 8. Its normals have length 1: where the data has no gradient, a triangle's takes the place of zero.
//! The document has one shape, which `serde_json` says in a page; a typed schema would be one more dependency.

use std::borrow::Cow;
use std::io::{self, Write};

use serde_json::{Value, json};

use super::chunks::{write_each, write_words};
use super::stl::facet_normal;
use super::{Mesh, MeshWriteError, Part, check};

/// Columns of the map from LPS millimetres to glTF's metres: left is +X, superior +Y, anterior +Z.
const GLTF_FROM_WORLD: [f64; 16] = [
    0.001, 0.0, 0.0, 0.0, //
    0.0, 0.0, -0.001, 0.0, //
    0.0, 0.001, 0.0, 0.0, //
    0.0, 0.0, 0.0, 1.0,
];

// Constants of the specification.
const MAGIC: &[u8; 4] = b"glTF";
const VERSION: u32 = 2;
const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// The mesh as a document and the length of its arrays.
#[derive(Default)]
struct Document {
    json: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    binary_bytes: u64,
}

/// Whether positions and normals are finite and the file's length fits in 32 bits.
pub fn check(mesh: &Mesh) -> Result<(), MeshWriteError> {
    check::finite(mesh, "GLB")?;
    check::within(Document::new(mesh).file_bytes(), "bytes", u64::from(u32::MAX), "GLB")
}

/// Writes a whole file of less than 2³² bytes.
pub fn write(out: &mut impl Write, mesh: &Mesh) -> io::Result<()> {
    let document = Document::new(mesh);
    out.write_all(MAGIC)?;
    write_words(out, &[VERSION, document.file_bytes() as u32])?;
    write_words(out, &[document.json.len() as u32, u32::from_le_bytes(*b"JSON")])?;
    out.write_all(&document.json)?;
    if document.binary_bytes == 0 {
        return Ok(());
    }
    write_words(out, &[document.binary_bytes as u32, u32::from_le_bytes(*b"BIN\0")])?;
    write_arrays(out, mesh)
}

/// Writes what the document's views describe, in their order.
fn write_arrays(out: &mut impl Write, mesh: &Mesh) -> io::Result<()> {
    write_words(out, &mesh.positions)?;
    write_words(out, &unit_normals(mesh))?;
    let linear: [u16; 256] = std::array::from_fn(|code| linear(code as u8));
    write_each(out, 0..mesh.colors.len(), |bytes, v| {
        let [r, g, b, alpha] = mesh.colors[v];
        let [r, g, b] = [r, g, b].map(|code| linear[usize::from(code)]);
        // 257 = 65535 / 255.
        let color = [r, g, b, 257 * u16::from(alpha)].map(u16::to_le_bytes);
        bytes.extend_from_slice(color.as_flattened());
    })?;
    write_words(out, &mesh.triangles)
}

/// The light of an sRGB code, 65535 for white (IEC 61966-2-1).
fn linear(code: u8) -> u16 {
    let coded = f64::from(code) / 255.0;
    let light = match coded <= 0.04045 {
        true => coded / 12.92,
        false => ((coded + 0.055) / 1.055).powf(2.4),
    };
    (light * 65535.0).round() as u16
}

/// The normals with none of length 0.
fn unit_normals(mesh: &Mesh) -> Cow<'_, [[f32; 3]]> {
    if !mesh.normals.contains(&[0.0; 3]) {
        return Cow::Borrowed(&mesh.normals);
    }
    let mut normals = mesh.normals.to_vec();
    for (n, triangle) in mesh.triangles.iter().enumerate() {
        let missing = triangle
            .map(|v| v as usize)
            .into_iter()
            .filter(|v| mesh.normals[*v] == [0.0; 3]);
        missing.for_each(|v| normals[v] = facet_normal(mesh.corners(n)));
    }
    // Around a vertex without a triangle of any area every direction is as good.
    let missing = normals.iter_mut().filter(|normal| **normal == [0.0; 3]);
    missing.for_each(|normal| *normal = [0.0, 0.0, 1.0]);
    Cow::Owned(normals)
}

impl Document {
    fn new(mesh: &Mesh) -> Self {
        let mut document = Self::default();
        let content = match mesh.is_empty() {
            // An accessor may not be empty, and so there is none.
            true => json!({ "asset": asset(), "scene": 0, "scenes": [{}] }),
            false => document.content(mesh),
        };
        document.json = content.to_string().into_bytes();
        let padded = document.json.len().next_multiple_of(4);
        document.json.resize(padded, b' ');
        document
    }

    /// Header, and each chunk after its length and type.
    fn file_bytes(&self) -> u64 {
        let binary = if self.binary_bytes == 0 {
            0
        } else {
            8 + self.binary_bytes
        };
        12 + 8 + self.json.len() as u64 + binary
    }

    fn content(&mut self, mesh: &Mesh) -> Value {
        let attributes = self.attributes(mesh);
        let indices = self.view(mesh.triangles.len() * 12, ELEMENT_ARRAY_BUFFER);
        let parts = mesh.parts.iter().filter(|part| !part.triangles.is_empty());
        let primitives: Vec<_> = parts.map(|part| self.primitive(part, indices, &attributes)).collect();
        json!({
            "asset": asset(),
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": [{ "mesh": 0, "matrix": GLTF_FROM_WORLD }],
            "meshes": [{ "primitives": primitives }],
            "materials": [material(mesh)],
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.binary_bytes }],
        })
    }

    /// Accessors of what belongs to a vertex, by their names in glTF.
    fn attributes(&mut self, mesh: &Mesh) -> Value {
        let vertices = mesh.positions.len();
        let [min, max] = bounds(&mesh.positions);
        let view = self.view(vertices * 12, ARRAY_BUFFER);
        let position = json!({ "bufferView": view, "componentType": FLOAT, "type": "VEC3", "count": vertices,
            "min": min, "max": max });
        let mut attributes = json!({ "POSITION": self.accessor(position) });
        if !mesh.normals.is_empty() {
            let view = self.view(vertices * 12, ARRAY_BUFFER);
            let normal = json!({ "bufferView": view, "componentType": FLOAT, "type": "VEC3", "count": vertices });
            attributes["NORMAL"] = self.accessor(normal).into();
        }
        if !mesh.colors.is_empty() {
            let view = self.view(vertices * 8, ARRAY_BUFFER);
            let color = json!({ "bufferView": view, "componentType": UNSIGNED_SHORT, "normalized": true,
                "type": "VEC4", "count": vertices });
            attributes["COLOR_0"] = self.accessor(color).into();
        }
        attributes
    }

    fn primitive(&mut self, part: &Part, view: usize, attributes: &Value) -> Value {
        let indices = json!({ "bufferView": view, "byteOffset": part.triangles.start * 12,
            "componentType": UNSIGNED_INT, "type": "SCALAR", "count": part.triangles.len() * 3 });
        json!({
            "attributes": attributes,
            "indices": self.accessor(indices),
            "material": 0,
            "extras": { "label": part.label, "iso": part.iso },
        })
    }

    /// The next `bytes` of the arrays, as a view whose number is returned.
    fn view(&mut self, bytes: usize, target: u32) -> usize {
        let offset = self.binary_bytes;
        self.views
            .push(json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes, "target": target }));
        self.binary_bytes += bytes as u64;
        self.views.len() - 1
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

fn asset() -> Value {
    json!({ "version": "2.0", "generator": "vcsg" })
}

/// No metal, seen from both sides (a surface that ends at the volume's border shows its back).
fn material(mesh: &Mesh) -> Value {
    let translucent = mesh.colors.iter().any(|color| color[3] < u8::MAX);
    json!({
        "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 0.6 },
        "alphaMode": if translucent { "BLEND" } else { "OPAQUE" },
        "doubleSided": true,
    })
}

/// Least and greatest coordinates; exact, since every `f32` is an `f64`.
fn bounds(positions: &[[f32; 3]]) -> [[f64; 3]; 2] {
    let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for position in positions {
        for (axis, x) in position.iter().enumerate() {
            bounds[0][axis] = bounds[0][axis].min(*x);
            bounds[1][axis] = bounds[1][axis].max(*x);
        }
    }
    bounds.map(|bound| bound.map(f64::from))
}
