//! Samples of a block's voxels, a bundle at a time: those of a packet at one plane.
//!
//! *Practice.* The place of a ray at every eighth plane is in double precision, and at the others in single precision from the whole
//! number below it: so no lattice is too large for them. Nothing depends on the block but where its voxels lie. Where all cells of a bundle
//! are among few voxels, those are read once, and else each cell's own; all else is done for all samples before the next.

use super::rays::PacketRays;
use super::simd::{Near, Pairs, RAYS, Simd, each};
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
    corners: Corners<S>,
    /// How far each sample is in its cell, along each axis.
    fraction: [S::Float; 3],
}

/// The stored voxels at the low corners of samples' cells.
enum Corners<S: Simd> {
    /// Together among few.
    Near(Near<S>),
    /// Each; any for a sample that is not asked for.
    Apart([i32; RAYS]),
}

/// A part of a vector, as it is stored.
pub trait Part: bytemuck::Pod + Default + Into<f32> {
    /// The low halves and the high ones.
    fn halves<S: Simd>(bits: S::Int) -> [S::Float; 2];
}

impl Part for u16 {
    #[inline(always)]
    fn halves<S: Simd>(bits: S::Int) -> [S::Float; 2] {
        S::unsigned_halves(bits)
    }
}

impl Part for i16 {
    #[inline(always)]
    fn halves<S: Simd>(bits: S::Int) -> [S::Float; 2] {
        S::signed_halves(bits)
    }
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
            corners: match S::near(&cell, inside, lowest, block.dims) {
                Some(near) => Corners::Near(near),
                None => Corners::Apart(apart::<S>(block, &cell, inside)),
            },
            fraction: each!(axis of [0, 1, 2] => along[axis] - below[axis]),
        }
    }

    /// The trilinear samples of numbers, in steps of what is stored.
    #[inline(always)]
    pub fn numbers(&self, block: &CastBlock, numbers: &[u16]) -> S::Float {
        self.interpolate::<u16>(match &self.corners {
            Corners::Near(near) => S::near_pairs(near, numbers),
            Corners::Apart(corners) => pairs::<S>(block, corners, numbers),
        })
    }

    /// The trilinear samples of the first three parts of vectors, those that are `shown`, in steps of what is stored.
    #[inline(always)]
    pub fn vectors<T: Part>(&self, block: &CastBlock, vectors: &[[T; 4]], shown: S::Mask) -> [S::Float; 3] {
        match &self.corners {
            Corners::Near(near) => {
                let pairs = S::near_vectors(near, bytemuck::cast_slice(vectors));
                each!(part of [0, 1, 2] => self.interpolate::<T>(pairs[part]))
            }
            Corners::Apart(corners) => {
                let edges = edges(block, vectors);
                let fraction = each!(axis of [0, 1, 2] => S::float_array(self.fraction[axis]));
                let mut all = [[0.0; 4]; RAYS];
                let mut left = S::bits(shown);
                while left != 0 {
                    let n = left.trailing_zeros() as usize % RAYS;
                    let fraction = [fraction[0][n], fraction[1][n], fraction[2][n]];
                    all[n] = vector(&edges, corners[n] as usize, fraction);
                    left &= left - 1;
                }
                let [x, y, z, _] = S::entries(&all, S::ints(std::array::from_fn(|n| n as i32)));
                [x, y, z]
            }
        }
    }

    /// The trilinear samples of what lies at the corners of cells.
    #[inline(always)]
    fn interpolate<T: Part>(&self, pairs: Pairs<S>) -> S::Float {
        let [tx, ty, tz] = self.fraction;
        let [a, b, c, d] = each!(edge of [0, 1, 2, 3] => T::halves::<S>(pairs[edge]));
        let [low, high] = each!(side of [0, 1] => {
            let (near, far) = (between::<S>(a[side], b[side], ty), between::<S>(c[side], d[side], ty));
            between::<S>(near, far, tz)
        });
        between::<S>(low, high, tx)
    }
}

/// What is `t` of the way from `a` to `b`.
#[inline(always)]
fn between<S: Simd>(a: S::Float, b: S::Float, t: S::Float) -> S::Float {
    a + t * (b - a)
}

/// The stored voxel at the low corner of each cell, of those that are asked for.
#[inline(always)]
fn apart<S: Simd>(block: &CastBlock, cell: &[S::Int; 3], inside: S::Mask) -> [i32; RAYS] {
    let [x, y, z] = each!(axis of [0, 1, 2] => cell[axis] * S::int(block.strides[axis]));
    S::int_array(S::choose_int(inside, x + y + z, S::int(0)))
}

/// The numbers round samples, one after another.
#[inline(always)]
fn pairs<S: Simd>(block: &CastBlock, corners: &[i32; RAYS], numbers: &[u16]) -> Pairs<S> {
    let mut pairs = [[0i32; RAYS]; 4];
    let edges = edges(block, numbers);
    for n in 0..RAYS {
        let at = corners[n] as usize;
        // Every place is in the block. But for this way out of the loop compilers may fetch by vectors, which is slower.
        if at + 1 >= edges[0].len() {
            break;
        }
        for (pair, edge) in pairs.iter_mut().zip(&edges) {
            pair[n] = i32::from(edge[at]) | i32::from(edge[at + 1]) << 16;
        }
    }
    each!(edge of [0, 1, 2, 3] => S::ints(pairs[edge]))
}

/// The trilinear sample of vectors on the [`edges`] of cells, in that whose low corner is voxel `at`, by the operations of [`Places::interpolate`].
#[inline(always)]
fn vector<T: Part>(edges: &[&[[T; 4]]; 4], at: usize, [tx, ty, tz]: [f32; 3]) -> [f32; 4] {
    // Two voxels side by side.
    let pair = |edge: usize| -> [f32; 8] {
        let pair: Option<&[[T; 4]; 2]> = edges[edge].get(at..).and_then(|rest| rest.first_chunk());
        let [a, b] = pair.copied().unwrap_or_default();
        [a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]].map(Into::into)
    };
    let between = |a: [f32; 8], b: [f32; 8], t: f32| {
        let mut mixed = [0.0; 8];
        for c in 0..8 {
            mixed[c] = a[c] + t * (b[c] - a[c]);
        }
        mixed
    };
    let near = between(pair(0), pair(1), ty);
    let far = between(pair(2), pair(3), ty);
    let both = between(near, far, tz);
    let mut mixed = [0.0; 4];
    for c in 0..4 {
        mixed[c] = both[c] + tx * (both[c + 4] - both[c]);
    }
    mixed
}

/// What is stored, from the first voxel on each of the four edges of a cell along x: an index in one is in all of them.
#[inline(always)]
fn edges<'a, T>(block: &CastBlock, stored: &'a [T]) -> [&'a [T]; 4] {
    let [_, y, z] = block.strides.map(|stride| stride as usize);
    let cells = stored.len().saturating_sub(y + z);
    [0, y, z, y + z].map(|by| stored.get(by..by + cells).unwrap_or_default())
}
