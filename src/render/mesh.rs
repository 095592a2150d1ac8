//! Meshes on a device.

use std::sync::Arc;

use super::mesh_pieces::{MeshVertex, Piece, pieces};
use crate::gpu::{Buffer, BufferCopy, BufferRole, Command, Device, GpuError, Recording};
use crate::math::Aabb;
use crate::surface::{Mesh, MeshLook};

/// Why a mesh cannot be brought to a device.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DeviceMeshError {
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} has vertex {vertex}, but the mesh has {vertices} vertices")]
    NoSuchVertex {
        /// The triangle.
        triangle: usize,
        /// Its vertex.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
    /// The device refused.
    #[error(transparent)]
    Device(#[from] GpuError),
}

/// A mesh on a device, in pieces of bounded size. Triangles with a vertex that is nowhere (NaN or infinite) are left out.
pub struct DeviceMesh {
    pub(super) pieces: Vec<DevicePiece>,
    bounds: Aabb,
}

/// Triangles that share a buffer of vertices.
pub(super) struct DevicePiece {
    pub vertices: Arc<Buffer>,
    pub indices: Arc<Buffer>,
    pub triangles: u32,
}

/// A mesh and how it looks.
#[derive(Clone, Copy)]
pub struct ShownMesh<'a> {
    /// The mesh.
    pub mesh: &'a DeviceMesh,
    /// How it looks.
    pub look: MeshLook,
}

impl DeviceMesh {
    /// Brings `mesh` to `device`.
    ///
    /// # Errors
    /// If a triangle's vertex does not exist, the device has not enough memory, or is lost.
    pub fn new(device: &Arc<Device>, mesh: &Mesh) -> Result<Self, DeviceMeshError> {
        require_vertices(mesh)?;
        let mut on_device = Self {
            pieces: Vec::new(),
            bounds: Aabb::EMPTY,
        };
        pieces(mesh, |piece| -> Result<(), GpuError> {
            on_device.bounds = on_device.bounds.hull(&piece.bounds());
            on_device.pieces.push(DevicePiece::new(device, piece)?);
            Ok(())
        })?;
        Ok(on_device)
    }

    /// The world box of what is drawn of it; empty if nothing is.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// How many triangles are drawn.
    pub fn triangles(&self) -> u64 {
        self.pieces.iter().map(|piece| u64::from(piece.triangles)).sum()
    }
}

/// The world box of all `meshes`.
pub(super) fn mesh_bounds(meshes: &[ShownMesh]) -> Aabb {
    meshes
        .iter()
        .fold(Aabb::EMPTY, |all, shown| all.hull(&shown.mesh.bounds()))
}

fn require_vertices(mesh: &Mesh) -> Result<(), DeviceMeshError> {
    let vertices = mesh.positions.len();
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices) {
            return Err(DeviceMeshError::NoSuchVertex {
                triangle,
                vertex,
                vertices,
            });
        }
    }
    Ok(())
}

impl DevicePiece {
    fn new(device: &Arc<Device>, piece: &Piece) -> Result<Self, GpuError> {
        Ok(Self {
            vertices: uploaded::<MeshVertex>(device, "mesh vertices", &piece.vertices)?,
            indices: uploaded::<[u32; 3]>(device, "mesh triangles", &piece.triangles)?,
            triangles: piece.triangles.len() as u32,
        })
    }
}

/// A buffer of the device's own that holds `data`.
fn uploaded<T: bytemuck::Pod>(device: &Arc<Device>, label: &str, data: &[T]) -> Result<Arc<Buffer>, GpuError> {
    let source = Buffer::with_data(device, label, data)?;
    let destination = Buffer::new(device, label, BufferRole::Device, source.bytes())?;
    let mut recording = Recording::new();
    recording.commands.push(Command::CopyBuffer(BufferCopy {
        bytes: source.bytes(),
        source,
        source_offset: 0,
        destination: Arc::clone(&destination),
        destination_offset: 0,
    }));
    device.submit(&recording)?.wait()?;
    Ok(destination)
}
