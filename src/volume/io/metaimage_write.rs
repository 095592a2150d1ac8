//! Writing MetaImage, in one file (.mha) or two (.mhd with .raw or .zraw).

use glam::DVec3;

use super::stored::ByteOrder;
use super::write::{Contents, Encoding, Output, Work, Writer, beside, name_of, voxel_bytes, zlib};
use crate::math::affine;
use crate::volume::voxel::VoxelType;

/// How MetaImage is written.
pub(super) const WRITER: Writer = Writer {
    suffixes: &[".mha", ".mhd"],
    writes: "raw or zlib; .mhd with .raw or .zraw beside it",
    files,
};

fn files<'a>(work: &Work<'a>) -> Result<Vec<Output<'a>>, String> {
    let data = data(work);
    if work.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("mha")) {
        let header = Contents::Made(header(work, &data, "LOCAL").into_bytes());
        let path = work.path.to_owned();
        return Ok(vec![Output {
            path,
            contents: vec![header, data],
        }]);
    }
    let path = match work.encoding {
        Encoding::Raw => beside(work.path, ".raw"),
        Encoding::Gzip => beside(work.path, ".zraw"),
    };
    let header = header(work, &data, name_of(&path)?).into_bytes();
    Ok(vec![
        Output {
            path,
            contents: vec![data],
        },
        Output {
            path: work.path.to_owned(),
            contents: vec![Contents::Made(header)],
        },
    ])
}

/// The voxels. Compressed, they are made whole, since their header tells their size.
fn data<'a>(work: &Work<'a>) -> Contents<'a> {
    match work.encoding {
        Encoding::Raw => Contents::There(voxel_bytes(work.grid)),
        Encoding::Gzip => Contents::Made(zlib(voxel_bytes(work.grid))),
    }
}

/// The header. ITK wants `ElementDataFile` last.
fn header(work: &Work, data: &Contents, data_file: &str) -> String {
    let place = work.grid.world_from_index();
    let spacing = affine::spacing(place);
    let axes = place.matrix3;
    // One axis after the other: the columns of what ITK calls the direction.
    let directions = [
        axes.x_axis / spacing.x,
        axes.y_axis / spacing.y,
        axes.z_axis / spacing.z,
    ]
    .map(numbers);
    let compression = match data {
        Contents::Made(bytes) => format!("CompressedData = True\nCompressedDataSize = {}\n", bytes.len()),
        _ => "CompressedData = False\n".to_owned(),
    };
    let order = match ByteOrder::NATIVE {
        ByteOrder::Little => "False",
        ByteOrder::Big => "True",
    };
    let [nx, ny, nz] = work.grid.dims();
    format!(
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = {order}\n{compression}\
         TransformMatrix = {}\nOffset = {}\nCenterOfRotation = 0 0 0\nElementSpacing = {}\n\
         DimSize = {nx} {ny} {nz}\nElementType = {}\nElementDataFile = {data_file}\n",
        directions.join(" "),
        numbers(place.translation),
        numbers(spacing),
        type_name(work.grid.voxel_type()),
    )
}

/// Rust prints the shortest digits that read back as the same number.
fn numbers(v: DVec3) -> String {
    format!("{:?} {:?} {:?}", v.x, v.y, v.z)
}

const fn type_name(voxel: VoxelType) -> &'static str {
    match voxel {
        VoxelType::U8 => "MET_UCHAR",
        VoxelType::I8 => "MET_CHAR",
        VoxelType::U16 => "MET_USHORT",
        VoxelType::I16 => "MET_SHORT",
        VoxelType::U32 => "MET_UINT",
        VoxelType::I32 => "MET_INT",
        VoxelType::F32 => "MET_FLOAT",
        VoxelType::F64 => "MET_DOUBLE",
    }
}
