//! Samples of a block's voxels, a bundle at a time: those of a packet at one plane.
//!
//! *Practice.* Where all cells of a bundle are among few voxels, those are read once for all its vectors, and else each cell's own; all
//! else is done for all samples of a vector before the next. Of a cell's four edges along x the two ends are weighed in whole numbers,
//! which is one operation of a processor, and what comes of that is interpolated along y and z.

use std::marker::PhantomData;

use super::kind::Kind;
use super::simd::{Apart, Pairs, Simd, each};
use super::template::{Moved, Places, Template};
use super::voxels::Voxels;

/// The samples of a packet at a plane, those of one block.
pub struct Bundle<'a, S: Simd, K: Kind, const N: usize> {
    pub voxels: &'a Voxels<'a>,
    /// Which samples are in the box, and seen.
    pub inside: [S::Mask; N],
    pub plane: i32,
    /// Millimetres of each ray a millimetre of depth; `None` where all are 1.
    pub paths: &'a Option<[S::Float; N]>,
    /// Values times coverage, or opacities.
    pub weighted: Numbers<'a, S>,
    moved: Moved,
    places: [Places<S>; N],
    kind: PhantomData<K>,
}

/// Numbers of a block.
pub struct Numbers<'a, S: Simd> {
    stored: &'a [i16],
    few: Option<S::Few>,
}

impl<'a, S: Simd> Numbers<'a, S> {
    /// Those of a block, those round a packet that is `moved` there read if they are few.
    #[inline(always)]
    pub fn new<K: Kind>(voxels: &Voxels, moved: &Moved, stored: &'a [i16]) -> Self {
        Self {
            stored,
            few: moved
                .is_few::<K>()
                .then(|| S::few(moved.first as usize, voxels.strides, stored)),
        }
    }

    /// Whether any of them may be at least that one.
    #[inline(always)]
    pub fn any_at_least(&self, least: i16) -> bool {
        self.few.as_ref().is_none_or(|few| S::any_at_least(few, least))
    }
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
    pub fn of(voxels: &Voxels<'a>) -> Self {
        let [rgb, normals] = each!(stored of [voxels.rgb, voxels.normals] => Vectors { stored, few: None });
        Self { rgb, normals }
    }
}

impl<'a, S: Simd, K: Kind, const N: usize> Bundle<'a, S, K, N> {
    /// The samples of `template` at `plane`, those `inside`, of the packet that it is `moved` to.
    #[inline(always)]
    pub fn new(
        (voxels, weighted): (&'a Voxels<'a>, Numbers<'a, S>),
        (template, moved): (&Template<S, K, N>, Moved),
        (plane, inside): (i32, [S::Mask; N]),
        paths: &'a Option<[S::Float; N]>,
    ) -> Self {
        let mut places = [template.places(0, voxels, &moved, inside[0]); N];
        for n in 1..N {
            places[n] = template.places(n, voxels, &moved, inside[n]);
        }
        Self {
            voxels,
            inside,
            plane,
            paths,
            weighted,
            moved,
            places,
            kind: PhantomData,
        }
    }

    /// Other numbers of the block, those round it read if they are few.
    #[inline(always)]
    pub fn numbers(&self, stored: &'a [i16]) -> Numbers<'a, S> {
        Numbers::new::<K>(self.voxels, &self.moved, stored)
    }

    /// The trilinear samples of numbers, those of vector `n`, in parts of [`ONE_WEIGHT`](super::simd::ONE_WEIGHT) of what is stored.
    #[inline(always)]
    pub fn sampled(&self, n: usize, numbers: &Numbers<S>) -> S::Float {
        let pairs = match &numbers.few {
            Some(few) => S::take(few, self.places[n].cells),
            None => S::apart_pairs(&self.apart(n), numbers.stored),
        };
        self.interpolate(n, pairs)
    }

    /// The trilinear samples of the first three parts of vectors, those of vector `n` that are `shown`, likewise.
    #[inline(always)]
    pub fn vectors(&self, n: usize, vectors: &mut Vectors<S>, shown: S::Mask) -> [S::Float; 3] {
        if !self.moved.is_few::<K>() {
            return S::apart_vectors(&self.apart(n), &self.places[n].within, vectors.stored, shown);
        }
        let few = match &vectors.few {
            Some(few) => few,
            None => vectors.few.insert(S::few_vectors(
                self.moved.first as usize,
                self.voxels.strides,
                vectors.stored,
            )),
        };
        each!(part of [0, 1, 2] => self.interpolate(n, S::take(&few[part], self.places[n].cells)))
    }

    #[inline(always)]
    fn apart(&self, n: usize) -> Apart<S> {
        Apart {
            voxels: self.places[n].cells,
            strides: self.voxels.strides,
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
