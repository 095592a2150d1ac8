//! A volume in sparse bricks with a min/max pyramid.
//!
//! *Theory.* VCSG stores its leaf volumes as octrees, so that uniform space costs nothing and is found quickly.
//! *Changes from the paper.* Two levels in place of an octree: bricks of 32³ voxels, of which a constant one stores one
//! value, and a pyramid of value ranges beside them.
//! *Practice.* **Index space**: voxel `(i, j, k)` has its centre at `(i, j, k)` and owns the unit cube round it, so the
//! volume's box is `[-0.5, n - 0.5]`; beyond the outermost centres the value is the nearest centre's. **Missing values**: a
//! voxel that is NaN, infinite or above half of `f32::MAX` is missing, and so is (as NaN, which is in no value window) every
//! sample whose eight voxels include it, whatever its weight.

mod build;
mod put;
mod pyramid;
mod ranges;
mod sample;
mod typed;

use std::fmt;

use glam::{DAffine3, DMat3, DVec3};

pub use self::build::{BrickBuilder, BuildError};
use self::pyramid::Pyramid;
pub use self::typed::TypedBricks;
use super::field::{Field, Sample, SampleRange};
use super::grid::Grid;
use super::voxel::{Voxel, VoxelType, for_type};
use crate::math::{Aabb, Interval, affine};

/// The bricks of a volume, by voxel type.
#[derive(Debug)]
pub enum BrickStore {
    /// Unsigned 8 bit.
    U8(TypedBricks<u8>),
    /// Signed 8 bit.
    I8(TypedBricks<i8>),
    /// Unsigned 16 bit.
    U16(TypedBricks<u16>),
    /// Signed 16 bit.
    I16(TypedBricks<i16>),
    /// Unsigned 32 bit.
    U32(TypedBricks<u32>),
    /// Signed 32 bit.
    I32(TypedBricks<i32>),
    /// Single precision.
    F32(TypedBricks<f32>),
    /// Double precision.
    F64(TypedBricks<f64>),
}

impl BrickStore {
    /// The voxels' type.
    fn voxel_type(&self) -> VoxelType {
        fn of<T: Voxel>(_: &TypedBricks<T>) -> VoxelType {
            T::TYPE
        }
        for_type!(BrickStore, self, b => of(b))
    }
}

/// A volume in sparse bricks.
pub struct Bricks {
    dims: [usize; 3],
    world_from_index: DAffine3,
    index_from_world: DAffine3,
    world_from_index_normals: DMat3,
    store: BrickStore,
    pyramid: Pyramid,
    has_missing: bool,
}

impl Bricks {
    /// The bricks of `grid`.
    pub fn new(grid: &Grid) -> Self {
        let (dims, place, voxels) = (grid.dims(), *grid.world_from_index(), grid.voxels());
        let bricks = BrickBuilder::new(dims, place, voxels.voxel_type(), u64::MAX).and_then(|mut builder| {
            builder.append(voxels)?;
            builder.finish()
        });
        bricks.expect("a grid has as many voxels as its size says")
    }

    /// The bricks of a grid of `dims` voxels, all of which have come.
    fn of_store(dims: [usize; 3], world_from_index: DAffine3, store: BrickStore) -> Self {
        let index_from_world = world_from_index.inverse();
        Self {
            dims,
            world_from_index,
            index_from_world,
            world_from_index_normals: index_from_world.matrix3.transpose(),
            pyramid: for_type!(BrickStore, &store, b => Pyramid::new(b)),
            has_missing: for_type!(BrickStore, &store, b => b.has_nan()),
            store,
        }
    }

    /// Voxels along x, y, z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// World LPS millimetres of an index-space point.
    pub fn world_from_index(&self) -> &DAffine3 {
        &self.world_from_index
    }

    /// Index-space point of a world point (LPS millimetres).
    pub fn index_from_world(&self) -> &DAffine3 {
        &self.index_from_world
    }

    /// The voxels' type.
    pub fn voxel_type(&self) -> VoxelType {
        self.store.voxel_type()
    }

    /// The bricks in the voxels' own type, for copies.
    pub fn store(&self) -> &BrickStore {
        &self.store
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        for_type!(BrickStore, &self.store, b => b.bytes()) + self.pyramid.bytes()
    }

    /// The range of all voxels, missing ones left out; empty when all are missing.
    pub fn value_range(&self) -> Interval {
        self.pyramid.root()
    }

    /// Whether a voxel is missing (see the module's head).
    pub fn has_missing(&self) -> bool {
        self.has_missing
    }

    /// The volume's box in index space: half a voxel beyond the outermost centres.
    pub fn index_bounds(&self) -> Aabb {
        let n = DVec3::from_array(self.dims.map(|n| n as f64));
        Aabb::new(DVec3::splat(-0.5), n - 0.5)
    }

    /// The voxel at `(i, j, k)` (below `dims`), NaN when missing.
    pub fn voxel(&self, i: usize, j: usize, k: usize) -> f32 {
        for_type!(BrickStore, &self.store, b => b.voxel([i, j, k]).to_f32())
    }

    /// The trilinear sample at the index-space point `p` in [`Self::index_bounds`]; beyond them, that of the nearest point.
    pub fn sample_index(&self, p: DVec3) -> f32 {
        for_type!(BrickStore, &self.store, b => b.sample(p))
    }

    /// [`Self::sample_index`] at `affine::step(index_from_lattice, row, i0 + n)` for each `n` of `out`, bit for bit; `row` is
    /// `affine::row(index_from_lattice, j, k)`.
    pub fn sample_row(&self, index_from_lattice: &DAffine3, row: DVec3, i0: f64, out: &mut [f32]) {
        for_type!(BrickStore, &self.store, b => b.sample_row(index_from_lattice, row, i0, out));
    }

    /// [`Self::sample_index`] at `affine::point(index_from_frame, p)` for each point p, bit for bit, of which `points` has the
    /// coordinates, axis by axis; each as many as `out`.
    pub fn sample_points(&self, index_from_frame: &DAffine3, points: [&[f64]; 3], out: &mut [f32]) {
        for_type!(BrickStore, &self.store, b => b.sample_points(index_from_frame, points, out));
    }

    /// [`Self::sample_index`] at the voxels from `(i0, j, k)` on along x, bit for bit; `out` reaches at most to the row's end.
    pub fn copy_row(&self, i0: usize, j: usize, k: usize, out: &mut [f32]) {
        if self.has_missing {
            // A missing neighbour of weight 0 is seen by the samples, and has to be here.
            let row = DVec3::new(0.0, j as f64, k as f64);
            self.sample_row(&DAffine3::IDENTITY, row, i0 as f64, out);
        } else {
            for_type!(BrickStore, &self.store, b => b.convert_row([i0, j, k], out, Voxel::to_f32));
        }
    }

    /// A range that holds every [`Self::sample_index`] in `region` (index space), missing ones left out; a point where all
    /// voxels are equal, empty where all are missing or the region holds nothing.
    pub fn range_index(&self, region: &Aabb) -> Interval {
        let Some([first, last]) = self.lower_voxels(region) else {
            return Interval::EMPTY;
        };
        rounded(self.pyramid.range(first, last))
    }

    /// Has what samples in `region` (index space) read brought near, unless it is more than a cache holds. Rows that run
    /// aslant through a volume wait for each line of it; in the order of memory, lines are fetched ahead.
    pub fn fetch(&self, region: &Aabb) {
        if let Some([first, last]) = self.lower_voxels(region) {
            for_type!(BrickStore, &self.store, b => b.fetch(first, last));
        }
    }

    /// The first and last of the lower voxels of all samples in `region` (index space); `None` if it holds nothing.
    fn lower_voxels(&self, region: &Aabb) -> Option<[[usize; 3]; 2]> {
        let region = region.intersect(&self.index_bounds());
        if region.is_empty() {
            return None;
        }
        let index = |p: f64, last: usize| (p.max(0.0) as usize).min(last);
        let [lo, hi] = [region.min.to_array(), region.max.to_array()];
        let first: [usize; 3] = std::array::from_fn(|a| index(lo[a].floor(), self.dims[a] - 1));
        // A sample on a voxel's centre has weight 0 on the next, so the last lower voxel lies below the box's end.
        let last = std::array::from_fn(|a| index(hi[a].ceil() - 1.0, self.dims[a] - 1).max(first[a]));
        Some([first, last])
    }

    /// The derivative of the volume along the index axes at `p`: the differences of samples one voxel before and after,
    /// which is the trilinear interpolation of the voxels' central differences. Towards the outermost centres the distance
    /// shrinks to one side; along an axis of one voxel it is 0. NaN next to missing voxels.
    pub fn gradient_index(&self, p: DVec3) -> DVec3 {
        let last = DVec3::from_array(self.dims.map(|n| (n - 1) as f64));
        let p = p.clamp(DVec3::ZERO, last);
        let [lo, hi] = [(p - 1.0).max(DVec3::ZERO), (p + 1.0).min(last)];
        DVec3::from_array(std::array::from_fn(|a| {
            let at = |q: DVec3| {
                let mut moved = p;
                moved[a] = q[a];
                f64::from(self.sample_index(moved))
            };
            match hi[a] - lo[a] {
                0.0 => 0.0,
                distance => (at(hi) - at(lo)) / distance,
            }
        }))
    }
}

/// The range of the trilinear samples between voxels in `range`.
///
/// With unit roundoff u = ε/2 and magnitudes up to M, the rounded `a + t·(b − a)` is monotone in `t`, is `a` at 0, and at 1
/// misses `b` by at most u·|b − a| + u·|result| ≤ 3uM. Three of them nested, the outer ones convex in their operands: 9uM, or
/// 4.5 ε·M, and terms in u² that the rest up to 5 holds. Equal corners are exact.
fn rounded(range: Interval) -> Interval {
    match range.is_point() {
        true => range,
        false => range.widen_ulps(5.0),
    }
}

impl Field for Bricks {
    fn bounds(&self) -> Aabb {
        self.index_bounds().transformed(&self.world_from_index)
    }

    fn sample(&self, p: DVec3) -> Sample {
        let p = affine::point(&self.index_from_world, p);
        if !self.index_bounds().contains(p) {
            return Sample::EMPTY;
        }
        match self.sample_index(p) {
            v if v.is_nan() => Sample::EMPTY,
            v => Sample::solid(v),
        }
    }

    /// The data's gradient inside the box; 0 outside and next to missing voxels.
    fn gradient(&self, p: DVec3) -> DVec3 {
        let p = affine::point(&self.index_from_world, p);
        if !self.index_bounds().contains(p) {
            return DVec3::ZERO;
        }
        match self.gradient_index(p) {
            g if g.is_nan() => DVec3::ZERO,
            g => self.world_from_index_normals * g,
        }
    }

    fn range(&self, region: &Aabb) -> SampleRange {
        // A thousandth of a voxel is far more than the transform's rounding.
        let region = region.transformed(&self.index_from_world);
        let region = region.expand(DVec3::splat(1e-3));
        let bounds = self.index_bounds();
        let value = self.range_index(&region);
        if value.is_empty() {
            return SampleRange::EMPTY;
        }
        let covered = bounds.min.cmple(region.min).all() && bounds.max.cmpge(region.max).all();
        let lowest = if covered && !self.has_missing { 1.0 } else { 0.0 };
        SampleRange {
            value,
            coverage: Interval::new(lowest, 1.0),
        }
    }
}

impl fmt::Debug for Bricks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Bricks")
            .field("dims", &self.dims)
            .field("voxel_type", &self.voxel_type())
            .field("world_from_index", &self.world_from_index)
            .finish_non_exhaustive()
    }
}
