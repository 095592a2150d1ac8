//! The reference projector: slow, in double precision, and obviously right.
//!
//! For each pixel it walks the planes from the farthest to the nearest, takes the trilinear sample of the voxels round the
//! point where the pixel's ray meets the plane, and blends it. It knows nothing of blocks, templates or visibility.

use glam::{DAffine3, DVec3};
use rayon::prelude::*;

use super::composite::{self, value_source};
use super::table::lengthened;
use super::{
    EMPTY_BELOW, FrameSpec, Mode, Planes, ProjectError, Projector, SoftNormals, TransferTable, half_differences,
};
use crate::image::Frame;
use crate::math::{Aabb, affine};
use crate::target::VoxelTarget;

/// See the module head.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reference;

impl Projector for Reference {
    fn project(&mut self, spec: &FrameSpec) -> Result<Frame, ProjectError> {
        spec.check()?;
        let voxels = VoxelTarget::new(spec.target);
        Ok(render(&voxels, spec))
    }
}

/// The frame of a target whose voxels are at hand.
pub fn render(voxels: &VoxelTarget, spec: &FrameSpec) -> Frame {
    render_where(voxels, spec, &|_| true)
}

/// Like [`render`], with only the samples at the points that `shown` (in lattice coordinates) admits.
pub fn render_where(voxels: &VoxelTarget, spec: &FrameSpec, shown: &(dyn Fn(DVec3) -> bool + Sync)) -> Frame {
    let marcher = Marcher::new(voxels, spec, shown);
    let [width, height] = spec.camera.size;
    let mut frame = Frame::transparent(width, height);
    frame
        .pixels_mut()
        .par_chunks_mut(width.max(1) as usize)
        .enumerate()
        .for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                *pixel = marcher.pixel(x as u32, y as u32).map(|c| c as f32);
            }
        });
    composite::resolve(spec.settings.mode, frame, spec.target.value_range, spec.transfer)
}

/// A sample of the target: fraction of the value range (or opacity) times coverage, coverage, colour times opacity and coverage, and
/// soft normal in the eye frame.
struct LatticeSample {
    weighted: f64,
    coverage: f64,
    rgb: [f64; 3],
    normal: DVec3,
}

struct Marcher<'a> {
    voxels: &'a VoxelTarget<'a>,
    spec: &'a FrameSpec<'a>,
    shown: &'a (dyn Fn(DVec3) -> bool + Sync),
    lattice_from_eye: DAffine3,
    bounds: Aabb,
    eye_bounds: Aabb,
    planes: Planes,
    table: TransferTable,
    /// See [`FrameSpec::slab_units`].
    slab_units: Option<f64>,
    normals: Option<SoftNormals>,
}

impl<'a> Marcher<'a> {
    fn new(voxels: &'a VoxelTarget<'a>, spec: &'a FrameSpec<'a>, shown: &'a (dyn Fn(DVec3) -> bool + Sync)) -> Self {
        let lattice = &spec.target.lattice;
        let eye_from_lattice = super::eye_from_lattice(lattice, spec.camera);
        Self {
            voxels,
            spec,
            shown,
            lattice_from_eye: eye_from_lattice.inverse(),
            bounds: lattice.bounds(),
            eye_bounds: lattice.bounds().transformed(&eye_from_lattice),
            planes: spec.planes(),
            table: spec.table(),
            slab_units: spec.slab_units(),
            normals: spec.shading().map(|s| SoftNormals::new(lattice, s.soft_gradient)),
        }
    }

    fn pixel(&self, x: u32, y: u32) -> [f64; 4] {
        let camera = self.spec.camera;
        let path_per_depth = camera.path_per_depth(x, y);
        let near = self.eye_bounds.min.z.max(camera.near_mm());
        let blending = self.spec.settings.mode.blending();
        let mut pixel = [0.0; 4];
        for k in self.planes.between(near, self.eye_bounds.max.z).rev() {
            let eye = camera.point_at_depth(x, y, self.planes.depth(k));
            let at = affine::point(&self.lattice_from_eye, eye);
            if !self.bounds.contains(at) || !(self.shown)(at) {
                continue;
            }
            let sample = self.sample(at);
            if sample.coverage > 0.0 {
                pixel = blending.blend(self.source(&sample, eye.z, path_per_depth), pixel);
            }
        }
        pixel
    }

    fn source(&self, s: &LatticeSample, depth: f64, path_per_depth: f64) -> [f64; 4] {
        let mode = self.spec.settings.mode;
        if !mode.classifies() {
            return value_source(mode, s.weighted, s.coverage, path_per_depth);
        }
        let [r, g, b, a] = self.colour(s, path_per_depth);
        if mode == Mode::XRay {
            return [a; 4];
        }
        let (factor, highlight) = self
            .spec
            .shading()
            .map_or((1.0, 0.0), |shading| shading.response(s.normal));
        let cue = self
            .spec
            .settings
            .depth_cue
            .factor(depth, self.eye_bounds.min.z, self.eye_bounds.max.z);
        let [r, g, b] = [r, g, b].map(|c| cue * (factor * c + highlight * a));
        [r, g, b, a]
    }

    /// Premultiplied colour and opacity of one slab of ray.
    fn colour(&self, s: &LatticeSample, path_per_depth: f64) -> [f64; 4] {
        match self.slab_units {
            Some(units) => {
                let [r, g, b] = s.rgb;
                lengthened([r, g, b, s.weighted], units * path_per_depth)
            }
            None => {
                let entry = lengthened(self.table.at(s.weighted / s.coverage), path_per_depth);
                entry.map(|c| c * s.coverage)
            }
        }
    }

    fn sample(&self, at: DVec3) -> LatticeSample {
        let (corners, fraction) = self.voxels.cell(at);
        let weights: [f64; 8] = std::array::from_fn(|n| weight(n, fraction));
        let mix = |f: &dyn Fn(usize) -> f64| (0..8).map(|n| weights[n] * f(n)).sum::<f64>();
        let coverage = mix(&|n| f64::from(corners[n].1));
        let weighted = mix(&|n| self.fraction(corners[n]));
        let base = at.floor().as_i64vec3().to_array();
        let corner = |n: usize| std::array::from_fn(|a| base[a] + (n >> a & 1) as i64);
        let mut normal = DVec3::ZERO;
        if coverage > 0.0 && self.normals.is_some() {
            for (n, w) in weights.into_iter().enumerate() {
                normal += w * self.voxel_normal(corner(n));
            }
        }
        let mut rgb = [0.0; 3];
        if coverage > 0.0 && self.slab_units.is_some() {
            let corners: [[f32; 3]; 8] = std::array::from_fn(|n| self.voxels.rgb(corner(n)));
            rgb = std::array::from_fn(|c| mix(&|n| f64::from(corners[n][c])));
        }
        LatticeSample {
            weighted,
            coverage,
            rgb,
            normal,
        }
    }

    /// (v − lo)/(hi − lo) · c of a voxel's (v·c, c).
    fn fraction(&self, (premultiplied, coverage): (f32, f32)) -> f64 {
        let range = self.voxels.target.value_range;
        let width = f64::from(range.hi) - f64::from(range.lo);
        if width <= 0.0 {
            return 0.0;
        }
        (f64::from(premultiplied) - f64::from(range.lo) * f64::from(coverage)) / width
    }

    /// The soft normal of a voxel in the eye frame. Beyond the lattice its outermost voxels go on,
    /// so a voxel there has the normal of the nearest one in it.
    fn voxel_normal(&self, at: [i64; 3]) -> DVec3 {
        let Some(normals) = self.normals else {
            return DVec3::ZERO;
        };
        let dims = self.voxels.target.lattice.dims;
        let at: [i64; 3] = std::array::from_fn(|a| at[a].clamp(0, dims[a] as i64 - 1));
        let half = half_differences(|by| {
            let voxel = self.voxels.voxel(std::array::from_fn(|a| at[a] + by[a]));
            self.fraction(voxel) + f64::from(EMPTY_BELOW) * f64::from(voxel.1)
        });
        self.spec.camera.eye_from_world.matrix3 * normals.normal(half)
    }
}

/// The trilinear weight of corner `n` of a cell.
fn weight(n: usize, fraction: DVec3) -> f64 {
    (0..3)
        .map(|a| {
            if n >> a & 1 == 1 {
                fraction[a]
            } else {
                1.0 - fraction[a]
            }
        })
        .product()
}
