//! Reconstructed voxels as texels: values, coverages and soft normals as unsigned fractions of 16 bits.
//!
//! *Practice.* A texel of a covered block is its value, and in a lit target its soft normal beside it: one fetch brings both.
//! A texel of a mixed block is value times coverage and coverage; its normals lie in an image of their own. Values are fractions of the
//! target's value range. Sixteen bits hold bytes exactly enough, and are filtered in single precision where 8 bits are in
//! fixed point: on lavapipe that is more exact and a tenth faster (`cargo bench --bench device`).

use std::ops::Range;

use glam::Vec3;

use crate::math::Interval;
use crate::projection::{EMPTY_BELOW, Slopes, SoftNormals};
use crate::target::{Block, BlockVoxels, Lattice};

/// The largest stored number, which stands for 1.
const LARGEST: f32 = 65535.0;

/// The stored number that stands for no gradient along an axis, so that none is exactly none, and how far 1 and −1 are from it.
/// shaders/slices.frag knows them too.
const NO_GRADIENT: f32 = 32768.0;
const HALF: f32 = 32767.0;

/// Stores a fraction of 1. Rust's float casts saturate.
#[inline(always)]
fn stored(fraction: f32) -> u16 {
    (fraction * LARGEST + 0.5) as u16
}

/// Stores a component of a normal, in [−1, 1].
#[inline(always)]
fn stored_normal(component: f32) -> u16 {
    (component * HALF + (NO_GRADIENT + 0.5)) as u16
}

/// The scales of value times coverage and of coverage that sum up to the fraction of `range` times coverage.
fn fraction_scales(range: Interval) -> [f32; 2] {
    if range.width() > 0.0 {
        [1.0 / range.width(), -range.lo / range.width()]
    } else {
        [0.0, 0.0]
    }
}

/// The texels of a fully covered block of one value: `count` of them.
pub fn uniform(range: Interval, value: f32, lit: bool, count: usize) -> Vec<u16> {
    let [scale, offset] = fraction_scales(range);
    let value = stored(scale * value + offset);
    if lit {
        let none = stored_normal(0.0);
        [value, none, none, none].repeat(count)
    } else {
        vec![value; count]
    }
}

/// A reconstructed block on its way to texels, seen without the apron that only normals need.
pub struct Rows<'a> {
    block: &'a Block,
    voxels: &'a BlockVoxels,
    /// See [`fraction_scales`].
    scales: [f32; 2],
}

impl<'a> Rows<'a> {
    /// The rows of a block that was reconstructed with at least [`Block::APRON`] voxels of apron.
    pub fn new(block: &'a Block, voxels: &'a BlockVoxels, range: Interval) -> Self {
        assert!(voxels.apron >= Block::APRON, "an apron of {}", voxels.apron);
        Self {
            block,
            voxels,
            scales: fraction_scales(range),
        }
    }

    /// Stored texels along axis `axis`.
    fn len(&self, axis: usize) -> usize {
        self.block.extent[axis] + 2 * Block::APRON
    }

    /// The place of stored row `(j, k)` among the voxels.
    fn at(&self, j: usize, k: usize) -> Range<usize> {
        let skip = self.voxels.apron - Block::APRON;
        let begin = skip + self.voxels.dims[0] * (j + skip + self.voxels.dims[1] * (k + skip));
        begin..begin + self.len(0)
    }

    /// Values (and coverages, where there are any) of the stored planes `planes`.
    pub fn values(&self, planes: Range<usize>) -> Vec<u16> {
        let channels = 1 + usize::from(self.voxels.coverage.is_some());
        let row_len = self.len(0) * channels;
        let mut texels = vec![0; row_len * self.len(1) * planes.len()];
        let [scale, offset] = self.scales;
        for (n, out) in texels.chunks_exact_mut(row_len).enumerate() {
            let row = self.at(n % self.len(1), planes.start + n / self.len(1));
            let values = &self.voxels.premultiplied[row.clone()];
            match &self.voxels.coverage {
                None => {
                    for (out, v) in out.iter_mut().zip(values) {
                        *out = stored(scale * v + offset);
                    }
                }
                Some(coverage) => {
                    let pairs = values.iter().zip(&coverage[row]);
                    for (out, (v, c)) in out.chunks_exact_mut(2).zip(pairs) {
                        out[0] = stored(scale * v + offset * c);
                        out[1] = stored(*c);
                    }
                }
            }
        }
        texels
    }

    /// Colours times coverage and opacities times coverage, four channels, of the stored planes `planes`.
    pub fn colors(&self, planes: Range<usize>) -> Vec<u16> {
        let row_len = self.len(0) * 4;
        let mut texels = vec![0; row_len * self.len(1) * planes.len()];
        let rgb = self.voxels.rgb().unwrap_or_default();
        for (n, out) in texels.chunks_exact_mut(row_len).enumerate() {
            let row = self.at(n % self.len(1), planes.start + n / self.len(1));
            let pairs = rgb[row.clone()].iter().zip(&self.voxels.premultiplied[row]);
            for (out, (rgb, opacity)) in out.chunks_exact_mut(4).zip(pairs) {
                out[..3].copy_from_slice(&rgb.map(stored));
                out[3] = stored(*opacity);
            }
        }
        texels
    }

    /// Values with their soft normals (world frame) beside them, four channels, of the planes `planes` of a covered block.
    pub fn lit_values(&self, normals: &NormalRows, planes: Range<usize>) -> Vec<u16> {
        let [scale, offset] = self.scales;
        self.with_normals(normals, planes, |row, texels| {
            for (out, v) in texels.chunks_exact_mut(4).zip(&self.voxels.premultiplied[row]) {
                out[0] = stored(scale * v + offset);
            }
        })
    }

    /// Soft normals alone, with an empty first channel.
    pub fn normals(&self, normals: &NormalRows, planes: Range<usize>) -> Vec<u16> {
        self.with_normals(normals, planes, |_, _| {})
    }

    fn with_normals(
        &self,
        normals: &NormalRows,
        planes: Range<usize>,
        fill_first: impl Fn(Range<usize>, &mut [u16]),
    ) -> Vec<u16> {
        let row_len = self.len(0) * 4;
        let mut texels = vec![0; row_len * self.len(1) * planes.len()];
        let (mut slopes, mut row_normals) = (Slopes::default(), vec![Vec3::ZERO; self.len(0)]);
        for (n, out) in texels.chunks_exact_mut(row_len).enumerate() {
            let (j, k) = (n % self.len(1), planes.start + n / self.len(1));
            normals.fill_row(self, [j, k], &mut slopes, &mut row_normals);
            for (out, m) in out.chunks_exact_mut(4).zip(&row_normals) {
                out[1..].copy_from_slice(&m.to_array().map(stored_normal));
            }
            fill_first(self.at(j, k), out);
        }
        texels
    }
}

/// Soft normals of rows of voxels. A voxel beyond the lattice has the normal of the nearest one in it.
pub struct NormalRows {
    matrix: glam::Mat3,
    /// What normals are made of (see [`SoftNormals`]), with the voxels' own layout.
    fractions: Vec<f32>,
    /// The stored rows of the lattice's first and last voxels along each axis, as far as the block has them.
    inside: [Range<usize>; 3],
}

impl NormalRows {
    /// For a block reconstructed with [`Block::REACH`] voxels of apron.
    pub fn new(soft: &SoftNormals, range: Interval, lattice: &Lattice, block: &Block, voxels: &BlockVoxels) -> Self {
        assert_eq!(voxels.apron, Block::REACH, "normals look one voxel beyond the apron");
        let [scale, offset] = fraction_scales(range);
        let offset = offset + EMPTY_BELOW;
        let fractions = match &voxels.coverage {
            None => voxels.premultiplied.iter().map(|v| scale * v + offset).collect(),
            Some(coverage) => voxels
                .premultiplied
                .iter()
                .zip(coverage.iter())
                .map(|(v, c)| scale * v + offset * c)
                .collect(),
        };
        let inside = std::array::from_fn(|a| {
            let first = Block::APRON.saturating_sub(block.origin[a]);
            let last =
                (lattice.dims[a] - 1 + Block::APRON - block.origin[a]).min(block.extent[a] + 2 * Block::APRON - 1);
            first..last + 1
        });
        Self {
            matrix: soft.matrix().as_mat3(),
            fractions,
            inside,
        }
    }

    /// The normals of stored row `(j, k)`.
    fn fill_row(&self, rows: &Rows, [j, k]: [usize; 2], slopes: &mut Slopes, out: &mut [Vec3]) {
        let clamp = |n: usize, inside: &Range<usize>| n.clamp(inside.start, inside.end - 1);
        let row = rows.at(clamp(j, &self.inside[1]), clamp(k, &self.inside[2]));
        slopes.of_row(&self.fractions, rows.voxels.dims, row.start, out);
        for m in out.iter_mut() {
            let g = self.matrix * *m;
            *m = g / (1.0 + g.length_squared()).sqrt();
        }
        let Range { start, end } = self.inside[0];
        let (first, last) = (out[start], out[end - 1]);
        out[..start].fill(first);
        out[end..].fill(last);
    }
}
