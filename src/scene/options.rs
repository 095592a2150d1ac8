//! How a scene wants its target to be built.

use super::element::Element;
use super::error::{Problem, SceneError};
use crate::math::Interval;
use crate::model::{Boundary, Model};
use crate::target::{Lattice, Levels, Subdivision, Target, TargetError, Update};

/// The target that a scene asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetOptions {
    /// Distance between samples, millimetres; the model's own when `None`.
    pub spacing_mm: Option<f64>,
    /// The most memory that the target's blocks may take, MiB.
    pub budget_mib: u32,
    /// Whether a target beyond the budget is made coarser instead of refused.
    pub coarsen: bool,
    /// What happens at a node's boundary.
    pub boundary: Boundary,
    /// Edge of the smallest block, voxels, a power of two; the builder's choice when `None`.
    pub min_block: Option<u32>,
    /// How many levels of the multiresolution hierarchy a frame may be drawn from; 1 for the target alone.
    pub levels: u32,
}

impl Default for TargetOptions {
    fn default() -> Self {
        Self {
            spacing_mm: None,
            budget_mib: 2048,
            coarsen: false,
            boundary: Boundary::default(),
            min_block: None,
            levels: 1,
        }
    }
}

impl TargetOptions {
    /// The options of a `scene` node.
    pub(super) fn read(scene: &Element) -> Result<Self, SceneError> {
        let default = Self::default();
        let boundaries = [("exact", Boundary::Exact), ("centre", Boundary::Centre)];
        let options = Self {
            spacing_mm: scene.get("spacing").map(|v| v.positive()).transpose()?,
            budget_mib: scene
                .get("budget-mib")
                .map_or(Ok(default.budget_mib), |v| v.whole(1, 1 << 24))?,
            coarsen: scene.get("coarsen").map_or(Ok(default.coarsen), |v| v.boolean())?,
            boundary: scene
                .get("boundary")
                .map_or(Ok(default.boundary), |v| v.one_of(&boundaries))?,
            min_block: scene.get("min-block").map(min_block).transpose()?,
            levels: scene
                .get("levels")
                .map_or(Ok(default.levels), |v| v.whole(1, Levels::MAX))?,
        };
        if options.levels > 1 && options.coarsen {
            let why = "a scene with `levels` is not coarsened; use a larger `spacing` or `budget-mib`";
            return Err(scene.error(Problem::Conflict(why)));
        }
        Ok(options)
    }

    /// The subdivision that they ask for.
    pub fn subdivision(&self) -> Subdivision {
        let default = Subdivision::default();
        Subdivision {
            min_block: self.min_block.map_or(default.min_block, |edge| edge as usize),
            boundary: self.boundary,
            budget_bytes: (self.budget_mib as usize).saturating_mul(1 << 20),
            ..default
        }
    }

    /// The lattice that the target of `model` has, and the range of its values.
    ///
    /// # Errors
    /// As [`Self::build`], but over budget only where a coarser lattice is looked for.
    pub fn lattice_and_range(&self, model: &Model) -> Result<(Lattice, Interval), TargetError> {
        let lattice = if self.coarsen {
            self.build(model)?.lattice
        } else {
            Lattice::of_model(model, self.spacing_mm)?
        };
        Ok((lattice, lattice.value_range(model)?))
    }

    /// The target of `model`, made from the one before an edit: where both lattices are on one grid, only what the edit touches is made
    /// anew. A lattice that was coarsened is looked for again.
    ///
    /// # Errors
    /// As [`Self::build`].
    pub fn update(&self, before: &Target, model: &Model) -> Result<Update, TargetError> {
        let lattice = Lattice::of_model(model, self.spacing_mm)?;
        if lattice.shares_grid(&before.lattice) {
            match before.updated(model, lattice, &self.subdivision()) {
                Err(TargetError::OverBudget { .. }) if self.coarsen => {}
                result => return result,
            }
        }
        self.build(model).map(Update::anew)
    }

    /// The target of `model`.
    ///
    /// # Errors
    /// Those of [`Target::build`]; over budget only where coarsening is not allowed.
    pub fn build(&self, model: &Model) -> Result<Target, TargetError> {
        let build = if self.coarsen {
            Target::build_coarsened
        } else {
            Target::build
        };
        build(model, self.spacing_mm, &self.subdivision())
    }
}

fn min_block(value: super::element::Value) -> Result<u32, SceneError> {
    let edge = value.whole(2, 256)?;
    if edge.is_power_of_two() {
        Ok(edge)
    } else {
        Err(value.bad("a power of two"))
    }
}
