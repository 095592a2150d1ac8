//! Samples of a block's voxels, several of a ray at a time.
//!
//! *Practice.* The place of the first of them is in double precision, and the others are in single precision from the whole
//! number below it: so no lattice is too large for them. Nothing depends on the block but where its voxels lie.

use std::ops::Range;

use super::lanes::{LANES, Lanes, each, lerp};
use super::voxels::CastBlock;

/// Where samples lie among a block's voxels.
pub struct Places {
    /// The stored voxel at the low corner of each sample's cell.
    corner: [i32; LANES],
    /// How far in the cell it is.
    fraction: [Lanes; 3],
}

impl Places {
    /// The samples in `block` of those from point `k` on of a ray, of which `lanes` are. The other lanes repeat the nearest of
    /// those, so that no lane is beyond the block.
    #[inline(always)]
    pub fn new(block: &CastBlock, [origin, step]: &[[f64; 3]; 2], k: i32, lanes: &Range<usize>) -> Self {
        let mut places = Self {
            corner: [0; LANES],
            fraction: [[0.0; LANES]; 3],
        };
        let (first, last) = (lanes.start as i32, lanes.end as i32 - 1);
        for axis in 0..3 {
            let at = origin[axis] + f64::from(k) * step[axis];
            let whole = at.floor();
            let (part, step) = ((at - whole) as f32, step[axis] as f32);
            let from = whole as i32 - block.first[axis];
            for n in 0..LANES {
                let along = part + (n as i32).max(first).min(last) as f32 * step;
                let below = along.floor();
                places.fraction[axis][n] = along - below;
                places.corner[n] += (from + below as i32) * block.strides[axis];
            }
        }
        places
    }

    /// The trilinear samples of what is stored in `numbers`.
    #[inline(always)]
    pub fn interpolate(&self, block: &CastBlock, numbers: &[f32]) -> Lanes {
        let [_, y, z] = block.strides.map(|stride| stride as usize);
        let [tx, ty, tz] = &self.fraction;
        // Samples between two rows of voxels.
        let along_x = |by: usize| {
            let (mut low, mut high) = ([0.0; LANES], [0.0; LANES]);
            for n in 0..LANES {
                let at = self.corner[n] as usize + by;
                if let Some(&[a, b]) = numbers.get(at..).and_then(|rest| rest.first_chunk()) {
                    (low[n], high[n]) = (a, b);
                }
            }
            lerp(&low, &high, tx)
        };
        let near = lerp(&along_x(0), &along_x(y), ty);
        let far = lerp(&along_x(z), &along_x(y + z), ty);
        lerp(&near, &far, tz)
    }

    /// The trilinear sample `n` of what is stored in `vectors`.
    #[inline(always)]
    pub fn vector(&self, block: &CastBlock, vectors: &[[f32; 4]], n: usize) -> [f32; 4] {
        let [_, y, z] = block.strides.map(|stride| stride as usize);
        let at = self.corner[n] as usize;
        let [tx, ty, tz] = [0, 1, 2].map(|axis| self.fraction[axis][n]);
        let numbers = vectors.as_flattened();
        // Two voxels side by side.
        let pair = |by: usize| -> Lanes {
            let rest = numbers.get(4 * (at + by)..);
            rest.and_then(|rest| rest.first_chunk()).copied().unwrap_or_default()
        };
        let near = lerp(&pair(0), &pair(y), &[ty; LANES]);
        let far = lerp(&pair(z), &pair(y + z), &[ty; LANES]);
        let both = lerp(&near, &far, &[tz; LANES]);
        let mut mixed = [0.0; 4];
        for (c, mixed) in mixed.iter_mut().enumerate() {
            *mixed = both[c] + tx * (both[c + 4] - both[c]);
        }
        mixed
    }
}

/// What samples are before they are classified.
pub struct Samples {
    /// Fraction of the value range, or opacity, times coverage.
    pub weighted: Lanes,
    /// Coverage; `None` where it is 1.
    pub coverage: Option<Lanes>,
}

impl Samples {
    /// The samples at `places`.
    #[inline(always)]
    pub fn new(block: &CastBlock, places: &Places) -> Self {
        let coverage = !block.coverage.is_empty();
        Self {
            weighted: places.interpolate(block, &block.weighted),
            coverage: coverage.then(|| places.interpolate(block, &block.coverage)),
        }
    }

    /// What fraction of the value range each is.
    #[inline(always)]
    pub fn fraction(&self) -> Lanes {
        match &self.coverage {
            None => self.weighted,
            // Where nothing is covered the quotient is any number, and its colour weighs nothing.
            Some(c) => each(|n| self.weighted[n] / c[n].max(f32::MIN_POSITIVE)),
        }
    }
}
