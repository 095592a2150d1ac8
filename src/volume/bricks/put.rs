//! A piece of a volume put in bricks.
//!
//! *Practice.* A brick holds one value until a voxel differs from it. Then it gets room for all voxels: those that may have come have
//! that value, the others are zeros until they come.

use std::ops::Range;

use rayon::prelude::*;

use super::typed::{Brick, EDGE, SHIFT, TypedBricks, Y_STRIDE, Z_STRIDE};
use crate::volume::grid::Region;
use crate::volume::voxel::Voxel;

/// What the voxels of a region are.
#[derive(Clone, Copy)]
pub(super) enum Values<'a, T> {
    /// These, x fastest.
    Each(&'a [T]),
    /// All this.
    All(T),
}

/// In which order pieces come.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    /// That of the grid: before a voxel come those before it.
    Grid,
    /// Any.
    Any,
}

impl<T: Voxel> TypedBricks<T> {
    /// [`Self::put`] of regions, each of a part of `voxels`.
    pub(super) fn put_each(&mut self, parts: &[(Region, Range<usize>)], order: Order, voxels: &[T]) -> usize {
        let parts = parts
            .iter()
            .map(|(region, range)| (*region, Values::Each(&voxels[range.clone()])));
        self.put(&parts.collect::<Vec<_>>(), order)
    }

    /// Puts the voxels of regions, one after the other, in the bricks that they touch: in their own, and in those before it whose
    /// aprons they are. How many bytes were allocated for them.
    pub(super) fn put(&mut self, parts: &[(Region, Values<T>)], order: Order) -> usize {
        let dims = self.dims();
        let touched = |a: usize| {
            let each = parts.iter().map(|(region, _)| touched(region, a));
            each.reduce(|p, q| p.start.min(q.start)..p.end.max(q.end))
                .unwrap_or(0..0)
        };
        self.part([touched(0), touched(1), touched(2)])
            .map(|(b, brick)| {
                let pieces = parts
                    .iter()
                    .filter_map(|(region, values)| Piece::new(b, dims, region, order, *values));
                pieces.map(|piece| brick.put(&piece)).sum::<usize>()
            })
            .sum()
    }
}

/// The places of the bricks along an axis that a region touches.
fn touched(region: &Region, axis: usize) -> Range<usize> {
    let last = region.first[axis] + region.size[axis] - 1;
    region.first[axis].saturating_sub(1) >> SHIFT..(last >> SHIFT) + 1
}

/// What is put in a brick.
struct Piece<'a, T> {
    /// Where the region meets the brick.
    overlaps: [Overlap; 3],
    /// The brick's planes.
    planes: usize,
    /// The region's size.
    size: [usize; 3],
    order: Order,
    values: Values<'a, T>,
}

/// Where a region and a brick meet, along an axis.
struct Overlap {
    /// The places in the brick, apron and volume's end included.
    places: Range<usize>,
    /// The voxel of the region at the first place.
    start: usize,
    /// The last voxel of the region; it is repeated at the places beyond the volume's end.
    last: usize,
}

impl Overlap {
    /// The overlap of the brick at place `b` of an axis of `dim` voxels with `size` voxels from `first` on.
    fn new(b: usize, dim: usize, first: usize, size: usize) -> Self {
        let brick = b << SHIFT;
        let start = first.saturating_sub(brick);
        let end = match first + size == dim {
            true => Y_STRIDE,
            false => Y_STRIDE.min(first + size - brick),
        };
        Self {
            places: start..end,
            start: brick.saturating_sub(first),
            last: size - 1,
        }
    }

    /// Each place, and the voxel of the region there.
    fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let voxels = self.start..;
        self.places.clone().zip(voxels.map(|v| v.min(self.last)))
    }
}

impl<'a, T> Piece<'a, T> {
    /// The values of `region` in the brick at place `b` of a grid of `dims`; `None` where it does not touch it.
    fn new(b: [usize; 3], dims: [usize; 3], region: &Region, order: Order, values: Values<'a, T>) -> Option<Self> {
        (0..3).all(|a| touched(region, a).contains(&b[a])).then(|| {
            let overlap = |a: usize| Overlap::new(b[a], dims[a], region.first[a], region.size[a]);
            // At the volume's end the last voxels are repeated when they come, which may be before others.
            let is_in_order = order == Order::Grid && (1..3).all(|a| (b[a] + 1) << SHIFT < dims[a]);
            Self {
                overlaps: [overlap(0), overlap(1), overlap(2)],
                planes: EDGE.min(dims[2] - (b[2] << SHIFT)) + 1,
                size: region.size,
                order: if is_in_order { Order::Grid } else { Order::Any },
                values,
            }
        })
    }

    /// The rows of the region in the brick, in the order of their places: those, and the voxels there.
    fn rows(&self) -> impl Iterator<Item = (Range<usize>, &[T])> {
        let [x, y, z] = &self.overlaps;
        let planes = z.pairs().take_while(|(plane, _)| *plane < self.planes);
        planes.flat_map(move |(plane, k)| {
            y.pairs().map(move |(row, j)| {
                let start = plane * Z_STRIDE + row * Y_STRIDE;
                (start + x.places.start..start + x.places.end, self.row(j, k))
            })
        })
    }

    /// The voxels of row `j` of slice `k` of the region, as far as the brick has places for them.
    fn row(&self, j: usize, k: usize) -> &[T] {
        let x = &self.overlaps[0];
        let voxels = match &self.values {
            Values::Each(all) => &all[(k * self.size[1] + j) * self.size[0]..][x.start..self.size[0]],
            Values::All(value) => std::slice::from_ref(value),
        };
        &voxels[..voxels.len().min(x.places.len())]
    }
}

impl<T: Voxel> Brick<T> {
    /// Puts a piece in it. How many bytes were allocated.
    fn put(&mut self, piece: &Piece<T>) -> usize {
        if let Values::All(value) = piece.values
            && self.is_all(&[value])
        {
            return 0;
        }
        let mut allocated = 0;
        // What comes first comes in order.
        let order = if self.is_empty() { Order::Grid } else { piece.order };
        let mut rows = piece.rows();
        if !self.has_room() {
            let Some((places, voxels)) = rows.find(|(_, voxels)| !self.is_all(voxels)) else {
                return 0;
            };
            allocated = self.make_room(piece.planes, order, places.start);
            self.put_rows(std::iter::once((places, voxels)));
        }
        self.put_rows(rows);
        allocated
    }

    /// Whether there is room for all its voxels.
    fn has_room(&self) -> bool {
        matches!(self, Self::Voxels(v) if !v.is_empty())
    }

    /// Whether all voxels that have come and `voxels` are one value; then that is held.
    fn is_all(&mut self, voxels: &[T]) -> bool {
        if self.is_empty() {
            *self = Self::Constant(voxels[0].regular());
        }
        let Self::Constant(value) = *self else {
            return false;
        };
        match value.to_f64().is_nan() {
            true => voxels.iter().all(|v| v.regular().to_f64().is_nan()),
            // Every voxel is looked at, which is quicker than to stop at one that differs.
            false => voxels.iter().fold(true, |all, v| all & (v.regular() == value)),
        }
    }

    /// Makes room for all voxels, if there is none, before one is put at `place`. How many bytes were allocated.
    fn make_room(&mut self, planes: usize, order: Order, place: usize) -> usize {
        let Self::Constant(value) = *self else {
            return 0;
        };
        let mut voxels = vec![T::zeroed(); planes * Z_STRIDE].into_boxed_slice();
        match order {
            Order::Grid => voxels[..place].fill(value),
            Order::Any => voxels.fill(value),
        }
        let allocated = size_of_val(&*voxels);
        *self = Self::Voxels(voxels);
        allocated
    }

    /// Puts rows of voxels, the last one repeated, in places for which there is room.
    fn put_rows<'a>(&mut self, rows: impl Iterator<Item = (Range<usize>, &'a [T])>) {
        let Self::Voxels(all) = self else {
            return;
        };
        for (places, voxels) in rows {
            let (each, beyond) = all[places].split_at_mut(voxels.len());
            each.iter_mut().zip(voxels).for_each(|(place, v)| *place = v.regular());
            beyond.fill(voxels[voxels.len() - 1].regular());
        }
    }
}
