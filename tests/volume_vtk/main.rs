//! VTK's images: what VTK writes is read bit for bit, in every variant it writes; hand-made files mean what the format says; bad
//! files are refused.

mod damage;
mod hand_made;
mod hand_made_samples;
mod oracle;
mod real;
mod written;

use std::fs;
use std::path::PathBuf;

use tempfile::TempDir;
use vcsg::volume::Voxels;
use vcsg::volume::io::{self, ReadError, ReadOptions, Volume};

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

/// A file of this folder with these bytes.
fn file(folder: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    path
}

/// Reads a file of this name and these bytes.
fn read(name: &str, bytes: &[u8], options: &ReadOptions) -> Result<Volume, ReadError> {
    let folder = folder();
    io::read_with(&file(&folder, name, bytes), options)
}

fn named(array: &str) -> ReadOptions {
    ReadOptions {
        array: Some(array.to_owned()),
        ..ReadOptions::default()
    }
}

fn f64s(voxels: &Voxels) -> Vec<f64> {
    (0..voxels.len()).map(|i| voxels.get(i)).collect()
}
