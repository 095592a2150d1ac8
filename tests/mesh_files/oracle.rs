//! VTK and trimesh as readers of what was written.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

const PYTHON: &str = "target/deps/vtk/bin/python";
const SCRIPT: &str = "tests/oracle/read_mesh.py";

/// What the readers, `vtk` or `trimesh`, say that the files hold: one process for all, as starting it takes longest.
pub fn read<const N: usize>(requests: [(&str, &PathBuf); N]) -> [Value; N] {
    assert!(Path::new(PYTHON).exists(), "{PYTHON} is missing: run make setup");
    let mut command = Command::new(PYTHON);
    command.arg(SCRIPT);
    requests.iter().for_each(|(reader, path)| {
        command.arg(reader).arg(path);
    });
    let output = command.output().expect("a Python that starts");
    let messages = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "{SCRIPT}: {}, {messages}\nIf a module is missing, run make setup",
        output.status
    );
    let mut found = serde_json::Deserializer::from_slice(&output.stdout).into_iter();
    requests.map(|_| found.next().expect("a line a file").expect("JSON"))
}

/// A float as the reader prints it.
pub fn bits(vectors: &[[f32; 3]]) -> Vec<[u32; 3]> {
    vectors.iter().map(|v| v.map(f32::to_bits)).collect()
}

/// The floats that the reader printed.
pub fn vectors(found: &Value) -> Vec<[f32; 3]> {
    let bits: Vec<[u32; 3]> = serde_json::from_value(found.clone()).expect("bits of vectors");
    bits.iter().map(|v| v.map(f32::from_bits)).collect()
}

/// Fails at the first entry in which what was read differs from what was written.
pub fn assert_same<T: serde::Serialize>(what: &str, found: &Value, written: &[T]) {
    let found = found
        .as_array()
        .unwrap_or_else(|| panic!("{what}: {found} instead of a list"));
    assert_eq!(found.len(), written.len(), "{what}");
    for (n, (found, written)) in found.iter().zip(written).enumerate() {
        assert_eq!(*found, serde_json::json!(written), "{what} {n}");
    }
}
