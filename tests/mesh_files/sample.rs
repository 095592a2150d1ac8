//! A mesh with everything that a mesh can hold.

use std::f64::consts::TAU;
use std::ops::Range;

use glam::DVec3;
use vcsg::surface::{Mesh, Part};

/// A lumpy torus away from the origin, closed, wound counterclockwise seen from outside.
pub struct Torus {
    /// Vertices round the ring and round the tube.
    pub around: [u32; 2],
}

/// A torus of 5120 triangles with normals, values, all colour codes, and parts labelled 1 and 7.
pub fn torus() -> Mesh {
    Torus { around: [64, 40] }.mesh()
}

/// The same with nothing that is optional, in one part.
pub fn bare() -> Mesh {
    let torus = torus();
    Mesh {
        parts: parts(&[(3, torus.triangles.len())]),
        positions: torus.positions,
        triangles: torus.triangles,
        ..Mesh::default()
    }
}

/// Parts with these labels and numbers of triangles.
pub fn parts(labels: &[(u32, usize)]) -> Vec<Part> {
    let mut start = 0;
    let next = |(label, count): &(u32, usize)| {
        let first = start;
        start += count;
        part(*label, None, first..start)
    };
    labels.iter().map(next).collect()
}

fn part(label: u32, iso: Option<f64>, triangles: Range<usize>) -> Part {
    Part { label, iso, triangles }
}

impl Torus {
    pub fn mesh(&self) -> Mesh {
        let [ring, tube] = self.around;
        let places: Vec<_> = (0..tube).flat_map(|j| (0..ring).map(move |i| [i, j])).collect();
        let each = || places.iter().copied();
        let triangles: Vec<_> = each().flat_map(|place| self.triangles(place)).collect();
        let (first, all) = (triangles.len() / 3, triangles.len());
        Mesh {
            positions: each().map(|p| self.position(p).as_vec3().to_array()).collect(),
            normals: each().map(|p| self.outwards(p).as_vec3().to_array()).collect(),
            values: each().map(|p| self.position(p).length().sin() as f32).collect(),
            colors: (0..each().len()).map(color).collect(),
            triangles: triangles.into(),
            parts: vec![part(1, Some(80.5), 0..first), part(7, None, first..all)],
        }
    }

    fn angles(&self, place: [u32; 2]) -> [f64; 2] {
        [0, 1].map(|n| f64::from(place[n]) * TAU / f64::from(self.around[n]))
    }

    /// The unit vector from the tube's middle to a vertex.
    fn outwards(&self, place: [u32; 2]) -> DVec3 {
        let [ring, tube] = self.angles(place);
        DVec3::new(ring.cos() * tube.cos(), ring.sin() * tube.cos(), tube.sin())
    }

    /// Millimetres, LPS.
    fn position(&self, place: [u32; 2]) -> DVec3 {
        let [ring, tube] = self.angles(place);
        let middle = DVec3::new(-31.7, 112.9, 1540.3) + 40.0 * DVec3::new(ring.cos(), ring.sin(), 0.0);
        let radius = 12.0 + (5.0 * ring).sin() + 0.5 * (3.0 * tube).cos();
        middle + radius * self.outwards(place)
    }

    /// The two triangles between a vertex and the next ones.
    fn triangles(&self, [i, j]: [u32; 2]) -> [[u32; 3]; 2] {
        let [ring, tube] = self.around;
        let vertex = |i: u32, j: u32| i % ring + j % tube * ring;
        let (a, b, c, d) = (vertex(i, j), vertex(i + 1, j), vertex(i, j + 1), vertex(i + 1, j + 1));
        [[a, b, d], [a, d, c]]
    }
}

/// Over 256 vertices every code of every channel.
fn color(vertex: usize) -> [u8; 4] {
    [1, 3, 5, 7].map(|step| (vertex * step) as u8)
}
