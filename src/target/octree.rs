//! Subdivision of the target into blocks, each with its optimal path (VCSG §3.1).
//!
//! *Theory.* A block that the boundary of a node's box crosses is split in eight, down to a smallest size; each part goes on
//! from its parent's path. A block that no boundary crosses has its optimal path and is not split further.
//! *Changes from the paper.* Blocks are also split where their coverage is not known to be one number, so that what a value
//! window leaves empty is skipped. Eight parts that turn out alike are one block again: neighbours with one path draw as one.
//! Blocks are no larger than a texture can be.
//! Cubes lie on the lattice's grid and not where the lattice begins, so that another lattice on the grid has the same ones.
//! *Practice.* The octants of large nodes are tested in parallel; the result does not depend on it.

use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::update::Before;
use super::{Block, Cube, Lattice, Layout, VoxelBox};
use crate::math::Interval;
use crate::model::{Boundary, Model, Pruned, Step, Tree};
use crate::volume::{Sample, SampleRange};

/// How the target is subdivided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Subdivision {
    /// Edge of the smallest blocks in voxels, a power of two.
    pub min_block: usize,
    /// Edge of the largest blocks in voxels, a power of two.
    pub max_block: usize,
    /// What happens at boundaries that cross a smallest block.
    pub boundary: Boundary,
    /// The most bytes that blocks may take as textures.
    pub budget_bytes: usize,
}

impl Default for Subdivision {
    fn default() -> Self {
        Self {
            min_block: 32,
            max_block: 512,
            boundary: Boundary::Exact,
            budget_bytes: 4 << 30,
        }
    }
}

/// A node of the target octree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OctreeNode {
    /// Nothing is there.
    Empty,
    /// The block of this index.
    Block(u32),
    /// Eight octants, from this node index on, in the order of [`Cube::octant`].
    Split(u32),
}

/// The target octree; node 0 is the root.
#[derive(Clone, Debug, PartialEq)]
pub struct Octree {
    /// The cube of the root, which holds the lattice, and is cut by it on any side.
    pub root: Cube,
    /// All nodes.
    pub nodes: Vec<OctreeNode>,
}

/// A subdivided model, ready to be reconstructed block by block.
#[derive(Clone, Debug)]
pub struct Target {
    /// Where voxels are.
    pub lattice: Lattice,
    /// The model, flattened in coordinates of the lattice's grid.
    pub tree: Tree,
    /// The subdivision.
    pub octree: Octree,
    /// The blocks that hold something, in octree order.
    pub blocks: Vec<Block>,
    /// The distinct paths.
    pub paths: Vec<Vec<Step>>,
    /// A range that holds every value; the same for every subdivision.
    pub value_range: Interval,
    /// How it was subdivided.
    pub subdivision: Subdivision,
}

/// Why a target cannot be built.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TargetError {
    /// The model has no lattice.
    #[error(transparent)]
    Lattice(#[from] super::LatticeError),
    /// The model cannot be flattened.
    #[error(transparent)]
    Tree(#[from] crate::model::TreeError),
    /// Too many blocks.
    #[error(
        "the target needs more than {needed_mib} MiB of blocks at a spacing of {spacing_mm:.4} mm, and the budget is \
         {budget_mib} MiB: raise the budget, use a larger spacing, or allow coarsening"
    )]
    OverBudget {
        /// What the blocks that were counted before stopping take.
        needed_mib: usize,
        /// What they may take.
        budget_mib: usize,
        /// The lattice's smallest spacing.
        spacing_mm: f64,
    },
}

/// Bytes of a voxel in a lit target: four channels of 16 bits, or two and four bytes of normal.
const TEXEL_BYTES: usize = 8;

/// A path of more steps than this is split further than the smallest block, as long as that may shorten it: in a scene of many
/// small parts each voxel would else be tested against all parts of a large block.
const LONG_PATH: usize = 64;

/// The edge at which even long paths are left as they are.
const FINEST: usize = 8;

/// Voxels of the coarsest lattice: one and the layer round it.
const FEWEST: usize = 27;

impl Target {
    /// Samples `model` on its lattice, or axis-aligned at `spacing_mm`.
    ///
    /// # Errors
    /// If the model has no lattice, cannot be flattened, or its blocks exceed the budget.
    pub fn build(model: &Model, spacing_mm: Option<f64>, subdivision: &Subdivision) -> Result<Self, TargetError> {
        let lattice = Lattice::of_model(model, spacing_mm)?;
        Self::on_lattice(model, lattice, subdivision)
    }

    /// Like [`Self::build`], with the spacing coarsened until the blocks fit the budget.
    ///
    /// # Errors
    /// As [`Self::build`], but for the budget.
    pub fn build_coarsened(
        model: &Model,
        spacing_mm: Option<f64>,
        subdivision: &Subdivision,
    ) -> Result<Self, TargetError> {
        let mut lattice = Lattice::of_model(model, spacing_mm)?;
        loop {
            match Self::on_lattice(model, lattice, subdivision) {
                Err(TargetError::OverBudget { spacing_mm, .. }) if lattice.len() > FEWEST => {
                    let coarser = Some(spacing_mm * 2f64.cbrt());
                    lattice = Lattice::of_model(model, coarser)?;
                }
                result => return result,
            }
        }
    }

    /// Samples `model` on a given lattice.
    ///
    /// # Errors
    /// If the model cannot be flattened, or its blocks exceed the budget.
    pub fn on_lattice(model: &Model, lattice: Lattice, subdivision: &Subdivision) -> Result<Self, TargetError> {
        let tree = Tree::new(model, lattice.world_from_grid())?;
        Self::of_tree(tree, lattice, subdivision)
    }

    /// Samples a tree that is flattened in coordinates of the grid of `lattice`.
    ///
    /// # Errors
    /// If its blocks exceed the budget.
    pub fn of_tree(tree: Tree, lattice: Lattice, subdivision: &Subdivision) -> Result<Self, TargetError> {
        Self::of_tree_after(tree, lattice, subdivision, Before::Unknown)
    }

    /// [`Self::of_tree`], where something is known of a target before.
    pub(super) fn of_tree_after(
        tree: Tree,
        lattice: Lattice,
        subdivision: &Subdivision,
        before: Before,
    ) -> Result<Self, TargetError> {
        let root = Cube::around(&lattice, subdivision.min_block);
        let splitter = Splitter {
            tree: &tree,
            lattice: &lattice,
            subdivision,
            stored_voxels: AtomicUsize::new(0),
        };
        let subtree = splitter.split(root, tree.steps(), &before);
        splitter.check_budget(&subtree)?;
        let mut flat = Flattener::default();
        flat.nodes.push(OctreeNode::Empty);
        flat.place(subtree, 0, lattice.dims);
        let value_range = value_range(&tree, &lattice);
        Ok(Self {
            octree: Octree {
                root,
                nodes: flat.nodes,
            },
            blocks: flat.blocks,
            paths: flat.paths,
            value_range,
            lattice,
            tree,
            subdivision: *subdivision,
        })
    }

    /// The model at point `p` of the lattice: the truth. The value of a colour is its opacity.
    pub fn sample(&self, p: DVec3) -> Sample {
        self.tree.sample(self.lattice.grid_point(p))
    }

    /// The steps of a block's path.
    pub fn path(&self, block: &Block) -> &[Step] {
        &self.paths[block.path as usize]
    }
}

/// A range that holds every value of `tree` on `lattice`: of the whole and not of blocks, because pictures are made of fractions
/// of it, and must not depend on the subdivision.
pub(super) fn value_range(tree: &Tree, lattice: &Lattice) -> Interval {
    if tree.has_colors() {
        // Opacities are fractions already.
        return Interval::new(0.0, 1.0);
    }
    let centres = lattice.grid_box(&lattice.centres());
    tree.prune(tree.steps(), &centres, None).range.value
}

/// A subtree of the octree while it is built.
enum Subtree {
    /// Outside the lattice.
    Beyond,
    Empty,
    Block(Box<Candidate>),
    Split(Box<[Subtree; 8]>),
}

/// A block with its path written out.
struct Candidate {
    cube: Cube,
    pruned: Pruned,
    layout: Layout,
}

struct Splitter<'a> {
    tree: &'a Tree,
    lattice: &'a Lattice,
    subdivision: &'a Subdivision,
    /// Voxels of all blocks so far, aprons apart. Merging changes nothing of it, so whether it ends above the budget does not
    /// depend on the order in which octants are split.
    stored_voxels: AtomicUsize,
}

impl Splitter<'_> {
    /// From this edge on octants are tested in parallel.
    const PARALLEL: usize = 128;

    fn split(&self, cube: Cube, path: &[Step], before: &Before) -> Subtree {
        let voxels = cube.voxels(self.lattice.dims);
        if voxels.is_empty() {
            return Subtree::Beyond;
        }
        if self.hopeless() {
            return Subtree::Empty;
        }
        let cells = voxels.bounds();
        let before = before.within(&self.lattice.endless_reach(&cells));
        if let Some(kept) = before.unchanged().and_then(|node| self.kept(cube, &before, node)) {
            return kept;
        }
        let smallest = cube.size <= self.subdivision.min_block.max(1);
        let by_centre = smallest && self.subdivision.boundary == Boundary::Centre;
        let decider = by_centre.then(|| self.lattice.grid_point(cells.center()));
        let pruned = self.tree.prune(path, &self.lattice.reach(&cells), decider);
        if pruned.steps.is_empty() {
            return Subtree::Empty;
        }
        let too_large = cube.size > self.subdivision.max_block;
        let finished = smallest && (pruned.steps.len() <= LONG_PATH || cube.size <= FINEST);
        if !too_large && (finished || !pruned.undecided) {
            return self.block(cube, pruned);
        }
        let octants = self.split_octants(&cube, &pruned.steps, &before);
        if too_large {
            return Subtree::Split(Box::new(octants));
        }
        self.merge(cube, octants)
    }

    fn split_octants(&self, cube: &Cube, path: &[Step], before: &Before) -> [Subtree; 8] {
        let octant = |i: usize| self.split(cube.octant(i), path, &before.octant(i, cube));
        if cube.size < Self::PARALLEL {
            return std::array::from_fn(octant);
        }
        let octants: Vec<Subtree> = (0..8).into_par_iter().map(octant).collect();
        octants.try_into().unwrap_or_else(|_| unreachable!("eight octants"))
    }

    fn block(&self, cube: Cube, pruned: Pruned) -> Subtree {
        let layout = if pruned.range.coverage.lo < 1.0 {
            Layout::Mixed
        } else if pruned.range.value.is_point() && !self.tree.has_colors() {
            Layout::Uniform
        } else {
            Layout::Covered
        };
        self.counted(Candidate { cube, pruned, layout })
    }

    fn counted(&self, candidate: Candidate) -> Subtree {
        if candidate.layout != Layout::Uniform {
            let voxels = candidate.cube.voxels(self.lattice.dims).len();
            self.stored_voxels.fetch_add(voxels, Ordering::Relaxed);
        }
        Subtree::Block(Box::new(candidate))
    }

    /// The subtree that a cube had before an edit that does not reach it; `None` if a part of it is gone after all.
    fn kept(&self, cube: Cube, before: &Before, node: OctreeNode) -> Option<Subtree> {
        Some(match node {
            OctreeNode::Empty => Subtree::Empty,
            OctreeNode::Block(index) => {
                let (pruned, layout) = before.block(index)?;
                self.counted(Candidate { cube, pruned, layout })
            }
            OctreeNode::Split(_) => {
                let octant = |i: usize| {
                    let before = before.octant(i, &cube);
                    self.kept(cube.octant(i), &before, before.unchanged()?)
                };
                let octants: Option<Vec<Subtree>> = (0..8).map(octant).collect();
                let octants = octants?.try_into().unwrap_or_else(|_| unreachable!("eight octants"));
                Subtree::Split(Box::new(octants))
            }
        })
    }

    /// One block instead of eight that are alike, beyond the lattice excepted.
    fn merge(&self, cube: Cube, octants: [Subtree; 8]) -> Subtree {
        let mut range: Option<SampleRange> = None;
        let mut first: Option<&Candidate> = None;
        for octant in &octants {
            match octant {
                Subtree::Beyond => {}
                Subtree::Block(c) if first.is_none_or(|f| f.like(c)) => {
                    first = first.or(Some(c));
                    range = Some(range.map_or(c.pruned.range, |r| SampleRange {
                        value: r.value.hull(c.pruned.range.value),
                        coverage: r.coverage.hull(c.pruned.range.coverage),
                    }));
                }
                _ => return Subtree::Split(Box::new(octants)),
            }
        }
        let (Some(first), Some(range)) = (first, range) else {
            return Subtree::Empty;
        };
        let merged = Candidate {
            cube,
            layout: first.layout,
            pruned: Pruned {
                steps: first.pruned.steps.clone(),
                range,
                undecided: true,
            },
        };
        Subtree::Block(Box::new(merged))
    }

    /// Whether the blocks so far are over the budget even at the fewest bytes a voxel can take.
    fn hopeless(&self) -> bool {
        self.stored_voxels.load(Ordering::Relaxed) > self.subdivision.budget_bytes / TEXEL_BYTES
    }

    fn check_budget(&self, subtree: &Subtree) -> Result<(), TargetError> {
        let budget = self.subdivision.budget_bytes;
        let needed = subtree.bytes(self.lattice);
        if needed <= budget && !self.hopeless() {
            return Ok(());
        }
        Err(TargetError::OverBudget {
            needed_mib: needed.max(budget) >> 20,
            budget_mib: budget >> 20,
            spacing_mm: self.lattice.spacing_mm().min_element(),
        })
    }
}

impl Subtree {
    fn bytes(&self, lattice: &Lattice) -> usize {
        match self {
            Self::Beyond | Self::Empty => 0,
            Self::Block(c) => c.bytes(lattice),
            Self::Split(octants) => octants.iter().map(|o| o.bytes(lattice)).sum(),
        }
    }
}

impl Candidate {
    fn like(&self, other: &Self) -> bool {
        self.layout == other.layout
            && self.pruned.steps == other.pruned.steps
            && (self.layout != Layout::Uniform || self.pruned.range == other.pruned.range)
    }

    /// Texture bytes in a lit target.
    fn bytes(&self, lattice: &Lattice) -> usize {
        let extent = self.cube.voxels(lattice.dims).extent;
        let voxels: usize = extent.iter().map(|n| n + 2 * Block::APRON).product();
        match self.layout {
            Layout::Covered | Layout::Mixed => voxels * TEXEL_BYTES,
            Layout::Uniform => TEXEL_BYTES,
        }
    }

    fn into_block(self, dims: [usize; 3], path: u32) -> Block {
        let VoxelBox { origin, extent } = self.cube.voxels(dims);
        Block {
            origin,
            size: self.cube.size,
            extent,
            path,
            layout: self.layout,
            range: self.pruned.range,
        }
    }
}

#[derive(Default)]
struct Flattener {
    nodes: Vec<OctreeNode>,
    blocks: Vec<Block>,
    paths: Vec<Vec<Step>>,
    path_ids: HashMap<Vec<Step>, u32>,
}

impl Flattener {
    fn place(&mut self, subtree: Subtree, at: usize, dims: [usize; 3]) {
        self.nodes[at] = match subtree {
            Subtree::Beyond | Subtree::Empty => OctreeNode::Empty,
            Subtree::Block(candidate) => {
                let path = self.intern(&candidate.pruned.steps);
                self.blocks.push(candidate.into_block(dims, path));
                OctreeNode::Block(self.blocks.len() as u32 - 1)
            }
            Subtree::Split(octants) => {
                let first = self.nodes.len();
                self.nodes.extend([OctreeNode::Empty; 8]);
                for (i, octant) in octants.into_iter().enumerate() {
                    self.place(octant, first + i, dims);
                }
                OctreeNode::Split(first as u32)
            }
        };
    }

    fn intern(&mut self, steps: &[Step]) -> u32 {
        if let Some(&id) = self.path_ids.get(steps) {
            return id;
        }
        let id = self.paths.len() as u32;
        self.paths.push(steps.to_vec());
        self.path_ids.insert(steps.to_vec(), id);
        id
    }
}
