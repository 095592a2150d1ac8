//! Files of landmarks: pairs in a table of our own, and 3D Slicer's lists of points, of which two make pairs.
//!
//! Coordinates are LPS millimetres here; what a file says of its own axes and unit is heeded.

mod fcsv;
mod markups;
mod pairs;

use std::collections::{HashMap, HashSet};
use std::io::Write;
use std::path::Path;

use glam::DVec3;

pub use self::pairs::{read_pairs, write_pairs};
use super::landmarks::Landmark;
use crate::output::write_whole;

/// A named point, LPS millimetres.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedPoint {
    /// Its label.
    pub name: String,
    /// Its place.
    pub place: DVec3,
}

/// Why a file of landmarks cannot be read or written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LandmarkFileError {
    /// The file cannot be opened, read or written.
    #[error("{path}: {reason}")]
    File {
        /// Which.
        path: String,
        /// Why.
        reason: String,
    },
    /// A line means nothing.
    #[error("{path}:{line}: {reason}")]
    Line {
        /// Which file.
        path: String,
        /// From 1.
        line: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// Two lists that are not as long as each other.
    #[error("{before} points before and {after} after: landmarks are pairs")]
    Unpaired {
        /// Points before.
        before: usize,
        /// Points after.
        after: usize,
    },
}

/// What went wrong, before the file is named: the line, if it is one's, and why.
struct Wrong {
    line: Option<usize>,
    reason: String,
}

impl Wrong {
    fn at(line: usize, reason: impl Into<String>) -> Self {
        Self {
            line: Some(line),
            reason: reason.into(),
        }
    }

    fn whole(reason: impl Into<String>) -> Self {
        Self {
            line: None,
            reason: reason.into(),
        }
    }

    fn of(self, path: &Path) -> LandmarkFileError {
        let (path, reason) = (path.display().to_string(), self.reason);
        match self.line {
            Some(line) => LandmarkFileError::Line { path, line, reason },
            None => LandmarkFileError::File { path, reason },
        }
    }
}

/// The longest file that is read: 2000 landmarks take far less.
const MOST_BYTES: u64 = 16 << 20;

fn text(path: &Path) -> Result<String, LandmarkFileError> {
    let fails = |reason: String| Wrong::whole(reason).of(path);
    let length = std::fs::metadata(path).map_err(|e| fails(e.to_string()))?.len();
    if length > MOST_BYTES {
        return Err(fails(format!("longer than {} MiB", MOST_BYTES >> 20)));
    }
    std::fs::read_to_string(path).map_err(|e| fails(e.to_string()))
}

/// Whether 3D Slicer's older or newer format is meant.
fn is_markups(path: &Path) -> Option<bool> {
    match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "fcsv" => Some(false),
        "json" => Some(true),
        _ => None,
    }
}

fn unknown(path: &Path) -> LandmarkFileError {
    Wrong::whole("a list of points is a .fcsv or a .mrk.json file").of(path)
}

/// Reads a list of points: `.fcsv` or `.mrk.json`.
///
/// # Errors
/// If the file cannot be read or means nothing.
pub fn read_points(path: &Path) -> Result<Vec<NamedPoint>, LandmarkFileError> {
    let read = match is_markups(path).ok_or_else(|| unknown(path))? {
        true => markups::read,
        false => fcsv::read,
    };
    read(&text(path)?).map_err(|wrong| wrong.of(path))
}

/// Writes a list of points, in LPS: `.fcsv` or `.mrk.json`.
///
/// # Errors
/// If the file cannot be written.
pub fn write_points(path: &Path, points: &[NamedPoint]) -> Result<(), LandmarkFileError> {
    let written = match is_markups(path).ok_or_else(|| unknown(path))? {
        true => markups::written(points),
        false => fcsv::written(points),
    };
    write_text(path, &written)
}

fn write_text(path: &Path, text: &str) -> Result<(), LandmarkFileError> {
    write_whole(path, |out| out.write_all(text.as_bytes())).map_err(|e| Wrong::whole(e.to_string()).of(path))
}

/// The landmarks of two lists: those of one name if both lists have the same names, each once, else those of one place in
/// their lists.
///
/// # Errors
/// If the lists are not as long as each other.
pub fn paired(before: &[NamedPoint], after: &[NamedPoint]) -> Result<Vec<Landmark>, LandmarkFileError> {
    if before.len() != after.len() {
        let (before, after) = (before.len(), after.len());
        return Err(LandmarkFileError::Unpaired { before, after });
    }
    let named: HashMap<&str, &NamedPoint> = after.iter().map(|p| (p.name.as_str(), p)).collect();
    let names: HashSet<&str> = before.iter().map(|p| p.name.as_str()).collect();
    let by_name =
        named.len() == after.len() && names.len() == before.len() && names.iter().all(|n| named.contains_key(n));
    let pair = |(p, q): (&NamedPoint, &NamedPoint)| Landmark {
        name: p.name.clone(),
        from: p.place,
        to: if by_name { named[p.name.as_str()].place } else { q.place },
    };
    Ok(before.iter().zip(after).map(pair).collect())
}

/// LPS from RAS, or back.
fn turned(p: DVec3) -> DVec3 {
    DVec3::new(-p.x, -p.y, p.z)
}
