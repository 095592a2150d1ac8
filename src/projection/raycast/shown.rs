//! What shows of blocks.
//!
//! *Practice.* Cells whose [ranges](CellRanges) show are looked into: of their halves along each axis, ranges come of the stored voxels
//! themselves. All is found when the transfer function changes, not in a frame.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::gaps::Gaps;
use super::voxels::{CastBlock, CastTarget, ONE};
use crate::math::{Aabb, Interval};
use crate::projection::VisibleValues;
use crate::target::{CELL, CellRanges, Target};

/// The shortest edge of cells, voxels.
const SHORTEST: usize = CELL / 2;

/// What shows of a block.
pub struct ShownBlock {
    /// The box of all that shows, in lattice coordinates.
    pub bounds: Aabb,
    /// Where in it nothing does.
    pub gaps: Gaps,
}

/// Which cells of a block show.
#[derive(Debug)]
pub struct Cells {
    /// Voxels along a cell's edge, a power of two.
    pub edge: usize,
    /// The low corner of the first cell, in stored voxels.
    pub begin: DVec3,
    /// Cells along each axis.
    pub dims: [usize; 3],
    /// Whether anything shows of each, x fastest.
    pub shown: Vec<bool>,
}

/// The edge of the smallest cells that no packet of such an extent is larger than, voxels.
pub fn edge_for(extent: f64) -> usize {
    /// That of the longest lattice there can be.
    const LONGEST: f64 = (1u32 << 30) as f64;
    (extent.min(LONGEST).ceil() as usize).next_power_of_two().max(SHORTEST)
}

impl ShownBlock {
    /// What shows of each block of a target if `values` do, in cells with an `edge` of so many voxels; `None` of a block of which nothing
    /// does.
    pub fn all(target: &Target, cast: &CastTarget, values: &VisibleValues, edge: usize) -> Vec<Option<Self>> {
        let range = target.value_range;
        let of = |n: usize| {
            let stored = &cast.blocks[n];
            let first = DVec3::from_array(stored.first.map(f64::from));
            let mut cells = Cells::of_ranges(&cast.cells[n], values, cast.cells[n].begin(&target.lattice) - first);
            if edge < CELL && stored.is_looked_into() {
                cells = cells.halved(stored, values, range);
            }
            while cells.edge < edge {
                cells = cells.doubled();
            }
            let bounds = cells.bounds()?;
            Some(Self {
                bounds: Aabb::new(bounds.min + first, bounds.max + first).intersect(&target.blocks[n].bounds()),
                gaps: Gaps::new(&cells),
            })
        };
        (0..cast.blocks.len()).into_par_iter().map(of).collect()
    }
}

impl Cells {
    /// Those of `ranges`, from `begin` on.
    fn of_ranges(ranges: &CellRanges, values: &VisibleValues, begin: DVec3) -> Self {
        Self {
            edge: CELL,
            begin,
            dims: ranges.dims,
            shown: ranges.ranges.par_iter().map(|range| values.any_in(*range)).collect(),
        }
    }

    /// The place of a cell.
    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.dims[0] * (y + self.dims[1] * z)
    }

    /// Cells half as long of `block`. They begin at voxels, half a voxel before these do, so that as few voxels as can be are samples in them
    /// between.
    fn halved(&self, block: &CastBlock, values: &VisibleValues, range: Interval) -> Self {
        let (edge, begin) = (self.edge / 2, self.begin - 0.5);
        let dims = self.dims.map(|n| 2 * n + 1);
        // The voxels that a cell's samples are between.
        let voxels = |axis: usize, cell: usize| {
            let begin = begin[axis] as i64 + (edge * cell) as i64;
            let within = |voxel: i64| voxel.clamp(0, i64::from(block.dims[axis])) as usize;
            within(begin)..within(begin + edge as i64 + 1)
        };
        // The whole cells that a half is in.
        let wholes = |axis: usize, half: usize| half.saturating_sub(1) / 2..(half / 2 + 1).min(self.dims[axis]);
        let value = |stored: i16| range.lo + f32::from(stored) / ONE * range.width();
        let mut shown = vec![false; dims.iter().product()];
        let rows = shown.par_chunks_exact_mut(dims[0]).enumerate();
        rows.for_each_init(Ends::default, |ends, (row, shown)| {
            let [y, z] = [row % dims[1], row / dims[1]];
            let whole = self.any_of_rows([wholes(1, y), wholes(2, z)]);
            if !whole.contains(&true) {
                return;
            }
            ends.of_rows(block, [voxels(1, y), voxels(2, z)]);
            for (x, shown) in shown.iter_mut().enumerate() {
                if whole[wholes(0, x)].contains(&true) {
                    let [lo, hi] = ends.of(voxels(0, x)).map(value);
                    *shown = values.any_in(Interval { lo, hi });
                }
            }
        });
        Self {
            edge,
            begin,
            dims,
            shown,
        }
    }

    /// Which cells of a row show, of any of some rows along y and z.
    fn any_of_rows(&self, [y, z]: [Range<usize>; 2]) -> Vec<bool> {
        let mut any = vec![false; self.dims[0]];
        for [y, z] in z.flat_map(|z| y.clone().map(move |y| [y, z])) {
            let row = &self.shown[self.index([0, y, z])..][..self.dims[0]];
            any.iter_mut().zip(row).for_each(|(any, shown)| *any |= shown);
        }
        any
    }

    /// Two along each axis taken for one.
    fn doubled(&self) -> Self {
        let mut doubled = Self {
            edge: 2 * self.edge,
            begin: self.begin,
            dims: self.dims.map(|n| n.div_ceil(2)),
            shown: Vec::new(),
        };
        doubled.shown = vec![false; doubled.dims.iter().product()];
        self.each_shown(|cell| {
            let at = doubled.index(cell.map(|n| n / 2));
            doubled.shown[at] = true;
        });
        doubled
    }

    /// Calls `f` with each cell that shows.
    fn each_shown(&self, mut f: impl FnMut([usize; 3])) {
        for (row, shown) in self.shown.chunks_exact(self.dims[0].max(1)).enumerate() {
            for x in (0..shown.len()).filter(|x| shown[*x]) {
                f([x, row % self.dims[1], row / self.dims[1]]);
            }
        }
    }

    /// The box of those that show, in stored voxels, if any does.
    fn bounds(&self) -> Option<Aabb> {
        let (mut first, mut end) = (self.dims, [0; 3]);
        self.each_shown(|cell| {
            for axis in 0..3 {
                first[axis] = first[axis].min(cell[axis]);
                end[axis] = end[axis].max(cell[axis] + 1);
            }
        });
        let corner = |cell: [usize; 3]| self.begin + self.edge as f64 * DVec3::from_array(cell.map(|n| n as f64));
        (end != [0; 3]).then(|| Aabb::new(corner(first), corner(end)))
    }
}

/// The least and the greatest of what is stored of values in several rows, voxel by voxel.
#[derive(Default)]
struct Ends {
    lo: Vec<i16>,
    hi: Vec<i16>,
}

impl Ends {
    /// Those of some rows of `block`, along y and z.
    fn of_rows(&mut self, block: &CastBlock, [y, z]: [Range<usize>; 2]) {
        let [width, height, _] = block.dims.map(|n| n as usize);
        for (ends, least) in [(&mut self.lo, i16::MAX), (&mut self.hi, i16::MIN)] {
            ends.clear();
            ends.resize(width, least);
        }
        for row in z.flat_map(|z| y.clone().map(move |y| y + height * z)) {
            let ends = self.lo.iter_mut().zip(&mut self.hi);
            for ((lo, hi), &v) in ends.zip(&block.weighted[width * row..][..width]) {
                (*lo, *hi) = ((*lo).min(v), (*hi).max(v));
            }
        }
    }

    /// Those of some voxels of a row; an end below the other if there are none.
    fn of(&self, voxels: Range<usize>) -> [i16; 2] {
        let lo = self.lo[voxels.clone()].iter().copied().fold(i16::MAX, i16::min);
        [lo, self.hi[voxels].iter().copied().fold(i16::MIN, i16::max)]
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::array::Array;
    use crate::projection::{ControlPoint, TransferFunction, TransferTable};

    const RANGE: Interval = Interval { lo: 0.0, hi: 1.0 };

    /// Values from the middle of the range on show.
    fn upper_half() -> VisibleValues {
        let point = |(value, opacity)| ControlPoint {
            value,
            color: [1.0; 3],
            opacity,
        };
        let points = [(0.0, 0.0), (0.4, 0.0), (0.5, 1.0), (1.0, 1.0)].map(point);
        let function = TransferFunction::new(points.to_vec(), 1.0).unwrap();
        VisibleValues::of(&TransferTable::new(&function, RANGE, 1.0), RANGE)
    }

    /// A block of such voxels, the largest values and the least.
    fn block(dims: [usize; 3], large: &[bool]) -> CastBlock {
        let weighted: Vec<i16> = large.iter().map(|large| if *large { ONE as i16 } else { 0 }).collect();
        CastBlock {
            first: [0; 3],
            strides: [dims[0], dims[0] * dims[1]],
            dims: dims.map(|n| n as i32),
            weighted: weighted.into(),
            coverage: Array::default(),
            rgb: Default::default(),
            normals: Array::default(),
        }
    }

    fn blocks() -> impl Strategy<Value = ([usize; 3], Vec<bool>)> {
        prop::array::uniform3(4usize..10).prop_flat_map(|dims| {
            let large = prop::collection::vec(prop::bool::weighted(0.03), dims.iter().product::<usize>());
            (Just(dims), large)
        })
    }

    proptest! {
        /// Half a cell shows if and only if any of the voxels does that samples in it are between.
        #[test]
        fn halves_show_what_their_samples_are_between((dims, large) in blocks(), before in prop::array::uniform3(0usize..4)) {
            let wholes = [0, 1, 2].map(|axis| (dims[axis] + before[axis]).div_ceil(CELL));
            let cells = Cells {
                edge: CELL,
                begin: DVec3::from_array(before.map(|n| -(n as f64) - 0.5)),
                dims: wholes,
                shown: vec![true; wholes.iter().product()],
            };
            let halves = cells.halved(&block(dims, &large), &upper_half(), RANGE);
            for (n, shown) in halves.shown.iter().enumerate() {
                let half = [n % halves.dims[0], n / halves.dims[0] % halves.dims[1], n / halves.dims[0] / halves.dims[1]];
                let between = (0..large.len()).filter(|n| large[*n]).any(|n| {
                    let voxel = [n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]];
                    (0..3).all(|axis| {
                        let from_begin = voxel[axis] as f64 - (halves.begin[axis] + (halves.edge * half[axis]) as f64);
                        // Those before the end and the next one, on which samples close to the end depend.
                        from_begin > -1.0 && from_begin < halves.edge as f64 + 1.0
                    })
                });
                prop_assert_eq!(*shown, between, "half {:?}", half);
            }
        }
    }
}
