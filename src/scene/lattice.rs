//! How a scene wants its target to be built.

use super::element::Element;
use super::error::SceneError;

/// What is done where a smallest block lies across a node's boundary (VCSG §3.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Boundary {
    /// Each voxel is tested.
    #[default]
    Exact,
    /// The block's centre decides for all of it.
    Centre,
}

/// The target lattice that a scene asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    /// Distance between samples, millimetres; the finest leaf's when `None`.
    pub spacing_mm: Option<f64>,
    /// The most memory that the target's blocks may take, MiB.
    pub budget_mib: u32,
    /// Whether a target beyond the budget is made coarser instead of refused.
    pub coarsen: bool,
    /// What happens at a node's boundary.
    pub boundary: Boundary,
    /// Edge of the smallest block, voxels, a power of two; the builder's choice when `None`.
    pub min_block: Option<u32>,
}

impl Default for Lattice {
    fn default() -> Self {
        Self {
            spacing_mm: None,
            budget_mib: 2048,
            coarsen: false,
            boundary: Boundary::default(),
            min_block: None,
        }
    }
}

impl Lattice {
    /// The options of a `scene` node.
    pub(super) fn read(scene: &Element) -> Result<Self, SceneError> {
        let default = Self::default();
        let boundaries = [("exact", Boundary::Exact), ("centre", Boundary::Centre)];
        Ok(Self {
            spacing_mm: scene.get("spacing").map(|v| v.positive()).transpose()?,
            budget_mib: scene
                .get("budget-mib")
                .map_or(Ok(default.budget_mib), |v| v.whole(1, 1 << 24))?,
            coarsen: scene
                .get("coarsen")
                .map_or(Ok(default.coarsen), |v| v.boolean())?,
            boundary: scene
                .get("boundary")
                .map_or(Ok(default.boundary), |v| v.one_of(&boundaries))?,
            min_block: scene
                .get("min-block")
                .map(|v| {
                    let edge = v.whole(2, 256)?;
                    if edge.is_power_of_two() {
                        Ok(edge)
                    } else {
                        Err(v.bad("a power of two"))
                    }
                })
                .transpose()?,
        })
    }
}
