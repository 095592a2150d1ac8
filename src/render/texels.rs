//! Reconstructed voxels as texels: values in 8 or 16 bits, soft normals in 8.

use glam::DVec3;

use crate::math::Interval;
use crate::model::{Source, Tree, ValueRule};
use crate::projection::SoftNormals;
use crate::target::{Block, BlockVoxels, Lattice, Target};
use crate::volume::VoxelType;

/// How values become texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Encoding {
    /// Whole numbers 0 to 255 as they are: nothing is lost.
    Bytes,
    /// Fractions of the target's value range, in 65535ths.
    Fractions(Interval),
}

impl Encoding {
    /// The encoding that suits `target`: bytes if its voxels are all copies of bytes.
    pub fn of(target: &Target) -> Self {
        if makes_bytes(&target.tree) {
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

    /// Scale and offset from what a shader reads (value and coverage) to fractions of `range`.
    pub fn fraction_of_stored(self, range: Interval) -> [f32; 2] {
        match self {
            Self::Bytes if range.width() > 0.0 => {
                [255.0 / range.width(), -range.lo / range.width()]
            }
            Self::Bytes => [0.0, 0.0],
            Self::Fractions(_) => [1.0, 0.0],
        }
    }

    fn push(self, premultiplied: f32, coverage: f32, texels: &mut Vec<u8>) {
        match self {
            // Rust's float casts saturate.
            Self::Bytes => texels.push((premultiplied + 0.5) as u8),
            Self::Fractions(range) => {
                let fraction = fraction(range, premultiplied, coverage);
                push_unorm16(fraction, texels);
            }
        }
    }

    fn push_coverage(self, coverage: f32, texels: &mut Vec<u8>) {
        match self {
            Self::Bytes => texels.push((coverage * 255.0 + 0.5) as u8),
            Self::Fractions(_) => push_unorm16(coverage, texels),
        }
    }
}

fn push_unorm16(fraction: f32, texels: &mut Vec<u8>) {
    texels.extend(((fraction * 65535.0 + 0.5) as u16).to_ne_bytes());
}

/// A value as a fraction of `range`, times coverage.
fn fraction(range: Interval, premultiplied: f32, coverage: f32) -> f32 {
    if range.width() > 0.0 {
        (premultiplied - range.lo * coverage) / range.width()
    } else {
        0.0
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
    let leaf_is_bytes = |source: &Source, whole_steps: bool| match source {
        Source::Volume(leaf) => leaf.bricks.voxel_type() == VoxelType::U8 && whole_steps,
        Source::Primitive { value, .. } => value.fract() == 0.0 && (0.0..=255.0).contains(value),
    };
    !tree.has_maps()
        && tree.operators().iter().all(|o| keeps_bytes(o.rule))
        && tree.leaves().iter().all(|leaf| {
            let map = leaf.local_from_frame;
            let whole = |v: DVec3| v.round() == v;
            let m = map.matrix3;
            let whole_steps = [m.x_axis, m.y_axis, m.z_axis, map.translation]
                .into_iter()
                .all(whole);
            leaf_is_bytes(&leaf.source, whole_steps)
        })
}

/// The texel of a fully covered voxel of one value.
pub fn one(encoding: Encoding, value: f32) -> Vec<u8> {
    let mut texel = Vec::new();
    encoding.push(value, 1.0, &mut texel);
    texel
}

/// The texels of the planes `planes` (counted from the first apron plane) of a block that was reconstructed with at least
/// [`Block::APRON`] voxels of apron.
pub fn values(
    encoding: Encoding,
    block: &Block,
    voxels: &BlockVoxels,
    planes: std::ops::Range<usize>,
) -> Vec<u8> {
    let skip = voxels.apron - Block::APRON;
    let [width, height] = [0, 1].map(|a| block.extent[a] + 2 * Block::APRON);
    let channels = 1 + usize::from(voxels.coverage.is_some());
    let mut texels =
        Vec::with_capacity(width * height * planes.len() * channels * encoding.bytes());
    for k in planes {
        for j in 0..height {
            let row = skip + voxels.dims[0] * (j + skip + voxels.dims[1] * (k + skip));
            let values = &voxels.premultiplied[row..row + width];
            match &voxels.coverage {
                None => values
                    .iter()
                    .for_each(|&v| encoding.push(v, 1.0, &mut texels)),
                Some(coverage) => {
                    for (&v, &c) in values.iter().zip(&coverage[row..row + width]) {
                        encoding.push(v, c, &mut texels);
                        encoding.push_coverage(c, &mut texels);
                    }
                }
            }
        }
    }
    texels
}

/// The soft normals (world frame) of the same planes, four bytes a texel: 128 stands for 0, a step for 1/127. The block must
/// have been reconstructed with [`Block::REACH`] voxels of apron. A voxel beyond the lattice has the normal of the nearest
/// one in it.
pub fn normals(
    soft: &SoftNormals,
    range: Interval,
    lattice: &Lattice,
    block: &Block,
    voxels: &BlockVoxels,
    planes: std::ops::Range<usize>,
) -> Vec<u8> {
    assert_eq!(
        voxels.apron,
        Block::REACH,
        "normals look one voxel beyond the apron"
    );
    let inside = |axis: usize| -> Vec<usize> {
        let stored = block.extent[axis] + 2 * Block::APRON;
        (0..stored)
            .map(|s| {
                let at = (block.origin[axis] + s).saturating_sub(Block::APRON);
                at.min(lattice.dims[axis] - 1) + voxels.apron - block.origin[axis]
            })
            .collect()
    };
    let (xs, ys, zs) = (inside(0), inside(1), inside(2));
    let strides = [1, voxels.dims[0], voxels.dims[0] * voxels.dims[1]];
    let at = |n: usize| {
        let coverage = voxels.coverage.as_ref().map_or(1.0, |c| c[n]);
        fraction(range, voxels.premultiplied[n], coverage)
    };
    let matrix = soft.matrix().as_mat3();
    let mut texels = Vec::with_capacity(xs.len() * ys.len() * planes.len() * 4);
    for &k in &zs[planes] {
        for &j in &ys {
            let row = j * strides[1] + k * strides[2];
            for &i in &xs {
                let n = row + i;
                let half = strides.map(|s| 0.5 * (at(n + s) - at(n - s)));
                let g = matrix * glam::Vec3::from_array(half);
                let m = g * (127.0 / (1.0 + g.length_squared()).sqrt());
                texels.extend([m.x, m.y, m.z].map(|c| (c + 128.5) as u8));
                texels.push(0);
            }
        }
    }
    texels
}
