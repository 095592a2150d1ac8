//! VTK XML PolyData: what there is of `Normals`, `Value` and `Colors` a point, and `Label` a cell.
//!
//! Format: VTK's documentation, VTK XML File Formats. The arrays follow the XML as raw bytes, each after its length. The
//! field `SPACE` is where 3D Slicer looks for the axes.

use std::io::{self, Write};

use super::Mesh;
use super::chunks::{write_each, write_words};

/// Bytes of an array's length, as `header_type` says.
const LENGTH_BYTES: u64 = 8;

/// An array of the file: its XML attributes, and where its numbers come from.
struct Array<'a> {
    attributes: &'static str,
    data: Data<'a>,
}

enum Data<'a> {
    Floats(&'a [f32]),
    Bytes(&'a [u8]),
    /// The label of each triangle's part.
    Labels,
    /// The corners of each triangle.
    Connectivity,
    /// Where each triangle's corners end.
    Offsets,
}

/// An element of the XML that holds arrays.
struct Section<'a> {
    name: &'static str,
    attributes: &'static str,
    arrays: Vec<Array<'a>>,
}

/// Writes a whole file.
pub fn write(out: &mut impl Write, mesh: &Mesh) -> io::Result<()> {
    let sections = [point_data(mesh), cell_data(mesh), points(mesh), polys()];
    out.write_all(xml(mesh, &sections).as_bytes())?;
    let mut arrays = sections.iter().flat_map(|section| &section.arrays);
    arrays.try_for_each(|array| array.data.write(out, mesh))?;
    out.write_all(b"\n</AppendedData>\n</VTKFile>\n")
}

fn point_data(mesh: &Mesh) -> Section<'_> {
    let (normals, colors) = (mesh.normals.as_flattened(), mesh.colors.as_flattened());
    let arrays = vec![
        floats(r#"type="Float32" Name="Normals" NumberOfComponents="3""#, normals),
        floats(r#"type="Float32" Name="Value""#, &mesh.values),
        Array {
            attributes: r#"type="UInt8" Name="Colors" NumberOfComponents="4""#,
            data: Data::Bytes(colors),
        },
    ];
    Section {
        name: "PointData",
        attributes: r#" Normals="Normals" Scalars="Value""#,
        arrays: there(arrays, mesh),
    }
}

fn cell_data(mesh: &Mesh) -> Section<'_> {
    let label = Array {
        attributes: r#"type="UInt32" Name="Label""#,
        data: Data::Labels,
    };
    Section {
        name: "CellData",
        attributes: r#" Scalars="Label""#,
        arrays: there(vec![label], mesh),
    }
}

fn points(mesh: &Mesh) -> Section<'_> {
    let positions = mesh.positions.as_flattened();
    Section {
        name: "Points",
        attributes: "",
        arrays: vec![floats(
            r#"type="Float32" Name="Points" NumberOfComponents="3""#,
            positions,
        )],
    }
}

fn polys() -> Section<'static> {
    let arrays = [
        (r#"type="Int64" Name="connectivity""#, Data::Connectivity),
        (r#"type="Int64" Name="offsets""#, Data::Offsets),
    ];
    Section {
        name: "Polys",
        attributes: "",
        arrays: arrays.map(|(attributes, data)| Array { attributes, data }).into(),
    }
}

fn floats<'a>(attributes: &'static str, floats: &'a [f32]) -> Array<'a> {
    Array {
        attributes,
        data: Data::Floats(floats),
    }
}

/// Those that have data.
fn there<'a>(mut arrays: Vec<Array<'a>>, mesh: &Mesh) -> Vec<Array<'a>> {
    arrays.retain(|array| array.data.bytes(mesh) > 0);
    arrays
}

fn xml(mesh: &Mesh, sections: &[Section]) -> String {
    let mut offset = 0;
    let sections = sections.iter().map(|section| section_xml(section, mesh, &mut offset));
    format!(
        "<?xml version=\"1.0\"?>\n<!-- vcsg, positions in millimetres, left-posterior-superior -->\n\
         <VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n\
         <FieldData>\n<Array type=\"String\" Name=\"SPACE\" NumberOfTuples=\"1\" format=\"ascii\">{}</Array>\n\
         </FieldData>\n<Piece NumberOfPoints=\"{}\" NumberOfPolys=\"{}\">\n{}</Piece>\n</PolyData>\n\
         <AppendedData encoding=\"raw\">\n_",
        "76 80 83 0", // LPS and its end, as character codes
        mesh.positions.len(),
        mesh.triangles.len(),
        sections.collect::<String>(),
    )
}

/// The element, whose arrays begin `offset` bytes into the data; moves `offset` to where they end.
fn section_xml(section: &Section, mesh: &Mesh, offset: &mut u64) -> String {
    let declaration = |array: &Array| {
        let text = format!(
            "<DataArray {} format=\"appended\" offset=\"{offset}\"/>\n",
            array.attributes
        );
        *offset += LENGTH_BYTES + array.data.bytes(mesh);
        text
    };
    let declarations: String = section.arrays.iter().map(declaration).collect();
    let (name, attributes) = (section.name, section.attributes);
    format!("<{name}{attributes}>\n{declarations}</{name}>\n")
}

impl Data<'_> {
    fn bytes(&self, mesh: &Mesh) -> u64 {
        let triangles = mesh.triangles.len() as u64;
        match self {
            Self::Floats(floats) => 4 * floats.len() as u64,
            Self::Bytes(bytes) => bytes.len() as u64,
            Self::Labels => 4 * triangles,
            Self::Connectivity => 3 * 8 * triangles,
            Self::Offsets => 8 * triangles,
        }
    }

    /// Writes the length and the numbers.
    fn write(&self, out: &mut impl Write, mesh: &Mesh) -> io::Result<()> {
        out.write_all(&self.bytes(mesh).to_le_bytes())?;
        let triangles = 0..mesh.triangles.len();
        match self {
            Self::Floats(floats) => write_words(out, floats),
            Self::Bytes(bytes) => out.write_all(bytes),
            Self::Labels => write_labels(out, mesh),
            Self::Connectivity => write_each(out, triangles, |bytes, t| {
                let corners = mesh.triangles[t].map(|v| i64::from(v).to_le_bytes());
                bytes.extend_from_slice(corners.as_flattened());
            }),
            Self::Offsets => write_each(out, triangles, |bytes, t| {
                bytes.extend_from_slice(&(3 * (t as i64 + 1)).to_le_bytes());
            }),
        }
    }
}

fn write_labels(out: &mut impl Write, mesh: &Mesh) -> io::Result<()> {
    mesh.parts.iter().try_for_each(|part| {
        let label = part.label.to_le_bytes();
        write_each(out, part.triangles.clone(), |bytes, _| bytes.extend_from_slice(&label))
    })
}
