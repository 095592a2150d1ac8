//! Writing a volume in the format that its suffix names, whole or not at all: beside its place first, then renamed into it. Of two
//! files the voxels come first, so that there is never a header without them.

use std::borrow::Cow;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};
use thiserror::Error;

use super::format::{FORMATS, Format};
use crate::volume::grid::{Grid, Voxels};
use crate::volume::voxel::for_type;

/// How the voxels are stored, where the format and its suffix leave that open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// As they are in memory.
    Raw,
    /// Compressed by deflate, in gzip or zlib as the format has it.
    Gzip,
}

/// How volumes are written in a format.
pub struct Writer {
    /// How the names of the files end, in lower case.
    pub suffixes: &'static [&'static str],
    /// What is written, in a line.
    pub writes: &'static str,
    /// The files of a volume, those with voxels first.
    pub(super) files: for<'a> fn(&Work<'a>) -> Result<Vec<Output<'a>>, String>,
}

/// What is to be written where.
pub(super) struct Work<'a> {
    pub path: &'a Path,
    pub grid: &'a Grid,
    pub encoding: Encoding,
}

/// One file of a volume.
pub(super) struct Output<'a> {
    /// Its place.
    pub path: PathBuf,
    /// What it holds.
    pub contents: Vec<Contents<'a>>,
}

/// A part of a file.
pub(super) enum Contents<'a> {
    /// Bytes that were made for it.
    Made(Vec<u8>),
    /// Bytes that are there.
    There(&'a [u8]),
    /// Bytes that become one gzip stream.
    Gzip(Vec<Cow<'a, [u8]>>),
}

/// A volume that could not be written. Nothing of it is left behind.
#[derive(Debug, Error)]
pub enum WriteError {
    /// The operating system refused.
    #[error("{}: cannot be written: {source} (check the folder, its permissions and the space left)", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// No format that is written has this suffix.
    #[error("{}: no format that is written has this suffix (those that have are {})", path.display(), suffixes())]
    Suffix {
        /// The file.
        path: PathBuf,
    },
    /// The format cannot hold the volume.
    #[error("{}: {what}", path.display())]
    Unfit {
        /// The file.
        path: PathBuf,
        /// Why not, and what helps.
        what: String,
    },
}

/// All suffixes that are written.
fn suffixes() -> String {
    let writers = FORMATS.iter().filter_map(|format| format.writer.as_ref());
    let suffixes: Vec<_> = writers.flat_map(|writer| writer.suffixes).copied().collect();
    suffixes.join(" ")
}

/// The format in which a file of this name is written.
///
/// # Errors
/// [`WriteError::Suffix`] where there is none.
pub fn writer_of(path: &Path) -> Result<(&'static Format, &'static Writer), WriteError> {
    let name = path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase();
    let writers = FORMATS
        .iter()
        .filter_map(|format| Some((*format, format.writer.as_ref()?)));
    let mut named = writers.filter(|(_, writer)| writer.suffixes.iter().any(|suffix| name.ends_with(suffix)));
    named.next().ok_or_else(|| WriteError::Suffix { path: path.to_owned() })
}

/// Writes `grid` to `path`, in the format that its suffix names.
///
/// # Errors
/// [`WriteError`]: a suffix of no format, a volume that the format cannot hold, or what the operating system says.
pub fn write(path: &Path, grid: &Grid, encoding: Encoding) -> Result<(), WriteError> {
    VolumeBeside::write(path, grid, encoding)?.put()
}

/// A volume whose files are complete beside the places that they are for; they disappear unless they are put there.
#[derive(Debug)]
pub struct VolumeBeside {
    files: Vec<Beside>,
}

impl VolumeBeside {
    /// Writes `grid` beside `path`.
    ///
    /// # Errors
    /// As [`write()`].
    pub fn write(path: &Path, grid: &Grid, encoding: Encoding) -> Result<Self, WriteError> {
        let (_, writer) = writer_of(path)?;
        Self::of(path, (writer.files)(&Work { path, grid, encoding }))
    }

    /// Writes what is for the volume at `path`.
    pub(super) fn of(path: &Path, outputs: Result<Vec<Output>, String>) -> Result<Self, WriteError> {
        let unfit = |what| WriteError::Unfit {
            path: path.to_owned(),
            what,
        };
        let files = outputs.map_err(unfit)?.into_iter().map(Beside::write);
        let files = files.collect::<Result<_, _>>()?;
        Ok(Self { files })
    }

    /// Puts it in its place.
    ///
    /// # Errors
    /// The operating system's, with the file's name.
    pub fn put(self) -> Result<(), WriteError> {
        self.files.iter().try_for_each(Beside::put)
    }
}

/// A file beside the one to write, removed when it goes out of use; after a rename it is no longer there.
#[derive(Debug)]
struct Beside {
    part: PathBuf,
    path: PathBuf,
}

impl Beside {
    fn write(output: Output) -> Result<Self, WriteError> {
        let mut name = output.path.file_name().unwrap_or_default().to_owned();
        name.push(format!(".{}.part", std::process::id()));
        let beside = Self {
            part: output.path.with_file_name(name),
            path: output.path,
        };
        let written = File::create(&beside.part).and_then(|file| fill(file, &output.contents));
        match written {
            Ok(()) => Ok(beside),
            Err(source) => Err(beside.error(source)),
        }
    }

    fn put(&self) -> Result<(), WriteError> {
        fs::rename(&self.part, &self.path).map_err(|source| self.error(source))
    }

    fn error(&self, source: io::Error) -> WriteError {
        let path = self.path.clone();
        WriteError::Io { path, source }
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        // It fails when there is none, which is what is wanted.
        let _ = fs::remove_file(&self.part);
    }
}

fn fill(file: File, contents: &[Contents]) -> io::Result<()> {
    let mut file = BufWriter::new(file);
    for part in contents {
        match part {
            Contents::Made(bytes) => file.write_all(bytes)?,
            Contents::There(bytes) => file.write_all(bytes)?,
            Contents::Gzip(parts) => {
                let mut gzip = GzEncoder::new(&mut file, Compression::fast());
                parts.iter().try_for_each(|bytes| gzip.write_all(bytes))?;
                gzip.finish()?;
            }
        }
    }
    file.into_inner()?.sync_all()
}

/// A grid's voxels, as they are in memory.
pub(super) fn voxel_bytes(grid: &Grid) -> &[u8] {
    for_type!(Voxels, grid.voxels(), v => bytemuck::cast_slice(v))
}

/// `bytes` as a zlib stream.
pub(super) fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut zlib = ZlibEncoder::new(Vec::new(), Compression::fast());
    zlib.write_all(bytes)
        .and_then(|()| zlib.finish())
        .expect("memory can be written")
}

/// The name of a file beside `path`, with `suffix` for its own: `head.mhd` and `.raw` make `head.raw`.
pub(super) fn beside(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(suffix);
    path.with_file_name(name)
}

/// A file's name, for a header that names the file beside it.
pub(super) fn name_of(path: &Path) -> Result<&str, String> {
    let name = path.file_name().and_then(|name| name.to_str());
    name.filter(|name| !name.contains(['\n', '\r']))
        .ok_or_else(|| "a header that names another file takes a name of readable characters".to_owned())
}
