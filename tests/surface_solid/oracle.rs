//! vtkClipClosedSurface, in a process of its own.

#[path = "../oracle/process.rs"]
mod process;

use glam::DVec3;
use process::Process;
use serde::Deserialize;
use serde_json::json;
use vcsg::surface::Mesh;

/// The areas of what VTK leaves of a closed mesh, and of its cap, where it is cut by a plane whose normal points away.
pub fn clipped_areas(mesh: &Mesh, through: DVec3, normal: DVec3) -> [f64; 2] {
    let request = json!({
        "points": mesh.positions.len(),
        "triangles": mesh.triangles.len(),
        "through": through.to_array(),
        "normal": (-normal).to_array(),
    });
    let data = [
        bytemuck::cast_slice(&mesh.positions),
        bytemuck::cast_slice(&mesh.triangles),
    ];
    let mut vtk = Process::start("tests/oracle/clip_closed.py");
    vtk.send(&request, &data);
    let mut answer = serde_json::Deserializer::from_reader(&mut vtk.answers);
    Deserialize::deserialize(&mut answer).expect("the oracle answers; see its message above")
}
