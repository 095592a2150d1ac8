//! Samples of a block's voxels, a bundle at a time: those of a packet at one plane.
//!
//! *Practice.* The place of a ray at every eighth plane is in double precision, and at the others in single precision from the whole
//! number below it: so no lattice is too large for them. Nothing depends on the block but where its voxels lie. Where all cells of a bundle
//! are among few voxels, those are read once, and else each cell's own; all else is done for all samples before the next. Of a cell's four edges along x
//! the two ends are weighed in whole numbers, which is one operation of a processor, and what comes of that is interpolated along y and z.

use super::rays::PacketRays;
use super::simd::{Apart, Near, Pairs, Simd, Within, each};
use super::voxels::CastBlock;

/// Planes from one whose places are worked out in double precision to the next.
pub const STRETCH: i32 = 8;

/// A packet's places at a multiple of [`STRETCH`], and the way to the next planes.
pub struct Start<S: Simd> {
    /// The plane.
    plane: i32,
    /// The whole number below each place, counted from the first stored voxel.
    from: [S::Int; 3],
    /// How far from it the place is.
    part: [S::Float; 3],
    step: [S::Float; 3],
}

impl<S: Simd> Start<S> {
    /// Of the stretch that `plane` is in.
    #[inline(always)]
    pub fn new(block: &CastBlock, rays: &PacketRays<S>, plane: i32) -> Self {
        let plane = plane - plane % STRETCH;
        let planes = S::double(f64::from(plane));
        let at = each!(axis of [0, 1, 2] => rays.origin[axis] + planes * rays.step[axis]);
        let whole = each!(axis of [0, 1, 2] => S::floor_double(at[axis]));
        Self {
            plane,
            from: each!(axis of [0, 1, 2] => S::whole_double(whole[axis]) - S::int(block.first[axis])),
            part: each!(axis of [0, 1, 2] => S::single(at[axis] - whole[axis])),
            step: each!(axis of [0, 1, 2] => S::single(rays.step[axis])),
        }
    }

    /// Whether `plane` is in its stretch.
    #[inline(always)]
    pub fn reaches(&self, plane: i32) -> bool {
        plane - self.plane < STRETCH
    }
}

/// Where samples lie among a block's voxels.
pub struct Places<S: Simd> {
    cells: Cells<S>,
    within: Within<S>,
}

/// The cells that samples are in.
enum Cells<S: Simd> {
    /// Together among few voxels.
    Near(Near<S>),
    /// Anywhere; any for a sample that is not asked for.
    Apart(Apart<S>),
}

impl<S: Simd> Places<S> {
    /// The samples at `plane`, which `start` reaches; those `inside` are asked for, and ray `lowest` of each axis has the lowest place
    /// along it.
    #[inline(always)]
    pub fn new(block: &CastBlock, start: &Start<S>, plane: i32, inside: S::Mask, lowest: &[usize; 3]) -> Self {
        let planes = S::float((plane - start.plane) as f32);
        let along = each!(axis of [0, 1, 2] => start.part[axis] + planes * start.step[axis]);
        let below = each!(axis of [0, 1, 2] => S::floor(along[axis]));
        let cell = each!(axis of [0, 1, 2] => start.from[axis] + S::whole(below[axis]));
        Self {
            cells: match S::near(&cell, inside, lowest, block.dims) {
                Some(near) => Cells::Near(near),
                None => Cells::Apart(apart::<S>(block, &cell, inside)),
            },
            within: Within {
                weights: S::weights(along[0] - below[0]),
                parts: each!(axis of [1, 2] => along[axis] - below[axis]),
            },
        }
    }

    /// The trilinear samples of numbers, in steps of what is stored.
    #[inline(always)]
    pub fn numbers(&self, numbers: &[i16]) -> S::Float {
        self.interpolate(match &self.cells {
            Cells::Near(near) => S::near_pairs(near, numbers),
            Cells::Apart(apart) => S::apart_pairs(apart, numbers),
        })
    }

    /// The trilinear samples of the first three parts of vectors, those that are `shown`, in steps of what is stored.
    #[inline(always)]
    pub fn vectors(&self, vectors: &[[i16; 4]], shown: S::Mask) -> [S::Float; 3] {
        match &self.cells {
            Cells::Near(near) => {
                let pairs = S::near_vectors(near, vectors);
                each!(part of [0, 1, 2] => self.interpolate(pairs[part]))
            }
            Cells::Apart(apart) => S::apart_vectors(apart, &self.within, vectors, shown),
        }
    }

    /// The trilinear samples of what lies at the corners of cells.
    #[inline(always)]
    fn interpolate(&self, pairs: Pairs<S>) -> S::Float {
        let edges = each!(edge of [0, 1, 2, 3] => S::weighed(pairs[edge], self.within.weights));
        self.within.between(edges)
    }
}

/// Each cell, of those that are asked for.
#[inline(always)]
fn apart<S: Simd>(block: &CastBlock, cell: &[S::Int; 3], inside: S::Mask) -> Apart<S> {
    let [x, y, z] = each!(axis of [0, 1, 2] => cell[axis] * S::int(block.strides[axis]));
    let [_, row, plane] = block.strides.map(|stride| stride as usize);
    Apart {
        voxels: S::choose_int(inside, x + y + z, S::int(0)),
        strides: [row, plane],
    }
}
