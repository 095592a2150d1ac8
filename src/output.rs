//! Writing a file whole or not at all: beside its place first, then renamed into it.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

/// An output that could not be written. Nothing of it is left behind, and what was there before is as it was.
#[derive(Debug, Error)]
#[error("cannot write {}: {source}", path.display())]
pub struct OutputError {
    /// The file that was asked for.
    pub path: PathBuf,
    /// What the system said.
    pub source: io::Error,
}

/// A file being written beside its place; it disappears unless it is renamed into it.
struct Part {
    path: PathBuf,
}

impl Drop for Part {
    fn drop(&mut self) {
        // After the rename there is nothing to remove, and on the way out of an error no second one can be reported.
        let _ = fs::remove_file(&self.path);
    }
}

/// Writes `path` with `write`, whole or not at all. A device or a pipe, which cannot be replaced, is written in place.
///
/// # Errors
/// [`OutputError`] if the folder is missing or read-only, the disk is full, `path` is a folder, or `write` fails.
pub fn write_whole(path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> Result<(), OutputError> {
    // A link stays a link: what it points to is replaced.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let written = match fs::metadata(&target) {
        Ok(place) if place.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        Ok(place) if !place.is_file() => write_in_place(&target, write),
        _ => write_beside(&target, write),
    };
    written.map_err(|source| OutputError {
        path: path.to_owned(),
        source,
    })
}

fn write_in_place(target: &Path, write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::new(OpenOptions::new().write(true).open(target)?);
    write(&mut out)?;
    out.flush()
}

fn write_beside(target: &Path, write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> io::Result<()> {
    let path = part_path(target)?;
    let file = OpenOptions::new().write(true).create_new(true).open(&path)?;
    let part = Part { path };
    let mut out = BufWriter::new(file);
    write(&mut out)?;
    out.into_inner()?.sync_data()?;
    fs::rename(&part.path, target)
}

/// A hidden name in the same folder, and so on the same file system, that no other writer uses.
fn part_path(target: &Path) -> io::Result<PathBuf> {
    use std::sync::atomic::{AtomicU32, Ordering};
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let name = target.file_name().ok_or(io::ErrorKind::InvalidFilename)?;
    let serial = NEXT.fetch_add(1, Ordering::Relaxed);
    let process = std::process::id();
    let part = format!(".{}.{process}-{serial}.part", name.to_string_lossy());
    Ok(target.with_file_name(part))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("a folder");
        let mut names: Vec<_> = entries
            .map(|e| e.expect("an entry").file_name().display().to_string())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_whole_file_replaces_the_old_one() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.bin");
        fs::write(&path, "old and longer").expect("a first file");
        write_whole(&path, |out| out.write_all(b"new")).expect("written");
        assert_eq!(fs::read(&path).expect("read"), b"new");
        assert_eq!(names(folder.path()), ["a.bin"]);
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.bin");
        fs::write(&path, "old").expect("a first file");
        let error = write_whole(&path, |out| {
            out.write_all(b"half")?;
            Err(io::ErrorKind::StorageFull.into())
        });
        assert!(error.is_err());
        assert_eq!(fs::read(&path).expect("read"), b"old");
        assert_eq!(names(folder.path()), ["a.bin"]);
    }

    #[test]
    fn a_missing_folder_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("none/a.bin");
        let error = write_whole(&path, |_| Ok(())).expect_err("no folder");
        assert!(error.to_string().contains("none/a.bin"), "{error}");
    }

    #[test]
    fn a_folder_is_not_replaced() {
        let folder = tempfile::tempdir().expect("a folder");
        assert!(write_whole(folder.path(), |_| Ok(())).is_err());
        assert!(folder.path().is_dir());
    }

    #[cfg(unix)]
    #[test]
    fn a_link_still_points_where_it_did() {
        let folder = tempfile::tempdir().expect("a folder");
        let (path, link) = (folder.path().join("a"), folder.path().join("b"));
        fs::write(&path, "old").expect("a first file");
        std::os::unix::fs::symlink(&path, &link).expect("a link");
        write_whole(&link, |out| out.write_all(b"new")).expect("written");
        assert!(fs::symlink_metadata(&link).expect("the link").is_symlink());
        assert_eq!(fs::read(&path).expect("read"), b"new");
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_written_in_place() {
        write_whole(Path::new("/dev/null"), |out| out.write_all(b"gone")).expect("written");
        let device = fs::metadata("/dev/null").expect("still there");
        assert!(!device.is_file());
    }
}
