//! How the parts of a block that show become as few boxes as pay.
//!
//! *Theory.* A k-d tree. A box is drawn in to what shows of it, and split by that plane of whose two sides, each drawn in likewise, the
//! boxes are cheapest to draw; parts that do not show are drawn with the rest where splitting is no cheaper. So do Vidal, Mei and
//! Decaudin (*Simple empty-space removal for interactive volume rendering*, journal of graphics tools 13(2), 2008), whose cost is the
//! volume of boxes where ours is what drawing them takes.
//! *Changes from the paper.* VCSG draws blocks whole.
//! *Practice.* What shows is a bit a cell, 64 cells to a word, so that all planes of all axes are asked in one pass over the words. The
//! farther side of a plane always comes first, so the boxes are in order.

use super::DrawCost;
use crate::math::{Aabb, Viewpoint};
use crate::target::{Cube, VoxelBox};

/// Cells along each axis of a grid at most.
const MOST_CELLS: usize = u64::BITS as usize;

/// A box that is drawn, and the block that holds its voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VisibleBox {
    /// Index of the block.
    pub block: u32,
    /// First voxel in the lattice.
    pub origin: [usize; 3],
    /// Voxels along each axis, at least 1.
    pub extent: [usize; 3],
}

impl VisibleBox {
    /// The box of its cells in lattice coordinates.
    pub fn bounds(&self) -> Aabb {
        let Self { origin, extent, .. } = *self;
        VoxelBox { origin, extent }.bounds()
    }
}

/// Which cells of a cube show.
pub(super) struct ShownGrid {
    cube: Cube,
    /// Edge of a cell, voxels.
    cell: usize,
    /// Cells along each axis.
    count: usize,
    /// A word a row along x, of which bit `x` says that cell `x` shows; rows along y first.
    rows: Vec<u64>,
}

impl ShownGrid {
    /// Nothing of `cube`, in cells with an edge of `least` voxels, a power of two: of more if the cube is too large for that, and of no
    /// more than it has.
    pub fn empty(cube: Cube, least: usize) -> Self {
        let cell = least.max(cube.size / MOST_CELLS).min(cube.size);
        let count = cube.size / cell;
        Self {
            cube,
            cell,
            count,
            rows: vec![0; count * count],
        }
    }

    /// Edge of a cell, voxels.
    pub fn cell(&self) -> usize {
        self.cell
    }

    /// Notes that the cell with this first voxel shows.
    pub fn show(&mut self, origin: [i64; 3]) {
        let [x, y, z] = [0, 1, 2].map(|a| (origin[a] - self.cube.origin[a]) as usize / self.cell);
        self.rows[y + self.count * z] |= 1 << x;
    }

    /// The cells of `part` that show, plane by plane along each axis.
    fn profile(&self, part: &Part) -> Profile {
        let mut profile = Profile::new(part);
        let width = part.high[0] - part.low[0];
        let mask = (u64::MAX >> (MOST_CELLS - width)) << part.low[0];
        for z in part.low[2]..part.high[2] {
            for y in part.low[1]..part.high[1] {
                profile.add_row(self.rows[y + self.count * z] & mask, y, z);
            }
        }
        profile
    }
}

/// A box of cells: its first cells, and those behind its last ones. Nothing is in one whose first are not before its last.
#[derive(Clone, Copy)]
struct Part {
    low: [usize; 3],
    high: [usize; 3],
}

impl Part {
    const NOTHING: Self = Self {
        low: [usize::MAX; 3],
        high: [0; 3],
    };

    fn is_nothing(&self) -> bool {
        self.high[0] == 0
    }

    /// The box round both.
    fn hull(&self, other: &Self) -> Self {
        Self {
            low: std::array::from_fn(|a| self.low[a].min(other.low[a])),
            high: std::array::from_fn(|a| self.high[a].max(other.high[a])),
        }
    }

    fn cells(&self) -> usize {
        (0..3).map(|a| self.high[a] - self.low[a]).product()
    }
}

/// What shows of a part.
struct Profile {
    /// The first plane along each axis.
    first: [usize; 3],
    /// The box round the cells of each plane along each axis.
    planes: [Vec<Part>; 3],
    /// How many cells show.
    cells: usize,
}

impl Profile {
    fn new(part: &Part) -> Self {
        Self {
            first: part.low,
            planes: std::array::from_fn(|a| vec![Part::NOTHING; part.high[a] - part.low[a]]),
            cells: 0,
        }
    }

    /// Adds the cells of a row along x.
    fn add_row(&mut self, mut row: u64, y: usize, z: usize) {
        if row == 0 {
            return;
        }
        self.cells += row.count_ones() as usize;
        let part = |low: usize, high: usize| Part {
            low: [low, y, z],
            high: [high, y + 1, z + 1],
        };
        let all = part(row.trailing_zeros() as usize, MOST_CELLS - row.leading_zeros() as usize);
        for (axis, at) in [(1, y), (2, z)] {
            self.add(axis, at, &all);
        }
        while row != 0 {
            let x = row.trailing_zeros() as usize;
            self.add(0, x, &part(x, x + 1));
            row &= row - 1;
        }
    }

    fn add(&mut self, axis: usize, at: usize, part: &Part) {
        let plane = &mut self.planes[axis][at - self.first[axis]];
        *plane = plane.hull(part);
    }

    /// The box round all.
    fn hull(&self) -> Part {
        self.planes[2].iter().fold(Part::NOTHING, |all, plane| all.hull(plane))
    }

    /// The boxes on the low and the high side of each plane between cells that show, with the plane's axis.
    fn splits(&self) -> impl Iterator<Item = (usize, [Part; 2])> {
        (0..3).flat_map(|axis| {
            let planes = &self.planes[axis];
            let mut above = vec![Part::NOTHING; planes.len()];
            for n in (1..planes.len()).rev() {
                let beyond = above.get(n + 1).copied().unwrap_or(Part::NOTHING);
                above[n] = beyond.hull(&planes[n]);
            }
            let below = planes.iter().scan(Part::NOTHING, |below, plane| {
                *below = below.hull(plane);
                Some(*below)
            });
            let sides = below.zip(above.into_iter().skip(1));
            sides
                .filter(|(below, above)| !below.is_nothing() && !above.is_nothing())
                .map(move |(below, above)| (axis, [below, above]))
        })
    }
}

/// Splits what shows of a block.
pub(super) struct Splitter<'a> {
    pub block: u32,
    /// What shows.
    pub grid: &'a ShownGrid,
    /// Of the lattice.
    pub dims: [usize; 3],
    pub cost: &'a DrawCost,
    /// In lattice coordinates.
    pub viewpoint: Viewpoint,
}

impl Splitter<'_> {
    /// Adds the boxes that are drawn, from back to front.
    pub fn split(&self, boxes: &mut Vec<VisibleBox>) {
        let all = Part {
            low: [0; 3],
            high: [self.grid.count; 3],
        };
        self.add(&all, boxes);
    }

    /// Adds the boxes that are drawn of `part`, and tells what they cost.
    fn add(&self, part: &Part, boxes: &mut Vec<VisibleBox>) -> f64 {
        let profile = self.grid.profile(part);
        if profile.cells == 0 {
            return 0.0;
        }
        let hull = profile.hull();
        let whole = self.voxels(&hull);
        let whole_cost = self.cost.of(whole.extent);
        let begin = boxes.len();
        if self.may_pay(&hull, profile.cells)
            && let Some((axis, sides)) = self.cheapest(&profile)
        {
            let sides = self.back_to_front(axis, sides);
            let cost: f64 = sides.iter().map(|side| self.add(side, boxes)).sum();
            if cost < whole_cost {
                return cost;
            }
            boxes.truncate(begin);
        }
        boxes.push(VisibleBox {
            block: self.block,
            origin: whole.origin,
            extent: whole.extent,
        });
        whole_cost
    }

    /// Whether what does not show of `part`, of which so many cells do, costs more than its two halves cost beside it.
    fn may_pay(&self, part: &Part, shown: usize) -> bool {
        let hidden = (part.cells() - shown) * self.grid.cell.pow(3);
        let extent = self.voxels(part).extent;
        let whole = self.cost.of(extent);
        let beside = (0..3).map(|axis| {
            let mut half = extent;
            half[axis] = extent[axis].div_ceil(2);
            2.0 * self.cost.of(half) - whole
        });
        self.cost.of_voxels(hidden) > beside.fold(f64::INFINITY, f64::min).max(0.0)
    }

    /// The split whose sides are cheapest.
    fn cheapest(&self, profile: &Profile) -> Option<(usize, [Part; 2])> {
        let cost = |sides: &[Part; 2]| -> f64 { sides.iter().map(|side| self.cost.of(self.voxels(side).extent)).sum() };
        let splits = profile.splits().map(|(axis, sides)| (cost(&sides), axis, sides));
        let cheapest = splits.min_by(|a, b| a.0.total_cmp(&b.0));
        cheapest.map(|(_, axis, sides)| (axis, sides))
    }

    /// The sides of a plane across `axis`, the farther one first.
    fn back_to_front(&self, axis: usize, [low, high]: [Part; 2]) -> [Part; 2] {
        // In lattice coordinates a voxel is a cube of edge 1 round its place.
        let plane = (self.grid.cube.origin[axis] + (self.grid.cell * high.low[axis]) as i64) as f64 - 0.5;
        let towards = match self.viewpoint {
            Viewpoint::Direction(towards) => towards[axis],
            Viewpoint::Point(eye) => eye[axis] - plane,
        };
        if towards <= 0.0 { [high, low] } else { [low, high] }
    }

    /// The lattice's voxels in a part.
    fn voxels(&self, part: &Part) -> VoxelBox {
        let grid = self.grid;
        let origin = std::array::from_fn(|a| grid.cube.origin[a] + (grid.cell * part.low[a]) as i64);
        let edges = std::array::from_fn(|a| grid.cell * (part.high[a] - part.low[a]));
        VoxelBox::clipped(origin, edges, self.dims)
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, dvec3};
    use proptest::prelude::*;

    use super::*;

    const CELL: usize = 4;

    /// A cube of 8 cells along each axis, whose first voxel is the lattice's.
    const CUBE: Cube = Cube {
        origin: [0; 3],
        size: 8 * CELL,
    };

    fn grid(shown: &[[usize; 3]]) -> ShownGrid {
        let mut grid = ShownGrid::empty(CUBE, CELL);
        let voxel = |cell: &[usize; 3]| cell.map(|n| (n * CELL) as i64);
        shown.iter().for_each(|cell| grid.show(voxel(cell)));
        grid
    }

    /// The boxes in cells: the first ones, and those behind the last ones.
    fn boxes(shown: &[[usize; 3]], dims: [usize; 3], cost: &DrawCost, viewpoint: Viewpoint) -> Vec<[[usize; 3]; 2]> {
        let mut boxes = Vec::new();
        let splitter = Splitter {
            block: 0,
            grid: &grid(shown),
            dims,
            cost,
            viewpoint,
        };
        splitter.split(&mut boxes);
        let ends = |b: &VisibleBox| {
            let high: [usize; 3] = std::array::from_fn(|a| (b.origin[a] + b.extent[a]).div_ceil(CELL));
            [b.origin.map(|n| n / CELL), high]
        };
        boxes.iter().map(ends).collect()
    }

    #[test]
    fn a_cube_smaller_than_a_cell_is_drawn_alone() {
        let cube = Cube {
            origin: [4, 0, 8],
            size: 4,
        };
        let mut grid = ShownGrid::empty(cube, 8);
        grid.show(cube.origin);
        let mut boxes = Vec::new();
        let splitter = Splitter {
            block: 0,
            grid: &grid,
            dims: [32; 3],
            cost: &DrawCost::VOXELS,
            viewpoint: ALONG_X,
        };
        splitter.split(&mut boxes);
        let drawn: Vec<_> = boxes.iter().map(|b| (b.origin, b.extent)).collect();
        assert_eq!(drawn, [([4, 0, 8], [4; 3])]);
    }

    const ALONG_X: Viewpoint = Viewpoint::Direction(DVec3::X);

    #[test]
    fn a_gap_is_drawn_where_another_box_costs_more() {
        let row = [[0, 2, 3], [1, 2, 3], [5, 2, 3]];
        let drawn = |cost: &DrawCost| boxes(&row, [8 * CELL; 3], cost, ALONG_X);
        assert_eq!(
            drawn(&DrawCost::VOXELS),
            [[[0, 2, 3], [2, 3, 4]], [[5, 2, 3], [6, 3, 4]]],
            "the farther one first"
        );
        // Of the gap's 3·4³ voxels each costs a fragment. Slices lie along x alone, so the row's cost 6·4 of so many fragments, and those of its
        // two parts 3·4 of them. Of slices along y, the row has 4 and its parts have 8.
        let along_x = DrawCost::VOXELS.with_slices(DVec3::X);
        assert_eq!(drawn(&along_x).len(), 2);
        let along_y =
            |slices: f64| drawn(&DrawCost::VOXELS.with_slices(dvec3(0.0, slices / DrawCost::SLICE, 0.0))).len();
        let gap = (3 * CELL.pow(3)) as f64;
        assert_eq!([0.99, 1.01].map(|part| along_y(part * gap / CELL as f64)), [2, 1]);
    }

    /// Whether `b` is not drawn after what it hides as seen from `viewpoint`: there is a plane between them, on whose farther side `a` is.
    fn may_follow(a: &[[usize; 3]; 2], b: &[[usize; 3]; 2], viewpoint: Viewpoint) -> bool {
        (0..3).any(|axis| {
            let towards = |plane: usize| match viewpoint {
                Viewpoint::Direction(towards) => towards[axis],
                Viewpoint::Point(eye) => eye[axis] - ((plane * CELL) as f64 - 0.5),
            };
            let (a, b) = ([a[0][axis], a[1][axis]], [b[0][axis], b[1][axis]]);
            a[1] <= b[0] && towards(a[1]) >= 0.0 || b[1] <= a[0] && towards(a[0]) <= 0.0
        })
    }

    fn cells() -> impl Strategy<Value = Vec<[usize; 3]>> {
        prop::collection::vec(prop::array::uniform3(0usize..8), 0..80)
    }

    fn viewpoint() -> impl Strategy<Value = Viewpoint> {
        let place = prop::array::uniform3(-40.0f64..70.0).prop_map(DVec3::from);
        let step = prop::array::uniform3(-1i32..2).prop_map(|d| DVec3::from_array(d.map(f64::from)));
        prop_oneof![place.prop_map(Viewpoint::Point), step.prop_map(Viewpoint::Direction)]
    }

    proptest! {
        #[test]
        fn each_cell_that_shows_is_in_one_box_and_farther_boxes_come_first(
            shown in cells(),
            viewpoint in viewpoint(),
            slices in prop::array::uniform3(0.0f64..0.02),
            dims in prop::array::uniform3(29usize..33),
        ) {
            let cost = DrawCost::VOXELS.with_slices(slices.into());
            let boxes = boxes(&shown, dims, &cost, viewpoint);
            let holders = |cell: &[usize; 3]| boxes.iter().filter(|[low, high]| (0..3).all(|a| (low[a]..high[a]).contains(&cell[a]))).count();
            for n in 0..512 {
                let cell = [n % 8, n / 8 % 8, n / 64];
                let held = holders(&cell);
                prop_assert!(if shown.contains(&cell) { held == 1 } else { held <= 1 }, "{:?} is in {} boxes", cell, held);
            }
            for (n, b) in boxes.iter().enumerate() {
                for axis in 0..3 {
                    let on_face = |at: usize| shown.iter().any(|cell| cell[axis] == at && (0..3).all(|a| (b[0][a]..b[1][a]).contains(&cell[a])));
                    prop_assert!(on_face(b[0][axis]) && on_face(b[1][axis] - 1), "{:?} is too large along {}", b, axis);
                }
                prop_assert!(boxes[..n].iter().all(|a| may_follow(a, b, viewpoint)), "{:?} comes too late", b);
            }
        }

        #[test]
        fn boxes_cost_no_more_than_one_and_of_voxels_alone_hold_nothing_else(shown in cells(), slices in prop::array::uniform3(0.0f64..0.02)) {
            let voxels = |boxes: &[[[usize; 3]; 2]]| -> usize { boxes.iter().map(|[low, high]| (0..3).map(|a| high[a] - low[a]).product::<usize>()).sum() };
            let mut distinct = shown.clone();
            distinct.sort_unstable();
            distinct.dedup();
            let dims = [8 * CELL; 3];
            prop_assert_eq!(voxels(&boxes(&shown, dims, &DrawCost::VOXELS, ALONG_X)), distinct.len());
            let cost = DrawCost::VOXELS.with_slices(slices.into());
            let of = |boxes: &[[[usize; 3]; 2]]| -> f64 { boxes.iter().map(|[low, high]| cost.of(std::array::from_fn(|a| CELL * (high[a] - low[a])))).sum() };
            let drawn = boxes(&shown, dims, &cost, ALONG_X);
            let hull = drawn.iter().copied().reduce(|a, b| [std::array::from_fn(|n| a[0][n].min(b[0][n])), std::array::from_fn(|n| a[1][n].max(b[1][n]))]);
            // Sums of at most 80 numbers each, all positive.
            prop_assert!(of(&drawn) <= of(hull.as_slice()) * (1.0 + 160.0 * f64::EPSILON));
        }
    }
}
