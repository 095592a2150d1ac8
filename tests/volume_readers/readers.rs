//! SimpleITK and VTK as readers of volume files.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde::Deserialize;

const PYTHON: &str = "target/deps/vtk/bin/python";
const SCRIPT: &str = "tests/oracle/read_volume.py";

/// What a reader says that a file holds.
#[derive(Debug, Deserialize)]
pub struct Read {
    pub size: Vec<usize>,
    pub spacing: Vec<f64>,
    pub origin: Vec<f64>,
    pub direction: Vec<f64>,
    pub voxel: String,
    pub components: usize,
    pub checksum: u32,
    pub min: f64,
    pub max: f64,
    pub mean: f64,
}

/// What the readers, `itk` or `vtk`, say that the files hold: one process for all, as starting it takes longest.
pub fn read(requests: &[(&str, PathBuf)]) -> Vec<Read> {
    assert!(Path::new(PYTHON).exists(), "{PYTHON} is missing: run make setup");
    let mut command = Command::new(PYTHON);
    command.arg(SCRIPT);
    for (reader, path) in requests {
        command.arg(reader).arg(path);
    }
    let output = command.output().expect("a Python that starts");
    let messages = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "{SCRIPT}: {}, {messages}\nIf a module is missing, run make setup",
        output.status
    );
    let found: Vec<Read> = serde_json::Deserializer::from_slice(&output.stdout)
        .into_iter()
        .map(|read| read.expect("a line a file"))
        .collect();
    assert_eq!(found.len(), requests.len(), "a line a file");
    found
}
