//! The files of an image: itself, or those that a parallel file (.pvti) names.
//!
//! *Practice.* A parallel file says where points lie and which files hold the pieces; each of those has a header, a byte order and a
//! compression of its own. They may overlap, as with ghost levels. One that is a parallel file again is refused, so none can name
//! itself.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::xml_header::{Header, Piece};
use crate::volume::io::error::ReadError;

/// A file with pieces of the image.
pub(super) struct PieceFile {
    pub path: PathBuf,
    pub header: Header,
}

impl PieceFile {
    /// The files of the image whose file at `path` has this header.
    pub(super) fn all(path: &Path, header: Header) -> Result<Vec<Arc<Self>>, ReadError> {
        if header.sources.is_empty() {
            let path = path.to_owned();
            return Ok(vec![Arc::new(Self { path, header })]);
        }
        let mut known = BTreeSet::new();
        let files = header.sources.iter().map(|source| match known.insert(source) {
            true => Self::named(path, source).map(Arc::new),
            false => Err(ReadError::header(path, format!("it names the piece `{source}` twice"))),
        });
        files.collect()
    }

    /// The one that the parallel file at `path` calls `source`: a name beside it.
    fn named(path: &Path, source: &str) -> Result<Self, ReadError> {
        let path = path.with_file_name(source);
        let header = Header::read(&path)?;
        match header.sources.is_empty() {
            true => Ok(Self { path, header }),
            false => Err(ReadError::header(&path, "a piece of a parallel file is one itself")),
        }
    }
}

/// All pieces of `files`, each with its file.
pub(super) fn pieces(files: &[Arc<PieceFile>]) -> impl Iterator<Item = (&Arc<PieceFile>, &Piece)> {
    files
        .iter()
        .flat_map(|file| file.header.pieces.iter().map(move |piece| (file, piece)))
}
