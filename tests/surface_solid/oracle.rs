//! vtkClipClosedSurface, in a process of its own.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use glam::DVec3;
use serde_json::json;
use vcsg::surface::Mesh;

const PYTHON: &str = "target/deps/vtk/bin/python";

/// The areas of what VTK leaves of a closed mesh, and of its cap, where it is cut by a plane whose normal points away.
pub fn clipped_areas(mesh: &Mesh, through: DVec3, normal: DVec3) -> [f64; 2] {
    assert!(Path::new(PYTHON).exists(), "{PYTHON} is missing: run make setup");
    let mut child = Command::new(PYTHON)
        .arg("tests/oracle/clip_closed.py")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the oracle starts");
    let request = json!({
        "points": mesh.positions.len(),
        "triangles": mesh.triangles.len(),
        "through": through.to_array(),
        "normal": (-normal).to_array(),
    });
    let mut stdin = child.stdin.take().expect("a pipe");
    writeln!(stdin, "{request}")
        .and_then(|()| stdin.write_all(bytemuck::cast_slice(&mesh.positions)))
        .and_then(|()| stdin.write_all(bytemuck::cast_slice(&mesh.triangles)))
        .expect("the oracle listens");
    drop(stdin);
    let output = child.wait_with_output().expect("the oracle ends");
    serde_json::from_slice(&output.stdout).expect("the oracle answers; see its message above")
}
