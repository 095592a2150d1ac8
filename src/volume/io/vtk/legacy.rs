//! VTK legacy files of structured points (.vtk).

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use super::bits::{BIT, Bits};
use super::legacy_header::{Data, FRACTIONS, Header};
use super::{Array, choose, declared};
use crate::volume::grid::voxel_count;
use crate::volume::io::error::ReadError;
use crate::volume::io::format::Format;
use crate::volume::io::open::{Opened, ReadOptions};
use crate::volume::io::scalars::{Scalars, Source, Words};
use crate::volume::io::stored::ByteOrder;

/// Legacy VTK files among the formats.
pub(in crate::volume::io) const FORMAT: Format = Format {
    name: "VTK legacy",
    suffixes: &[".vtk"],
    reads: "structured points, ascii and binary, versions 1 to 5.1: scalars, vectors, fields, of points or cells",
    recognises: |probe| {
        !probe.is_folder && !probe.has_layout && (probe.is_named(&FORMAT) || probe.start.starts_with(b"# vtk DataFile"))
    },
    open: |path, options| Ok(vec![open(path, options)?]),
    writer: None,
};

fn open(path: &Path, options: &ReadOptions) -> Result<Opened, ReadError> {
    let header = Header::read(path)?;
    let arrays: Vec<Array> = header.arrays.iter().map(|(array, _)| array.clone()).collect();
    let choice = choose(path, &arrays, options)?;
    let declared = declared(FORMAT.name, &arrays, &choice, &header.lattice);
    let data = &header.arrays[choice.index].1;
    let voxels = voxel_count(declared.dims).map_err(|e| ReadError::new(path, e))?;
    if data.tuples != voxels {
        let name = &arrays[choice.index].name;
        let what = format!("the array `{name}` has {} values for {voxels} voxels", data.tuples);
        return Err(ReadError::header(path, what).byte(data.start));
    }
    let count = voxels.saturating_mul(choice.components.count());
    let scalars = Scalars::new(
        path.to_owned(),
        choice.stored,
        count,
        source(path, data, header.is_binary, &arrays[choice.index])?,
    );
    Opened::new(path.to_owned(), declared, scalars.chunks(choice.components))
}

fn source(path: &Path, data: &Data, is_binary: bool, array: &Array) -> Result<Source, ReadError> {
    let io_error = |e| ReadError::io(path, e);
    let mut file = File::open(path).map_err(io_error)?;
    file.seek(SeekFrom::Start(data.start)).map_err(io_error)?;
    let bytes = BufReader::new(file).take(data.bytes);
    Ok(match is_binary {
        true if array.kind.0 == BIT => Source::Binary(Box::new(Bits::new(bytes)), ByteOrder::Big),
        true => Source::Binary(Box::new(bytes), ByteOrder::Big),
        false if array.kind.0 == FRACTIONS => Source::Fractions(Words::new(Box::new(bytes))),
        false => Source::Text(Words::new(Box::new(bytes))),
    })
}
