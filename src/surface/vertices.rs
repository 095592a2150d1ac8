//! Vertices on crossed edges, and their normals (LC87 §4, steps 5 to 7, equations 2–4).
//!
//! *Theory.* A vertex divides its edge as the isovalue divides the values of the edge's ends. Its normal is the gradient there,
//! interpolated between those of the ends, which are central differences.
//! *Changes from the paper.* Ends are not normalised before interpolation but the result is, and at the lattice's border
//! differences are one-sided; both as VTK does. On oblique lattices normals are turned as gradients are, by the inverse
//! transpose.
//! *Practice.* Everything is computed in `f64` in index space and rounded once there, as vtkMarchingCubes does, so that the
//! positions are its own bit for bit.

use glam::{DAffine3, DMat3, DVec3};

use super::cells::{RowsRound, SetBits};
use crate::volume::Voxel;

/// Consecutive slices of a lattice of voxels, x fastest.
#[derive(Clone, Copy)]
pub(super) struct Slices<'a, T> {
    /// The voxels of the slices from `first_slice` on.
    pub voxels: &'a [T],
    pub first_slice: usize,
    /// Voxels along each axis of the whole lattice.
    pub dims: [usize; 3],
}

impl<'a, T: Voxel> Slices<'a, T> {
    fn stride(&self) -> [usize; 3] {
        [1, self.dims[0], self.dims[0] * self.dims[1]]
    }

    /// The rows of slice `k`.
    pub fn slice(&self, k: usize) -> &'a [T] {
        let plane = self.dims[0] * self.dims[1];
        &self.voxels[(k - self.first_slice) * plane..][..plane]
    }

    #[inline(always)]
    fn value(&self, at: usize) -> f64 {
        self.voxels[at].to_f64()
    }

    /// The difference quotient along each axis at the voxel `index`, which lies at `at` of `voxels`, in values a voxel.
    #[inline(always)]
    fn gradient(&self, index: [usize; 3], at: usize) -> DVec3 {
        let stride = self.stride();
        let mut gradient = [0.0; 3];
        for axis in 0..3 {
            let lower = usize::from(index[axis] > 0) * stride[axis];
            let upper = usize::from(index[axis] + 1 < self.dims[axis]) * stride[axis];
            let scale = if lower > 0 && upper > 0 { 0.5 } else { 1.0 };
            gradient[axis] = scale * (self.value(at + upper) - self.value(at - lower));
        }
        DVec3::from_array(gradient)
    }
}

/// A vertex that falls on a voxel when it is rounded, and so together with those of the voxel's other edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Hit {
    /// The voxel, by its place in the lattice, x fastest.
    pub voxel: u64,
    pub vertex: u32,
}

/// Where vertices are written to: places for all of a layer's, and what to do with hits.
pub(super) struct VertexSink<'a> {
    pub positions: &'a mut [[f32; 3]],
    pub normals: &'a mut [[f32; 3]],
    pub hits: Vec<Hit>,
    /// The number of the first of the layer's vertices.
    pub first: u32,
    /// How many are written.
    pub written: usize,
}

/// Puts vertices on edges.
#[derive(Clone, Copy)]
pub(super) struct Interpolator<'a, T> {
    slices: Slices<'a, T>,
    iso: f64,
    world_from_index: DAffine3,
    /// Turns a gradient, in values a voxel, to the direction of falling values in the world.
    normal_from_gradient: DMat3,
}

impl<'a, T: Voxel> Interpolator<'a, T> {
    /// Vertices at `iso` in a lattice whose voxels lie in the world as `world_from_index`, which can be inverted, says.
    pub fn new(slices: Slices<'a, T>, iso: f64, world_from_index: DAffine3) -> Self {
        Self {
            slices,
            iso,
            world_from_index,
            normal_from_gradient: -world_from_index.matrix3.inverse().transpose(),
        }
    }

    /// Adds the vertex on the edge from voxel `index` along `axis`.
    #[inline(always)]
    fn push(&self, sink: &mut VertexSink<'_>, index: [usize; 3], axis: usize) {
        let slices = &self.slices;
        let stride = slices.stride()[axis];
        let [i, j, k] = index;
        let at = i + slices.dims[0] * (j + slices.dims[1] * (k - slices.first_slice));
        let (lower, upper) = (slices.value(at), slices.value(at + stride));
        let t = (self.iso - lower) / (upper - lower);

        let mut position = index.map(|n| n as f32);
        let ends = [position[axis], (index[axis] + 1) as f32];
        position[axis] = (index[axis] as f64 + t) as f32;
        if let Some(end) = ends.iter().position(|end| *end == position[axis]) {
            let voxel = slices.first_slice * slices.stride()[2] + at + end * stride;
            sink.hits.push(Hit {
                voxel: voxel as u64,
                vertex: sink.first + sink.written as u32,
            });
        }
        let mut next = index;
        next[axis] += 1;
        let gradient = slices.gradient(index, at);
        let gradient = gradient + t * (slices.gradient(next, at + stride) - gradient);
        sink.positions[sink.written] = self.world(position);
        sink.normals[sink.written] = unit(self.normal_from_gradient * gradient);
        sink.written += 1;
    }

    /// Terms are added in the order in which VTK adds them.
    #[inline(always)]
    fn world(&self, index: [f32; 3]) -> [f32; 3] {
        let m = &self.world_from_index.matrix3;
        let [x, y, z] = index.map(f64::from);
        (m.x_axis * x + m.y_axis * y + m.z_axis * z + self.world_from_index.translation)
            .as_vec3()
            .to_array()
    }
}

/// `v` at length 1; zero where it has none, or is not finite.
#[inline(always)]
fn unit(v: DVec3) -> [f32; 3] {
    let length = v.length();
    if length > 0.0 && length < f64::INFINITY {
        (v / length).as_vec3().to_array()
    } else {
        [0.0; 3]
    }
}

/// Adds the vertices on the edges along `axes` that start in voxel row `j` of slice `k`, which `round` begins with.
#[multiversion::multiversion(targets("x86_64+avx2+popcnt+bmi1+bmi2"))]
pub(super) fn interpolate<T: Voxel>(
    interpolator: &Interpolator<'_, T>,
    round: RowsRound<'_>,
    [j, k]: [usize; 2],
    axes: &[usize],
    sink: &mut VertexSink<'_>,
) {
    for &axis in axes {
        for w in 0..round.rows[0].len() {
            for i in SetBits(round.crossed(w)[axis]) {
                interpolator.push(sink, [w * 64 + i as usize, j, k], axis);
            }
        }
    }
}
