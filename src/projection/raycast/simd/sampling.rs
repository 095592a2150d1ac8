//! What is sampled among voxels, by vectors.
//!
//! *Practice.* Numbers, of which all samples are asked for, are interpolated in whole numbers of 16 bits: there are thirty-two in a register of
//! 512 bits, where of single precision there are sixteen. Normals are asked for where something shows, sixteen at a time: eight
//! weights are found once and serve all parts.

use super::{EDGE, Simd};

/// Pairs of vectors of the largest packets.
pub const PAIRS: usize = 2;

/// Bits of the parts of a voxel that samples are counted in: 16 but for two, which count [`EDGE`] voxels.
pub const PART_BITS: u32 = 16 - EDGE.ilog2();

/// What all weights of a sample of normals sum up to, but for rounding, with its sign.
pub const ALL_WEIGHTS: f32 = -32767.0;

/// Where the samples of two vectors are in cells.
#[derive(Clone, Copy)]
pub struct Places<S: Sampling> {
    /// Which of few voxels is at the low corner of each cell, x fastest.
    pub cell: S::Short,
    /// How far they are in their cells along each axis, in parts of 2¹⁵.
    pub within: [S::Short; 3],
}

/// Cells of a vector that are anywhere.
#[derive(Clone, Copy)]
pub struct Apart<S: Simd> {
    /// The stored voxel at each cell's low corner.
    pub voxels: S::Int,
    /// How far rows and planes of stored voxels are apart.
    pub strides: [usize; 2],
}

/// A way of sampling at sixteen places at once, or at thirty-two.
pub trait Sampling: Simd {
    /// Thirty-two integers of 16 bits, those of two vectors.
    type Short: Copy;
    /// [`EDGE`]³ numbers of 16 bits, those of few voxels.
    type Few;

    /// The low halves of integers.
    fn shorts(first: Self::Int, second: Self::Int) -> Self::Short;
    /// Vector `n` of the `N` that these are of, all numbers from 0 on.
    fn wide<const N: usize>(all: &[Self::Short; PAIRS], n: usize) -> Self::Int;
    /// Where `x` is from the one end on to the other, of each vector; ends are in order.
    fn in_range(x: Self::Short, ends: [i16; 2]) -> [Self::Mask; 2];

    /// Says that the few voxels of a packet from `corner` on, whose rows and planes are so far apart, will soon be read, if that can be said.
    fn ask_for_all<T>(corner: usize, strides: [usize; 2], stored: &[T]);
    /// Says that of the few voxels of a packet from `corner` on, whose rows and planes are so far apart, the `last` row of each plane and all of the
    /// `last` plane will soon be read, if that can be said.
    fn ask_for<T>(corner: usize, strides: [usize; 2], last: [usize; 2], stored: &[T]);
    /// Whether any of few numbers is at least that one.
    fn any_at_least(few: &Self::Few, least: i16) -> bool;
    /// The numbers of the few voxels of a packet from `corner` on, whose rows and planes are so far apart.
    fn few(corner: usize, strides: [usize; 2], numbers: &[i16]) -> Self::Few;
    /// Likewise the parts of normals, in parts of [`ONE_NORMAL`](super::ONE_NORMAL).
    fn few_normals(corner: usize, strides: [usize; 2], normals: &[u32]) -> [Self::Few; 3];
    /// Where samples are that are so far from few voxels' first one along each axis, `low` and `parts` together, which wrap, in parts of
    /// [`PART_BITS`] bits.
    fn places(low: &[Self::Short; 3], parts: [i16; 3], vectors: usize) -> Places<Self>;
    /// The trilinear samples of few numbers from 0 on: interpolated along x, y and z, from `a` to `b` by `t` parts of 2¹⁵ to `a` and the nearest whole
    /// number to `(b − a)·t/2¹⁵`, the higher of two. Of the first of two `vectors`, or of both; of the other, any.
    fn sampled(few: &Self::Few, places: &Places<Self>, vectors: usize) -> Self::Short;
    /// Likewise of pairs on the edges along x of cells, those of either vector.
    fn sampled_apart(pairs: [&[Self::Int; 4]; 2], within: &[Self::Short; 3], vectors: usize) -> Self::Short;
    /// What the ends of the four edges along x weigh of each cell of vector `n` of `N`, side by side. Of `t` parts of 2¹⁵ along x the ends are
    /// `−(2¹⁵ − t)` and `−t`, since 16 bits hold no positive 2¹⁵; along y and z they are `yz = y·z/2¹⁵`, `z − yz`, `y − yz`, and what those leave of
    /// 2¹⁵ − 1. All products are such nearest numbers.
    fn weights<const N: usize>(within: &[[Self::Short; PAIRS]; 3], n: usize) -> [Self::Short; 4];
    /// The trilinear samples of the parts of few normals, of vector `n` of `N` of samples, by such weights.
    fn weighed<const N: usize>(
        few: &[Self::Few; 3],
        cells: &[Self::Short; PAIRS],
        n: usize,
        weights: &[Self::Short; 4],
    ) -> [Self::Float; 3];
    /// Two numbers side by side on each of the four edges along x of each cell, the first in the low half; of cells beyond what is stored, any.
    fn apart_pairs(apart: &Apart<Self>, numbers: &[i16]) -> [Self::Int; 4];
    /// The trilinear samples of the parts of normals, by what pairs on the four edges weigh, those that are `shown`; of others, any.
    fn apart_normals(
        apart: &Apart<Self>,
        weights: &[Self::Short; 4],
        normals: &[u32],
        shown: Self::Mask,
    ) -> [Self::Float; 3];
}
