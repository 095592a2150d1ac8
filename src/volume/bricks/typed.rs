//! Sparse bricks of one voxel type.

use std::fmt;
use std::hint::black_box;
use std::ops::Range;

use rayon::prelude::*;

use crate::math::Interval;
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
    /// 33 × 33 × (planes + 1) voxels, x fastest; only the volume's last bricks in z have less than 32 planes.
    Voxels(Box<[T]>),
}

impl<T: Voxel> TypedBricks<T> {
    /// The bricks of a grid of `dims` voxels.
    pub(super) fn new(dims: [usize; 3], voxels: &[T]) -> Self {
        let brick_dims = dims.map(|n| n.div_ceil(EDGE));
        let [nx, ny, nz] = brick_dims;
        let bricks = (0..nx * ny * nz)
            .into_par_iter()
            .map(|b| Brick::new(dims, voxels, [b % nx, b / nx % ny, b / (nx * ny)]))
            .collect();
        Self {
            dims,
            brick_dims,
            bricks,
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

    /// The brick of an [`Self::index`].
    #[inline(always)]
    pub(super) fn at(&self, index: u64) -> &Brick<T> {
        &self.bricks[index as usize]
    }

    /// The range of voxels `edge·cell ..= edge·(cell + 1)`, as far as the volume goes. `edge` divides a brick's.
    pub(super) fn cell_range(&self, cell: [usize; 3], edge: usize) -> Interval {
        let first = cell.map(|c| c * edge);
        let planes: [usize; 3] = std::array::from_fn(|a| edge.min(self.dims[a] - 1 - first[a]) + 1);
        match self.brick(first.map(|i| i >> SHIFT)) {
            Brick::Constant(v) => Interval::point(v.to_f32()).hull(Interval::EMPTY),
            Brick::Voxels(v) => box_range(&v[offset(first)..], planes),
        }
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
    /// The brick at place `b` of a grid.
    fn new(dims: [usize; 3], voxels: &[T], b: [usize; 3]) -> Self {
        let [x0, y0, z0] = b.map(|b| b << SHIFT);
        let planes = EDGE.min(dims[2] - z0) + 1;
        let whole = Y_STRIDE.min(dims[0] - x0);
        let mut brick = Vec::with_capacity(planes * Z_STRIDE);
        for k in z0..z0 + planes {
            for j in y0..y0 + Y_STRIDE {
                let row = k.min(dims[2] - 1) * dims[1] + j.min(dims[1] - 1);
                let row = &voxels[row * dims[0] + x0..][..whole];
                brick.extend(row.iter().map(|v| v.regular()));
                brick.resize(brick.len() + Y_STRIDE - whole, row[whole - 1].regular());
            }
        }
        match brick.iter().all(|v| *v == brick[0]) {
            true => Self::Constant(brick[0]),
            false => Self::Voxels(brick.into()),
        }
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

/// The range of a box of `size` voxels at the start of `voxels`.
fn box_range<T: Voxel>(voxels: &[T], size: [usize; 3]) -> Interval {
    let mut range = Interval::EMPTY;
    for k in 0..size[2] {
        for j in 0..size[1] {
            for v in &voxels[k * Z_STRIDE + j * Y_STRIDE..][..size[0]] {
                range = range.hull(Interval::point(v.to_f32()));
            }
        }
    }
    range
}
