//! tifffile, in a process of its own.

#[path = "../oracle/process.rs"]
mod process;

use std::io::{BufRead, Read};
use std::path::Path;

use process::Process;
use serde_json::{Value, json};

pub struct Oracle(Process);

impl Oracle {
    /// Starts tifffile.
    pub fn start() -> Self {
        Self(Process::start("tests/oracle/write_tiff.py"))
    }

    /// Has it write `values` of type `kind` in this shape; what it reads.
    pub fn write(&mut self, path: &Path, kind: &str, shape: &[usize], options: &Value) -> Vec<f64> {
        let bytes = values(kind, shape.iter().product());
        let request = json!({"path": path, "type": kind, "shape": shape, "bytes": bytes.len(), "options": options});
        self.0.send(&request, &[&bytes]);
        self.answer()
    }

    /// What it reads of the file at `path`.
    pub fn read(&mut self, path: &Path) -> Vec<f64> {
        self.0.send(&json!({"path": path}), &[]);
        self.answer()
    }

    fn answer(&mut self) -> Vec<f64> {
        let mut line = String::new();
        self.0.answers.read_line(&mut line).expect("the oracle answers");
        let answer: Value = serde_json::from_str(&line).expect("the oracle answers; see its message above");
        let shape: Vec<usize> = serde_json::from_value(answer["shape"].clone()).expect("sizes");
        let mut values = vec![0.0; shape.iter().product()];
        let bytes = bytemuck::cast_slice_mut(&mut values);
        self.0.answers.read_exact(bytes).expect("the oracle answers");
        values
    }
}

/// Bytes of the type, no NaN, that change from value to value.
fn values(kind: &str, count: usize) -> Vec<u8> {
    let number = |i: usize| (i * 2_654_435_761) % 200_003;
    let mut bytes = Vec::new();
    for i in 0..count {
        let v = number(i);
        match kind {
            "u8" | "i8" => bytes.push(v as u8),
            "u16" | "i16" => bytes.extend((v as u16).to_le_bytes()),
            // Half floats from 1 to 2.
            "f16" => bytes.extend((0x3c00 | v as u16 & 0x3ff).to_le_bytes()),
            "u32" | "i32" => bytes.extend((v as u32).wrapping_mul(65_521).to_le_bytes()),
            "f32" => bytes.extend((v as f32 / 7.0).to_le_bytes()),
            "f64" => bytes.extend((v as f64 / 7.0).to_le_bytes()),
            _ => bytes.extend((v as u64).to_le_bytes()),
        }
    }
    bytes
}
