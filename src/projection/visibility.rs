//! Which parts of the target a transfer function shows.
//!
//! *Changes from the paper.* VCSG draws every block that the tree reaches; here only those cubes of a block are drawn whose
//! value ranges ([`CellRanges`]) are not invisible throughout.
//! *Practice.* Opaque table entries are counted once in a running sum, so asking for a range of values costs two look-ups.

use super::TransferTable;
use crate::math::{Interval, Viewpoint};
use crate::target::{CELL, CellRanges, Cube, OctreeNode, Target, octants_back_to_front};

/// The values that are not invisible.
#[derive(Clone, Debug, PartialEq)]
pub struct VisibleValues {
    value_range: Interval,
    /// `visible_before[i]` counts the opaque table entries before entry `i`; `None` when every value shows.
    visible_before: Option<Vec<u32>>,
}

impl VisibleValues {
    /// Every value shows (maximum, minimum and average projections).
    pub fn all(value_range: Interval) -> Self {
        Self {
            value_range,
            visible_before: None,
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
            value_range,
            visible_before: Some(visible_before),
        }
    }

    /// Whether a value in `range` can show. An entry on each side counts too, for the rounding of stored values.
    pub fn any_in(&self, range: Interval) -> bool {
        if range.is_empty() {
            return false;
        }
        let Some(visible_before) = &self.visible_before else {
            return true;
        };
        let last = TransferTable::LEN - 1;
        let entry = |v: f32| {
            let width = self.value_range.width().max(f32::MIN_POSITIVE);
            ((v - self.value_range.lo) / width).clamp(0.0, 1.0) * last as f32
        };
        let first = (entry(range.lo).floor() as usize).saturating_sub(1);
        let end = (entry(range.hi).ceil() as usize + 2).min(last + 1);
        visible_before[end] > visible_before[first]
    }
}

/// What is drawn of a target: whole octree cubes inside its blocks.
pub struct Visibility<'a> {
    /// The subdivision.
    pub target: &'a Target,
    /// The cells of each block.
    pub cells: &'a [CellRanges],
    /// What shows.
    pub values: &'a VisibleValues,
    /// Edge of the smallest cubes that are drawn apart, a power of two of at least [`CELL`] voxels.
    pub min_cube: usize,
}

impl Visibility<'_> {
    /// The visible cubes with the index of their block, from back to front. Eight visible octants of one block are one cube.
    pub fn cubes_back_to_front(&self, viewpoint: Viewpoint) -> Vec<(u32, Cube)> {
        let mut found = Vec::new();
        self.visit(0, self.target.octree.root, viewpoint, &mut found);
        found
    }

    fn visit(&self, node: usize, cube: Cube, viewpoint: Viewpoint, found: &mut Vec<(u32, Cube)>) {
        match self.target.octree.nodes[node] {
            OctreeNode::Empty => {}
            OctreeNode::Block(block) => {
                self.visit_block(block, cube, viewpoint, found);
            }
            OctreeNode::Split(first) => {
                for octant in octants_back_to_front(&cube, viewpoint) {
                    let node = first as usize + octant;
                    self.visit(node, cube.octant(octant), viewpoint, found);
                }
            }
        }
    }

    /// Adds the visible cubes of `cube`, a part of `block`; whether all of it shows.
    fn visit_block(
        &self,
        block: u32,
        cube: Cube,
        viewpoint: Viewpoint,
        found: &mut Vec<(u32, Cube)>,
    ) -> bool {
        if cube.extent(self.target.lattice.dims).contains(&0) {
            return true;
        }
        if cube.size <= self.min_cube.max(CELL) {
            let visible = self.any_cell(block, &cube);
            if visible {
                found.push((block, cube));
            }
            return visible;
        }
        let begin = found.len();
        let mut full = true;
        for octant in octants_back_to_front(&cube, viewpoint) {
            full &= self.visit_block(block, cube.octant(octant), viewpoint, found);
        }
        if full {
            found.truncate(begin);
            found.push((block, cube));
        }
        full
    }

    fn any_cell(&self, block: u32, cube: &Cube) -> bool {
        let origin = self.target.blocks[block as usize].origin;
        let cells = &self.cells[block as usize];
        let first: [usize; 3] = std::array::from_fn(|a| (cube.origin[a] - origin[a]) / CELL);
        let last: [usize; 3] =
            std::array::from_fn(|a| (first[a] + cube.size.div_ceil(CELL)).min(cells.dims[a]));
        (first[2]..last[2]).any(|z| {
            (first[1]..last[1])
                .any(|y| (first[0]..last[0]).any(|x| self.values.any_in(cells.range([x, y, z]))))
        })
    }
}
