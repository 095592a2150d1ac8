//! Reading a scene file and parsing its KDL, within bounds.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use kdl::KdlDocument;

use super::error::{Problem, SceneError};
use super::guard::{self, MAX_BYTES};
use super::source::Source;

/// The text at `path`.
///
/// # Errors
/// If the file cannot be read, is longer than [`MAX_BYTES`], or is not UTF-8.
pub(super) fn read(path: &Path) -> Result<String, Problem> {
    let mut bytes = Vec::new();
    let limit = MAX_BYTES as u64 + 1;
    File::open(path)
        .and_then(|file| regular(file)?.take(limit).read_to_end(&mut bytes))
        .map_err(|e| unreadable(path, &e))?;
    if bytes.len() > MAX_BYTES {
        return Err(Problem::TooLong { limit: MAX_BYTES });
    }
    String::from_utf8(bytes).map_err(|e| Problem::Unreadable {
        path: path.to_owned(),
        reason: format!("byte {} is not UTF-8 text", e.utf8_error().valid_up_to()),
    })
}

/// A pipe would block and a device would never end.
fn regular(file: File) -> io::Result<File> {
    if file.metadata()?.is_file() {
        Ok(file)
    } else {
        Err(io::Error::other("not a regular file"))
    }
}

pub(super) fn unreadable(path: &Path, error: &io::Error) -> Problem {
    Problem::Unreadable {
        path: path.to_owned(),
        reason: error.to_string(),
    }
}

/// The nodes of a source.
///
/// # Errors
/// If the text is too long, nests too deeply, or is not KDL 2.
pub(super) fn parse(source: &Source) -> Result<KdlDocument, SceneError> {
    guard::check(source.text())
        .map_err(|(at, problem)| SceneError::at(source, (at..at + 1).into(), problem))?;
    KdlDocument::parse_v2(source.text()).map_err(|error| syntax_error(source, &error))
}

fn syntax_error(source: &Source, error: &kdl::KdlError) -> SceneError {
    let first = error.diagnostics.iter().min_by_key(|d| d.span.offset());
    let message = first
        .and_then(|d| d.message.clone())
        .unwrap_or_else(|| "this is not KDL".into());
    let help = first.and_then(|d| d.help.clone());
    let span = first.map_or((0..0).into(), |d| d.span);
    SceneError::at(source, span, Problem::Syntax { message, help })
}
