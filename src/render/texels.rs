//! Reconstructed voxels as texels: values, coverages and soft normals as unsigned fractions of 8 or 16 bits.
//!
//! *Practice.* A texel of a covered block is its value, and in a lit target its soft normal beside it: one fetch brings both.
//! A texel of a mixed block is value times coverage and coverage; its normals lie in an image of their own.

use std::ops::Range;

use glam::{DVec3, Vec3};

use crate::math::Interval;
use crate::model::{Source, Tree, ValueRule};
use crate::projection::{EMPTY_BELOW, SoftNormals};
use crate::target::{Block, BlockVoxels, Lattice, Target};
use crate::volume::VoxelType;

/// How values become stored numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Encoding {
    /// Whole numbers 0 to 255 as they are, in 8 bits: nothing is lost.
    Bytes,
    /// Fractions of the target's value range, in 16 bits.
    Fractions(Interval),
}

impl Encoding {
    /// The encoding that suits `target`: bytes if its voxels are all copies of bytes. A `lit` target's normals want more
    /// than 8 bits, and four channels of 16 bits are fetched no slower than of 8 (`cargo bench --bench device`).
    pub fn of(target: &Target, lit: bool) -> Self {
        if !lit && makes_bytes(&target.tree) {
            Self::Bytes
        } else {
            Self::Fractions(target.value_range)
        }
    }

    /// Bytes of one stored number.
    pub fn bytes(self) -> usize {
        match self {
            Self::Bytes => 1,
            Self::Fractions(_) => 2,
        }
    }

    /// The largest stored number, which stands for 1.
    fn largest(self) -> f32 {
        match self {
            Self::Bytes => 255.0,
            Self::Fractions(_) => 65535.0,
        }
    }

    /// Scale and offset from what a shader reads (value and coverage) to fractions of `range`.
    pub fn fraction_of_stored(self, range: Interval) -> [f32; 2] {
        match self {
            Self::Bytes if range.width() > 0.0 => [255.0 / range.width(), -range.lo / range.width()],
            Self::Bytes => [0.0, 0.0],
            Self::Fractions(_) => [1.0, 0.0],
        }
    }

    /// Scale and offset from what a shader reads to the components of a normal: with the middle number standing for 0, no
    /// gradient is exactly none.
    pub fn normal_of_stored(self) -> [f32; 2] {
        let half = (self.largest() - 1.0) * 0.5;
        [self.largest() / half, -(half + 1.0) / half]
    }

    /// Scales of value times coverage and of coverage that sum up to the stored fraction of 1.
    fn stored_of_value(self) -> [f32; 2] {
        match self {
            Self::Bytes => [1.0 / 255.0, 0.0],
            Self::Fractions(range) => fraction_scales(range),
        }
    }

    /// Stores a fraction of 1. Rust's float casts saturate.
    #[inline(always)]
    fn put(self, fraction: f32, out: &mut [u8]) {
        let number = fraction * self.largest() + 0.5;
        match self {
            Self::Bytes => out[0] = number as u8,
            Self::Fractions(_) => out.copy_from_slice(&(number as u16).to_ne_bytes()),
        }
    }

    /// Stores a component of a normal, in [−1, 1].
    #[inline(always)]
    fn put_normal(self, component: f32, out: &mut [u8]) {
        let half = (self.largest() - 1.0) * 0.5;
        self.put((component * half + half + 1.0) / self.largest(), out);
    }
}

/// The scales of value times coverage and of coverage that sum up to the fraction of `range` times coverage.
fn fraction_scales(range: Interval) -> [f32; 2] {
    if range.width() > 0.0 {
        [1.0 / range.width(), -range.lo / range.width()]
    } else {
        [0.0, 0.0]
    }
}

/// Whether every sample of the tree at a lattice point is a whole number of 0 to 255: all volumes are bytes on the lattice
/// itself, and no operation makes other numbers of them.
fn makes_bytes(tree: &Tree) -> bool {
    let keeps_bytes = |rule: ValueRule| {
        matches!(
            rule,
            ValueRule::First | ValueRule::Second | ValueRule::Max | ValueRule::Min
        )
    };
    !tree.has_maps()
        && tree.operators().iter().all(|o| keeps_bytes(o.rule))
        && tree.leaves().iter().all(|leaf| match &leaf.source {
            Source::Volume(volume) => {
                volume.bricks.voxel_type() == VoxelType::U8 && steps_whole(&leaf.local_from_frame)
            }
            Source::Primitive { value, .. } => value.fract() == 0.0 && (0.0..=255.0).contains(value),
        })
}

/// Whether a map takes whole numbers to whole numbers.
fn steps_whole(map: &glam::DAffine3) -> bool {
    let m = &map.matrix3;
    [m.x_axis, m.y_axis, m.z_axis, map.translation]
        .into_iter()
        .all(|v: DVec3| v.round() == v)
}

/// The texels of a fully covered block of one value: `count` of them.
pub fn uniform(encoding: Encoding, value: f32, lit: bool, count: usize) -> Vec<u8> {
    let size = encoding.bytes();
    let mut texel = vec![0; size * if lit { 4 } else { 1 }];
    let [scale, offset] = encoding.stored_of_value();
    encoding.put(scale * value + offset, &mut texel[..size]);
    for component in texel.chunks_exact_mut(size).skip(1) {
        encoding.put_normal(0.0, component);
    }
    texel.repeat(count)
}

/// A reconstructed block on its way to texels, seen without the apron that only normals need.
pub struct Rows<'a> {
    block: &'a Block,
    voxels: &'a BlockVoxels,
    encoding: Encoding,
}

impl<'a> Rows<'a> {
    /// The rows of a block that was reconstructed with at least [`Block::APRON`] voxels of apron.
    pub fn new(block: &'a Block, voxels: &'a BlockVoxels, encoding: Encoding) -> Self {
        assert!(voxels.apron >= Block::APRON, "an apron of {}", voxels.apron);
        Self {
            block,
            voxels,
            encoding,
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
    pub fn values(&self, planes: Range<usize>) -> Vec<u8> {
        let size = self.encoding.bytes();
        let channels = 1 + usize::from(self.voxels.coverage.is_some());
        let row_bytes = self.len(0) * size * channels;
        let mut texels = vec![0; row_bytes * self.len(1) * planes.len()];
        let [scale, offset] = self.encoding.stored_of_value();
        for (n, out) in texels.chunks_exact_mut(row_bytes).enumerate() {
            let row = self.at(n % self.len(1), planes.start + n / self.len(1));
            let values = &self.voxels.premultiplied[row.clone()];
            match &self.voxels.coverage {
                None => {
                    for (out, v) in out.chunks_exact_mut(size).zip(values) {
                        self.encoding.put(scale * v + offset, out);
                    }
                }
                Some(coverage) => {
                    let pairs = values.iter().zip(&coverage[row]);
                    for (out, (v, c)) in out.chunks_exact_mut(2 * size).zip(pairs) {
                        let (value, cover) = out.split_at_mut(size);
                        self.encoding.put(scale * v + offset * c, value);
                        self.encoding.put(*c, cover);
                    }
                }
            }
        }
        texels
    }

    /// Values with their soft normals (world frame) beside them, four channels, of the planes `planes` of a covered block.
    pub fn lit_values(&self, normals: &NormalRows, planes: Range<usize>) -> Vec<u8> {
        let [scale, offset] = self.encoding.stored_of_value();
        self.with_normals(normals, planes, self.encoding, |row, first, size| {
            let values = &self.voxels.premultiplied[row];
            for (out, v) in first.chunks_exact_mut(4 * size).zip(values) {
                self.encoding.put(scale * v + offset, &mut out[..size]);
            }
        })
    }

    /// Soft normals alone, in 8 bits with an empty first channel.
    pub fn normals(&self, normals: &NormalRows, planes: Range<usize>) -> Vec<u8> {
        self.with_normals(normals, planes, Encoding::Bytes, |_, _, _| {})
    }

    fn with_normals(
        &self,
        normals: &NormalRows,
        planes: Range<usize>,
        encoding: Encoding,
        fill_first: impl Fn(Range<usize>, &mut [u8], usize),
    ) -> Vec<u8> {
        let size = encoding.bytes();
        let row_bytes = self.len(0) * size * 4;
        let mut texels = vec![0; row_bytes * self.len(1) * planes.len()];
        let mut row_normals = vec![Vec3::ZERO; self.len(0)];
        for (n, out) in texels.chunks_exact_mut(row_bytes).enumerate() {
            let (j, k) = (n % self.len(1), planes.start + n / self.len(1));
            normals.fill_row(self, j, k, &mut row_normals);
            for (out, m) in out.chunks_exact_mut(4 * size).zip(&row_normals) {
                for (a, component) in m.to_array().into_iter().enumerate() {
                    encoding.put_normal(component, &mut out[(a + 1) * size..(a + 2) * size]);
                }
            }
            fill_first(self.at(j, k), out, size);
        }
        texels
    }
}

/// Soft normals by central differences. A voxel beyond the lattice has the normal of the nearest one in it.
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
                .zip(coverage)
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

    fn fill_row(&self, rows: &Rows, j: usize, k: usize, out: &mut [Vec3]) {
        let clamp = |n: usize, inside: &Range<usize>| n.clamp(inside.start, inside.end - 1);
        let row = rows.at(clamp(j, &self.inside[1]), clamp(k, &self.inside[2]));
        let (y, z) = (rows.voxels.dims[0], rows.voxels.dims[0] * rows.voxels.dims[1]);
        let part = |from: usize| &self.fractions[from..from + row.len()];
        let (x0, x1) = (part(row.start - 1), part(row.start + 1));
        let (y0, y1) = (part(row.start - y), part(row.start + y));
        let (z0, z1) = (part(row.start - z), part(row.start + z));
        for (n, m) in out.iter_mut().enumerate() {
            let half = 0.5 * Vec3::new(x1[n] - x0[n], y1[n] - y0[n], z1[n] - z0[n]);
            let g = self.matrix * half;
            *m = g / (1.0 + g.length_squared()).sqrt();
        }
        let Range { start, end } = self.inside[0];
        let (first, last) = (out[start], out[end - 1]);
        out[..start].fill(first);
        out[end..].fill(last);
    }
}
