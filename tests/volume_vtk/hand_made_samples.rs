//! Small files of every variant, written here so that they can be damaged at will.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;

const PIECE: &str =
    "<ImageData WholeExtent=\"0 7 0 3 0 1\" Spacing=\"1 2 3\"><Piece Extent=\"0 7 0 3 0 1\"><PointData Scalars=\"a\">";

/// The 64 voxels.
fn voxels() -> Vec<u8> {
    (0..64).map(|i| i * 3).collect()
}

/// The voxels, compressed.
pub fn zlib() -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(&voxels()).unwrap();
    encoder.finish().unwrap()
}

/// The file of an array whose `data` is appended as it is.
pub fn appended(attributes: &str, data: &[u8]) -> Vec<u8> {
    let array = "<DataArray type=\"UInt8\" Name=\"a\" format=\"appended\" offset=\"0\"/>";
    let text = format!(
        "<VTKFile type=\"ImageData\" {attributes}>{PIECE}{array}</PointData></Piece></ImageData><AppendedData encoding=\"raw\">_"
    );
    [text.as_bytes(), data, b"</AppendedData></VTKFile>"].concat()
}

fn compressed(compressor: &str, data: &[u8]) -> Vec<u8> {
    let words = [1, 64, 0, data.len() as u32].map(u32::to_le_bytes).concat();
    appended(&format!("compressor=\"{compressor}\""), &[&words[..], data].concat())
}

/// Names and files.
pub fn samples() -> Vec<(&'static str, Vec<u8>)> {
    let numbers: Vec<_> = voxels().iter().map(u8::to_string).collect();
    let text = format!(
        "<VTKFile type=\"ImageData\">{PIECE}<DataArray type=\"UInt8\" Name=\"a\" format=\"ascii\">{}</DataArray></PointData></Piece></ImageData></VTKFile>",
        numbers.join(" ")
    );
    let header = "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 8 4 2\nPOINT_DATA 64\nSCALARS a unsigned_char\nLOOKUP_TABLE default\n";
    let ascii = format!("{}{}\n", header.replace("BINARY", "ASCII"), numbers.join(" "));
    vec![
        (
            "a.vti",
            appended(
                "header_type=\"UInt64\"",
                &[&64_u64.to_le_bytes()[..], &voxels()].concat(),
            ),
        ),
        ("a.vti", compressed("vtkZLibDataCompressor", &zlib())),
        (
            "a.vti",
            compressed("vtkLZ4DataCompressor", &[&[0xf0, 49][..], &voxels()].concat()),
        ),
        ("a.vti", text.into_bytes()),
        ("a.vtk", [header.as_bytes(), &voxels()].concat()),
        ("a.vtk", ascii.into_bytes()),
    ]
}

#[test]
fn the_samples_are_whole() {
    for (name, bytes) in samples() {
        let volume = crate::read(name, &bytes, &Default::default()).unwrap();
        assert_eq!(*volume.grid.voxels(), vcsg::volume::Voxels::U8(voxels()), "{name}");
    }
}
