//! Writing VTK's image data as XML (.vti), its voxels appended, raw or zlib.
//!
//! Format: "VTK XML file formats", of VTK's documentation. Compressed data is a table of 64-bit numbers (blocks, bytes of one, bytes
//! of the last unless it is whole, compressed bytes of each) and the blocks.

use glam::DVec3;
use rayon::prelude::*;

use super::stored::ByteOrder;
use super::write::{Contents, Encoding, Output, Work, Writer, voxel_bytes, zlib};
use crate::math::affine;
use crate::volume::voxel::VoxelType;

/// How VTI is written.
pub(super) const WRITER: Writer = Writer {
    suffixes: &[".vti"],
    writes: "one array of point data, appended, raw or zlib",
    files,
};

/// Bytes that are compressed together.
const BLOCK: usize = 1 << 20;

fn files<'a>(work: &Work<'a>) -> Result<Vec<Output<'a>>, String> {
    let end = b"\n  </AppendedData>\n</VTKFile>\n";
    let mut contents = vec![Contents::Made(head(work).into_bytes())];
    contents.extend(data(work));
    contents.push(Contents::There(end));
    let path = work.path.to_owned();
    Ok(vec![Output { path, contents }])
}

/// The XML, up to the byte after which the voxels begin.
fn head(work: &Work) -> String {
    let place = work.grid.world_from_index();
    let spacing = affine::spacing(place);
    let axes = place.matrix3.transpose();
    let direction = [axes.x_axis, axes.y_axis, axes.z_axis].map(|row| numbers(row / spacing));
    let compressor = match work.encoding {
        Encoding::Raw => "",
        Encoding::Gzip => " compressor=\"vtkZLibDataCompressor\"",
    };
    let order = match ByteOrder::NATIVE {
        ByteOrder::Little => "LittleEndian",
        ByteOrder::Big => "BigEndian",
    };
    let [x, y, z] = work.grid.dims().map(|n| n - 1);
    format!(
        r#"<?xml version="1.0"?>
<VTKFile type="ImageData" version="1.0" byte_order="{order}" header_type="UInt64"{compressor}>
  <ImageData WholeExtent="0 {x} 0 {y} 0 {z}" Origin="{}" Spacing="{}" Direction="{}">
    <Piece Extent="0 {x} 0 {y} 0 {z}">
      <PointData Scalars="values">
        <DataArray type="{}" Name="values" format="appended" offset="0"/>
      </PointData>
    </Piece>
  </ImageData>
  <AppendedData encoding="raw">
   _"#,
        numbers(place.translation),
        numbers(spacing),
        direction.join(" "),
        type_name(work.grid.voxel_type()),
    )
}

/// The voxels behind their sizes.
fn data<'a>(work: &Work<'a>) -> Vec<Contents<'a>> {
    let bytes = voxel_bytes(work.grid);
    match work.encoding {
        Encoding::Raw => vec![Contents::Made(sizes([bytes.len()])), Contents::There(bytes)],
        Encoding::Gzip => {
            let blocks: Vec<_> = bytes.par_chunks(BLOCK).map(zlib).collect();
            let table = [blocks.len(), BLOCK, bytes.len() % BLOCK].into_iter();
            let table = sizes(table.chain(blocks.iter().map(Vec::len)));
            [table].into_iter().chain(blocks).map(Contents::Made).collect()
        }
    }
}

fn sizes(numbers: impl IntoIterator<Item = usize>) -> Vec<u8> {
    let bytes = |n: usize| (n as u64).to_ne_bytes();
    numbers.into_iter().flat_map(bytes).collect()
}

/// Rust prints the shortest digits that read back as the same number.
fn numbers(v: DVec3) -> String {
    format!("{:?} {:?} {:?}", v.x, v.y, v.z)
}

const fn type_name(voxel: VoxelType) -> &'static str {
    match voxel {
        VoxelType::U8 => "UInt8",
        VoxelType::I8 => "Int8",
        VoxelType::U16 => "UInt16",
        VoxelType::I16 => "Int16",
        VoxelType::U32 => "UInt32",
        VoxelType::I32 => "Int32",
        VoxelType::F32 => "Float32",
        VoxelType::F64 => "Float64",
    }
}
