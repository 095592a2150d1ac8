//! Samples of a block's voxels, a bundle at a time: those of a packet at one plane.
//!
//! *Practice.* Where all cells of a bundle are among few voxels, those are read once for all its vectors, and else each cell's own. All that
//! is between reading and classifying is in whole numbers of 16 bits, thirty-two at once: a number is interpolated along x, y and z
//! and rounded each time, so samples among equal numbers are that number. Of normals, which fewer samples ask for, all three parts are
//! weighed by the same eight weights.

use super::kind::Kind;
use super::simd::{Apart, PAIRS, Places, Sampling, each};
use super::template::{Moved, Template, pairs};
use super::voxels::Voxels;

/// The samples of a packet at a plane, those of one block.
pub struct Bundle<'a, S: Sampling, K: Kind, const N: usize> {
    pub voxels: &'a Voxels<'a>,
    /// Which samples are in the box, and seen.
    pub inside: [S::Mask; N],
    pub plane: i32,
    /// Millimetres of each ray a millimetre of depth; `None` where all are 1.
    pub paths: &'a Option<[S::Float; N]>,
    /// Values times coverage, or opacities.
    pub weighted: Numbers<'a, S>,
    template: &'a Template<S, K, N>,
    moved: Moved,
    /// Which of few voxels is at the low corner of each cell, if they are few.
    cells: [S::Short; PAIRS],
    /// How far samples are in their cells along each axis, in parts of 2¹⁵.
    within: [[S::Short; PAIRS]; 3],
}

/// Numbers of a block.
pub struct Numbers<'a, S: Sampling> {
    stored: &'a [i16],
    few: Option<S::Few>,
}

impl<'a, S: Sampling> Numbers<'a, S> {
    /// Those of a block, those round a packet that is `moved` there read if they are few.
    #[inline(always)]
    pub fn new<K: Kind>(voxels: &Voxels, moved: &Moved, stored: &'a [i16]) -> Self {
        let few = if moved.is_few::<K>() {
            Some(S::few(moved.first as usize, voxels.strides, stored))
        } else {
            None
        };
        Self { stored, few }
    }

    /// Whether any of them may be at least that one.
    #[inline(always)]
    pub fn any_at_least(&self, least: i16) -> bool {
        match &self.few {
            Some(few) => S::any_at_least(few, least),
            None => true,
        }
    }
}

/// Normals of a block, those round a bundle read when they are first asked for.
pub struct Normals<'a, S: Sampling> {
    stored: &'a [u32],
    few: Option<[S::Few; 3]>,
}

impl<'a, S: Sampling> Normals<'a, S> {
    /// None of them read.
    #[inline(always)]
    pub fn of(voxels: &Voxels<'a>) -> Self {
        Self {
            stored: voxels.normals,
            few: None,
        }
    }
}

impl<'a, S: Sampling, K: Kind, const N: usize> Bundle<'a, S, K, N> {
    /// The samples of `template` at `plane`, those `inside`, of the packet that it is `moved` to.
    #[inline(always)]
    pub fn new(
        (voxels, weighted): (&'a Voxels<'a>, Numbers<'a, S>),
        (template, moved): (&'a Template<S, K, N>, Moved),
        (plane, inside): (i32, [S::Mask; N]),
        paths: &'a Option<[S::Float; N]>,
    ) -> Self {
        let first = template.places(0, &moved);
        let mut cells = [first.cell; PAIRS];
        let mut within = each!(axis of [0, 1, 2] => [first.within[axis]; PAIRS]);
        for m in 1..pairs(N) {
            let places = template.places(m, &moved);
            cells[m] = places.cell;
            for (within, of) in within.iter_mut().zip(places.within) {
                within[m] = of;
            }
        }
        Self {
            voxels,
            inside,
            plane,
            paths,
            weighted,
            template,
            moved,
            cells,
            within,
        }
    }

    /// Other numbers of the block, those round it read if they are few.
    #[inline(always)]
    pub fn numbers(&self, stored: &'a [i16]) -> Numbers<'a, S> {
        Numbers::new::<K>(self.voxels, &self.moved, stored)
    }

    /// The trilinear samples of numbers from 0 on.
    #[inline(always)]
    pub fn sampled(&self, numbers: &Numbers<S>) -> [S::Short; PAIRS] {
        let mut all = [self.sampled_pair(0, numbers); PAIRS];
        if pairs(N) > 1 {
            all[1] = self.sampled_pair(1, numbers);
        }
        all
    }

    /// Those of pair `m` of vectors.
    #[inline(always)]
    fn sampled_pair(&self, m: usize, numbers: &Numbers<S>) -> S::Short {
        let within = each!(axis of [0, 1, 2] => self.within[axis][m]);
        let vectors = N.min(2);
        if let Some(few) = &numbers.few {
            let cell = self.cells[m];
            return S::sampled(few, &Places { cell, within }, vectors);
        }
        let first = S::apart_pairs(&self.apart(2 * m), numbers.stored);
        if N == 1 {
            return S::sampled_apart([&first, &first], &within, vectors);
        }
        let second = S::apart_pairs(&self.apart(2 * m + 1), numbers.stored);
        S::sampled_apart([&first, &second], &within, vectors)
    }

    /// The trilinear samples of normals, those of vector `n` that are `shown`, in parts of [`ONE_NORMAL`](super::simd::ONE_NORMAL) times
    /// [`ALL_WEIGHTS`](super::simd::ALL_WEIGHTS).
    #[inline(always)]
    pub fn normals(&self, n: usize, normals: &mut Normals<S>, shown: S::Mask) -> [S::Float; 3] {
        let weights = S::weights::<N>(&self.within, n);
        if !self.moved.is_few::<K>() {
            return S::apart_normals(&self.apart(n), &weights, normals.stored, shown);
        }
        let few = match &normals.few {
            Some(few) => few,
            None => normals.few.insert(S::few_normals(
                self.moved.first as usize,
                self.voxels.strides,
                normals.stored,
            )),
        };
        S::weighed::<N>(few, &self.cells, n, &weights)
    }

    /// The cells of vector `n`, which are anywhere.
    #[inline(always)]
    fn apart(&self, n: usize) -> Apart<S> {
        Apart {
            voxels: self.template.cells(n, self.voxels, &self.moved, self.inside[n]),
            strides: self.voxels.strides,
        }
    }
}
