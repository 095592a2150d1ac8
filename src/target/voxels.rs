//! Reconstructed blocks in memory: what a CPU projector reads, and what a GPU page is filled from.
//!
//! *Practice.* A block is made in small parts, and before each its stretch of the volumes is read once in the order of memory.
//! Rows that run aslant would else wait for one cache line after the other.

use std::array::from_fn;
use std::mem::take;
use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::update::Earlier;
use super::{Block, Cube, Layout, OctreeNode, RowEvaluator, Target};
use crate::array::{Array, Part};
use crate::math::Aabb;
use crate::volume::Sample;

/// Voxels along x, y, z of the parts that blocks are reconstructed in: what a part needs of a volume stays in a processor's
/// cache.
const PART: [usize; 3] = [32, 16, 8];

/// The voxels of one block and of an apron round it, x fastest. Beyond the lattice its outermost voxels go on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BlockVoxels {
    /// Voxels along each axis, apron included.
    pub dims: [usize; 3],
    /// Apron voxels on each side.
    pub apron: usize,
    /// Value times coverage.
    pub premultiplied: Part<f32>,
    /// Coverage; `None` where it is 1 throughout.
    pub coverage: Option<Part<f32>>,
    /// In a target of colours, whose values are opacities: red, green and blue times opacity and coverage, of one voxel after the
    /// other.
    rgb: Option<Part<f32>>,
}

impl BlockVoxels {
    /// Reconstructs `block` with `apron` voxels on each side, slabs of it in parallel.
    pub fn reconstruct(target: &Target, block: &Block, apron: usize) -> Self {
        let filler = Filler {
            target,
            block,
            apron,
            earlier: None,
        };
        filler.alone()
    }

    /// Reconstructs `block` without an apron, with what still holds of earlier voxels copied.
    pub(super) fn reconstruct_after(target: &Target, block: &Block, earlier: &Earlier) -> Self {
        let filler = Filler {
            target,
            block,
            apron: 0,
            earlier: Some(earlier),
        };
        filler.alone()
    }

    /// Reconstructs all blocks without aprons, in parallel, in memory that they share.
    fn reconstruct_all(target: &Target) -> Vec<Self> {
        let filler = |block| Filler {
            target,
            block,
            apron: 0,
            earlier: None,
        };
        let fillers: Vec<_> = target.blocks.iter().map(filler).collect();
        let mut numbers = Array::zeroed(fillers.iter().map(Filler::len).sum());
        let mut rest = &mut numbers[..];
        let pieces: Vec<_> = fillers
            .iter()
            .map(|filler| {
                let (piece, after) = take(&mut rest).split_at_mut(filler.len());
                rest = after;
                (filler, piece)
            })
            .collect();
        pieces.into_par_iter().for_each(|(filler, piece)| filler.fill(piece));
        let numbers = Arc::new(numbers);
        let starts = fillers.iter().scan(0, |end, filler| {
            let start = *end;
            *end += filler.len();
            Some(start)
        });
        fillers
            .iter()
            .zip(starts)
            .map(|(filler, start)| filler.voxels(&numbers, start))
            .collect()
    }

    /// In a target of colours, whose values are opacities: red, green and blue times opacity and coverage.
    pub fn rgb(&self) -> Option<&[[f32; 3]]> {
        self.rgb.as_ref().map(|rgb| rgb.as_chunks().0)
    }

    /// The place of voxel `at` of the lattice, which lies in the block or its apron.
    pub(super) fn index(&self, origin: [usize; 3], at: [usize; 3]) -> usize {
        let [i, j, k]: [usize; 3] = from_fn(|a| at[a] + self.apron - origin[a]);
        i + self.dims[0] * (j + self.dims[1] * k)
    }

    /// The sample stored at voxel `at` of the lattice, which lies in the block or its apron.
    fn premultiplied_at(&self, origin: [usize; 3], at: [usize; 3]) -> (f32, f32) {
        let n = self.index(origin, at);
        (self.premultiplied[n], self.coverage.as_ref().map_or(1.0, |c| c[n]))
    }
}

/// Some of a block's voxels, one after another.
pub(super) struct Slab<'a> {
    pub premultiplied: &'a mut [f32],
    pub coverage: Option<&'a mut [f32]>,
    pub rgb: Option<&'a mut [[f32; 3]]>,
}

/// Fills the stored voxels of a block, those of its apron included.
struct Filler<'a> {
    target: &'a Target,
    block: &'a Block,
    apron: usize,
    earlier: Option<&'a Earlier<'a>>,
}

impl Filler<'_> {
    fn dims(&self) -> [usize; 3] {
        self.block.extent.map(|n| n + 2 * self.apron)
    }

    /// Numbers that its voxels take: of values, after them of coverages, and of colours, where there are any.
    fn lens(&self) -> [usize; 3] {
        let voxels = self.dims().iter().product();
        let mixed = usize::from(self.block.layout == Layout::Mixed);
        let colored = usize::from(self.target.tree.has_colors());
        [voxels, mixed * voxels, 3 * colored * voxels]
    }

    fn len(&self) -> usize {
        self.lens().iter().sum()
    }

    /// The block's voxels, whose numbers begin at `start`.
    fn voxels(&self, numbers: &Arc<Array<f32>>, start: usize) -> BlockVoxels {
        let [values, coverages, colors] = self.lens();
        let part = |start: usize, len: usize| (len > 0).then(|| Part::new(numbers, start..start + len));
        BlockVoxels {
            dims: self.dims(),
            apron: self.apron,
            premultiplied: Part::new(numbers, start..start + values),
            coverage: part(start + values, coverages),
            rgb: part(start + values + coverages, colors),
        }
    }

    /// The block's voxels in memory of their own.
    fn alone(&self) -> BlockVoxels {
        let mut numbers = vec![0.0; self.len()];
        self.fill(&mut numbers);
        self.voxels(&Arc::new(numbers.into()), 0)
    }

    /// Fills the block's numbers, slabs of it in parallel.
    fn fill(&self, numbers: &mut [f32]) {
        let [width, height, _] = self.dims();
        let len = width * height * PART[2];
        let [values, coverages, _] = self.lens();
        let (values, rest) = numbers.split_at_mut(values);
        let (coverages, colors) = rest.split_at_mut(coverages);
        let mut coverages = coverages.chunks_mut(len);
        let mut colors = colors.as_chunks_mut().0.chunks_mut(len);
        let slabs: Vec<Slab> = values
            .chunks_mut(len)
            .map(|premultiplied| Slab {
                premultiplied,
                coverage: coverages.next(),
                rgb: colors.next(),
            })
            .collect();
        slabs
            .into_par_iter()
            .enumerate()
            .for_each(|(n, slab)| self.fill_slab(n * PART[2], slab));
    }

    /// Fills the slab of planes from `plane` on, part by part.
    fn fill_slab(&self, plane: usize, mut slab: Slab) {
        let [width, height, _] = self.dims();
        let planes = plane..plane + slab.premultiplied.len() / (width * height);
        // Stored columns before the first and after the last one evaluated repeat it.
        let before = self.apron.saturating_sub(self.block.origin[0]);
        let inside = before..before + self.lattice(0, width - 1) + 1 - self.lattice(0, 0);
        let mut evaluator = RowEvaluator::new(self.target);
        for rows in parts(0..height, PART[1]) {
            for columns in parts(inside.clone(), PART[0]) {
                let part = [columns, rows.clone(), planes.clone()];
                self.fill_part(&mut evaluator, part, &mut slab);
            }
        }
        repeat_ends(slab.premultiplied, width, &inside);
        if let Some(coverage) = slab.coverage {
            repeat_ends(coverage, width, &inside);
        }
        if let Some(rgb) = slab.rgb {
            repeat_ends(rgb, width, &inside);
        }
    }

    /// Fills some columns of some rows of a slab of planes.
    fn fill_part(&self, evaluator: &mut RowEvaluator, part: [Range<usize>; 3], slab: &mut Slab) {
        let path = self.target.path(self.block);
        let end = |axis: usize| self.lattice(axis, part[axis].end - 1);
        let start: [usize; 3] = from_fn(|axis| self.lattice(axis, part[axis].start));
        let box_of =
            |corners: [[usize; 3]; 2]| Aabb::of_points(corners.map(|c| DVec3::from_array(c.map(|n| n as f64))));
        let last: [usize; 3] = from_fn(end);
        let earlier = self.earlier.and_then(|earlier| earlier.rows(start, last));
        if earlier.is_none() {
            evaluator.fetch(path, &box_of([start, last]));
        }
        let [columns, rows, planes] = part;
        let [width, height, _] = self.dims();
        for k in planes.clone() {
            for j in rows.clone() {
                let row = ((k - planes.start) * height + j) * width;
                let out = row + columns.start..row + columns.end;
                let i = start[0]..start[0] + columns.len();
                let jk = [self.lattice(1, j), self.lattice(2, k)];
                let row = Slab {
                    premultiplied: &mut slab.premultiplied[out.clone()],
                    coverage: slab.coverage.as_mut().map(|c| &mut c[out.clone()]),
                    rgb: slab.rgb.as_mut().map(|rgb| &mut rgb[out]),
                };
                match &earlier {
                    Some(rows) => rows.copy(i, jk, row),
                    None => {
                        evaluator.evaluate(path, i, jk, row.premultiplied, row.coverage);
                        if let Some(rgb) = row.rgb {
                            evaluator.premultiplied_rgb(rgb);
                        }
                    }
                }
            }
        }
    }

    /// The voxel of the lattice that the `n`th stored one along an axis shows.
    fn lattice(&self, axis: usize, n: usize) -> usize {
        let last = self.target.lattice.dims[axis] - 1;
        (self.block.origin[axis] + n).saturating_sub(self.apron).min(last)
    }
}

/// A range in parts of at most `size`.
fn parts(all: Range<usize>, size: usize) -> impl Iterator<Item = Range<usize>> {
    let end = all.end;
    all.step_by(size).map(move |start| start..end.min(start + size))
}

/// Repeats the first and last number of `inside` on both sides of it, in each row.
fn repeat_ends<T: Copy>(rows: &mut [T], width: usize, inside: &Range<usize>) {
    if inside.len() == width {
        return;
    }
    for row in rows.chunks_exact_mut(width) {
        let (first, last) = (row[inside.start], row[inside.end - 1]);
        row[..inside.start].fill(first);
        row[inside.end..].fill(last);
    }
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
        Self::with(target, BlockVoxels::reconstruct_all(target))
    }

    /// The target with `voxels` for its blocks, which have no aprons.
    pub fn with(target: &'a Target, voxels: Vec<BlockVoxels>) -> Self {
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
        let at: [usize; 3] = from_fn(|a| at[a].clamp(0, dims[a] as i64 - 1) as usize);
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

    /// Red, green and blue times opacity and coverage of voxel `at` of a target of colours, else black; beyond the lattice its
    /// outermost voxels go on.
    pub fn rgb(&self, at: [i64; 3]) -> [f32; 3] {
        let dims = self.target.lattice.dims;
        let at: [usize; 3] = from_fn(|a| at[a].clamp(0, dims[a] as i64 - 1) as usize);
        let Some(b) = self.target.block_at(at) else {
            return [0.0; 3];
        };
        let voxels = &self.voxels[b];
        let n = voxels.index(self.target.blocks[b].origin, at);
        voxels.rgb().map_or([0.0; 3], |rgb| rgb[n])
    }

    /// The eight voxels round lattice point `p`, bit `a` of the index being the higher one on axis `a`, and the fractions
    /// of the way from the lower ones to the higher.
    pub fn cell(&self, p: DVec3) -> ([(f32, f32); 8], DVec3) {
        let base = p.floor();
        let at = base.as_i64vec3().to_array();
        let corner = |n: usize| self.voxel(from_fn(|a| at[a] + (n >> a & 1) as i64));
        (from_fn(corner), p - base)
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
        match self.leaf_at(at).1 {
            OctreeNode::Block(index) => Some(index as usize),
            _ => None,
        }
    }

    /// The leaf of the octree that holds voxel `at` of the lattice, and its cube.
    pub(super) fn leaf_at(&self, at: [usize; 3]) -> (Cube, OctreeNode) {
        let at = at.map(|n| n as i64);
        let mut cube = self.octree.root;
        let mut node = self.octree.nodes[0];
        while let OctreeNode::Split(first) = node {
            let octant = cube.octant_with(at);
            cube = cube.octant(octant);
            node = self.octree.nodes[first as usize + octant];
        }
        (cube, node)
    }
}
