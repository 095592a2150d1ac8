//! From voxels to a mesh (LC87 §4).

use glam::DAffine3;
use thiserror::Error;

use super::assemble::Assembly;
use super::inside::{Classifier, Ties};
use super::mesh::Mesh;
use super::slices::Slices;
use super::vertices::Level;
use crate::volume::{Grid, Voxel, Voxels, for_type};

/// Why a surface could not be extracted.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ExtractError {
    /// The isovalue is NaN or infinite.
    #[error("the isovalue {iso} is not a finite number")]
    NoIsovalue {
        /// What was asked for.
        iso: f64,
    },
    /// More vertices or triangles than 32 bits count.
    #[error("the surface has more than {} {what}: reduce the volume, or cut it", u32::MAX)]
    TooLarge {
        /// Vertices or triangles.
        what: &'static str,
    },
}

/// How the surface runs through cells whose corners leave it open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Topology {
    /// As vtkMarchingCubes has it: inside corners on a diagonal of a face are parted. Vertices that fall together are merged,
    /// and triangles that lose a corner by it left out.
    #[default]
    Vtk,
    /// As the trilinear interpolant has it. The mesh is always a manifold, closed away from the lattice's border.
    Trilinear,
}

/// The surface where the values of `grid` are `iso`: the triangles of vtkMarchingCubes. It is empty where `iso` is beyond the
/// values, or the grid has an axis of one voxel.
///
/// # Errors
/// Those of [`extract`].
pub fn marching_cubes(grid: &Grid, iso: f64) -> Result<Mesh, ExtractError> {
    extract(grid, iso, Topology::Vtk)
}

/// The surface where the values of `grid` are `iso`.
///
/// A voxel is inside where its value is not below `iso`, and NaN is outside; an edge with an end that is NaN has its vertex at
/// NaN. Where `world_from_index` is a reflection, triangles are turned over, so that they always face lower values.
///
/// # Errors
/// If `iso` is not finite, or the mesh has more vertices or triangles than `u32` counts.
pub fn extract(grid: &Grid, iso: f64, topology: Topology) -> Result<Mesh, ExtractError> {
    for_type!(Voxels, grid.voxels(), voxels => extract_typed(
        voxels, grid.dims(), grid.world_from_index(), iso, topology
    ))
}

fn extract_typed<T: Voxel>(
    voxels: &[T],
    dims: [usize; 3],
    world_from_index: &DAffine3,
    iso: f64,
    topology: Topology,
) -> Result<Mesh, ExtractError> {
    let level = Level::new(iso, *world_from_index)?;
    let slices = Slices {
        voxels,
        first_slice: 0,
        dims,
    };
    let ties = match topology {
        Topology::Vtk => Ties::OneVertex,
        Topology::Trilinear => Ties::Apart,
    };
    let mut assembly = Assembly::new(level, dims, topology);
    if dims.iter().any(|n| *n < 2) {
        return Ok(assembly.finish());
    }
    assembly.add(&Classifier::new(slices, iso, ties), 0..dims[2])?;
    Ok(assembly.finish())
}
