//! Where leaves and cuts stand: in a tree's frame, or in it as it is below deformations.
//!
//! *Practice.* A leaf's map leads from the frame to the leaf as if nothing were deformed; a deformation maps the frame to itself.
//! So what is below one differs from what is not in the point that it is asked at, and in nothing else.

use glam::{DAffine3, DVec3};

use super::deform::{Frame, Morph, Region, Table, Warp, WarpReport};
use super::flatten::{Sampling, Visit};
use super::{Node, Step, Tree, TreeError};
use crate::math::{Aabb, affine};

/// Where a leaf or a cut stands: in the tree's frame, or in that frame as it is below a deformation, by its number.
pub type Space = Option<u32>;

impl Tree {
    /// The space that the children of a node stand in.
    pub(super) fn enter(&mut self, node: &Node, visit: &Visit, sampling: &Sampling<'_>) -> Result<Space, TreeError> {
        let Node::Deform {
            morph, error_voxels, ..
        } = node
        else {
            return Ok(visit.space);
        };
        let frames = [&visit.node_from_frame, &sampling.world_from_frame];
        let frame = Frame::new(morph, frames, sampling.voxel(), *error_voxels);
        let warp = Warp::new(visit.space, self.nesting(visit.space) + 1, frame)?;
        self.warps.push(warp);
        Ok(Some(self.warps.len() as u32 - 1))
    }

    /// How many deformations hold a space.
    fn nesting(&self, space: Space) -> usize {
        space.map_or(0, |warp| self.warps[warp as usize].nesting)
    }

    /// States what the deformation of a space deforms, which the last steps are.
    pub(super) fn place_warp(&mut self, space: Space) -> Result<(), TreeError> {
        let steps = &self.steps()[operand_start(self.steps())..];
        let source = self.bounds_of(steps, space, &DAffine3::IDENTITY);
        let warp = space.and_then(|index| self.warps.get_mut(index as usize));
        Ok(warp.map_or(Ok(()), |warp| warp.place(source))?)
    }

    /// For each deformation the one of `other`, a tree in the same frame, that is the same there; none of them is that of two.
    pub(super) fn warps_in(&self, other: &Self) -> Vec<Option<u32>> {
        let mut places: Vec<Option<u32>> = Vec::with_capacity(self.warps.len());
        let mut taken = vec![false; other.warps.len()];
        for warp in &self.warps {
            // A deformation comes after those that it stands in.
            let outer = space_in(&places, warp.outer);
            let same = |at: &usize| {
                let known = &other.warps[*at];
                !taken[*at] && outer == Some(known.outer) && warp.is_like(known)
            };
            let place = (0..other.warps.len()).find(same);
            place.into_iter().for_each(|at| taken[at] = true);
            places.push(place.map(|at| at as u32));
        }
        places
    }

    /// How many deformations there are.
    pub fn warp_count(&self) -> usize {
        self.warps.len()
    }

    /// The deformations, and what their tables came to.
    pub fn deformations(&self) -> impl Iterator<Item = (&Morph, &WarpReport)> {
        self.warps.iter().map(|warp| (&*warp.frame.morph, warp.table.report()))
    }

    /// φ⁻¹ of deformation `index`.
    pub fn table(&self, index: u32) -> &Table {
        &self.warp(index).table
    }

    /// The space that deformation `index` stands in.
    pub fn space_around(&self, index: u32) -> Space {
        self.warp(index).outer
    }

    fn warp(&self, index: u32) -> &Warp {
        &self.warps[index as usize]
    }

    /// Of the deformations that lead from `space` to `below`, the first; `None` if there is none.
    pub(super) fn outermost_below(&self, space: Space, below: Space) -> Option<&Warp> {
        let mut at = below;
        while at != space {
            let warp = self.warp(at?);
            if warp.outer == space {
                return Some(warp);
            }
            at = warp.outer;
        }
        None
    }

    /// The frame's point `p` in `space`; NaN where nothing is deformed to. As deep as deformations nest.
    pub fn in_space(&self, space: Space, p: DVec3) -> DVec3 {
        match space {
            None => p,
            Some(index) => {
                let warp = self.warp(index);
                warp.table.point(self.in_space(warp.outer, p))
            }
        }
    }

    /// Where the points of `block`, a box of the frame, are in `space`.
    pub fn region_in(&self, space: Space, block: &Aabb) -> Region {
        let Some(index) = space else {
            return Region {
                hull: *block,
                beyond: false,
            };
        };
        let warp = self.warp(index);
        let outer = self.region_in(warp.outer, block);
        if outer.hull.is_empty() {
            return Region::NOWHERE;
        }
        let region = warp.table.region(&outer.hull);
        Region {
            beyond: region.beyond || outer.beyond,
            ..region
        }
    }
}

/// What a space is in another tree, by what its deformations are there; `None` if its own is none of them.
pub(super) fn space_in(warps: &[Option<u32>], space: Space) -> Option<Space> {
    match space {
        None => Some(None),
        Some(index) => warps[index as usize].map(Some),
    }
}

/// Where the operand begins that stands last in `steps`.
fn operand_start(steps: &[Step]) -> usize {
    let mut wanted = 1;
    let mut start = steps.len();
    while wanted > 0 && start > 0 {
        start -= 1;
        match steps[start] {
            Step::Leaf(_) | Step::LeafInside(_) => wanted -= 1,
            Step::Combine(_) | Step::Blend(_) => wanted += 1,
            Step::Map(_) | Step::Cut(_) | Step::Classify(_) => {}
        }
    }
    start
}

impl Sampling<'_> {
    /// A voxel in the frame's units, as far as deformations go: 1 on a lattice. Where there is none, a millimetre.
    fn voxel(&self) -> f64 {
        let voxel = self.voxel_mm / affine::spacing(&self.world_from_frame).max_element();
        match voxel > 0.0 {
            true if (voxel - 1.0).abs() < 1e-9 => 1.0,
            true => voxel,
            false => 1.0,
        }
    }
}
