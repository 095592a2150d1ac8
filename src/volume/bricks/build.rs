//! Bricks of voxels that come piece by piece.
//!
//! *Theory.* What a sparse volume takes shows only once its voxels are there. So bricks are made from voxels as they come, in pieces of
//! any size and order, and no grid of all of them is held on the way.
//! *Practice.* A piece is put in each brick that it touches, aprons included, all bricks at a time. A brick takes room for its voxels
//! when one differs from the others. So nothing is held beside the bricks that stay and the piece in hand, and the bricks depend
//! neither on the pieces nor on the number of threads.

use std::ops::Range;

use glam::DAffine3;
use thiserror::Error;

use super::put::{Order, Values};
use super::pyramid::Pyramid;
use super::typed::{Brick, EDGE, TypedBricks};
use super::{BrickStore, Bricks};
use crate::math::affine;
use crate::volume::grid::{GridError, Region, Voxels, voxel_count};
use crate::volume::voxel::{Voxel, VoxelType, for_type};

/// Why bricks cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum BuildError {
    /// The grid is impossible.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// The bricks take more memory than they may.
    #[error("the volume's bricks take {bytes} bytes of memory or more, and may take {budget}")]
    Budget {
        /// Bytes that they take, at least.
        bytes: u64,
        /// Bytes that they may take.
        budget: u64,
    },
}

/// The [`Bricks`] of voxels that come piece by piece.
pub struct BrickBuilder {
    dims: [usize; 3],
    world_from_index: DAffine3,
    store: BrickStore,
    /// How many voxels have come.
    filled: usize,
    /// Bytes of the bricks so far.
    bytes: u64,
    /// Bytes that they may take.
    budget: u64,
}

impl BrickBuilder {
    /// Bricks of a grid of `dims` voxels of which none has come yet. They may take `budget` bytes.
    ///
    /// # Errors
    /// As [`Grid::new`](crate::volume::Grid::new), and if so many bricks of one value each take more.
    pub fn new(
        dims: [usize; 3],
        world_from_index: DAffine3,
        voxel: VoxelType,
        budget: u64,
    ) -> Result<Self, BuildError> {
        voxel_count(dims)?;
        affine::invert(&world_from_index).ok_or(GridError::Singular)?;
        let bricks = dims.iter().map(|n| n.div_ceil(EDGE) as u64);
        let bricks = bricks.fold(1, u64::saturating_mul);
        let bytes = bricks.saturating_mul((size_of::<Brick<f64>>() + Pyramid::BYTES_OF_BRICK) as u64);
        if bytes > budget {
            return Err(BuildError::Budget { bytes, budget });
        }
        Ok(Self {
            dims,
            world_from_index,
            store: empty_store(dims, voxel),
            filled: 0,
            bytes,
            budget,
        })
    }

    /// The voxels that come next in the grid's order, x fastest, of the grid's type.
    ///
    /// # Errors
    /// If the grid has fewer, or the bricks take more memory than they may.
    pub fn append(&mut self, voxels: &Voxels) -> Result<(), BuildError> {
        let (start, end) = (self.filled, self.filled.saturating_add(voxels.len()));
        let expected = self.dims.iter().product();
        if end > expected {
            return Err(GridError::Count { expected, found: end }.into());
        }
        let parts = Region::of_range(self.dims, start..end);
        let parts: Vec<_> = parts
            .map(|(region, range)| (region, range.start - start..range.end - start))
            .collect();
        self.put_parts(&parts, Order::Grid, voxels)
    }

    /// The voxels of `region`, which lies in the grid and has not come before: x fastest, of the grid's type, and as many as it has.
    ///
    /// # Errors
    /// If the bricks take more memory than they may.
    pub fn put(&mut self, region: &Region, voxels: &Voxels) -> Result<(), BuildError> {
        self.put_parts(&[(*region, 0..voxels.len())], Order::Any, voxels)
    }

    /// The voxels of regions, each a part of `voxels`.
    fn put_parts(&mut self, parts: &[(Region, Range<usize>)], order: Order, voxels: &Voxels) -> Result<(), BuildError> {
        for (region, range) in parts {
            let expected = region.size.iter().product::<usize>();
            assert_eq!(range.len(), expected, "as many as {region:?} has");
        }
        let types = (self.store.voxel_type(), voxels.voxel_type());
        let new = match (&mut self.store, voxels) {
            (BrickStore::U8(bricks), Voxels::U8(v)) => bricks.put_each(parts, order, v),
            (BrickStore::I8(bricks), Voxels::I8(v)) => bricks.put_each(parts, order, v),
            (BrickStore::U16(bricks), Voxels::U16(v)) => bricks.put_each(parts, order, v),
            (BrickStore::I16(bricks), Voxels::I16(v)) => bricks.put_each(parts, order, v),
            (BrickStore::U32(bricks), Voxels::U32(v)) => bricks.put_each(parts, order, v),
            (BrickStore::I32(bricks), Voxels::I32(v)) => bricks.put_each(parts, order, v),
            (BrickStore::F32(bricks), Voxels::F32(v)) => bricks.put_each(parts, order, v),
            (BrickStore::F64(bricks), Voxels::F64(v)) => bricks.put_each(parts, order, v),
            _ => panic!("voxels of another type than the grid's: {types:?}"),
        };
        self.count(voxels.len(), new)
    }

    /// Voxels that are all `value`, which the grid's type has, in `region`, which has not come before.
    ///
    /// # Errors
    /// If the bricks take more memory than they may.
    pub fn fill(&mut self, region: &Region, value: f64) -> Result<(), BuildError> {
        fn filled<T: Voxel>(bricks: &mut TypedBricks<T>, region: &Region, value: f64) -> usize {
            bricks.put(&[(*region, Values::All(T::nearest(value)))], Order::Any)
        }
        let new = for_type!(BrickStore, &mut self.store, bricks => filled(bricks, region, value));
        self.count(region.size.iter().product(), new)
    }

    /// Counts `voxels`, for which `new` bytes were allocated.
    fn count(&mut self, voxels: usize, new: usize) -> Result<(), BuildError> {
        self.filled += voxels;
        self.bytes += new as u64;
        let Self { bytes, budget, .. } = *self;
        (bytes <= budget)
            .then_some(())
            .ok_or(BuildError::Budget { bytes, budget })
    }

    /// The bricks.
    ///
    /// # Errors
    /// If voxels have not come.
    pub fn finish(self) -> Result<Bricks, BuildError> {
        let (expected, found) = (self.dims.iter().product(), self.filled);
        match expected == found {
            true => Ok(Bricks::of_store(self.dims, self.world_from_index, self.store)),
            false => Err(GridError::Count { expected, found }.into()),
        }
    }
}

/// Bricks of which no voxel has come.
fn empty_store(dims: [usize; 3], voxel: VoxelType) -> BrickStore {
    match voxel {
        VoxelType::U8 => BrickStore::U8(TypedBricks::without_voxels(dims)),
        VoxelType::I8 => BrickStore::I8(TypedBricks::without_voxels(dims)),
        VoxelType::U16 => BrickStore::U16(TypedBricks::without_voxels(dims)),
        VoxelType::I16 => BrickStore::I16(TypedBricks::without_voxels(dims)),
        VoxelType::U32 => BrickStore::U32(TypedBricks::without_voxels(dims)),
        VoxelType::I32 => BrickStore::I32(TypedBricks::without_voxels(dims)),
        VoxelType::F32 => BrickStore::F32(TypedBricks::without_voxels(dims)),
        VoxelType::F64 => BrickStore::F64(TypedBricks::without_voxels(dims)),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::typed::{SHIFT, Y_STRIDE, Z_STRIDE};
    use super::*;
    use crate::volume::Grid;

    /// The brick at place `b` of a grid, voxel by voxel as it is defined.
    fn slow_brick<T: Voxel>(dims: [usize; 3], voxels: &[T], b: [usize; 3]) -> Brick<T> {
        let planes = EDGE.min(dims[2] - (b[2] << SHIFT)) + 1;
        let mut all = Vec::new();
        for n in 0..planes * Z_STRIDE {
            let place = [n % Y_STRIDE, n / Y_STRIDE % Y_STRIDE, n / Z_STRIDE];
            let [i, j, k] = std::array::from_fn(|a| ((b[a] << SHIFT) + place[a]).min(dims[a] - 1));
            all.push(voxels[(k * dims[1] + j) * dims[0] + i].regular());
        }
        match all.iter().all(|v| bits(v) == bits(&all[0])) {
            true => Brick::Constant(all[0]),
            false => Brick::Voxels(all.into()),
        }
    }

    fn bits<T: Voxel>(v: &T) -> &[u8] {
        bytemuck::bytes_of(v)
    }

    fn assert_bricks<T: Voxel>(bricks: &TypedBricks<T>, voxels: &[T]) {
        let dims = bricks.dims();
        let [nx, ny, nz] = dims.map(|n| n.div_ceil(EDGE));
        for n in 0..nx * ny * nz {
            let b = [n % nx, n / nx % ny, n / (nx * ny)];
            match (bricks.brick(b), &slow_brick(dims, voxels, b)) {
                (Brick::Constant(v), Brick::Constant(slow)) => assert_eq!(bits(v), bits(slow), "{b:?}"),
                (Brick::Voxels(v), Brick::Voxels(slow)) => {
                    assert_eq!(
                        bytemuck::cast_slice::<T, u8>(v),
                        bytemuck::cast_slice::<T, u8>(slow),
                        "{b:?}"
                    );
                }
                (fast, _) => panic!("{b:?} is constant: {}", matches!(fast, Brick::Constant(_))),
            }
        }
    }

    fn assert_store(store: &BrickStore, voxels: &Voxels) {
        match (store, voxels) {
            (BrickStore::U8(bricks), Voxels::U8(v)) => assert_bricks(bricks, v),
            (BrickStore::I8(bricks), Voxels::I8(v)) => assert_bricks(bricks, v),
            (BrickStore::U16(bricks), Voxels::U16(v)) => assert_bricks(bricks, v),
            (BrickStore::I16(bricks), Voxels::I16(v)) => assert_bricks(bricks, v),
            (BrickStore::U32(bricks), Voxels::U32(v)) => assert_bricks(bricks, v),
            (BrickStore::I32(bricks), Voxels::I32(v)) => assert_bricks(bricks, v),
            (BrickStore::F32(bricks), Voxels::F32(v)) => assert_bricks(bricks, v),
            (BrickStore::F64(bricks), Voxels::F64(v)) => assert_bricks(bricks, v),
            _ => panic!("another type"),
        }
    }

    /// A few values of each type, special ones among them.
    const VALUES: [f64; 6] = [0.0, -0.0, 7.0, f64::NAN, f64::INFINITY, 100.0];

    fn typed(voxel: VoxelType, values: &[f64]) -> Voxels {
        fn of<T: Voxel>(values: &[f64]) -> Vec<T> {
            values.iter().map(|v| T::nearest(*v)).collect()
        }
        match voxel {
            VoxelType::U8 => Voxels::U8(of(values)),
            VoxelType::I8 => Voxels::I8(of(values)),
            VoxelType::U16 => Voxels::U16(of(values)),
            VoxelType::I16 => Voxels::I16(of(values)),
            VoxelType::U32 => Voxels::U32(of(values)),
            VoxelType::I32 => Voxels::I32(of(values)),
            VoxelType::F32 => Voxels::F32(of(values)),
            VoxelType::F64 => Voxels::F64(of(values)),
        }
    }

    const TYPES: [VoxelType; 8] = [
        VoxelType::U8,
        VoxelType::I8,
        VoxelType::U16,
        VoxelType::I16,
        VoxelType::U32,
        VoxelType::I32,
        VoxelType::F32,
        VoxelType::F64,
    ];

    prop_compose! {
        /// A grid of one background, with boxes of values in it.
        fn volumes()(
            dims in [axis(), axis(), axis()], voxel in prop::sample::select(&TYPES[..]), background in prop::sample::select(&VALUES[..]),
            boxes in prop::collection::vec((any::<[prop::sample::Index; 6]>(), prop::sample::select(&VALUES[..]), any::<bool>()), 0..4),
        ) -> ([usize; 3], VoxelType, Vec<f64>) {
            let mut values = vec![background; dims.iter().product()];
            for (ends, value, noisy) in boxes {
                let ends: [_; 3] = std::array::from_fn(|a| {
                    let [p, q] = [ends[a].index(dims[a]), ends[a + 3].index(dims[a])];
                    p.min(q)..p.max(q) + 1
                });
                for k in ends[2].clone() {
                    for j in ends[1].clone() {
                        for i in ends[0].clone() {
                            let noise = if noisy { ((i * 31 + j * 17 + k * 7) % 101) as f64 } else { 0.0 };
                            values[(k * dims[1] + j) * dims[0] + i] = value + noise;
                        }
                    }
                }
            }
            (dims, voxel, values)
        }
    }

    fn axis() -> impl Strategy<Value = usize> {
        prop_oneof![Just(1), 2usize..12, 31usize..36, 63usize..67]
    }

    /// The voxels of a region.
    fn of_region(dims: [usize; 3], values: &[f64], region: &Region) -> Vec<f64> {
        let Region { first, size } = region;
        let mut inside = Vec::new();
        for k in first[2]..first[2] + size[2] {
            for j in first[1]..first[1] + size[1] {
                inside.extend(&values[(k * dims[1] + j) * dims[0] + first[0]..][..size[0]]);
            }
        }
        inside
    }

    /// Boxes of `size` that fill a grid, the last ones cut.
    fn tiles(dims: [usize; 3], size: [usize; 3]) -> Vec<Region> {
        let count: [usize; 3] = std::array::from_fn(|a| dims[a].div_ceil(size[a]));
        let tile = |n: usize| {
            let first = [n % count[0], n / count[0] % count[1], n / (count[0] * count[1])];
            let first: [usize; 3] = std::array::from_fn(|a| first[a] * size[a]);
            let size = std::array::from_fn(|a| size[a].min(dims[a] - first[a]));
            Region { first, size }
        };
        (0..count.iter().product()).map(tile).collect()
    }

    fn builder(dims: [usize; 3], voxel: VoxelType) -> BrickBuilder {
        BrickBuilder::new(dims, DAffine3::IDENTITY, voxel, u64::MAX).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]

        #[test]
        fn a_stream_makes_the_bricks_of_its_grid(
            (dims, voxel, values) in volumes(), lengths in prop::collection::vec(prop_oneof![1usize..40, 100usize..9000], 1..6),
        ) {
            let all = typed(voxel, &values);
            let mut builder = builder(dims, voxel);
            let (mut rest, mut lengths) = (&values[..], lengths.iter().cycle());
            // Few pieces of a large grid are small.
            let least = values.len() / 500;
            while !rest.is_empty() {
                let length = lengths.next().unwrap().max(&least);
                let (chunk, after) = rest.split_at(rest.len().min(*length));
                builder.append(&typed(voxel, chunk)).unwrap();
                rest = after;
            }
            let bricks = builder.finish().unwrap();
            assert_store(bricks.store(), &all);
            let at_once = Bricks::new(&Grid::new(dims, DAffine3::IDENTITY, all.clone()).unwrap());
            assert_store(at_once.store(), &all);
            prop_assert_eq!(bricks.bytes(), at_once.bytes());
        }

        #[test]
        fn boxes_in_any_order_make_the_bricks_of_their_grid(
            (dims, voxel, values) in volumes(), size in [9usize..70, 9usize..70, 9usize..70], seed: u64,
        ) {
            let mut builder = builder(dims, voxel);
            let mut tiles = tiles(dims, size);
            tiles.sort_by_key(|tile| tile.first.iter().fold(seed, |h, n| (h ^ *n as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)));
            for tile in tiles {
                let inside = of_region(dims, &values, &tile);
                match inside.iter().all(|v| v.to_bits() == inside[0].to_bits()) {
                    true => builder.fill(&tile, inside[0]).unwrap(),
                    false => builder.put(&tile, &typed(voxel, &inside)).unwrap(),
                }
            }
            assert_store(builder.finish().unwrap().store(), &typed(voxel, &values));
        }
    }

    #[test]
    fn too_few_or_too_many_voxels_are_no_bricks() {
        let mut short = builder([3, 2, 1], VoxelType::U8);
        short.append(&Voxels::U8(vec![1; 5])).unwrap();
        let count = |found| BuildError::Grid(GridError::Count { expected: 6, found });
        assert_eq!(short.append(&Voxels::U8(vec![1; 2])), Err(count(7)));
        assert_eq!(short.finish().unwrap_err(), count(5));
    }

    #[test]
    fn bricks_keep_within_their_budget() {
        let make = |dims, budget| BrickBuilder::new(dims, DAffine3::IDENTITY, VoxelType::U8, budget);
        let is_over =
            |result| matches!(result, Err(BuildError::Budget { bytes, budget }) if bytes > budget && budget == 1 << 20);
        assert!(is_over(make([1 << 20; 3], 1 << 20).map(|_| ())));
        let mut noise = make([320, 32, 320], 1 << 20).unwrap();
        let slice = Voxels::U8((0..320 * 32).map(|n| n as u8).collect());
        assert!(is_over((0..320).try_for_each(|_| noise.append(&slice))));
    }
}
