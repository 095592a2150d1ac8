//! Sparse bricks of one voxel type.

use std::fmt;
use std::hint::black_box;
use std::ops::Range;

use rayon::prelude::*;

use crate::volume::voxel::Voxel;

/// log₂ of a brick's edge.
pub(super) const SHIFT: u32 = 5;

/// Voxels along a brick's edge, without its apron.
pub(super) const EDGE: usize = 1 << SHIFT;

/// Where a voxel is in its brick.
pub(super) const MASK: usize = EDGE - 1;

/// Distance of y neighbours in a brick's voxels; x neighbours are 1 apart.
pub(super) const Y_STRIDE: usize = EDGE + 1;

/// Distance of z neighbours in a brick's voxels.
pub(super) const Z_STRIDE: usize = Y_STRIDE * Y_STRIDE;

/// Bytes of a cache line.
const LINE: usize = 64;

/// Bytes that are sure to stay in a core's own cache while they are sampled.
const NEAR: usize = 256 << 10;

/// A volume's bricks in the voxels' own type. Values are as [`Voxel::regular`] makes them.
pub struct TypedBricks<T> {
    dims: [usize; 3],
    brick_dims: [usize; 3],
    bricks: Vec<Brick<T>>,
}

/// 32³ voxels and, on the high sides, the first layer of the next bricks (at the volume's end, the last layer again), so
/// that the eight voxels of a trilinear sample lie in one brick.
pub(super) enum Brick<T> {
    /// All voxels have this value.
    Constant(T),
    /// 33 × 33 × (planes + 1) voxels, x fastest; only the volume's last bricks in z have less than 32 planes. While a volume is
    /// built, none: no voxel has come.
    Voxels(Box<[T]>),
}

impl<T: Voxel> TypedBricks<T> {
    /// The bricks of a grid of `dims` voxels, of which none has come.
    pub(super) fn without_voxels(dims: [usize; 3]) -> Self {
        let brick_dims = dims.map(|n| n.div_ceil(EDGE));
        let count = brick_dims.iter().product();
        Self {
            dims,
            brick_dims,
            bricks: std::iter::repeat_with(|| Brick::Voxels(Box::default()))
                .take(count)
                .collect(),
        }
    }

    /// Voxels along x, y, z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// The voxel at `index` (below `dims` on each axis).
    pub fn voxel(&self, index: [usize; 3]) -> T {
        match self.brick(index.map(|i| i >> SHIFT)) {
            Brick::Constant(v) => *v,
            Brick::Voxels(v) => v[offset(index)],
        }
    }

    /// The voxels from `first` on along x; `out` reaches at most to the row's end.
    pub fn copy_row(&self, first: [usize; 3], out: &mut [T]) {
        self.convert_row(first, out, |v| v);
    }

    /// [`Self::copy_row`] through `convert`.
    pub(super) fn convert_row<U: Copy>(&self, first: [usize; 3], mut out: &mut [U], convert: impl Fn(T) -> U) {
        let [mut i, j, k] = first;
        while !out.is_empty() {
            let here = (EDGE - (i & MASK)).min(out.len());
            let (head, tail) = out.split_at_mut(here);
            match self.brick([i, j, k].map(|i| i >> SHIFT)) {
                Brick::Constant(v) => head.fill(convert(*v)),
                Brick::Voxels(voxels) => {
                    let row = &voxels[offset([i, j, k])..][..here];
                    head.iter_mut().zip(row).for_each(|(out, v)| *out = convert(*v));
                }
            }
            out = tail;
            i += here;
        }
    }

    /// The bricks at some places of each axis, with their places, to be changed.
    pub(super) fn part(
        &mut self,
        [xs, ys, zs]: [Range<usize>; 3],
    ) -> impl ParallelIterator<Item = ([usize; 3], &mut Brick<T>)> {
        let [nx, ny, _] = self.brick_dims;
        let layers = self.bricks.par_chunks_mut(nx * ny).skip(zs.start);
        layers.zip(zs).flat_map(move |(layer, z)| {
            let (rows, xs) = (layer.par_chunks_mut(nx).skip(ys.start), xs.clone());
            rows.zip(ys.clone()).flat_map(move |(row, y)| {
                let bricks = row[xs.clone()].par_iter_mut();
                bricks.zip(xs.clone()).map(move |(brick, x)| ([x, y, z], brick))
            })
        })
    }

    /// How many bricks there are.
    pub(super) fn count(&self) -> usize {
        self.bricks.len()
    }

    /// Bricks along x, y, z.
    pub(super) fn brick_dims(&self) -> [usize; 3] {
        self.brick_dims
    }

    /// The brick at place `b`.
    #[inline]
    pub(super) fn brick(&self, b: [usize; 3]) -> &Brick<T> {
        self.at(self.index(b.map(|b| b as u64)))
    }

    /// Where the brick at place `b` is among all.
    #[inline(always)]
    pub(super) fn index(&self, b: [u64; 3]) -> u64 {
        let [nx, ny, _] = self.brick_dims.map(|n| u64::from(n as u32));
        (b[2] * ny + b[1]) * nx + b[0]
    }

    /// The place of the brick of an [`Self::index`].
    pub(super) fn place(&self, index: u64) -> [usize; 3] {
        let ([nx, ny, _], index) = (self.brick_dims, index as usize);
        [index % nx, index / nx % ny, index / (nx * ny)]
    }

    /// The brick of an [`Self::index`].
    #[inline(always)]
    pub(super) fn at(&self, index: u64) -> &Brick<T> {
        &self.bricks[index as usize]
    }

    /// Reads a voxel of each cache line of the samples whose lower voxels are `first..=last`, if all of them take less than
    /// [`NEAR`].
    pub(super) fn fetch(&self, first: [usize; 3], last: [usize; 3]) {
        let size: [usize; 3] = std::array::from_fn(|a| last[a] - first[a] + 2);
        if size.iter().product::<usize>() * size_of::<T>() > NEAR {
            return;
        }
        let brick = |a: usize| first[a] >> SHIFT..=last[a] >> SHIFT;
        for (z, y) in brick(2).flat_map(|z| brick(1).map(move |y| (z, y))) {
            for x in brick(0) {
                if let Brick::Voxels(voxels) = self.brick([x, y, z]) {
                    let part = |a: usize, b: usize| {
                        let start = first[a].saturating_sub(b << SHIFT);
                        start..(last[a] - (b << SHIFT)).min(MASK) + 2
                    };
                    fetch_rows(voxels, part(1, y), part(2, z));
                }
            }
        }
    }

    /// Whether a voxel is NaN.
    pub(super) fn has_nan(&self) -> bool {
        let is_nan = |v: &T| v.to_f32().is_nan();
        T::TYPE.is_float()
            && self.bricks.par_iter().any(|brick| match brick {
                Brick::Constant(v) => is_nan(v),
                Brick::Voxels(v) => v.iter().any(is_nan),
            })
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        let voxels = |brick: &Brick<T>| match brick {
            Brick::Constant(_) => 0,
            Brick::Voxels(v) => size_of_val(&**v),
        };
        self.bricks.iter().map(voxels).sum::<usize>() + size_of_val(&*self.bricks)
    }
}

impl<T> fmt::Debug for TypedBricks<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TypedBricks")
            .field("dims", &self.dims)
            .finish_non_exhaustive()
    }
}

impl<T: Voxel> Brick<T> {
    /// Whether none of its voxels has come.
    pub(super) fn is_empty(&self) -> bool {
        matches!(self, Self::Voxels(v) if v.is_empty())
    }
}

/// Where the voxel at `index` is in its brick's voxels.
#[inline(always)]
pub(super) fn offset(index: [usize; 3]) -> usize {
    (index[0] & MASK) + (index[1] & MASK) * Y_STRIDE + (index[2] & MASK) * Z_STRIDE
}

/// Reads a voxel of each cache line of some rows in each of some planes.
fn fetch_rows<T: Voxel>(voxels: &[T], rows: Range<usize>, planes: Range<usize>) {
    for plane in planes {
        let rows = &voxels[plane * Z_STRIDE..][rows.start * Y_STRIDE..rows.end * Y_STRIDE];
        for voxel in rows.iter().step_by(LINE / size_of::<T>()) {
            black_box(*voxel);
        }
    }
}
