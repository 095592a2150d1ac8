//! VTK's measures, from a process of its own.

#[path = "../oracle/process.rs"]
mod process;

use process::Process;
use serde::Deserialize;
use serde_json::json;
use vcsg::surface::Mesh;

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

pub struct Oracle(Process);

impl Oracle {
    /// Starts VTK.
    pub fn start() -> Self {
        Self(Process::start("tests/oracle/measures.py"))
    }

    pub fn measure(&mut self, mesh: &Mesh) -> Figures {
        let request = json!({"points": mesh.positions.len(), "triangles": mesh.triangles.len()});
        let data = [
            bytemuck::cast_slice(&mesh.positions),
            bytemuck::cast_slice(&mesh.triangles),
        ];
        self.0.send(&request, &data);
        let mut answer = serde_json::Deserializer::from_reader(&mut self.0.answers);
        Figures::deserialize(&mut answer).expect("the oracle answers; see its message above")
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
