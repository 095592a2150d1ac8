//! A target after an edit of its model, made from the one before (design §4).
//!
//! *Theory.* An edit changes samples only in the boxes of the leaves that it changes, where they were and where they are
//! ([`Changes`]). A cube of the octree that none of them meets has the path that it had; the others are tested again.
//! *Changes from the paper.* VCSG subdivides the target anew for each tree. Here the result is that, bit for bit (design law 5),
//! and the work is that of the blocks that an edit touches.
//! *Practice.* The lattice must stay as it was: the bits of a sample depend on where the lattice is. An edit that moves the
//! model's bounds, or its finest spacing, moves the lattice, and then everything is made anew. A block that is touched but in the
//! end has the path that it had keeps its voxels too; one that has another takes over the voxels that lie in none of the boxes.

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::voxels::Slab;
use super::{Block, BlockVoxels, Cube, Layout, OctreeNode, Subdivision, Target, TargetError};
use crate::math::Aabb;
use crate::model::{Boundary, Changes, Model, Pruned, Tree};

/// A target after an edit, and what it has in common with the one before.
#[derive(Clone, Debug)]
pub struct Update {
    /// What building the model anew gives, bit for bit.
    pub target: Target,
    /// For each block the one of the target before that has the same voxels, if there is one.
    pub kept: Vec<Option<u32>>,
    /// Boxes of the lattice outside which no voxel has changed.
    pub changed: Vec<Aabb>,
}

impl Update {
    /// A target that has nothing in common with any before.
    pub fn anew(target: Target) -> Self {
        Self {
            kept: vec![None; target.blocks.len()],
            changed: vec![Aabb::ALL],
            target,
        }
    }

    /// The voxels of all blocks, without aprons, from those of the target before. What is kept is not copied; blocks that were
    /// made together lie in memory together, which lasts as long as one of them is kept.
    pub fn voxels(&self, before: &Target, voxels: &[BlockVoxels]) -> Vec<BlockVoxels> {
        let earlier = Earlier {
            target: before,
            voxels,
            changed: &self.changed,
        };
        let blocks = self.target.blocks.par_iter().zip(&self.kept);
        blocks
            .map(|(block, kept)| match kept {
                Some(index) => voxels[*index as usize].clone(),
                None => BlockVoxels::reconstruct_after(&self.target, block, &earlier),
            })
            .collect()
    }
}

impl Target {
    /// The target of `model` on the same lattice, for which only blocks that the change touches are tested again.
    ///
    /// # Errors
    /// As [`Target::on_lattice`].
    pub fn updated(&self, model: &Model, subdivision: &Subdivision) -> Result<Update, TargetError> {
        let tree = Tree::after(&self.tree, model, &self.lattice.world_from_lattice)?;
        let like = |s: &Subdivision| (s.min_block, s.max_block, s.boundary);
        // A deformation that changes moves all that it holds.
        if like(subdivision) != like(&self.subdivision) || !self.tree.deforms_like(&tree) {
            return Self::of_tree(tree, self.lattice, subdivision).map(Update::anew);
        }
        let mut changes = Changes::between(&self.tree, &tree);
        if subdivision.boundary == Boundary::Centre {
            for changed in &mut changes.boxes {
                *changed = whole_blocks(changed, subdivision.min_block);
            }
        }
        let edit = Edit {
            before: self,
            changes: &changes,
        };
        let target = Self::of_tree_after(tree, self.lattice, subdivision, Before::of(&edit))?;
        Ok(Update {
            kept: edit.kept(&target),
            changed: changes.boxes,
            target,
        })
    }
}

/// The cells of the smallest blocks that a box touches: under [`Boundary::Centre`] a leaf may fill all of a block that it only
/// reaches into.
fn whole_blocks(changed: &Aabb, min_block: usize) -> Aabb {
    let edge = min_block.max(1) as f64;
    let touched = changed.expand(DVec3::splat(Block::REACH as f64));
    Aabb {
        min: ((touched.min + 0.5) / edge).floor() * edge - 0.5,
        max: ((touched.max + 0.5) / edge).ceil() * edge - 0.5,
    }
}

/// From a target to the tree that its model has become.
pub(super) struct Edit<'a> {
    before: &'a Target,
    changes: &'a Changes,
}

impl Edit<'_> {
    /// For each block of `after` the one before of the same cube, layout and path.
    fn kept(&self, after: &Target) -> Vec<Option<u32>> {
        let paths: Vec<_> = self.before.paths.iter().map(|path| self.changes.path(path)).collect();
        let same_path = |old: &Block, new: &Block| {
            let path = paths[old.path as usize].as_ref();
            path.is_some_and(|path| path == after.path(new))
        };
        let cube = |block: &Block| (block.origin, block.size);
        let before: HashMap<_, _> = self.before.blocks.iter().map(cube).zip(0u32..).collect();
        let kept = |block: &Block| {
            let index = *before.get(&cube(block))?;
            let old = &self.before.blocks[index as usize];
            (old.layout == block.layout && same_path(old, block)).then_some(index)
        };
        after.blocks.iter().map(kept).collect()
    }
}

/// What is known of a cube from before an edit.
pub(super) enum Before<'a> {
    /// Nothing.
    Unknown,
    /// What it was, and the boxes of the edit that may meet it.
    Known {
        edit: &'a Edit<'a>,
        node: OctreeNode,
        changed: Cow<'a, [Aabb]>,
    },
}

impl<'a> Before<'a> {
    /// What is known of the root.
    fn of(edit: &'a Edit<'a>) -> Self {
        Self::Known {
            edit,
            node: edit.before.octree.nodes[0],
            changed: Cow::Borrowed(&edit.changes.boxes),
        }
    }

    /// The same, with only the boxes that meet `reach`.
    pub fn within(&self, reach: &Aabb) -> Self {
        let Self::Known { edit, node, changed } = self else {
            return Self::Unknown;
        };
        let meets = |b: &&Aabb| !b.intersect(reach).is_empty();
        Self::Known {
            edit,
            node: *node,
            changed: changed.iter().filter(meets).copied().collect(),
        }
    }

    /// What the cube was, if the edit does not meet it.
    pub fn unchanged(&self) -> Option<OctreeNode> {
        match self {
            Self::Known { node, changed, .. } if changed.is_empty() => Some(*node),
            _ => None,
        }
    }

    /// What is known of an octant.
    pub fn octant(&self, index: usize) -> Self {
        let Self::Known { edit, node, changed } = self else {
            return Self::Unknown;
        };
        let node = match *node {
            OctreeNode::Empty => OctreeNode::Empty,
            OctreeNode::Split(first) => edit.before.octree.nodes[first as usize + index],
            // How parts of a block would have been alone is not kept.
            OctreeNode::Block(_) => return Self::Unknown,
        };
        Self::Known {
            edit,
            node,
            changed: changed.clone(),
        }
    }

    /// Block `index` of the target before, in terms of the tree after; `None` if a part of its path is gone.
    pub fn block(&self, index: u32) -> Option<(Pruned, Layout)> {
        let Self::Known { edit, .. } = self else {
            return None;
        };
        let block = &edit.before.blocks[index as usize];
        let pruned = Pruned {
            steps: edit.changes.path(edit.before.path(block))?,
            range: block.range,
            undecided: false,
        };
        Some((pruned, block.layout))
    }
}

/// Voxels from before an edit.
pub(super) struct Earlier<'a> {
    target: &'a Target,
    voxels: &'a [BlockVoxels],
    /// Boxes of the lattice in which they do not hold.
    changed: &'a [Aabb],
}

/// Rows of one block's voxels, or of nothing.
pub(super) struct EarlierRows<'a>(Option<(&'a Block, &'a BlockVoxels)>);

impl<'a> Earlier<'a> {
    /// The rows that lie in the part of the lattice between two voxels, ends included; `None` if the edit touches it, or if it was
    /// not one block or empty cube.
    pub fn rows(&self, first: [usize; 3], last: [usize; 3]) -> Option<EarlierRows<'a>> {
        let point = |at: [usize; 3]| DVec3::from_array(at.map(|n| n as f64));
        let part = Aabb::new(point(first), point(last));
        if self.changed.iter().any(|b| !b.intersect(&part).is_empty()) {
            return None;
        }
        let (cube, node) = self.target.leaf_at(first);
        if !holds(&cube, last) {
            return None;
        }
        match node {
            OctreeNode::Block(index) => {
                let index = index as usize;
                Some(EarlierRows(Some((&self.target.blocks[index], &self.voxels[index]))))
            }
            _ => Some(EarlierRows(None)),
        }
    }
}

fn holds(cube: &Cube, at: [usize; 3]) -> bool {
    (0..3).all(|a| (cube.origin[a]..cube.origin[a] + cube.size).contains(&at[a]))
}

impl EarlierRows<'_> {
    /// Copies the voxels `(i, j, k)` for `i` in `columns`.
    pub fn copy(&self, columns: Range<usize>, [j, k]: [usize; 2], out: Slab) {
        let Some((block, voxels)) = self.0 else {
            out.premultiplied.fill(0.0);
            out.coverage.into_iter().for_each(|row| row.fill(0.0));
            out.rgb.into_iter().for_each(|row| row.fill([0.0; 3]));
            return;
        };
        let [x, y, z] = block.origin;
        let start = columns.start - x + voxels.dims[0] * (j - y + voxels.dims[1] * (k - z));
        let row = start..start + columns.len();
        out.premultiplied.copy_from_slice(&voxels.premultiplied[row.clone()]);
        match (out.coverage, &voxels.coverage) {
            (Some(coverage), Some(before)) => coverage.copy_from_slice(&before[row.clone()]),
            (Some(coverage), None) => coverage.fill(1.0),
            (None, _) => {}
        }
        if let (Some(rgb), Some(before)) = (out.rgb, voxels.rgb()) {
            rgb.copy_from_slice(&before[row]);
        }
    }
}
