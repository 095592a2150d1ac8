//! Samples of a block's voxels, several of a ray at a time.
//!
//! *Practice.* The place of the first of them is in double precision, and the others are in single precision from the whole
//! number below it: so no lattice is too large for them. Nothing depends on the block but where its voxels lie.

use super::lanes::{LANES, Lanes, each, lerp};
use super::voxels::CastBlock;

/// Where samples lie among a block's voxels.
pub struct Places {
    /// The stored voxel at the low corner of each sample's cell.
    corner: [i32; LANES],
    /// How far in the cell it is.
    fraction: [Lanes; 3],
    /// The lanes that are samples.
    pub first: usize,
    pub end: usize,
}

impl Places {
    /// The samples `first..end` of those from point `k` on of a ray, in `block`.
    #[inline(always)]
    pub fn new(block: &CastBlock, [origin, step]: &[[f64; 3]; 2], k: i32, first: usize, end: usize) -> Self {
        let mut places = Self {
            corner: [0; LANES],
            fraction: [[0.0; LANES]; 3],
            first,
            end,
        };
        for axis in 0..3 {
            let at = origin[axis] + f64::from(k) * step[axis];
            let whole = at.floor();
            let (part, step) = ((at - whole) as f32, step[axis] as f32);
            let from = whole as i32 - block.first[axis];
            for n in 0..LANES {
                let along = part + n as f32 * step;
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
        let mut corners = [[0.0; LANES]; 8];
        let [_, y, z] = block.strides.map(|stride| stride as usize);
        for n in self.first..self.end {
            let at = self.corner[n] as usize;
            for (pair, by) in [0, y, z, y + z].into_iter().enumerate() {
                if let Some(&[a, b]) = numbers.get(at + by..).and_then(|rest| rest.first_chunk()) {
                    corners[2 * pair][n] = a;
                    corners[2 * pair + 1][n] = b;
                }
            }
        }
        self.within(&corners)
    }

    #[inline(always)]
    fn within(&self, corners: &[Lanes; 8]) -> Lanes {
        let [x, y, z] = &self.fraction;
        let along_x = |pair: usize| lerp(&corners[2 * pair], &corners[2 * pair + 1], x);
        let near = lerp(&along_x(0), &along_x(1), y);
        let far = lerp(&along_x(2), &along_x(3), y);
        lerp(&near, &far, z)
    }

    /// The trilinear sample `n` of what is stored in `vectors`.
    #[inline(always)]
    pub fn vector(&self, block: &CastBlock, vectors: &[[f32; 4]], n: usize) -> [f32; 4] {
        let [_, y, z] = block.strides.map(|stride| stride as usize);
        let at = self.corner[n] as usize;
        let [tx, ty, tz] = [0, 1, 2].map(|axis| self.fraction[axis][n]);
        let mix = |a: &[f32; 4], b: &[f32; 4], t: f32| -> [f32; 4] { std::array::from_fn(|c| a[c] + t * (b[c] - a[c])) };
        let along_x = |by: usize| match vectors.get(at + by..).and_then(|rest| rest.first_chunk()) {
            Some([a, b]) => mix(a, b, tx),
            None => [0.0; 4],
        };
        let near = mix(&along_x(0), &along_x(y), ty);
        let far = mix(&along_x(z), &along_x(y + z), ty);
        mix(&near, &far, tz)
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
