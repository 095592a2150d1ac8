//! Samples of a block's voxels, a bundle at a time: those of a packet at one plane.
//!
//! *Practice.* Where all cells of a bundle are among few voxels, those are read once for all its vectors, and else each cell's own; all
//! else is done for all samples of a vector before the next. Of a cell's four edges along x the two ends are weighed in whole numbers,
//! which is one operation of a processor, and what comes of that is interpolated along y and z.

use super::simd::{Apart, Pairs, Simd, each};
use super::template::{Moved, Places, Template};
use super::voxels::CastBlock;

/// The samples of a packet at a plane, those of one block.
pub struct Bundle<'a, S: Simd, const N: usize> {
    pub block: &'a CastBlock,
    /// Which samples are in the box, and seen.
    pub inside: [S::Mask; N],
    pub plane: i32,
    /// Millimetres of each ray a millimetre of depth; `None` where all are 1.
    pub paths: &'a Option<[S::Float; N]>,
    moved: Moved<N>,
    places: [Places<S>; N],
}

/// Vectors of a block, those round a bundle read when they are first asked for.
pub struct Vectors<'a, S: Simd> {
    stored: &'a [[i16; 4]],
    few: Option<[S::Few; 3]>,
}

/// The vectors of a block: see [`CastBlock`].
pub struct BlockVectors<'a, S: Simd> {
    pub rgb: Vectors<'a, S>,
    pub normals: Vectors<'a, S>,
}

impl<'a, S: Simd> BlockVectors<'a, S> {
    /// None of them read.
    #[inline(always)]
    pub fn of(block: &'a CastBlock) -> Self {
        let [rgb, normals] = each!(stored of [&block.rgb, &block.normals] => Vectors { stored, few: None });
        Self { rgb, normals }
    }
}

impl<'a, S: Simd, const N: usize> Bundle<'a, S, N> {
    /// The samples of `template` at `plane`, those `inside`, of the packet that it is `moved` to.
    #[inline(always)]
    pub fn new(
        block: &'a CastBlock,
        template: &Template<S, N>,
        moved: Moved<N>,
        plane: i32,
        inside: [S::Mask; N],
        paths: &'a Option<[S::Float; N]>,
    ) -> Self {
        let mut places = [template.places(0, &moved, inside[0]); N];
        for n in 1..N {
            places[n] = template.places(n, &moved, inside[n]);
        }
        Self {
            block,
            inside,
            plane,
            paths,
            moved,
            places,
        }
    }

    /// The trilinear samples of numbers, in steps of what is stored.
    #[inline(always)]
    pub fn numbers(&self, numbers: &[i16]) -> [S::Float; N] {
        let mut all = [S::float(0.0); N];
        if self.moved.few() {
            let few = S::few(self.moved.first as usize, self.strides(), numbers);
            for (n, sample) in all.iter_mut().enumerate() {
                *sample = self.interpolate(n, S::take(&few, self.places[n].cells));
            }
        } else {
            for (n, sample) in all.iter_mut().enumerate() {
                *sample = self.interpolate(n, S::apart_pairs(&self.apart(n), numbers));
            }
        }
        all
    }

    /// The trilinear samples of the first three parts of vectors, those of vector `n` that are `shown`, in steps of what is stored.
    #[inline(always)]
    pub fn vectors(&self, n: usize, vectors: &mut Vectors<S>, shown: S::Mask) -> [S::Float; 3] {
        if !self.moved.few() {
            return S::apart_vectors(&self.apart(n), &self.places[n].within, vectors.stored, shown);
        }
        let few = match &vectors.few {
            Some(few) => few,
            None => vectors.few.insert(S::few_vectors(
                self.moved.first as usize,
                self.strides(),
                vectors.stored,
            )),
        };
        each!(part of [0, 1, 2] => self.interpolate(n, S::take(&few[part], self.places[n].cells)))
    }

    /// How far rows and planes of stored voxels are apart.
    #[inline(always)]
    fn strides(&self) -> [usize; 2] {
        [self.moved.strides[1], self.moved.strides[2]]
    }

    #[inline(always)]
    fn apart(&self, n: usize) -> Apart<S> {
        Apart {
            voxels: self.places[n].cells,
            strides: self.strides(),
        }
    }

    /// The trilinear samples of what lies at the corners of cells.
    #[inline(always)]
    fn interpolate(&self, n: usize, pairs: Pairs<S>) -> S::Float {
        let within = &self.places[n].within;
        let edges = each!(edge of [0, 1, 2, 3] => S::weighed(pairs[edge], within.weights));
        within.between(edges)
    }
}
