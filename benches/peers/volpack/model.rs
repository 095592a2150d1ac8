//! A slow model of how we draw and of how VolPack does, in double precision: every cause of a difference is there both ways.
//!
//! A picture is made of rays, a ray of samples from front to back, a sample of eight voxels. VolPack's way is that of its sources
//! and of P. Lacroute, "Fast volume rendering using a shear-warp factorization of the viewing transformation" (1995).

use glam::{BVec3, DAffine3, DVec2, DVec3};
use rayon::prelude::*;
use vcsg::image::Frame;
use vcsg::math::Aabb;
use vcsg::projection::{FrameSpec, Planes, Shading, SoftNormals, eye_from_lattice, half_differences};

use super::causes::{Cause, END, FAINT};
use super::normals;
use super::slices::SliceRays;
use crate::Outcome;

const OUR_END: f64 = 1.0 - 1.0 / 1024.0;

/// Where the light of a ray comes from: lattice coordinates.
#[derive(Clone, Copy)]
pub struct Ray {
    /// A point on it.
    pub through: DVec3,
    /// Away from the eye.
    pub along: DVec3,
}

/// Opacity, and light weighted by it.
type Shown = [f64; 2];

/// A volume of bytes in a view, drawn in VolPack's way as far as `theirs` says, and else in ours.
pub struct Model<'a> {
    values: &'a [u8],
    spec: &'a FrameSpec<'a>,
    shading: &'a Shading,
    theirs: &'a [Cause],
    eye_from_lattice: DAffine3,
    planes: Planes,
    /// Between samples, voxels.
    step: f64,
    /// Of each voxel, in the eye frame.
    normals: Vec<DVec3>,
    /// Of each voxel, for a step of ray.
    opacities: Vec<f64>,
    /// What each voxel sends back.
    lights: Vec<f64>,
}

impl<'a> Model<'a> {
    /// The volume is that of the target's one leaf.
    pub fn new(values: &'a [u8], spec: &'a FrameSpec<'a>, theirs: &'a [Cause]) -> Outcome<Self> {
        let mut model = Self {
            values,
            spec,
            shading: spec.settings.shading.as_ref().ok_or("the model is lit")?,
            theirs,
            eye_from_lattice: eye_from_lattice(&spec.target.lattice, spec.camera),
            planes: spec.planes(),
            step: spec.planes().step_mm,
            normals: Vec::new(),
            opacities: Vec::new(),
            lights: Vec::new(),
        };
        if model.is(Cause::Slices) {
            model.step = 1.0 / model.ray(DVec2::ZERO).along.abs().max_element();
        }
        let all = || (0..values.len()).into_par_iter();
        model.normals = all().map(|n| model.normal(n)).collect();
        model.opacities = all().map(|n| model.opacity(f64::from(values[n]))).collect();
        model.lights = all().map(|n| model.light(model.normals[n])).collect();
        Ok(model)
    }

    /// The picture.
    pub fn draw(&self) -> Outcome<Frame> {
        let [width, height] = self.spec.camera.size;
        let middle = |n: u32| DVec2::new(f64::from(n % width), f64::from(n / width)) + 0.5;
        let pixels = (0..width * height).into_par_iter().map(middle);
        let light: Vec<f64> = match self.is(Cause::Resolution) {
            true => {
                let picture = SliceRays::new(self).draw(self);
                pixels.map(|px| picture.at(self, px)).collect()
            }
            false => pixels.map(|px| self.cast(self.ray(px))).collect(),
        };
        let grey = |c: f64| {
            let c = if self.is(Cause::Rounding) { byte_below(c) } else { c } as f32;
            [c, c, c, 1.0]
        };
        Ok(Frame::from_pixels(
            width,
            height,
            light.into_iter().map(grey).collect(),
        )?)
    }

    /// Whether that is done in VolPack's way.
    pub fn is(&self, cause: Cause) -> bool {
        self.theirs.contains(&cause)
    }

    /// Voxels along each axis.
    pub fn dims(&self) -> [usize; 3] {
        self.spec.target.lattice.dims
    }

    /// The ray through a place in the frame.
    pub fn ray(&self, px: DVec2) -> Ray {
        let lattice_from_eye = self.eye_from_lattice.inverse();
        Ray {
            through: lattice_from_eye.transform_point3(self.spec.camera.unproject(px, 0.0)),
            along: lattice_from_eye.transform_vector3(DVec3::Z),
        }
    }

    /// The light that comes along a ray.
    pub fn cast(&self, ray: Ray) -> f64 {
        let end = if self.is(Cause::End) { END } else { OUR_END };
        let points = match self.is(Cause::Slices) {
            true => self.points_in_slices(ray),
            false => self.points_in_planes(ray),
        };
        let [mut opacity, mut light] = [0.0; 2];
        for [shown, lit] in points.into_iter().map(|at| self.sample(at)) {
            light += (1.0 - opacity) * lit;
            opacity += (1.0 - opacity) * shown;
            if opacity >= end {
                break;
            }
        }
        light
    }

    /// Ours: in planes across the view.
    fn points_in_planes(&self, ray: Ray) -> Vec<DVec3> {
        let depth_through = self.eye_from_lattice.transform_point3(ray.through).z;
        let bounds = self.spec.target.lattice.bounds();
        let depths = bounds.transformed(&self.eye_from_lattice);
        let planes = self.planes.between(depths.min.z, depths.max.z);
        let point = |k| ray.through + ray.along * (self.planes.depth(k) - depth_through);
        planes.map(point).filter(|&at| bounds.contains(at)).collect()
    }

    /// VolPack's: in slices, until they have faded beyond the outermost voxels.
    fn points_in_slices(&self, ray: Ray) -> Vec<DVec3> {
        let axis = ray.along.abs().max_position();
        let count = self.dims()[axis];
        let bounds = self.spec.target.lattice.bounds();
        let faded = Aabb::new(bounds.min - 0.5, bounds.max + 0.5);
        let points = (0..count)
            .map(|k| ray.in_slice(axis, k as f64))
            .filter(|&at| faded.contains(at));
        match ray.along[axis] > 0.0 {
            true => points.collect(),
            false => points.rev().collect(),
        }
    }

    fn sample(&self, at: DVec3) -> Shown {
        let corners = self.corners(at);
        let mean = |of: &dyn Fn(usize) -> f64| corners.iter().map(|&(n, weight)| weight * of(n)).sum::<f64>();
        let opacity = match self.is(Cause::Opacity) {
            true => mean(&|n| self.opacities[n]),
            false => self.opacity(mean(&|n| f64::from(self.values[n]))),
        };
        if opacity == 0.0 || self.is_dropped(opacity) {
            return [0.0; 2];
        }
        let light = match (self.is(Cause::Light), self.is(Cause::Opacity)) {
            (true, true) => mean(&|n| self.opacities[n] * self.lights[n]),
            (true, false) => opacity * mean(&|n| self.lights[n]),
            (false, _) => opacity * self.light(corners.iter().map(|&(n, weight)| weight * self.normals[n]).sum()),
        };
        [opacity, light]
    }

    fn is_dropped(&self, opacity: f64) -> bool {
        self.is(Cause::Faint) && opacity <= FAINT
    }

    /// The voxels round a point, and their trilinear weights: bilinear in a slice.
    fn corners(&self, at: DVec3) -> [(usize, f64); 8] {
        let [base, fraction] = [at.floor(), at - at.floor()];
        std::array::from_fn(|n| {
            let upper = BVec3::new(n & 1 != 0, n & 2 != 0, n & 4 != 0);
            let weight = DVec3::select(upper, fraction, 1.0 - fraction).element_product();
            let place = DVec3::select(upper, base + 1.0, base);
            self.voxel(place).map_or((0, 0.0), |voxel| (voxel, weight))
        })
    }

    /// The voxel at a place; beyond the outermost ones these, or nothing.
    fn voxel(&self, place: DVec3) -> Option<usize> {
        let dims = self.dims();
        let last = DVec3::from_array(dims.map(|n| n as f64 - 1.0));
        let nearest = place.clamp(DVec3::ZERO, last);
        let [x, y, z] = nearest.to_array().map(|n| n as usize);
        (nearest == place || !self.is(Cause::Slices)).then_some(x + dims[0] * (y + dims[1] * z))
    }

    fn opacity(&self, value: f64) -> f64 {
        let (_, opacity) = self.spec.transfer.evaluate(value as f32);
        let opacity = match (f64::from(opacity), self.is(Cause::Rounding)) {
            (opacity, _) if self.is_dropped(opacity) => 0.0,
            (opacity, true) => byte_below(opacity),
            (opacity, false) => opacity,
        };
        1.0 - (1.0 - opacity).powf(self.step)
    }

    fn light(&self, normal: DVec3) -> f64 {
        let (factor, highlight) = self.shading.response(normal);
        let kept = match self.is(Cause::NoNormal) {
            true => (1.0 - normal.length()) * (1.0 - f64::from(self.shading.material.ambient)),
            false => 0.0,
        };
        factor - kept + highlight
    }

    fn normal(&self, voxel: usize) -> DVec3 {
        let lattice = &self.spec.target.lattice;
        let range = self.spec.target.value_range;
        let differences = self.differences(voxel);
        let normal = match self.is(Cause::Normals) {
            true => normals::nearest(differences),
            false => SoftNormals::new(lattice, self.shading.soft_gradient)
                .normal(differences / f64::from(range.hi - range.lo)),
        };
        self.spec.camera.eye_from_world.matrix3 * normal
    }

    /// Half the differences of a voxel's neighbours.
    fn differences(&self, voxel: usize) -> DVec3 {
        let dims = self.dims();
        let at = [voxel % dims[0], voxel / dims[0] % dims[1], voxel / (dims[0] * dims[1])];
        let height = |by: [i64; 3]| {
            let near = |a: usize| (at[a] as i64 + by[a]).clamp(0, dims[a] as i64 - 1) as usize;
            f64::from(self.values[near(0) + dims[0] * (near(1) + dims[1] * near(2))])
        };
        if !self.is(Cause::Differences) {
            return half_differences(height);
        }
        if (0..3).any(|a| at[a] == 0 || at[a] + 1 == dims[a]) {
            return DVec3::ZERO;
        }
        let along = |[x, y, z]: [i64; 3]| 0.5 * (height([x, y, z]) - height([-x, -y, -z]));
        DVec3::from_array([[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(along))
    }
}

impl Ray {
    /// Where it meets slice `k` across an axis.
    pub fn in_slice(&self, axis: usize, k: f64) -> DVec3 {
        let mut at = self.through + self.along * ((k - self.through[axis]) / self.along[axis]);
        at[axis] = k;
        at
    }
}

/// The byte that is not above.
fn byte_below(part: f64) -> f64 {
    (part * 255.0).floor() / 255.0
}
