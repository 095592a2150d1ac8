//! Samples of a block's voxels, a bundle at a time.
//!
//! *Practice.* The place of a ray at the first plane is in double precision, and at the others in single precision from the whole
//! number below it: so no lattice is too large for them. Nothing depends on the block but where its voxels lie. Each step is
//! done for all samples before the next: voxels are fetched one after another, what is done with them is done in vectors.

use super::bundle::{Lanes, RAYS, SAMPLES, STEPS, each, whole_f32, whole_f64};
use super::rays::TileRays;
use super::voxels::CastBlock;

/// Where samples lie among a block's voxels.
pub struct Places {
    /// The stored voxel at the low corner of each sample's cell; any for a sample that is not in the box.
    corner: [i32; SAMPLES],
    /// How far in the cell it is.
    fraction: [Lanes; 3],
}

impl Places {
    /// The samples in `block` of the rays of `pixel` and its neighbours, from plane `plane` on.
    #[inline(always)]
    pub fn new(block: &CastBlock, rays: &TileRays, pixel: usize, plane: i32, inside: &[bool; SAMPLES]) -> Self {
        let mut places = Self {
            corner: [0; SAMPLES],
            fraction: [[0.0; SAMPLES]; 3],
        };
        for axis in 0..3 {
            let stride = block.strides[axis];
            let ([mut part, mut step], mut from) = ([[0.0; RAYS]; 2], [0; RAYS]);
            for r in 0..RAYS {
                let [origin, along] = rays.axis(axis, pixel + r);
                let at = origin + f64::from(plane) * along;
                let whole = at.floor();
                (part[r], step[r]) = ((at - whole) as f32, along as f32);
                from[r] = whole_f64(whole).wrapping_sub(block.first[axis]);
            }
            for s in 0..STEPS {
                for r in 0..RAYS {
                    let n = s * RAYS + r;
                    let along = part[r] + s as f32 * step[r];
                    let below = along.floor();
                    places.fraction[axis][n] = along - below;
                    let cell = from[r].wrapping_add(whole_f32(below)).wrapping_mul(stride);
                    places.corner[n] = places.corner[n].wrapping_add(cell);
                }
            }
        }
        for (corner, inside) in places.corner.iter_mut().zip(inside) {
            *corner = if *inside { *corner } else { 0 };
        }
        places
    }

    /// The trilinear samples of what is stored in `numbers`, in steps of what is stored.
    #[inline(always)]
    pub fn interpolate(&self, block: &CastBlock, numbers: &[u16]) -> Lanes {
        // Two voxels side by side on each edge of the cells along x.
        let mut pairs = [[0u32; SAMPLES]; 4];
        let edges = edges(block, numbers);
        for n in 0..SAMPLES {
            let at = self.corner[n] as usize;
            // Every place is in the block. But for this way out of the loop compilers may fetch by vectors, which is slower.
            if at + 1 >= edges[0].len() {
                break;
            }
            for (pair, edge) in pairs.iter_mut().zip(&edges) {
                pair[n] = u32::from(edge[at]) | u32::from(edge[at + 1]) << 16;
            }
        }
        let [tx, ty, tz] = &self.fraction;
        let along_x = |n: usize, pair: &[u32; SAMPLES]| {
            let low = (pair[n] & 0xffff) as i32 as f32;
            let high = (pair[n] >> 16) as i32 as f32;
            low + tx[n] * (high - low)
        };
        each(|n| {
            let [a, b, c, d] = [0, 1, 2, 3].map(|edge| along_x(n, &pairs[edge]));
            let (near, far) = (a + ty[n] * (b - a), c + ty[n] * (d - c));
            near + tz[n] * (far - near)
        })
    }

    /// The trilinear sample `n` of what is stored in `vectors`, in steps of what is stored.
    #[inline(always)]
    pub fn vector<T: Copy + Default + Into<f32>>(&self, block: &CastBlock, vectors: &[[T; 4]], n: usize) -> [f32; 4] {
        let at = self.corner[n] as usize;
        let edges = edges(block, vectors);
        let [tx, ty, tz] = [0, 1, 2].map(|axis| self.fraction[axis][n]);
        // Two voxels side by side.
        let pair = |edge: usize| -> [f32; 8] {
            let [a, b] = edges[edge]
                .get(at..)
                .and_then(|rest| rest.first_chunk())
                .copied()
                .unwrap_or_default();
            [a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]].map(Into::into)
        };
        let lerp = |a: [f32; 8], b: [f32; 8], t: f32| {
            let mut mixed = [0.0; 8];
            for c in 0..8 {
                mixed[c] = a[c] + t * (b[c] - a[c]);
            }
            mixed
        };
        let near = lerp(pair(0), pair(1), ty);
        let far = lerp(pair(2), pair(3), ty);
        let both = lerp(near, far, tz);
        let mut mixed = [0.0; 4];
        for c in 0..4 {
            mixed[c] = both[c] + tx * (both[c + 4] - both[c]);
        }
        mixed
    }
}

/// What is stored, from the first voxel on each of the four edges of a cell along x: an index in one is in all of them.
#[inline(always)]
fn edges<'a, T>(block: &CastBlock, stored: &'a [T]) -> [&'a [T]; 4] {
    let [_, y, z] = block.strides.map(|stride| stride as usize);
    let cells = stored.len().saturating_sub(y + z);
    [0, y, z, y + z].map(|by| stored.get(by..by + cells).unwrap_or_default())
}
