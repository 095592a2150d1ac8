//! Reconstructed blocks in memory: what a CPU projector reads, and what a GPU page is filled from.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::{Block, Layout, OctreeNode, RowEvaluator, Target};
use crate::volume::Sample;

/// The voxels of one block and of an apron round it, x fastest. Beyond the lattice its outermost voxels go on.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockVoxels {
    /// Voxels along each axis, apron included.
    pub dims: [usize; 3],
    /// Apron voxels on each side.
    pub apron: usize,
    /// Value times coverage.
    pub premultiplied: Vec<f32>,
    /// Coverage; `None` where it is 1 throughout.
    pub coverage: Option<Vec<f32>>,
}

impl BlockVoxels {
    /// Reconstructs `block` with `apron` voxels on each side, its planes in parallel.
    pub fn reconstruct(target: &Target, block: &Block, apron: usize) -> Self {
        let dims = block.extent.map(|n| n + 2 * apron);
        let plane = dims[0] * dims[1];
        let mut premultiplied = vec![0.0; plane * dims[2]];
        let mut coverage = vec![
            0.0;
            if block.layout == Layout::Mixed {
                plane * dims[2]
            } else {
                0
            }
        ];
        // An absent coverage still needs a slice for each plane.
        let coverage_plane = if coverage.is_empty() { 0 } else { plane };
        let planes = premultiplied.par_chunks_mut(plane).enumerate();
        if coverage_plane == 0 {
            planes.for_each(|(k, values)| fill_plane(target, block, apron, k, values, None));
        } else {
            planes
                .zip(coverage.par_chunks_mut(coverage_plane))
                .for_each(|((k, values), coverage)| {
                    fill_plane(target, block, apron, k, values, Some(coverage));
                });
        }
        Self {
            dims,
            apron,
            premultiplied,
            coverage: (coverage_plane > 0).then_some(coverage),
        }
    }

    /// The sample stored at voxel `at` of the lattice, which lies in the block or its apron.
    fn premultiplied_at(&self, origin: [usize; 3], at: [usize; 3]) -> (f32, f32) {
        let [i, j, k]: [usize; 3] = std::array::from_fn(|a| at[a] + self.apron - origin[a]);
        let n = i + self.dims[0] * (j + self.dims[1] * k);
        (self.premultiplied[n], self.coverage.as_ref().map_or(1.0, |c| c[n]))
    }
}

fn fill_plane(
    target: &Target,
    block: &Block,
    apron: usize,
    k: usize,
    values: &mut [f32],
    mut coverage: Option<&mut [f32]>,
) {
    let dims = target.lattice.dims;
    let width = block.extent[0] + 2 * apron;
    let clamped = |axis: usize, n: usize| (block.origin[axis] + n).saturating_sub(apron).min(dims[axis] - 1);
    let columns = clamped(0, 0)..clamped(0, width - 1) + 1;
    // Stored columns before the first and after the last one evaluated repeat it.
    let before = (apron).saturating_sub(block.origin[0]);
    let inside = before..before + columns.len();
    let mut rows = RowEvaluator::new(&target.tree);
    for (j, out) in values.chunks_exact_mut(width).enumerate() {
        let mut coverage = coverage.as_mut().map(|c| &mut c[j * width..(j + 1) * width]);
        rows.evaluate(
            target.path(block),
            columns.clone(),
            [clamped(1, j), clamped(2, k)],
            &mut out[inside.clone()],
            coverage.as_mut().map(|c| &mut c[inside.clone()]),
        );
        repeat_ends(out, &inside);
        if let Some(coverage) = coverage {
            repeat_ends(coverage, &inside);
        }
    }
}

/// Repeats the first and last number of `inside` on both sides of it.
fn repeat_ends(row: &mut [f32], inside: &Range<usize>) {
    let (first, last) = (row[inside.start], row[inside.end - 1]);
    row[..inside.start].fill(first);
    row[inside.end..].fill(last);
}

/// A target with all its blocks reconstructed in memory.
#[derive(Clone, Debug)]
pub struct VoxelTarget<'a> {
    /// The subdivision.
    pub target: &'a Target,
    /// The voxels of each block of [`Target::blocks`].
    pub voxels: Vec<BlockVoxels>,
    /// All voxels of a small lattice once more, x fastest, where none needs the octree to be found; empty for a large one.
    dense: Vec<(f32, f32)>,
}

/// The most voxels of a lattice that is small: 32 MiB.
const SMALL: usize = 1 << 22;

impl<'a> VoxelTarget<'a> {
    /// Reconstructs every block, without aprons.
    pub fn new(target: &'a Target) -> Self {
        let voxels = target
            .blocks
            .par_iter()
            .map(|block| BlockVoxels::reconstruct(target, block, 0))
            .collect();
        let mut whole = Self {
            target,
            voxels,
            dense: Vec::new(),
        };
        if target.lattice.len() <= SMALL {
            whole.dense = whole.all_voxels();
        }
        whole
    }

    fn all_voxels(&self) -> Vec<(f32, f32)> {
        let [nx, ny, _] = self.target.lattice.dims;
        (0..self.target.lattice.len())
            .into_par_iter()
            .map(|n| self.find([n % nx, n / nx % ny, n / (nx * ny)]))
            .collect()
    }

    /// Value times coverage, and coverage, of voxel `at`; beyond the lattice its outermost voxels go on.
    pub fn voxel(&self, at: [i64; 3]) -> (f32, f32) {
        let dims = self.target.lattice.dims;
        let at: [usize; 3] = std::array::from_fn(|a| at[a].clamp(0, dims[a] as i64 - 1) as usize);
        match self.dense.get(at[0] + dims[0] * (at[1] + dims[1] * at[2])) {
            Some(&voxel) => voxel,
            None => self.find(at),
        }
    }

    /// The voxel `at` of the lattice in its block.
    fn find(&self, at: [usize; 3]) -> (f32, f32) {
        match self.target.block_at(at) {
            Some(b) => self.voxels[b].premultiplied_at(self.target.blocks[b].origin, at),
            None => (0.0, 0.0),
        }
    }

    /// The eight voxels round lattice point `p`, bit `a` of the index being the higher one on axis `a`, and the fractions
    /// of the way from the lower ones to the higher.
    pub fn cell(&self, p: DVec3) -> ([(f32, f32); 8], DVec3) {
        let base = p.floor();
        let at = base.as_i64vec3().to_array();
        let corner = |n: usize| self.voxel(std::array::from_fn(|a| at[a] + (n >> a & 1) as i64));
        (std::array::from_fn(corner), p - base)
    }

    /// The voxel `at` as a sample.
    pub fn sample(&self, at: [i64; 3]) -> Sample {
        let (premultiplied, coverage) = self.voxel(at);
        if coverage > 0.0 {
            Sample {
                value: premultiplied / coverage,
                coverage,
            }
        } else {
            Sample::EMPTY
        }
    }
}

impl Target {
    /// The index of the block that holds voxel `at` of the lattice; `None` where nothing is.
    pub fn block_at(&self, at: [usize; 3]) -> Option<usize> {
        let mut cube = self.octree.root;
        let mut node = self.octree.nodes[0];
        loop {
            match node {
                OctreeNode::Empty => return None,
                OctreeNode::Block(b) => return Some(b as usize),
                OctreeNode::Split(first) => {
                    let half = cube.size / 2;
                    let octant = (0..3).fold(0, |o, a| o | usize::from(at[a] >= cube.origin[a] + half) << a);
                    cube = cube.octant(octant);
                    node = self.octree.nodes[first as usize + octant];
                }
            }
        }
    }
}
