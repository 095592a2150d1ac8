//! Soft normals of a block's voxels. A voxel beyond the lattice has the normal of the nearest one in it.

use glam::{Mat3, Vec3};
use rayon::prelude::*;

use super::simd::packed;
use crate::array::Array;
use crate::projection::{EMPTY_BELOW, Slopes, SoftNormals};
use crate::target::{Block, BlockVoxels, Target};

/// The normals of the stored voxels of a block, which was reconstructed with [`Block::REACH`] voxels of apron; `scales` make
/// value times coverage and coverage a fraction of the value range.
pub fn voxel_normals(
    soft: &SoftNormals,
    target: &Target,
    block: &Block,
    voxels: &BlockVoxels,
    scales: [f32; 2],
) -> Array<u32> {
    let (matrix, heights) = (soft.matrix().as_mat3(), heights(voxels, scales));
    let dims = block.stored_dims();
    let skip = voxels.apron - Block::APRON;
    // The reconstructed voxel with the normal of the nth stored one of an axis.
    let nearest = |axis: usize, n: usize| {
        let beyond = block.origin[axis] + n;
        let inside = beyond.clamp(Block::APRON, target.lattice.dims[axis] - 1 + Block::APRON);
        inside - block.origin[axis] + skip
    };
    let mut normals = Array::<u32>::zeroed(dims.iter().product());
    let [first, last] = [nearest(0, 0), nearest(0, dims[0] - 1)];
    let scratch = || (Slopes::default(), vec![Vec3::ZERO; last + 1 - first]);
    let rows = normals.par_chunks_mut(dims[0]).enumerate();
    rows.for_each_init(scratch, |(slopes, found), (row, normals)| {
        let [j, k] = [nearest(1, row % dims[1]), nearest(2, row / dims[1])];
        let begin = first + voxels.dims[0] * (j + voxels.dims[1] * k);
        slopes.of_row(&heights, voxels.dims, begin, found);
        for (i, stored) in normals.iter_mut().enumerate() {
            *stored = normal(&matrix, found[nearest(0, i) - first]);
        }
    });
    normals
}

/// The soft normal of a slope.
fn normal(matrix: &Mat3, slope: Vec3) -> u32 {
    let g = *matrix * slope;
    packed((g / (1.0 + g.length_squared()).sqrt()).to_array())
}

/// What normals are made of: see [`SoftNormals`].
fn heights(voxels: &BlockVoxels, [scale, offset]: [f32; 2]) -> Vec<f32> {
    let offset = offset + EMPTY_BELOW;
    let values = voxels.premultiplied.iter();
    match &voxels.coverage {
        None => values.map(|v| scale * v + offset).collect(),
        Some(coverage) => {
            let pairs = values.zip(coverage.iter());
            pairs.map(|(v, c)| scale * v + offset * c).collect()
        }
    }
}
