//! Small arrays and images, written by hand.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use tempfile::TempDir;
use vcsg::volume::io::{self, Opened, ReadError, ReadOptions};

/// A folder with files in it that goes away.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Writes a file, its folders too.
    pub fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, bytes).unwrap();
        path
    }

    pub fn json(&self, name: &str, value: &Value) {
        self.file(name, value.to_string().as_bytes());
    }

    /// An array of version 3 and of bytes, a chunk of which is an element of the first axis; element `n` is `n`.
    pub fn array(&self, name: &str, shape: &[usize]) {
        let mut chunk = shape.to_vec();
        chunk[0] = 1;
        self.json(&format!("{name}/zarr.json"), &version_3(shape, &chunk));
        let count: usize = chunk.iter().product();
        for n in 0..shape[0] {
            let bytes: Vec<u8> = (n * count..(n + 1) * count).map(|n| n as u8).collect();
            let rest = "/0".repeat(shape.len() - 1);
            self.file(&format!("{name}/c/{n}{rest}"), &bytes);
        }
    }

    pub fn open(&self, options: &ReadOptions) -> Result<Opened, ReadError> {
        io::open(self.path(), options)
    }
}

/// The metadata of an array of bytes.
pub fn version_3(shape: &[usize], chunk: &[usize]) -> Value {
    json!({
        "zarr_format": 3, "node_type": "array", "shape": shape, "data_type": "uint8", "fill_value": 9,
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": chunk}},
        "chunk_key_encoding": {"name": "default"}, "codecs": ["bytes"],
    })
}

/// The same of version 2.
pub fn version_2(shape: &[usize], chunk: &[usize]) -> Value {
    json!({
        "zarr_format": 2, "shape": shape, "chunks": chunk, "dtype": "|u1", "compressor": null, "fill_value": 9, "order": "C",
        "filters": null,
    })
}
