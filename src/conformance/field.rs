//! The voxels of a target at hand, and all that a trilinear sample can be whose position is known up to a box.
//!
//! *Theory.* A trilinear sample is linear along each axis between voxel centres, so over a box that no plane of centres
//! cuts its extremes are at corners. The quotient of value times coverage by coverage is, at any point, a mean of what it is at
//! the corners, weighted by their coverage, so its extremes are there too.

use glam::DVec3;
use rayon::prelude::*;

use super::normal::StoredNormals;
use super::span::Span;
use crate::math::Aabb;
use crate::projection::{EMPTY_BELOW, FrameSpec, half_differences};
use crate::target::{Layout, Target, VoxelTarget};

/// Fraction of the value range times coverage, coverage, and the least and the most that the three parts of the soft normal
/// in the world may have been stored as; of colours, whose values are opacities, red, green and blue times opacity and coverage.
type Channels = [f64; 11];

const WEIGHTED: usize = 0;
const COVERAGE: usize = 1;
const NORMAL_LO: usize = 2;
const NORMAL_HI: usize = 5;
const RGB: usize = 8;

/// All voxels of a target.
pub(super) struct VoxelField {
    dims: [usize; 3],
    voxels: Vec<Channels>,
    /// Whether the voxel's block stores coverage.
    mixed: Vec<bool>,
    /// How many of the channels are used.
    channels: usize,
}

/// What a sample can be, before anything is rounded.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hull {
    /// Fraction of the value range times coverage.
    pub weighted: Span,
    /// Coverage.
    pub coverage: Span,
    /// Fraction of the value range where coverage is above 0.
    pub fraction: Span,
    /// Red, green and blue times opacity and coverage, of colours.
    pub rgb: [Span; 3],
    /// The soft normal in the world.
    pub normal: [Span; 3],
    /// Whether it may be read from texels that store coverage.
    pub mixed: bool,
    /// Whether all coverage round it is 0 or 1, which no format rounds.
    pub crisp: bool,
}

impl VoxelField {
    pub(super) fn new(spec: &FrameSpec) -> Self {
        let voxels = VoxelTarget::new(spec.target);
        let dims = spec.target.lattice.dims;
        let places: Vec<[i64; 3]> = places(dims);
        let mut field = Self {
            dims,
            voxels: places.par_iter().map(|&at| value_and_coverage(&voxels, at)).collect(),
            mixed: places.par_iter().map(|&at| is_mixed(spec.target, at)).collect(),
            channels: NORMAL_LO,
        };
        if let Some(normals) = StoredNormals::of(spec) {
            field.add_normals(&normals, &places);
        }
        if spec.target.tree.has_colors() {
            field.add_colors(&voxels, &places);
        }
        field
    }

    fn add_colors(&mut self, voxels: &VoxelTarget, places: &[[i64; 3]]) {
        for (voxel, &at) in self.voxels.iter_mut().zip(places) {
            voxel[RGB..].copy_from_slice(&voxels.rgb(at).map(f64::from));
        }
        self.channels = RGB + 3;
    }

    fn add_normals(&mut self, normals: &StoredNormals, places: &[[i64; 3]]) {
        let stored: Vec<[Span; 3]> = places
            .par_iter()
            .map(|&at| normals.at(self.half_differences(at)))
            .collect();
        for (voxel, normal) in self.voxels.iter_mut().zip(stored) {
            voxel[NORMAL_LO..NORMAL_HI].copy_from_slice(&normal.map(|part| part.lo));
            voxel[NORMAL_HI..RGB].copy_from_slice(&normal.map(|part| part.hi));
        }
        self.channels = RGB;
    }

    fn half_differences(&self, at: [i64; 3]) -> DVec3 {
        half_differences(|by| {
            let voxel = &self.voxels[self.index(std::array::from_fn(|a| at[a] + by[a]))];
            voxel[WEIGHTED] + f64::from(EMPTY_BELOW) * voxel[COVERAGE]
        })
    }

    /// The voxel at a lattice point of whole coordinates; beyond the lattice its outermost voxels go on.
    fn index(&self, at: [i64; 3]) -> usize {
        let [i, j, k]: [usize; 3] = std::array::from_fn(|a| at[a].clamp(0, self.dims[a] as i64 - 1) as usize);
        i + self.dims[0] * (j + self.dims[1] * k)
    }

    /// All that samples in `region` (lattice coordinates) can be; `None` where there is nothing.
    pub(super) fn hull(&self, region: &Aabb) -> Option<Hull> {
        let mut hull = Hull {
            weighted: Span::EMPTY,
            coverage: Span::EMPTY,
            fraction: Span::EMPTY,
            rgb: [Span::EMPTY; 3],
            normal: [Span::EMPTY; 3],
            mixed: self.may_be_mixed(region),
            crisp: true,
        };
        for_each_part(region, |base, from, to| {
            let cell = self.cell(base);
            hull.crisp &= cell.iter().all(|voxel| voxel[COVERAGE].fract() == 0.0);
            for corner in 0..8 {
                let at = std::array::from_fn(|a| if corner >> a & 1 == 0 { from[a] } else { to[a] });
                hull.add(&trilinear(&cell, at, self.channels));
            }
        });
        (hull.coverage.hi > 0.0).then_some(hull)
    }

    fn cell(&self, base: [i64; 3]) -> [Channels; 8] {
        std::array::from_fn(|n| self.voxels[self.index(std::array::from_fn(|a| base[a] + (n >> a & 1) as i64))])
    }

    /// A voxel's own cell reaches half a step from it.
    fn may_be_mixed(&self, region: &Aabb) -> bool {
        region
            .corners()
            .into_iter()
            .any(|corner| self.mixed[self.index(corner.round().as_i64vec3().to_array())])
    }
}

impl Hull {
    fn add(&mut self, sample: &Channels) {
        let [weighted, coverage, ..] = *sample;
        self.weighted = self.weighted.with(weighted);
        self.coverage = self.coverage.with(coverage);
        if coverage > 0.0 {
            self.fraction = self.fraction.with(weighted / coverage);
        }
        for (n, span) in self.normal.iter_mut().enumerate() {
            let stored = Span::new(sample[NORMAL_LO + n], sample[NORMAL_HI + n]);
            *span = span.hull(stored);
        }
        for (n, span) in self.rgb.iter_mut().enumerate() {
            *span = span.with(sample[RGB + n]);
        }
    }
}

fn places(dims: [usize; 3]) -> Vec<[i64; 3]> {
    let [width, height, depth] = dims.map(|n| n as i64);
    (0..depth)
        .flat_map(|k| (0..height).flat_map(move |j| (0..width).map(move |i| [i, j, k])))
        .collect()
}

fn value_and_coverage(voxels: &VoxelTarget, at: [i64; 3]) -> Channels {
    let (premultiplied, coverage) = voxels.voxel(at);
    let [premultiplied, coverage] = [premultiplied, coverage].map(f64::from);
    let range = voxels.target.value_range;
    let width = f64::from(range.hi) - f64::from(range.lo);
    let weighted = if width > 0.0 {
        (premultiplied - f64::from(range.lo) * coverage) / width
    } else {
        0.0
    };
    let mut channels = [0.0; 11];
    channels[WEIGHTED] = weighted;
    channels[COVERAGE] = coverage;
    channels
}

fn is_mixed(target: &Target, at: [i64; 3]) -> bool {
    let block = target.block_at(at.map(|n| n as usize));
    block.is_some_and(|b| target.blocks[b].layout == Layout::Mixed)
}

/// Cuts `region` at the planes of voxel centres, and hands out the base voxel of each part and its ends from there.
fn for_each_part(region: &Aabb, mut part: impl FnMut([i64; 3], [f64; 3], [f64; 3])) {
    let first = region.min.floor();
    let pieces = (region.max - first).ceil().max(DVec3::ONE);
    let [nx, ny, nz] = pieces.as_i64vec3().to_array();
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                let base = first + DVec3::new(x as f64, y as f64, z as f64);
                let from = (region.min - base).clamp(DVec3::ZERO, DVec3::ONE);
                let to = (region.max - base).clamp(DVec3::ZERO, DVec3::ONE);
                part(base.as_i64vec3().to_array(), from.to_array(), to.to_array());
            }
        }
    }
}

/// The first `channels` of the sample at fraction `at` of a cell, bit `a` of a corner's index being the higher one on axis `a`.
fn trilinear(cell: &[Channels; 8], [x, y, z]: [f64; 3], channels: usize) -> Channels {
    let mix = |a: f64, b: f64, t: f64| a + t * (b - a);
    let mut sample = Channels::default();
    for (c, mixed) in sample.iter_mut().enumerate().take(channels) {
        let along_x: [f64; 4] = std::array::from_fn(|n| mix(cell[2 * n][c], cell[2 * n + 1][c], x));
        let along_y = [mix(along_x[0], along_x[1], y), mix(along_x[2], along_x[3], y)];
        *mixed = mix(along_y[0], along_y[1], z);
    }
    sample
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn field(values: &[f64], covered: &[bool]) -> VoxelField {
        let voxels = values.iter().zip(covered).map(|(&v, &c)| {
            let mut channels = Channels::default();
            channels[COVERAGE] = f64::from(u8::from(c));
            channels[WEIGHTED] = v * channels[COVERAGE];
            channels
        });
        VoxelField {
            dims: [3; 3],
            voxels: voxels.collect(),
            mixed: vec![true; 27],
            channels: NORMAL_LO,
        }
    }

    proptest! {
        #[test]
        fn a_hull_holds_every_sample_of_its_region(
            values in prop::collection::vec(0.0f64..1.0, 27),
            covered in prop::collection::vec(any::<bool>(), 27),
            middle in prop::array::uniform3(-0.4f64..2.4),
            at in prop::array::uniform3(-1.0f64..1.0),
        ) {
            let field = field(&values, &covered);
            let (middle, reach) = (DVec3::from_array(middle), DVec3::splat(0.3));
            let p = middle + reach * DVec3::from_array(at);
            let base = p.floor();
            let cell = field.cell(base.as_i64vec3().to_array());
            let sample = trilinear(&cell, (p - base).to_array(), NORMAL_LO);
            let hull = field.hull(&Aabb::new(middle - reach, middle + reach));
            let holds = |span: Span, v: f64| span.lo - 1e-12 <= v && v <= span.hi + 1e-12;
            match hull {
                None => prop_assert_eq!(sample[COVERAGE], 0.0),
                Some(hull) => {
                    prop_assert!(holds(hull.weighted, sample[WEIGHTED]));
                    prop_assert!(holds(hull.coverage, sample[COVERAGE]));
                    if sample[COVERAGE] > 1e-9 {
                        prop_assert!(holds(hull.fraction, sample[WEIGHTED] / sample[COVERAGE]));
                    }
                }
            }
        }
    }
}
