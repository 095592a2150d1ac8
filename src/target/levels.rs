//! The multiresolution hierarchy (WK94, *manipulating volume-sampled models*, figures 6 and 7).
//!
//! *Theory.* Level l has voxels 2^l times as wide as the base, and is voxelised with a filter as much wider: no level is averaged
//! from the one below, so none inherits aliasing.
//! *Changes from the paper.* Levels are not stored. Densities are computed where they are asked for, so a part of a level, and
//! what lies between two levels, is a target like any other, built where a frame needs it.
//! *Practice.* Scans have no filter: on coarser levels their voxels are interpolated and may alias, and so do crisp primitives.

use glam::DAffine3;

use super::octree::value_range;
use super::{Lattice, Subdivision, Target, TargetError};
use crate::math::{Aabb, Interval, Plane};
use crate::model::{Model, Source, Tree};
use crate::voxelize::{Footprint, Grade};

/// The levels of a model.
#[derive(Clone, Copy, Debug)]
pub struct Levels<'a> {
    /// What is sampled.
    pub model: &'a Model,
    /// How many there are, at least 1.
    pub count: u32,
    /// The lattice of the finest level.
    pub base: Lattice,
    /// A box of the world that holds every level.
    pub bounds: Aabb,
    /// A range that holds every value of every level.
    pub value_range: Interval,
    spacing_mm: Option<f64>,
    has_volume: bool,
}

impl<'a> Levels<'a> {
    /// The most levels that there can be.
    pub const MAX: u32 = 8;

    /// `count` levels of `model`, the finest on the lattice that [`Target::build`] samples at `spacing_mm`.
    ///
    /// # Errors
    /// If the model cannot be flattened or has no such lattice.
    pub fn new(model: &'a Model, spacing_mm: Option<f64>, count: u32) -> Result<Self, TargetError> {
        let base = Lattice::of_model(model, spacing_mm)?;
        let crisp = Tree::outline(model, &DAffine3::IDENTITY, 0.0, None)?;
        let is_volume = |leaf: &crate::model::Leaf| matches!(leaf.source, Source::Volume(_));
        let mut levels = Self {
            model,
            count: count.clamp(1, Self::MAX),
            base,
            bounds: Aabb::EMPTY,
            value_range: Interval::EMPTY,
            spacing_mm,
            has_volume: crisp.leaves().iter().any(is_volume),
        };
        for level in 0..levels.count {
            let lattice = levels.whole(level)?;
            let tree = Tree::new(model, lattice.world_from_grid())?;
            levels.bounds = levels.bounds.hull(&lattice.world_bounds());
            levels.value_range = levels.value_range.hull(value_range(&tree, &lattice));
        }
        Ok(levels)
    }

    /// Distance between voxels of a level, millimetres: what its filters are made for.
    pub fn voxel_mm(&self, level: u32) -> f64 {
        self.base.spacing_mm().max_element() * Grade::WIDER.powi(level as i32)
    }

    /// The lattice of a whole level. Axis-aligned ones lie on one another: of each the points are points of the one before.
    ///
    /// # Errors
    /// If the model cannot be flattened, or has too many voxels.
    pub fn whole(&self, level: u32) -> Result<Lattice, TargetError> {
        self.lattice(level, &self.in_world(level, None)?)
    }

    /// The part of a level that `planes` (world) do not cut away, with filters that change to the next level's as pixels of
    /// `footprint` ask; those of the last level stay. `None` if nothing of the lattice is left.
    ///
    /// The lattice is a part of the whole level's, wherever the planes are: a voxel that two frames have is the same in both.
    ///
    /// # Errors
    /// If the blocks exceed the budget.
    pub fn part(
        &self,
        level: u32,
        footprint: &Footprint,
        planes: &[Plane],
        subdivision: &Subdivision,
    ) -> Result<Option<Target>, TargetError> {
        let voxel_mm = self.voxel_mm(level);
        let footprint = *footprint;
        let grade = (level + 1 < self.count).then_some(Grade { footprint, voxel_mm });
        let whole = self.in_world(level, grade)?;
        let lattice = self.lattice(level, &whole)?;
        let kept = whole.cut_by(planes, &DAffine3::IDENTITY);
        let Some(part) = lattice.part(&kept.bounds_in(&lattice.world_from_lattice)) else {
            return Ok(None);
        };
        let tree = Tree::graded(self.model, part.world_from_grid(), voxel_mm, grade)?;
        let tree = tree.cut_by(planes, part.world_from_grid());
        let target = Target::of_tree(tree, part, subdivision)?;
        Ok(Some(Target {
            value_range: self.value_range,
            ..target
        }))
    }

    fn in_world(&self, level: u32, grade: Option<Grade>) -> Result<Tree, TargetError> {
        Ok(Tree::outline(
            self.model,
            &DAffine3::IDENTITY,
            self.voxel_mm(level),
            grade,
        )?)
    }

    /// The whole lattice of a level for `tree`, flattened in the world.
    fn lattice(&self, level: u32, tree: &Tree) -> Result<Lattice, TargetError> {
        let spacing_mm = self.voxel_mm(level);
        let lattice = if self.has_volume && level == 0 {
            Lattice::of_tree(tree, self.spacing_mm)
        } else {
            Lattice::of_tree_with_point(tree, spacing_mm, 0.5 * self.voxel_mm(0))
        };
        Ok(lattice?)
    }
}
