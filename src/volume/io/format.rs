//! The formats that are read and written, in one table: the command line, `vcsg info` and docs/FORMATS.md tell of it, and reading goes by it.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::error::ReadError;
use super::open::{Opened, ReadOptions};
use super::write::Writer;
use super::{dicom, metaimage, nifti, nrrd, raw, slices, tiff, volpack, vtk, zarr};

/// A format of volume files.
pub struct Format {
    /// Its name.
    pub name: &'static str,
    /// How its files' names end, in lower case.
    pub suffixes: &'static [&'static str],
    /// What of it is read, in a line.
    pub reads: &'static str,
    /// Whether a file or folder is of it.
    pub(super) recognises: fn(&Probe) -> bool,
    /// Opens all volumes of a file that the options allow.
    pub(super) open: fn(&Path, &ReadOptions) -> Result<Vec<Opened>, ReadError>,
    /// How it is written; `None` where it is not.
    pub writer: Option<Writer>,
}

/// All formats; the first that recognises a file reads it. (DICOM before TIFF: what comes before a DICOM file's data may be a TIFF header.)
pub const FORMATS: [&Format; 11] = [
    &nrrd::FORMAT,
    &nifti::FORMAT,
    &metaimage::FORMAT,
    &dicom::FORMAT,
    &vtk::XML,
    &vtk::LEGACY,
    &tiff::FORMAT,
    &zarr::FORMAT,
    &slices::FORMAT,
    &volpack::FORMAT,
    &raw::FORMAT,
];

/// What tells a file's format.
pub(super) struct Probe {
    /// The file or folder.
    pub path: PathBuf,
    /// Its name in lower case.
    pub name: String,
    /// Its first bytes, [`Probe::BYTES`] at most; of a folder none.
    pub start: Vec<u8>,
    /// Whether it is a folder.
    pub is_folder: bool,
    /// Whether the caller says what raw voxels are.
    pub has_layout: bool,
}

impl Probe {
    /// How many of a file's first bytes are looked at.
    const BYTES: u64 = 512;

    fn new(path: &Path, options: &ReadOptions) -> Result<Self, ReadError> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let is_folder = path.is_dir();
        let mut start = Vec::new();
        if !is_folder {
            let file = File::open(path).map_err(|e| ReadError::io(path, e))?;
            (file.take(Self::BYTES).read_to_end(&mut start)).map_err(|e| ReadError::io(path, e))?;
        }
        Ok(Self {
            path: path.to_owned(),
            name: name.to_ascii_lowercase(),
            start,
            is_folder,
            has_layout: options.raw.is_some(),
        })
    }

    /// Whether its name ends like one of the format's files.
    pub(super) fn is_named(&self, format: &Format) -> bool {
        format.suffixes.iter().any(|suffix| self.name.ends_with(suffix))
    }
}

/// Opens all volumes of the file or folder at `path` that `options` allow: of a folder of several DICOM series, for one, each.
///
/// # Errors
/// Whatever [`ReadError`] can say: what is wrong, where, and what the user can do.
pub fn open_all(path: &Path, options: &ReadOptions) -> Result<Vec<Opened>, ReadError> {
    let probe = Probe::new(path, options)?;
    match FORMATS.iter().find(|format| (format.recognises)(&probe)) {
        Some(format) => {
            let volumes = (format.open)(path, options)?;
            Ok(volumes.into_iter().map(|v| v.within(options.budget)).collect())
        }
        None => Err(unknown(&probe)),
    }
}

/// Opens the one volume that `options` name of the file or folder at `path`.
///
/// # Errors
/// As [`open_all`], and if there are several.
pub fn open(path: &Path, options: &ReadOptions) -> Result<Opened, ReadError> {
    let mut volumes = open_all(path, options)?;
    match (volumes.pop(), &volumes[..]) {
        (Some(only), []) => Ok(only),
        (None, _) => Err(ReadError::unsupported(path, "it holds no volume")),
        (Some(last), others) => {
            let names: Vec<_> = others
                .iter()
                .chain([&last])
                .map(|v| format!("`{}`", v.declared().name))
                .collect();
            let what = format!("it holds {} volumes: {}", names.len(), names.join(", "));
            Err(ReadError::unsupported(path, what).hint("say which, with --series"))
        }
    }
}

/// The error for a file of no format.
fn unknown(probe: &Probe) -> ReadError {
    let what = match probe.is_folder {
        true => "it is no folder of slices that is known",
        false => "it is no volume file that is known",
    };
    let names: Vec<_> = FORMATS.iter().map(|format| format.name).collect();
    ReadError::unsupported(&probe.path, what).hint(format!("what is read: {}", names.join(", ")))
}
