//! A mesh cut into runs of triangles, each with the vertices it needs, as the device reads them.

use glam::DVec3;

use crate::gpu::{Attribute, Format, StepRate, VertexInput};
use crate::math::Aabb;
use crate::surface::{Mesh, unit_normal};

/// Most vertices, and most triangles, of a piece: 2²¹ vertices are 56 MiB, and any device allocates 1 GiB at once.
const LIMIT: usize = 1 << 21;

/// A vertex in a buffer.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct MeshVertex {
    /// World, millimetres.
    pub position: [f32; 3],
    /// World, of length 1, or zero.
    pub normal: [f32; 3],
    /// Not premultiplied; white if the mesh has no colours.
    pub color: [u8; 4],
}

const fn attribute(location: u32, format: Format, offset: usize) -> Attribute {
    Attribute {
        location,
        format,
        offset: offset as u32,
    }
}

/// What the vertex shader reads.
pub const VERTEX_INPUT: VertexInput<'static> = VertexInput {
    stride: size_of::<MeshVertex>() as u32,
    rate: StepRate::Vertex,
    attributes: &[
        attribute(0, Format::R32G32B32_SFLOAT, std::mem::offset_of!(MeshVertex, position)),
        attribute(1, Format::R32G32B32_SFLOAT, std::mem::offset_of!(MeshVertex, normal)),
        attribute(2, Format::R8G8B8A8_UNORM, std::mem::offset_of!(MeshVertex, color)),
    ],
};

/// A run of triangles and their vertices.
#[derive(Default)]
pub struct Piece {
    /// The vertices in the order of their first use.
    pub vertices: Vec<MeshVertex>,
    /// Three of them each.
    pub triangles: Vec<[u32; 3]>,
}

impl Piece {
    /// The box of its vertices.
    pub fn bounds(&self) -> Aabb {
        Aabb::of_points(
            self.vertices
                .iter()
                .map(|v| DVec3::from_array(v.position.map(f64::from))),
        )
    }
}

/// Hands the pieces of `mesh`, whose triangles name vertices that exist, to `take`.
pub fn pieces<E>(mesh: &Mesh, take: impl FnMut(&Piece) -> Result<(), E>) -> Result<(), E> {
    pieces_of(mesh, LIMIT, take)
}

fn pieces_of<E>(mesh: &Mesh, limit: usize, mut take: impl FnMut(&Piece) -> Result<(), E>) -> Result<(), E> {
    let mut piece = Piece::default();
    // Each vertex's place in the piece, if `place < piece.vertices.len()` and the vertex there is it.
    let mut places = vec![0u32; mesh.positions.len()];
    let mut members: Vec<u32> = Vec::new();
    for corners in &mesh.triangles {
        if !is_somewhere(mesh, corners) {
            continue;
        }
        if members.len() + 3 > limit || piece.triangles.len() + 1 > limit {
            take(&piece)?;
            piece = Piece::default();
            members.clear();
        }
        let triangle = corners.map(|v| {
            let place = places[v as usize];
            if members.get(place as usize) == Some(&v) {
                return place;
            }
            let place = members.len() as u32;
            places[v as usize] = place;
            members.push(v);
            piece.vertices.push(vertex(mesh, v as usize));
            place
        });
        piece.triangles.push(triangle);
    }
    if piece.triangles.is_empty() {
        Ok(())
    } else {
        take(&piece)
    }
}

fn is_somewhere(mesh: &Mesh, corners: &[u32; 3]) -> bool {
    let mut coordinates = corners.iter().flat_map(|&v| mesh.positions[v as usize]);
    coordinates.all(f32::is_finite)
}

fn vertex(mesh: &Mesh, v: usize) -> MeshVertex {
    let normal = mesh.normals.get(v).map_or(DVec3::ZERO, |n| unit_normal(*n));
    MeshVertex {
        position: mesh.positions[v],
        normal: normal.as_vec3().to_array(),
        color: mesh.colors.get(v).copied().unwrap_or([u8::MAX; 4]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    /// A strip of `count` triangles, of which number 3 is nowhere.
    fn strip(count: u32) -> Mesh {
        let position = |n: u32| [n as f32, (n % 2) as f32, if n == 3 { f32::NAN } else { 0.0 }];
        Mesh {
            positions: (0..count + 2).map(position).collect(),
            triangles: (0..count).map(|n| [n, n + 1, n + 2]).collect(),
            ..Mesh::default()
        }
    }

    #[test]
    fn pieces_have_all_triangles_that_are_somewhere() {
        let mesh = strip(20);
        for limit in [3, 4, 7, 100] {
            let mut found = Vec::new();
            let taken = pieces_of(&mesh, limit, |piece| -> Result<(), Infallible> {
                assert!(piece.vertices.len() <= limit && piece.triangles.len() <= limit);
                let positions = |t: &[u32; 3]| t.map(|v| piece.vertices[v as usize].position);
                found.extend(piece.triangles.iter().map(positions));
                Ok(())
            });
            taken.expect("nothing fails");
            let somewhere = (0..20).filter(|n| !(1..=3).contains(n));
            let expected: Vec<_> = somewhere.map(|n| mesh.corners(n)).collect();
            assert_eq!(found, expected, "in pieces of {limit}");
        }
    }
}
