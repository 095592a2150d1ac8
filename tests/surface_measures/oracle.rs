//! VTK's measures, from a process of its own.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde::Deserialize;
use serde_json::json;
use vcsg::surface::Mesh;

const PYTHON: &str = "target/deps/vtk/bin/python";

/// What VTK says of a mesh.
#[derive(Debug, Deserialize)]
pub struct Figures {
    pub area: f64,
    pub volume: f64,
    /// The number of triangles of each region.
    pub regions: Vec<usize>,
    /// The checksum ([`checksum`]) of the region with the most triangles.
    pub largest: u32,
    pub boundary: usize,
    pub non_manifold: usize,
}

pub struct Oracle {
    child: Child,
    requests: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl Oracle {
    /// Starts VTK.
    pub fn start() -> Self {
        assert!(Path::new(PYTHON).exists(), "{PYTHON} is missing: run make setup");
        let mut child = Command::new(PYTHON)
            .arg("tests/oracle/measures.py")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the oracle starts");
        let requests = child.stdin.take();
        let answers = BufReader::new(child.stdout.take().expect("a pipe"));
        Self {
            child,
            requests,
            answers,
        }
    }

    pub fn measure(&mut self, mesh: &Mesh) -> Figures {
        let request = json!({"points": mesh.positions.len(), "triangles": mesh.triangles.len()});
        let out = self.requests.as_mut().expect("the oracle runs");
        writeln!(out, "{request}")
            .and_then(|()| out.write_all(bytemuck::cast_slice(&mesh.positions)))
            .and_then(|()| out.write_all(bytemuck::cast_slice(&mesh.triangles)))
            .and_then(|()| out.flush())
            .expect("the oracle listens");
        let mut line = String::new();
        self.answers.read_line(&mut line).expect("the oracle answers");
        serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: {line:?}; see the oracle's message above"))
    }
}

/// The CRC-32 of the corners' coordinates, triangle after triangle.
pub fn checksum(mesh: &Mesh) -> u32 {
    let mut sum = flate2::Crc::new();
    for n in 0..mesh.triangles.len() {
        sum.update(bytemuck::cast_slice(&mesh.corners(n)));
    }
    sum.sum()
}

impl Drop for Oracle {
    fn drop(&mut self) {
        // Without requests the process ends by itself.
        drop(self.requests.take());
        let _ = self.child.wait();
    }
}
