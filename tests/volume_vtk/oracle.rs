//! VTK as a writer and reader of images, in a process of its own.

#[path = "../oracle/process.rs"]
mod process;

use std::io::{BufRead, Read};
use std::path::Path;

use process::Process;
use serde_json::{Value, json};

pub struct Oracle(Process);

/// What VTK reads of a file.
pub struct Seen {
    /// Where the first point, or the first cell's centre, is.
    pub first: [f64; 3],
    /// How many values there are.
    pub count: usize,
    /// The rest of the answer.
    pub answer: Value,
}

impl Oracle {
    /// Starts VTK.
    pub fn start() -> Self {
        Self(Process::start("tests/oracle/write_vtk.py"))
    }

    /// Has VTK write what `request` says, of `bytes`, and read it.
    pub fn write(&mut self, request: &Value, bytes: &[u8]) -> Seen {
        self.0.send(request, &[bytes]);
        self.seen()
    }

    /// What VTK reads of the file at `path`: where, and which values.
    pub fn read(&mut self, path: &Path, of: &str) -> (Seen, Vec<f64>) {
        self.0.send(&json!({"path": path, "of": of}), &[]);
        let seen = self.seen();
        let mut values = vec![0.0; seen.count];
        let bytes = bytemuck::cast_slice_mut(&mut values);
        self.0
            .answers
            .read_exact(bytes)
            .expect("the oracle answers; see its message above");
        (seen, values)
    }

    fn seen(&mut self) -> Seen {
        let mut line = String::new();
        self.0.answers.read_line(&mut line).expect("the oracle answers");
        let answer: Value = serde_json::from_str(&line).expect("the oracle answers; see its message above");
        Seen {
            first: serde_json::from_value(answer["first"].clone()).expect("three numbers"),
            count: serde_json::from_value(answer["count"].clone()).expect("a number"),
            answer,
        }
    }
}
