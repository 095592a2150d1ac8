//! Vertices on crossed edges, and their normals (LC87 §4, steps 5 to 7, equations 2–4).
//!
//! *Theory.* A vertex divides its edge as the isovalue divides the values of the edge's ends. Its normal is the gradient there,
//! interpolated between those of the ends, which are central differences.
//! *Changes from the paper.* Ends are not normalised before interpolation but the result is, and at the lattice's border
//! differences are one-sided; both as VTK does. On oblique lattices normals are turned as gradients are, by the inverse
//! transpose.
//! *Practice.* Everything is computed in `f64` in index space and rounded once there, as vtkMarchingCubes does, so that the
//! positions are its own bit for bit. What an edge needs of the voxels is gathered first, for many edges; the arithmetic then
//! runs over all of them in wide registers. No operation is fused or reordered, so every version gives the same bits.

use glam::{DAffine3, DMat3, DVec3};

use super::cells::{KINDS, ON_VOXELS, RowPlan, RowsRound, SetBits};
use super::extract::ExtractError;
use super::inside::InsideRows;
use super::slices::{HERE, NEIGHBOURS, Slices, Stencil};
use crate::volume::Voxel;

/// A vertex that falls on a voxel when it is rounded, and so together with those of the voxel's other edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Hit {
    /// The voxel, by its place in the lattice, x fastest.
    pub voxel: u64,
    pub vertex: u32,
}

impl Hit {
    /// `vertex` falls on the voxel `index` of a lattice of `dims`.
    pub fn new([x, y, z]: [usize; 3], dims: [usize; 3], vertex: u32) -> Self {
        let voxel = x as u64 + dims[0] as u64 * (y as u64 + dims[1] as u64 * z as u64);
        Self { voxel, vertex }
    }
}

/// A vertex whose place on its edge is not known: one of the ends is not a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Loose {
    /// The voxel that the edge starts from.
    pub voxel: [usize; 3],
    pub axis: usize,
    pub vertex: u32,
}

/// Where a slice's vertices are written to.
pub(super) struct VertexSink<'a> {
    pub positions: &'a mut [[f32; 3]],
    pub normals: &'a mut [[f32; 3]],
    pub hits: Vec<Hit>,
    pub loose: Vec<Loose>,
    /// The number of the first of the slice's vertices.
    pub first: u32,
    /// How many are written.
    pub written: usize,
}

/// A surface in the world: its value, and where the lattice lies.
#[derive(Clone, Copy)]
pub(super) struct Level {
    iso: f64,
    world_from_index: DAffine3,
    /// Turns a gradient, in values a voxel, to the direction of falling values in the world.
    normal_from_gradient: DMat3,
}

impl Level {
    /// The surface at `iso` in a lattice whose voxels lie in the world as `world_from_index`, which can be inverted, says.
    ///
    /// # Errors
    /// [`ExtractError::NoIsovalue`].
    pub fn new(iso: f64, world_from_index: DAffine3) -> Result<Self, ExtractError> {
        if !iso.is_finite() {
            return Err(ExtractError::NoIsovalue { iso });
        }
        Ok(Self {
            iso,
            world_from_index,
            normal_from_gradient: -world_from_index.matrix3.inverse().transpose(),
        })
    }

    /// The value whose surface it is.
    pub fn iso(&self) -> f64 {
        self.iso
    }

    /// Whether the lattice is a reflection, which turns triangles over.
    pub fn is_mirrored(&self) -> bool {
        self.world_from_index.matrix3.determinant() < 0.0
    }

    /// Where a place of the lattice is in the world. Terms are added in the order in which VTK adds them.
    #[inline(always)]
    pub fn position(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let m = &self.world_from_index.matrix3;
        let (x, y, z) = (f64::from(x), f64::from(y), f64::from(z));
        let world = m.x_axis * x + m.y_axis * y + m.z_axis * z + self.world_from_index.translation;
        world.as_vec3().to_array()
    }

    /// The unit normal where the gradient is `gradient`, in values a voxel; zero where that has no direction.
    pub fn normal(&self, gradient: DVec3) -> [f32; 3] {
        let normal = (self.normal_from_gradient * gradient).try_normalize();
        normal.unwrap_or(DVec3::ZERO).as_vec3().to_array()
    }
}

/// Edges whose vertices are computed together.
const LANES: usize = 64;

/// A number for each edge of a batch.
type Lanes<N> = [N; LANES];

/// Edges of one slice along one axis, and what their vertices follow from; or voxels that are vertices themselves.
struct Batch<T> {
    kind: usize,
    slice: usize,
    len: usize,
    /// The voxels that the edges start from, by index in x and y.
    index: [Lanes<f64>; 2],
    /// The voxels at both ends and their neighbours, as [`Stencil::values`] has them.
    values: [[Lanes<T>; 7]; 2],
    /// What differences in x are multiplied by at both ends.
    x_scale: [Lanes<f64>; 2],
    /// The same for y and z, where it is one for all edges.
    yz_scale: [[f64; 2]; 2],
}

/// The vertices of a batch: where they are in the lattice along their edges, and in the world.
struct Vertices {
    along: Lanes<f32>,
    positions: [Lanes<f32>; 3],
    normals: [Lanes<f32>; 3],
}

impl<T: Voxel> Batch<T> {
    fn new(kind: usize, slice: usize) -> Self {
        Self {
            kind,
            slice,
            len: 0,
            index: [[0.0; LANES]; 2],
            values: [[[T::zeroed(); LANES]; 7]; 2],
            x_scale: [[0.0; LANES]; 2],
            yz_scale: [[0.0; 2]; 2],
        }
    }

    /// Adds the edge from voxel `i` of row `j`, which is `ends[0]`.
    #[inline(always)]
    fn push(&mut self, ends: &[Stencil<'_, T>; 2], [i, j]: [usize; 2]) {
        let n = self.len;
        self.index[0][n] = i as f64;
        self.index[1][n] = j as f64;
        let at = [i, i + usize::from(self.kind == 0)];
        for end in 0..2 {
            let (values, x_scale) = ends[end].values(at[end]);
            for v in 0..7 {
                self.values[end][v][n] = values[v];
            }
            self.x_scale[end][n] = x_scale;
        }
        self.len += 1;
    }

    /// The value at lane `n` of an end.
    #[inline(always)]
    fn value(&self, end: usize, n: usize) -> f64 {
        self.values[end][HERE][n].to_f64()
    }

    /// The gradient at lane `n` of an end along axis `a`, in values a voxel.
    #[inline(always)]
    fn gradient(&self, end: usize, a: usize, n: usize) -> f64 {
        let [lower, upper] = NEIGHBOURS[a];
        let values = &self.values[end];
        let scale = if a == 0 {
            self.x_scale[end][n]
        } else {
            self.yz_scale[end][a - 1]
        };
        scale * (values[upper][n].to_f64() - values[lower][n].to_f64())
    }

    /// The vertices; lanes beyond `len` hold nothing of use.
    #[inline(always)]
    fn vertices(&self, level: &Level, out: &mut Vertices) {
        let world = level.world_from_index.matrix3.to_cols_array_2d();
        let origin = level.world_from_index.translation.to_array();
        let turn = level.normal_from_gradient.to_cols_array_2d();
        let mut direction = [0.0; KINDS];
        direction[self.kind] = 1.0;
        let k = self.slice as f64;
        for n in 0..LANES {
            let (lower, upper) = (self.value(0, n), self.value(1, n));
            let t = if self.kind == ON_VOXELS {
                0.0
            } else {
                (level.iso - lower) / (upper - lower)
            };
            let x = (self.index[0][n] + t * direction[0]) as f32;
            let y = (self.index[1][n] + t * direction[1]) as f32;
            let z = (k + t * direction[2]) as f32;
            out.along[n] = if self.kind == 0 {
                x
            } else if self.kind == 1 {
                y
            } else {
                z
            };
            let (x, y, z) = (f64::from(x), f64::from(y), f64::from(z));
            // Terms are added in the order in which VTK adds them.
            for a in 0..3 {
                out.positions[a][n] = (world[0][a] * x + world[1][a] * y + world[2][a] * z + origin[a]) as f32;
            }
            let mut gradient = [0.0; 3];
            for a in 0..3 {
                let lower = self.gradient(0, a, n);
                gradient[a] = lower + t * (self.gradient(1, a, n) - lower);
            }
            let [gx, gy, gz] = gradient;
            let nx = turn[0][0] * gx + turn[1][0] * gy + turn[2][0] * gz;
            let ny = turn[0][1] * gx + turn[1][1] * gy + turn[2][1] * gz;
            let nz = turn[0][2] * gx + turn[1][2] * gy + turn[2][2] * gz;
            // Without a length, or one that is not finite, there is no direction.
            let length = (nx * nx + ny * ny + nz * nz).sqrt();
            let has_length = length > 0.0 && length < f64::INFINITY;
            let shrink = 1.0 / length;
            out.normals[0][n] = if has_length { nx * shrink } else { 0.0 } as f32;
            out.normals[1][n] = if has_length { ny * shrink } else { 0.0 } as f32;
            out.normals[2][n] = if has_length { nz * shrink } else { 0.0 } as f32;
        }
    }

    /// Writes the vertices, notes those of them that fall on voxels of a lattice of `dims` or nowhere, and empties the batch.
    #[inline(always)]
    fn flush(&mut self, level: &Level, dims: [usize; 3], vertices: &mut Vertices, sink: &mut VertexSink<'_>) {
        self.vertices(level, vertices);
        let places = sink.written..sink.written + self.len;
        let positions = sink.positions[places.clone()].iter_mut();
        for (n, (position, normal)) in positions.zip(&mut sink.normals[places]).enumerate() {
            *position = [
                vertices.positions[0][n],
                vertices.positions[1][n],
                vertices.positions[2][n],
            ];
            *normal = [vertices.normals[0][n], vertices.normals[1][n], vertices.normals[2][n]];
        }
        let edges = if self.kind == ON_VOXELS { 0 } else { self.len };
        for n in 0..edges {
            let voxel = [self.index[0][n] as usize, self.index[1][n] as usize, self.slice];
            let (along, lower) = (vertices.along[n], voxel[self.kind] as f32);
            let vertex = sink.first + (sink.written + n) as u32;
            if along.is_nan() {
                sink.loose.push(Loose {
                    voxel,
                    axis: self.kind,
                    vertex,
                });
            } else if along == lower || along == lower + 1.0 {
                let mut on = voxel;
                on[self.kind] += usize::from(along != lower);
                sink.hits.push(Hit::new(on, dims, vertex));
            }
        }
        sink.written += self.len;
        self.len = 0;
    }
}

/// Adds the vertices of `kind` that start in slice `k`, whose rows `plan` is for.
#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512dq+avx512vl+popcnt+bmi1+bmi2",
    "x86_64+avx2+popcnt+bmi1+bmi2"
))]
pub(super) fn interpolate<T: Voxel>(
    slices: Slices<'_, T>,
    rows: &InsideRows,
    plan: &[RowPlan],
    level: &Level,
    [kind, k]: [usize; 2],
    sink: &mut VertexSink<'_>,
) {
    let dims = slices.dims;
    let mut batch = Batch::new(kind, k);
    let mut vertices = Vertices {
        along: [0.0; LANES],
        positions: [[0.0; LANES]; 3],
        normals: [[0.0; LANES]; 3],
    };
    for j in (0..dims[1]).filter(|j| plan[*j].any[kind]) {
        let round = RowsRound::new(rows, j, k);
        let ends = slices.ends(kind, j, k);
        let yz_scale = [ends[0].scale, ends[1].scale];
        if batch.yz_scale != yz_scale {
            batch.flush(level, dims, &mut vertices, sink);
            batch.yz_scale = yz_scale;
        }
        for w in 0..round.words() {
            for i in SetBits(round.vertices(w, kind)) {
                batch.push(&ends, [w * 64 + i as usize, j]);
                if batch.len == LANES {
                    batch.flush(level, dims, &mut vertices, sink);
                }
            }
        }
    }
    batch.flush(level, dims, &mut vertices, sink);
}
