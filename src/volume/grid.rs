//! A typed scalar grid with its place in the world.

use std::ops::Range;

use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use thiserror::Error;

use super::field::Field;
use super::voxel::{Voxel, VoxelType, for_type};
use crate::math::affine;

/// Voxel values in their own type, x fastest, then y, then z.
#[derive(Clone, Debug, PartialEq)]
pub enum Voxels {
    /// Unsigned 8 bit.
    U8(Vec<u8>),
    /// Signed 8 bit.
    I8(Vec<i8>),
    /// Unsigned 16 bit.
    U16(Vec<u16>),
    /// Signed 16 bit.
    I16(Vec<i16>),
    /// Unsigned 32 bit.
    U32(Vec<u32>),
    /// Signed 32 bit.
    I32(Vec<i32>),
    /// Single precision.
    F32(Vec<f32>),
    /// Double precision.
    F64(Vec<f64>),
}

impl Voxels {
    /// How many there are.
    pub fn len(&self) -> usize {
        for_type!(Voxels, self, v => v.len())
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Their type.
    pub fn voxel_type(&self) -> VoxelType {
        fn of<T: Voxel>(_: &[T]) -> VoxelType {
            T::TYPE
        }
        for_type!(Voxels, self, v => of(v))
    }

    /// No voxel of `voxel` type.
    pub(super) fn none(voxel: VoxelType) -> Self {
        Self::zeros(voxel, 0)
    }

    /// `count` voxels of `voxel` type, all 0.
    pub(super) fn zeros(voxel: VoxelType, count: usize) -> Self {
        match voxel {
            VoxelType::U8 => Self::U8(vec![0; count]),
            VoxelType::I8 => Self::I8(vec![0; count]),
            VoxelType::U16 => Self::U16(vec![0; count]),
            VoxelType::I16 => Self::I16(vec![0; count]),
            VoxelType::U32 => Self::U32(vec![0; count]),
            VoxelType::I32 => Self::I32(vec![0; count]),
            VoxelType::F32 => Self::F32(vec![0.0; count]),
            VoxelType::F64 => Self::F64(vec![0.0; count]),
        }
    }

    /// Puts those of `from`, of the same type, that are in `range` in the place of these from `start` on.
    pub(super) fn overwrite(&mut self, start: usize, from: &Self, range: Range<usize>) {
        let to = start..start + range.len();
        match (self, from) {
            (Self::U8(v), Self::U8(from)) => v[to].copy_from_slice(&from[range]),
            (Self::I8(v), Self::I8(from)) => v[to].copy_from_slice(&from[range]),
            (Self::U16(v), Self::U16(from)) => v[to].copy_from_slice(&from[range]),
            (Self::I16(v), Self::I16(from)) => v[to].copy_from_slice(&from[range]),
            (Self::U32(v), Self::U32(from)) => v[to].copy_from_slice(&from[range]),
            (Self::I32(v), Self::I32(from)) => v[to].copy_from_slice(&from[range]),
            (Self::F32(v), Self::F32(from)) => v[to].copy_from_slice(&from[range]),
            (Self::F64(v), Self::F64(from)) => v[to].copy_from_slice(&from[range]),
            (to, from) => panic!(
                "voxels of two types put together: {:?}",
                (to.voxel_type(), from.voxel_type())
            ),
        }
    }

    /// Puts `next`, of the same type, behind these. The bytes that would be needed where there is no memory for them.
    pub(super) fn append(&mut self, next: Self) -> Result<(), u64> {
        fn joined<T>(voxels: &mut Vec<T>, mut next: Vec<T>) -> Result<(), u64> {
            if voxels.is_empty() {
                *voxels = next;
                return Ok(());
            }
            let bytes = ((voxels.len() + next.len()) * size_of::<T>()) as u64;
            voxels.try_reserve(next.len()).map_err(|_| bytes)?;
            voxels.append(&mut next);
            Ok(())
        }
        let types = (self.voxel_type(), next.voxel_type());
        match (self, next) {
            (Self::U8(v), Self::U8(next)) => joined(v, next),
            (Self::I8(v), Self::I8(next)) => joined(v, next),
            (Self::U16(v), Self::U16(next)) => joined(v, next),
            (Self::I16(v), Self::I16(next)) => joined(v, next),
            (Self::U32(v), Self::U32(next)) => joined(v, next),
            (Self::I32(v), Self::I32(next)) => joined(v, next),
            (Self::F32(v), Self::F32(next)) => joined(v, next),
            (Self::F64(v), Self::F64(next)) => joined(v, next),
            _ => panic!("voxels of two types put together: {types:?}"),
        }
    }

    /// Their statistics, to go on with.
    pub(super) fn tally(&self) -> Tally {
        for_type!(Self, self, v => Tally::of(v))
    }

    /// The voxel at linear index `i` (`< len()`).
    pub fn get(&self, i: usize) -> f64 {
        for_type!(Voxels, self, v => v[i].to_f64())
    }
}

/// What makes a [`Grid`] impossible.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum GridError {
    /// An axis without voxels.
    #[error("the grid has no voxels: its size is {} x {} x {}", .dims[0], .dims[1], .dims[2])]
    Empty {
        /// Voxels along x, y, z.
        dims: [usize; 3],
    },
    /// An axis longer than [`Grid::MAX_DIM`], or more voxels than can be counted.
    #[error("the grid is too large: its size is {} x {} x {}", .dims[0], .dims[1], .dims[2])]
    TooLarge {
        /// Voxels along x, y, z.
        dims: [usize; 3],
    },
    /// More or fewer voxels than the size says.
    #[error("the grid's size asks for {expected} voxels, but there are {found}")]
    Count {
        /// The product of the dims.
        expected: usize,
        /// The number of voxels given.
        found: usize,
    },
    /// `world_from_index` has no inverse or is not finite.
    #[error("the grid's axes do not span space: its index-to-world transform is singular or not finite")]
    Singular,
}

/// What the voxels of a [`Grid`] are on the whole; non-finite ones are left out and counted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stats {
    /// Smallest finite value; NaN when there is none.
    pub min: f64,
    /// Largest finite value; NaN when there is none.
    pub max: f64,
    /// Mean of the finite values; NaN when there is none.
    pub mean: f64,
    /// How many voxels are NaN or infinite.
    pub non_finite: usize,
}

/// A regular lattice of scalar voxels. `world_from_index` maps a voxel's index (its centre) to LPS millimetres.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    dims: [usize; 3],
    world_from_index: DAffine3,
    voxels: Voxels,
}

impl Grid {
    /// The most voxels along one axis: a position is a voxel and 24 bits of a fraction, in the 52 bits of a number's mantissa.
    pub const MAX_DIM: usize = 1 << 26;

    /// A grid of `dims` voxels along x, y, z.
    ///
    /// # Errors
    /// An axis of no or too many voxels, another number of voxels than `dims` say, or a transform that cannot be inverted.
    pub fn new(dims: [usize; 3], world_from_index: DAffine3, voxels: Voxels) -> Result<Self, GridError> {
        let expected = voxel_count(dims)?;
        let found = voxels.len();
        if found != expected {
            return Err(GridError::Count { expected, found });
        }
        affine::invert(&world_from_index).ok_or(GridError::Singular)?;
        Ok(Self {
            dims,
            world_from_index,
            voxels,
        })
    }

    /// `field` at the voxels of a lattice, in `f32`; 0 where it has no coverage.
    ///
    /// # Errors
    /// Those of [`Grid::new`].
    pub fn from_field(field: &dyn Field, dims: [usize; 3], world_from_index: DAffine3) -> Result<Self, GridError> {
        voxel_count(dims)?;
        let voxel = |i, j, k| {
            let p = affine::point(&world_from_index, DVec3::new(i as f64, j as f64, k as f64));
            field.sample(p).premultiplied()
        };
        let values = (0..dims[2])
            .into_par_iter()
            .flat_map_iter(|k| (0..dims[1]).flat_map(move |j| (0..dims[0]).map(move |i| voxel(i, j, k))))
            .collect();
        Self::new(dims, world_from_index, Voxels::F32(values))
    }

    /// Voxels along x, y, z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// World LPS millimetres of a voxel index.
    pub fn world_from_index(&self) -> &DAffine3 {
        &self.world_from_index
    }

    /// The voxels.
    pub fn voxels(&self) -> &Voxels {
        &self.voxels
    }

    /// The voxels' type.
    pub fn voxel_type(&self) -> VoxelType {
        self.voxels.voxel_type()
    }

    /// The voxel at `index` (below `dims` on each axis).
    pub fn value_at(&self, index: [usize; 3]) -> f64 {
        let [i, j, k] = index;
        self.voxels.get((k * self.dims[1] + j) * self.dims[0] + i)
    }

    /// Smallest, largest and mean value, and how many are not finite.
    pub fn stats(&self) -> Stats {
        self.voxels.tally().stats()
    }
}

/// The number of voxels of a grid of `dims`, checked.
pub(crate) fn voxel_count(dims: [usize; 3]) -> Result<usize, GridError> {
    if dims.contains(&0) {
        return Err(GridError::Empty { dims });
    }
    if dims.iter().any(|&n| n > Grid::MAX_DIM) {
        return Err(GridError::TooLarge { dims });
    }
    dims.iter()
        .try_fold(1usize, |n, &d| n.checked_mul(d))
        .ok_or(GridError::TooLarge { dims })
}

/// [`Stats`] of voxels that are still coming.
#[derive(Clone, Copy)]
pub(super) struct Tally {
    min: f64,
    max: f64,
    sum: f64,
    finite: usize,
    non_finite: usize,
}

impl Tally {
    /// Of no voxel.
    pub const NONE: Self = Self {
        min: f64::INFINITY,
        max: f64::NEG_INFINITY,
        sum: 0.0,
        finite: 0,
        non_finite: 0,
    };

    /// Chunks of fixed size are summed in their order, so that the mean does not depend on the number of threads.
    fn of<T: Voxel>(voxels: &[T]) -> Self {
        let chunks: Vec<Self> = voxels
            .par_chunks(1 << 16)
            .map(|chunk| chunk.iter().fold(Self::NONE, |tally, v| tally.with(v.to_f64())))
            .collect();
        chunks.into_iter().fold(Self::NONE, Self::join)
    }

    fn with(mut self, v: f64) -> Self {
        if !v.is_finite() {
            self.non_finite += 1;
            return self;
        }
        self.join(Self {
            min: v,
            max: v,
            sum: v,
            finite: 1,
            non_finite: 0,
        })
    }

    /// Of both's voxels.
    pub fn join(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
            sum: self.sum + other.sum,
            finite: self.finite + other.finite,
            non_finite: self.non_finite + other.non_finite,
        }
    }

    /// What it comes to.
    pub fn stats(&self) -> Stats {
        let some = |v: f64| if self.finite > 0 { v } else { f64::NAN };
        Stats {
            min: some(self.min),
            max: some(self.max),
            mean: self.sum / self.finite as f64,
            non_finite: self.non_finite,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(dims: [usize; 3], voxels: Voxels) -> Result<Grid, GridError> {
        Grid::new(dims, DAffine3::IDENTITY, voxels)
    }

    #[test]
    fn x_is_the_fastest_axis() {
        let g = grid([2, 3, 4], Voxels::U8((0..24).collect())).unwrap();
        assert_eq!(g.value_at([1, 0, 0]), 1.0);
        assert_eq!(g.value_at([0, 1, 0]), 2.0);
        assert_eq!(g.value_at([0, 0, 1]), 6.0);
    }

    #[test]
    fn impossible_grids_are_refused() {
        let huge = [1 << 26; 3];
        assert_eq!(
            grid([2, 2, 2], Voxels::U8(vec![0; 7])),
            Err(GridError::Count { expected: 8, found: 7 })
        );
        assert_eq!(
            grid([2, 0, 2], Voxels::U8(vec![])),
            Err(GridError::Empty { dims: [2, 0, 2] })
        );
        assert_eq!(grid(huge, Voxels::U8(vec![])), Err(GridError::TooLarge { dims: huge }));
        let flat = DAffine3::from_scale(DVec3::new(1.0, 1.0, 0.0));
        assert_eq!(Grid::new([1; 3], flat, Voxels::U8(vec![0])), Err(GridError::Singular));
    }

    #[test]
    fn stats_leave_out_what_is_not_finite() {
        let v = vec![1.0, f32::NAN, 4.0, f32::INFINITY];
        let stats = grid([4, 1, 1], Voxels::F32(v)).unwrap().stats();
        assert_eq!(
            stats,
            Stats {
                min: 1.0,
                max: 4.0,
                mean: 2.5,
                non_finite: 2
            }
        );
    }

    #[test]
    fn stats_of_no_finite_voxel_are_nan() {
        let stats = grid([1; 3], Voxels::F64(vec![f64::NAN])).unwrap().stats();
        assert!(stats.min.is_nan() && stats.max.is_nan() && stats.mean.is_nan());
    }
}
