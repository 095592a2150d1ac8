//! Writing NRRD with attached or detached header.

use std::path::Path;

use glam::DVec3;

use super::stored::ByteOrder;
use super::write::{Contents, Encoding, Output, VolumeBeside, Work, WriteError, Writer, beside, name_of, voxel_bytes};
use crate::volume::grid::Grid;
use crate::volume::voxel::VoxelType;

/// How NRRD is written.
pub(super) const WRITER: Writer = Writer {
    suffixes: &[".nrrd", ".nhdr"],
    writes: "raw or gzip; .nhdr with .raw or .raw.gz beside it",
    files,
};

/// Writes `grid` to `path` as NRRD, whatever its suffix. The file appears there only when it is complete.
///
/// # Errors
/// The operating system's, with the file's name.
pub fn write_nrrd(path: &Path, grid: &Grid, encoding: Encoding) -> Result<(), WriteError> {
    let output = attached(&Work { path, grid, encoding });
    VolumeBeside::of(path, Ok(vec![output]))?.put()
}

fn files<'a>(work: &Work<'a>) -> Result<Vec<Output<'a>>, String> {
    let is_detached = work.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("nhdr"));
    match (is_detached, work.encoding) {
        (false, _) => Ok(vec![attached(work)]),
        (true, Encoding::Raw) => detached(work, &beside(work.path, ".raw"), work.path),
        (true, Encoding::Gzip) => detached(work, &beside(work.path, ".raw.gz"), work.path),
    }
}

/// Raw voxels at the path, and the header beside them.
pub(super) fn raw_files<'a>(work: &Work<'a>) -> Result<Vec<Output<'a>>, String> {
    let raw = Work {
        encoding: Encoding::Raw,
        ..*work
    };
    detached(&raw, work.path, &beside(work.path, ".nhdr"))
}

fn attached<'a>(work: &Work<'a>) -> Output<'a> {
    Output {
        path: work.path.to_owned(),
        contents: vec![Contents::Made(header(work, "").into_bytes()), voxels(work)],
    }
}

fn detached<'a>(work: &Work<'a>, data: &Path, header_path: &Path) -> Result<Vec<Output<'a>>, String> {
    let named = format!("data file: {}\n", name_of(data)?);
    Ok(vec![
        Output {
            path: data.to_owned(),
            contents: vec![voxels(work)],
        },
        Output {
            path: header_path.to_owned(),
            contents: vec![Contents::Made(header(work, &named).into_bytes())],
        },
    ])
}

fn voxels<'a>(work: &Work<'a>) -> Contents<'a> {
    match work.encoding {
        Encoding::Raw => Contents::There(voxel_bytes(work.grid)),
        Encoding::Gzip => Contents::Gzip(vec![voxel_bytes(work.grid).into()]),
    }
}

/// The header, with the line `data_file` in it, and the empty line that ends it.
fn header(work: &Work, data_file: &str) -> String {
    let [nx, ny, nz] = work.grid.dims();
    let place = work.grid.world_from_index();
    let axes = place.matrix3;
    let order = match ByteOrder::NATIVE {
        ByteOrder::Little => "little",
        ByteOrder::Big => "big",
    };
    let encoding = match work.encoding {
        Encoding::Raw => "raw",
        Encoding::Gzip => "gzip",
    };
    format!(
        "NRRD0004\ntype: {}\ndimension: 3\nspace: left-posterior-superior\nsizes: {nx} {ny} {nz}\n\
         space directions: {} {} {}\nkinds: domain domain domain\nendian: {order}\nencoding: {encoding}\n\
         space units: \"mm\" \"mm\" \"mm\"\nspace origin: {}\n{data_file}\n",
        type_name(work.grid.voxel_type()),
        vector(axes.x_axis),
        vector(axes.y_axis),
        vector(axes.z_axis),
        vector(place.translation),
    )
}

const fn type_name(voxel: VoxelType) -> &'static str {
    match voxel {
        VoxelType::U8 => "uint8",
        VoxelType::I8 => "int8",
        VoxelType::U16 => "uint16",
        VoxelType::I16 => "int16",
        VoxelType::U32 => "uint32",
        VoxelType::I32 => "int32",
        VoxelType::F32 => "float",
        VoxelType::F64 => "double",
    }
}

/// Rust prints the shortest digits that read back as the same number.
fn vector(v: DVec3) -> String {
    format!("({:?},{:?},{:?})", v.x, v.y, v.z)
}
