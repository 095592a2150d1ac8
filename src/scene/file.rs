//! Reading a scene file and parsing its KDL, within bounds.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use kdl::{KdlDiagnostic, KdlDocument};

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
    guard::check(source.text()).map_err(|(at, problem)| SceneError::at(source, (at..at + 1).into(), problem))?;
    KdlDocument::parse_v2(source.text()).map_err(|error| syntax_error(source, &error))
}

/// The parser's first complaint, in the user's terms.
///
/// Braces are known to balance here, so a complaint about one follows from another mistake. A span over several lines runs
/// from the start of an outer node to the mistake, so its end is the place.
fn syntax_error(source: &Source, error: &kdl::KdlError) -> SceneError {
    let of_brace = |d: &&KdlDiagnostic| d.message.as_ref().is_some_and(|m| m.contains('}'));
    let mut causes = error.diagnostics.iter().filter(|d| !of_brace(d));
    let Some(first) = causes.next().or(error.diagnostics.first()) else {
        return SceneError::at(source, (0..0).into(), not_kdl(String::new(), None));
    };
    let (start, end) = (first.span.offset(), first.span.offset() + first.span.len());
    let quoted = source.text().get(start..end).unwrap_or_default();
    let message = match first.message.as_deref() {
        Some("Expected end of document") | None => format!("`{quoted}` does not belong here"),
        Some(message) => message.to_owned(),
    };
    let help = match quoted {
        "true" | "false" | "null" => Some(format!("write #{quoted}, or \"{quoted}\" for a string")),
        _ => first.help.clone(),
    };
    let span = if quoted.contains('\n') { end..end } else { start..end };
    SceneError::at(source, span.into(), not_kdl(message, help))
}

fn not_kdl(message: String, help: Option<String>) -> Problem {
    Problem::Syntax { message, help }
}
