//! The DICOM files of a folder and the folders in it.

use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::source::is_dicom;
use crate::volume::io::error::ReadError;

/// How deep folders are gone into: exports have patient, study, series.
const MAX_DEPTH: usize = 12;

/// How many files are looked at.
const MAX_FILES: usize = 1 << 20;

/// How many files are looked at to find the first DICOM file.
const MAX_PROBED: usize = 1 << 12;

/// Whether there is a DICOM file in the folder at `path`.
pub(super) fn holds_dicom(path: &Path) -> bool {
    listing(path, MAX_PROBED).is_ok_and(|files| files.iter().any(|file| starts_as_dicom(file)))
}

/// The DICOM files, in the order of their paths. What lists them, DICOMDIR, is none.
pub(super) fn files(path: &Path) -> Result<Vec<PathBuf>, ReadError> {
    let mut files = listing(path, MAX_FILES)?;
    if files.len() >= MAX_FILES {
        let what = format!("it holds more than {MAX_FILES} files");
        return Err(ReadError::unsupported(path, what).hint("choose a folder further in"));
    }
    files.sort();
    Ok(files.into_par_iter().filter(|file| starts_as_dicom(file)).collect())
}

/// Up to `most` files below `path`. Links to folders are not followed, so that there is an end to them.
fn listing(path: &Path, most: usize) -> Result<Vec<PathBuf>, ReadError> {
    let mut files = Vec::new();
    let mut folders = vec![(path.to_owned(), 0)];
    while let Some((folder, depth)) = folders.pop() {
        let entries = match fs::read_dir(&folder) {
            Err(e) if depth == 0 => return Err(ReadError::io(path, e)),
            Err(_) => continue,
            Ok(entries) => entries,
        };
        for entry in entries.flatten() {
            let Ok(kind) = entry.file_type() else { continue };
            if kind.is_dir() && depth < MAX_DEPTH {
                folders.push((entry.path(), depth + 1));
            } else if !kind.is_dir() && !entry.file_name().eq_ignore_ascii_case("DICOMDIR") {
                files.push(entry.path());
            }
            if files.len() >= most {
                return Ok(files);
            }
        }
    }
    Ok(files)
}

fn starts_as_dicom(file: &Path) -> bool {
    let mut start = Vec::new();
    // A pipe among the files would be waited for.
    let read = match fs::metadata(file) {
        Ok(kind) if kind.is_file() => File::open(file).and_then(|f| f.take(132).read_to_end(&mut start)),
        _ => return false,
    };
    read.is_ok() && is_dicom(&start)
}
