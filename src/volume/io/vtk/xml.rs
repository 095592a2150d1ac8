//! VTK XML image data (.vti), and pieces of it in files of their own (.pvti).

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;

use super::base64::Base64;
use super::bits::Bits;
use super::blocks::Blocks;
use super::parallel::{PieceFile, pieces};
use super::pieces::{Part, in_slices};
use super::xml_header::{Content, Header, Piece};
use super::{Array, Choice, Extent, choose, declared};
use crate::volume::grid::voxel_count;
use crate::volume::io::error::{Problem, ReadError};
use crate::volume::io::format::Format;
use crate::volume::io::open::{Opened, ReadOptions};
use crate::volume::io::scalars::{Scalars, Source, Words as Text};
use crate::volume::io::vti_write;

/// VTK XML image data among the formats.
pub(in crate::volume::io) const FORMAT: Format = Format {
    name: "VTK XML",
    suffixes: &[".vti", ".pvti"],
    reads: "image data: ascii, base64 and raw, inline and appended; zlib, LZ4, LZMA; values of points or cells; pieces in files",
    recognises: |probe| !probe.is_folder && !probe.has_layout && (probe.is_named(&FORMAT) || is_vtk_xml(&probe.start)),
    open: |path, options| Ok(vec![open(path, options)?]),
    writer: Some(vti_write::WRITER),
};

fn is_vtk_xml(start: &[u8]) -> bool {
    start.windows(8).any(|bytes| bytes == b"<VTKFile")
}

fn open(path: &Path, options: &ReadOptions) -> Result<Opened, ReadError> {
    let header = Header::read(path)?;
    let lattice = header.lattice;
    let files = PieceFile::all(path, header)?;
    let Some((_, first)) = pieces(&files).next() else {
        return Err(ReadError::header(path, "it has no Piece"));
    };
    let arrays: Vec<Array> = first.arrays.iter().map(|(array, _)| array.clone()).collect();
    let choice = choose(path, &arrays, options)?;
    let declared = declared(FORMAT.name, &arrays, &choice, &lattice);
    voxel_count(declared.dims).map_err(|e| ReadError::new(path, e))?;
    let parts = pieces(&files).map(|(file, piece)| {
        let content = content(&file.path, piece, &arrays[choice.index])?;
        match lattice.extent.contains(&piece.extent) {
            true => part(file, piece.extent, &choice, content),
            false => Err(ReadError::header(
                &file.path,
                "a piece lies outside the image's WholeExtent",
            )),
        }
    });
    let chunks = match <[Part; 1]>::try_from(parts.collect::<Result<Vec<_>, _>>()?) {
        Ok([part]) if part.extent == lattice.extent => (part.open)()?.chunks(choice.components),
        Ok([part]) => in_slices(path, vec![part], &lattice.extent, &choice)?,
        Err(parts) => in_slices(path, parts, &lattice.extent, &choice)?,
    };
    Opened::new(path.to_owned(), declared, chunks)
}

/// The piece of `file` whose numbers are `content`. What that declares is held against the file now, and it is opened again when its
/// turn comes.
fn part(file: &Arc<PieceFile>, extent: Extent, choice: &Choice, content: Content) -> Result<Part, ReadError> {
    let (file, choice) = (Arc::clone(file), *choice);
    let open = move || scalars(&file.path, &file.header, &choice, extent.dims(choice.of), &content);
    open().map(drop)?;
    Ok(Part {
        extent,
        open: Box::new(open),
    })
}

/// Where the data of the piece's array is that is like `wanted`.
fn content(path: &Path, piece: &Piece, wanted: &Array) -> Result<Content, ReadError> {
    let is_it = |array: &Array| array.of == wanted.of && array.name == wanted.name && array.kind == wanted.kind;
    let found = (piece.arrays.iter()).find(|(array, _)| is_it(array) && array.components == wanted.components);
    match found {
        Some((_, content)) => Ok(content.clone()),
        None => Err(ReadError::header(
            path,
            format!("a piece has no array `{}` like the first's", wanted.name),
        )),
    }
}

/// The numbers of a piece of so many voxels.
fn scalars(
    path: &Path,
    header: &Header,
    choice: &Choice,
    dims: [usize; 3],
    content: &Content,
) -> Result<Scalars, ReadError> {
    let count = voxel_count(dims).map_err(|e| ReadError::new(path, e))?;
    let count = count.saturating_mul(choice.components.count());
    let expected = choice.bytes(count as u64);
    let io_error = |e| ReadError::io(path, e);
    let mut file = File::open(path).map_err(io_error)?;
    let length = file.metadata().map_err(io_error)?.len();
    let (start, bytes) = span(path, header, content, length)?;
    let truncated = |found| ReadError::new(path, Problem::Truncated { expected, found }).byte(start);
    file.seek(SeekFrom::Start(start)).map_err(io_error)?;
    let text = BufReader::new(file).take(bytes);
    let is_base64 = match content {
        Content::Ascii(_) => {
            // A number takes a digit and a separator.
            if bytes.saturating_add(1) / 2 < count as u64 {
                return Err(too_few(path, count).byte(start));
            }
            let source = Source::Text(Text::new(Box::new(text)));
            return Ok(Scalars::new(path.to_owned(), choice.stored, count, source));
        }
        Content::Inline(_) => true,
        Content::Appended(_) => header.appended.is_some_and(|appended| appended.is_base64),
    };
    let ratio = header.compressor.map_or(1, super::xml_header::Compressor::best_ratio);
    if expected / ratio > bytes {
        return Err(truncated(bytes));
    }
    let bytes: Box<dyn Read + Send> = match is_base64 {
        true => Box::new(Base64::new(text)),
        false => Box::new(text),
    };
    let opened = decoded(header, bytes).map_err(|e| match e.kind() {
        io::ErrorKind::UnexpectedEof => truncated(0),
        io::ErrorKind::InvalidData => ReadError::new(path, Problem::Compressed(e)).byte(start),
        _ => ReadError::io(path, e),
    });
    match opened? {
        (declared, _) if declared < expected => Err(truncated(declared)),
        (declared, _) if declared > expected => {
            let what = format!("an array has {declared} bytes, where its extent asks for {expected}");
            Err(ReadError::header(path, what).byte(start))
        }
        (_, bytes) => {
            let bytes = if choice.are_bits {
                Box::new(Bits::new(bytes))
            } else {
                bytes
            };
            let source = Source::Binary(bytes, header.words.order);
            Ok(Scalars::new(path.to_owned(), choice.stored, count, source))
        }
    }
}

fn too_few(path: &Path, count: usize) -> ReadError {
    ReadError::header(path, format!("its text has less than {count} numbers"))
}

/// Where an array's data begins in a file of so many bytes, and how many there are for it.
fn span(path: &Path, header: &Header, content: &Content, length: u64) -> Result<(u64, u64), ReadError> {
    match (content, header.appended) {
        (Content::Ascii(range) | Content::Inline(range), _) => Ok((range.start, range.end - range.start)),
        (Content::Appended(offset), Some(appended)) => {
            let start = appended.start.saturating_add(*offset);
            Ok((start, length.saturating_sub(start)))
        }
        (Content::Appended(_), None) => Err(ReadError::header(path, "it has no AppendedData")),
    }
}

/// How many bytes an array declares, and them.
fn decoded(header: &Header, mut bytes: Box<dyn Read + Send>) -> io::Result<(u64, Box<dyn Read + Send>)> {
    Ok(match header.compressor {
        None => {
            let [declared] = header.words.read(&mut bytes)?;
            (declared, bytes)
        }
        Some(compressor) => {
            let blocks = Blocks::new(bytes, header.words, compressor)?;
            (blocks.declared(), Box::new(blocks))
        }
    })
}
