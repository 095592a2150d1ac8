//! A target after an edit of its model, made from the one before (design §4).
//!
//! *Theory.* An edit changes samples only in the boxes of the leaves that it changes, where they were and where they are
//! ([`Changes`]). A cube of the octree that none of them meets has the path that it had; the others are tested again.
//! *Changes from the paper.* VCSG subdivides the target anew for each tree. Here the result is that, bit for bit (design law 5),
//! and the work is that of the blocks that an edit touches.
//! *Practice.* Samples and cubes lie on a grid that bounds do not move ([`Lattice`]). Where an edit moves the model's bounds, what
//! their faces cut before and after is touched too, and blocks elsewhere stay. Another spacing, or other axes, are another grid:
//! then everything is made anew. A block that is touched but in the end has the path that it had keeps its voxels too; one
//! that has another takes over the voxels that lie in none of the boxes. Of deformations the tables of those that have not changed
//! are kept; one that has touches the box of what it deforms, before and after.

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;

use glam::{DVec3, I64Vec3};
use rayon::prelude::*;

use super::voxels::Slab;
use super::{Block, BlockVoxels, Cube, Lattice, Layout, OctreeNode, Subdivision, Target, TargetError};
use crate::math::Aabb;
use crate::model::{Boundary, Changes, Model, Pruned, Tree};

/// A target after an edit, and what it has in common with the one before.
#[derive(Clone, Debug)]
pub struct Update {
    /// What building the model anew gives, bit for bit.
    pub target: Target,
    /// For each block the one of the target before that has the same voxels, if there is one.
    pub kept: Vec<Option<u32>>,
    /// Boxes of the lattice's grid outside which no voxel has changed.
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
            lattice: &self.target.lattice,
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
    /// The target of `model` on `lattice`. If that is on the same grid, only blocks that the change touches, or a face of the
    /// lattice that has moved, are tested again.
    ///
    /// # Errors
    /// As [`Target::on_lattice`].
    pub fn updated(&self, model: &Model, lattice: Lattice, subdivision: &Subdivision) -> Result<Update, TargetError> {
        if !lattice.shares_grid(&self.lattice) {
            return Self::on_lattice(model, lattice, subdivision).map(Update::anew);
        }
        let tree = Tree::after(&self.tree, model, lattice.world_from_grid())?;
        let root = Cube::around(&lattice, subdivision.min_block);
        let phase = phase(&root, &lattice, subdivision);
        let like = |s: &Subdivision| (s.min_block, s.max_block, s.boundary);
        let is_like = phase == self::phase(&self.octree.root, &self.lattice, &self.subdivision);
        if like(subdivision) != like(&self.subdivision) || !is_like {
            return Self::of_tree(tree, lattice, subdivision).map(Update::anew);
        }
        let mut changes = Changes::between(&self.tree, &tree);
        changes.boxes.extend(self.lattice.difference(&lattice));
        if subdivision.boundary == Boundary::Centre {
            for changed in &mut changes.boxes {
                *changed = whole_blocks(changed, subdivision.min_block, phase);
            }
        }
        let edit = Edit {
            before: self,
            changes: &changes,
            shift: shift(&lattice, &self.lattice),
        };
        let target = Self::of_tree_after(tree, lattice, subdivision, Before::of(&edit, &root))?;
        Ok(Update {
            kept: edit.kept(&target),
            changed: changes.boxes,
            target,
        })
    }
}

/// From coordinates of one lattice to those of another on the same grid.
fn shift(from: &Lattice, to: &Lattice) -> I64Vec3 {
    from.first() - to.first()
}

/// By how many points the smallest blocks lie beside multiples of their edge on the grid: 0 but for a root that is one of them.
fn phase(root: &Cube, lattice: &Lattice, subdivision: &Subdivision) -> I64Vec3 {
    let edge = I64Vec3::splat(subdivision.min_block.max(1) as i64);
    (I64Vec3::from_array(root.origin) + lattice.first()).rem_euclid(edge)
}

/// The cells of the smallest blocks that a box touches: under [`Boundary::Centre`] a leaf may fill all of a block that it only
/// reaches into.
fn whole_blocks(changed: &Aabb, min_block: usize, phase: I64Vec3) -> Aabb {
    let edge = min_block.max(1) as f64;
    let touched = changed.expand(DVec3::splat(Block::REACH as f64));
    let face = phase.as_dvec3() - 0.5;
    Aabb {
        min: ((touched.min - face) / edge).floor() * edge + face,
        max: ((touched.max - face) / edge).ceil() * edge + face,
    }
}

/// From a target to the tree that its model has become.
pub(super) struct Edit<'a> {
    before: &'a Target,
    changes: &'a Changes,
    /// From coordinates of the lattice after the edit to those of the one before.
    shift: I64Vec3,
}

impl Edit<'_> {
    /// For each block of `after` the one before of the same cube, layout, path and surroundings: a face of the lattice that has moved
    /// changes the apron.
    fn kept(&self, after: &Target) -> Vec<Option<u32>> {
        let paths: Vec<_> = self.before.paths.iter().map(|path| self.changes.path(path)).collect();
        let same_path = |old: &Block, new: &Block| {
            let path = paths[old.path as usize].as_ref();
            path.is_some_and(|path| path == after.path(new))
        };
        let cube = |block: &Block, shift: I64Vec3| {
            let origin = I64Vec3::from_array(block.origin.map(|n| n as i64)) + shift;
            (origin, block.size, block.extent)
        };
        let same_reach =
            |old: &Block, new: &Block| self.before.lattice.reach(&old.bounds()) == after.lattice.reach(&new.bounds());
        let before = self.before.blocks.iter().map(|block| cube(block, I64Vec3::ZERO));
        let before: HashMap<_, _> = before.zip(0u32..).collect();
        let kept = |block: &Block| {
            let index = *before.get(&cube(block, self.shift))?;
            let old = &self.before.blocks[index as usize];
            let same = old.layout == block.layout && same_reach(old, block) && same_path(old, block);
            same.then_some(index)
        };
        after.blocks.iter().map(kept).collect()
    }

    /// What `cube`, of the lattice after the edit, was before; `None` if it was no cube, or a part of a block.
    fn node(&self, cube: &Cube) -> Option<OctreeNode> {
        let octree = &self.before.octree;
        let cube = Cube {
            origin: (I64Vec3::from_array(cube.origin) + self.shift).to_array(),
            ..*cube
        };
        let (mut around, mut node) = (octree.root, octree.nodes[0]);
        while around.holds(&cube) {
            match node {
                _ if around == cube => return Some(node),
                OctreeNode::Empty => return Some(node),
                // How parts of a block would have been alone is not kept.
                OctreeNode::Block(_) => return None,
                OctreeNode::Split(first) => {
                    let octant = around.octant_with(cube.origin);
                    around = around.octant(octant);
                    node = octree.nodes[first as usize + octant];
                }
            }
        }
        None
    }
}

/// What is known of a cube from before an edit.
pub(super) enum Before<'a> {
    /// Nothing.
    Unknown,
    /// What it was, if it was a cube, and the boxes of the edit that may meet it.
    Known {
        edit: &'a Edit<'a>,
        node: Option<OctreeNode>,
        changed: Cow<'a, [Aabb]>,
    },
}

impl<'a> Before<'a> {
    /// What is known of the root.
    fn of(edit: &'a Edit<'a>, root: &Cube) -> Self {
        Self::Known {
            edit,
            node: edit.node(root),
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
            Self::Known { node, changed, .. } if changed.is_empty() => *node,
            _ => None,
        }
    }

    /// What is known of octant `index` of `cube`.
    pub fn octant(&self, index: usize, cube: &Cube) -> Self {
        let Self::Known { edit, node, changed } = self else {
            return Self::Unknown;
        };
        let node = match *node {
            Some(OctreeNode::Split(first)) => Some(edit.before.octree.nodes[first as usize + index]),
            Some(OctreeNode::Empty) => *node,
            // What was no cube may have held some.
            _ => edit.node(&cube.octant(index)),
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
    /// Boxes of the grid in which they do not hold.
    changed: &'a [Aabb],
    /// After the edit.
    lattice: &'a Lattice,
}

/// Rows of one block's voxels, or of nothing.
pub(super) struct EarlierRows<'a> {
    of: Option<(&'a Block, &'a BlockVoxels)>,
    /// From coordinates of the lattice after the edit to those of the one before.
    shift: I64Vec3,
}

impl<'a> Earlier<'a> {
    /// The rows that lie in the part of the lattice between two voxels, ends included; `None` if the edit touches it, or if it was
    /// not one block or empty cube.
    pub fn rows(&self, first: [usize; 3], last: [usize; 3]) -> Option<EarlierRows<'a>> {
        let point = |at: [usize; 3]| DVec3::from_array(at.map(|n| n as f64));
        let part = self.lattice.grid_box(&Aabb::new(point(first), point(last)));
        if self.changed.iter().any(|b| !b.intersect(&part).is_empty()) {
            return None;
        }
        let shift = shift(self.lattice, &self.target.lattice);
        let [first, last] = [shifted(first, shift)?, shifted(last, shift)?];
        let (cube, node) = self.target.leaf_at(first);
        if !cube.voxels(self.target.lattice.dims).holds(last) {
            return None;
        }
        let of = match node {
            OctreeNode::Block(index) => {
                let index = index as usize;
                Some((&self.target.blocks[index], &self.voxels[index]))
            }
            _ => None,
        };
        Some(EarlierRows { of, shift })
    }
}

/// Voxel `at` in the coordinates of another lattice, if it does not lie before it.
fn shifted(at: [usize; 3], shift: I64Vec3) -> Option<[usize; 3]> {
    let [x, y, z] = (I64Vec3::from_array(at.map(|n| n as i64)) + shift).to_array();
    Some([x.try_into().ok()?, y.try_into().ok()?, z.try_into().ok()?])
}

impl EarlierRows<'_> {
    /// Copies the voxels `(i, j, k)` for `i` in `columns`.
    pub fn copy(&self, columns: Range<usize>, [j, k]: [usize; 2], out: Slab) {
        let start = shifted([columns.start, j, k], self.shift);
        let (Some((block, voxels)), Some(start)) = (self.of, start) else {
            out.premultiplied.fill(0.0);
            out.coverage.into_iter().for_each(|row| row.fill(0.0));
            out.rgb.into_iter().for_each(|row| row.fill([0.0; 3]));
            return;
        };
        let start = voxels.index(block.origin, start);
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
