//! A Python script of this folder, in a process of its own, that answers one request after another.

use std::io::{BufReader, BufWriter, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde_json::Value;

const PYTHON: &str = "target/deps/vtk/bin/python";

/// The process. It ends when it is dropped.
pub struct Process {
    child: Child,
    /// `None` once it has been told to end.
    requests: Option<BufWriter<ChildStdin>>,
    /// What it answers.
    pub answers: BufReader<ChildStdout>,
}

impl Process {
    /// Starts `script`.
    pub fn start(script: &str) -> Self {
        assert!(Path::new(PYTHON).exists(), "{PYTHON} is missing: run make setup");
        let mut child = Command::new(PYTHON)
            .arg(script)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the oracle starts");
        let requests = child.stdin.take().map(BufWriter::new);
        let answers = BufReader::new(child.stdout.take().expect("a pipe"));
        Self {
            child,
            requests,
            answers,
        }
    }

    /// Sends a line of JSON, and `data` after it.
    pub fn send(&mut self, request: &Value, data: &[&[u8]]) {
        let out = self.requests.as_mut().expect("the oracle runs");
        writeln!(out, "{request}")
            .and_then(|()| data.iter().try_for_each(|part| out.write_all(part)))
            .and_then(|()| out.flush())
            .expect("the oracle listens; see its message above");
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // Without requests the process ends by itself.
        drop(self.requests.take());
        let _ = self.child.wait();
    }
}
