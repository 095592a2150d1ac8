//! Which parts of the target a transfer function shows.
//!
//! *Changes from the paper.* VCSG draws every block that the tree reaches; here only those parts of a block are drawn whose
//! value ranges ([`CellRanges`](crate::target::CellRanges)) are not invisible throughout, and of which something may still show ([`Remaining`]).
//! *Practice.* Opaque table entries are counted once in a running sum, so asking for a range of values costs two look-ups.

use glam::DVec3;

use super::split::{ShownGrid, Splitter};
use super::table::TakenEntries;
use super::{Camera, FrameSpec, Planes, Remaining, ShownCells, TransferTable, VisibleBox, eye_from_lattice};
use crate::math::{Interval, Viewpoint, affine};
use crate::target::{CELL, Cube, Lattice, OctreeNode, Target, VoxelBox, octants_back_to_front};

/// The values that are not invisible.
#[derive(Clone, Debug, PartialEq)]
pub struct VisibleValues {
    taken: TakenEntries,
    shown: Which,
}

#[derive(Clone, Debug, PartialEq)]
enum Which {
    All,
    /// Opacities above 0.
    Positive,
    /// Entry `i` counts the opaque table entries before `i`.
    Opaque(Vec<u32>),
}

impl VisibleValues {
    /// Every value shows (maximum, minimum and average projections).
    pub fn all(value_range: Interval) -> Self {
        Self {
            taken: TakenEntries::new(value_range),
            shown: Which::All,
        }
    }

    /// The values that show in a frame: all of them where it shows values, of colours those that are at all opaque, and else those that
    /// `table`, its transfer function's, makes so.
    pub fn in_frame(spec: &FrameSpec, table: &TransferTable) -> Self {
        let range = spec.target.value_range;
        if !spec.settings.mode.classifies() {
            Self::all(range)
        } else if spec.target.tree.has_colors() {
            Self {
                taken: TakenEntries::new(range),
                shown: Which::Positive,
            }
        } else {
            Self::of(table, range)
        }
    }

    /// The values that `table`, which spans `value_range`, makes at all opaque.
    pub fn of(table: &TransferTable, value_range: Interval) -> Self {
        let mut count = 0;
        let mut visible_before = vec![0];
        for entry in table.entries() {
            count += u32::from(entry[3] > 0.0);
            visible_before.push(count);
        }
        Self {
            taken: TakenEntries::new(value_range),
            shown: Which::Opaque(visible_before),
        }
    }

    /// Whether a value in `range` can show.
    pub fn any_in(&self, range: Interval) -> bool {
        if range.is_empty() {
            return false;
        }
        let visible_before = match &self.shown {
            Which::All => return true,
            Which::Positive => return range.hi > 0.0,
            Which::Opaque(visible_before) => visible_before,
        };
        visible_before[self.taken.end(range)] > visible_before[self.taken.first(range)]
    }
}

/// What drawing a box costs, in fragments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawCost {
    /// Fragments of all slices of a voxel.
    fragments_per_voxel: f64,
    /// Slices that a lattice step along each axis adds to a box.
    slices_per_step: DVec3,
}

impl DrawCost {
    /// What a slice costs beside its fragments, in fragments: a rough choice. On lavapipe, for one head, what 200, 300 and 450
    /// drew differed by less than the noise, and 80 took a tenth longer. No other device was tried.
    pub(super) const SLICE: f64 = 300.0;

    /// Fragments alone: a box is drawn whole only if all of it shows.
    pub const VOXELS: Self = Self {
        fragments_per_voxel: 1.0,
        slices_per_step: DVec3::ZERO,
    };

    /// Likewise with so many slices a lattice step along each axis.
    #[cfg(test)]
    pub(super) fn with_slices(self, slices_per_step: DVec3) -> Self {
        Self {
            slices_per_step,
            ..self
        }
    }

    /// The cost in a frame of `camera`; under perspective, that in the middle of the lattice.
    pub fn new(lattice: &Lattice, camera: &Camera, planes: &Planes) -> Self {
        let eye_from_lattice = eye_from_lattice(lattice, camera);
        let middle = affine::point(&eye_from_lattice, lattice.bounds().center());
        let pixels_per_mm = camera.pixels_per_mm(middle.z.max(camera.near_mm()));
        let voxel_mm3 = eye_from_lattice.matrix3.determinant().abs();
        Self {
            fragments_per_voxel: voxel_mm3 * pixels_per_mm.powi(2) / planes.step_mm,
            slices_per_step: eye_from_lattice.matrix3.row(2).abs() / planes.step_mm,
        }
    }

    /// The cost of so many voxels more in a box that is drawn anyhow.
    pub(super) fn of_voxels(&self, count: usize) -> f64 {
        self.fragments_per_voxel * count as f64
    }

    /// The cost of a box of `extent` voxels.
    pub(super) fn of(&self, extent: [usize; 3]) -> f64 {
        let fragments = self.of_voxels(extent.iter().product());
        let extent = DVec3::from_array(extent.map(|n| n as f64));
        fragments + Self::SLICE * self.slices_per_step.dot(extent)
    }
}

/// What is drawn of a target: boxes inside its blocks.
pub struct Visibility<'a> {
    /// The subdivision.
    pub target: &'a Target,
    /// The cells of its blocks in which something shows.
    pub shown: &'a ShownCells<'a>,
    /// Edge of the smallest cubes that are drawn apart, a power of two of at least [`CELL`] voxels; larger in blocks of more than 64 of
    /// them along an axis.
    pub min_cube: usize,
    /// What of the frame is left to be drawn, unless that is all of it.
    pub remaining: Option<Remaining<'a>>,
    /// What a box costs: parts that do not show are drawn with the rest where that is cheaper than to draw around them.
    pub cost: DrawCost,
}

impl Visibility<'_> {
    /// The visible boxes, from back to front. Parts of one block are one box where that is no dearer.
    pub fn boxes_back_to_front(&self, viewpoint: Viewpoint) -> Vec<VisibleBox> {
        let mut found = Vec::new();
        self.visit(0, self.target.octree.root, viewpoint, &mut found);
        found
    }

    fn visit(&self, node: usize, cube: Cube, viewpoint: Viewpoint, found: &mut Vec<VisibleBox>) {
        match self.target.octree.nodes[node] {
            OctreeNode::Empty => {}
            OctreeNode::Block(block) => self.split(block, cube, viewpoint, found),
            OctreeNode::Split(_) if !self.remains(&cube.voxels(self.target.lattice.dims)) => {}
            OctreeNode::Split(first) => {
                for octant in octants_back_to_front(&cube, viewpoint) {
                    let node = first as usize + octant;
                    self.visit(node, cube.octant(octant), viewpoint, found);
                }
            }
        }
    }

    /// Adds what is drawn of `block`, which fills `cube`.
    fn split(&self, block: u32, cube: Cube, viewpoint: Viewpoint, found: &mut Vec<VisibleBox>) {
        let mut grid = ShownGrid::empty(cube, self.min_cube.max(CELL));
        self.note_shown(block, cube, &mut grid);
        let splitter = Splitter {
            block,
            grid: &grid,
            dims: self.target.lattice.dims,
            cost: &self.cost,
            viewpoint,
        };
        splitter.split(found);
    }

    /// Notes in `grid` which of its cells in `cube`, a part of `block`, show.
    fn note_shown(&self, block: u32, cube: Cube, grid: &mut ShownGrid) {
        let lattice = &self.target.lattice;
        let voxels = cube.voxels(lattice.dims);
        if voxels.is_empty() || !self.shown.any_in(block, lattice, &voxels) || !self.remains(&voxels) {
            return;
        }
        if cube.size <= grid.cell() {
            grid.show(cube.origin);
        } else {
            (0..8).for_each(|octant| self.note_shown(block, cube.octant(octant), grid));
        }
    }

    /// Whether something in `voxels` may have to do with what remains.
    fn remains(&self, voxels: &VoxelBox) -> bool {
        self.remaining
            .is_none_or(|remaining| remaining.may_show(&voxels.bounds()))
    }
}
