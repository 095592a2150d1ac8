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

use super::cells::SetBits;
use super::crossings::{Crossings, ON_VOXELS};
use super::extract::ExtractError;
use super::slices::{HERE, NEIGHBOURS, RowsRound, Slices};
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
    /// Voxels on each side that the lattice has been widened by: its first voxel has this index, negated.
    pub margin: usize,
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
            margin: 0,
            world_from_index,
            normal_from_gradient: -world_from_index.matrix3.inverse().transpose(),
        })
    }

    /// The index of a voxel of the widened lattice in the lattice itself.
    pub fn index(&self, voxel: [usize; 3]) -> [f64; 3] {
        voxel.map(|n| n as f64 - self.margin as f64)
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

/// Edges that start in one slice, and what their vertices follow from; or voxels that are vertices themselves.
struct Batch<'a, T> {
    slices: Slices<'a, T>,
    slice: usize,
    len: usize,
    /// Whether an edge leads along x, y or z, or it is a voxel.
    kind: Lanes<u32>,
    /// The voxels that the edges start from, by index in x and y.
    index: [Lanes<u32>; 2],
    /// The voxels at both ends and their neighbours.
    values: [[Lanes<T>; 7]; 2],
}

/// The vertices of a batch: where they are in the lattice along their edges, and in the world.
struct Vertices {
    along: Lanes<f32>,
    positions: [Lanes<f32>; 3],
    normals: [Lanes<f32>; 3],
}

impl<'a, T: Voxel> Batch<'a, T> {
    fn new(slices: Slices<'a, T>, slice: usize) -> Self {
        Self {
            slices,
            slice,
            len: 0,
            kind: [0; LANES],
            index: [[0; LANES]; 2],
            values: [[[T::zeroed(); LANES]; 7]; 2],
        }
    }

    /// Adds the edges along `AXIS` from the voxels of row `j` whose bits are set, or these voxels themselves if there is no such
    /// axis, and writes the vertices of full batches.
    #[inline(always)]
    fn push_row<const AXIS: usize>(
        &mut self,
        bits: &[u64],
        (j, rows): (usize, &RowsRound<'_, T>),
        level: &Level,
        vertices: &mut Vertices,
        sink: &mut VertexSink<'_>,
    ) {
        for (w, word) in bits.iter().enumerate() {
            for bit in SetBits(*word) {
                let i = w * 64 + bit as usize;
                let n = self.len % LANES;
                self.kind[n] = AXIS as u32;
                self.index[0][n] = i as u32;
                self.index[1][n] = j as u32;
                let ends = rows.ends::<AXIS>(i);
                for (lanes, value) in self.values.as_flattened_mut().iter_mut().zip(ends.as_flattened()) {
                    lanes[n] = *value;
                }
                self.len += 1;
                if self.len == LANES {
                    self.flush(level, vertices, sink);
                }
            }
        }
    }

    /// What the two ends of the edge in lane `n` differ by in x, y and z; nothing for a voxel.
    #[inline(always)]
    fn step(&self, n: usize) -> [f64; 3] {
        let along = |axis: u32| if self.kind[n] == axis { 1.0 } else { 0.0 };
        [along(0), along(1), along(2)]
    }

    /// What differences along `axis` are multiplied by at lane `n` of an end: one over the voxels between the neighbours.
    #[inline(always)]
    fn scale(&self, end: usize, axis: usize, n: usize) -> f64 {
        let from = if axis == 2 {
            self.slice as u32
        } else {
            self.index[axis][n]
        };
        let at = from + u32::from(end == 1 && self.kind[n] == axis as u32);
        if at > 0 && at + 1 < self.slices.dims[axis] as u32 {
            0.5
        } else {
            1.0
        }
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
        self.scale(end, a, n) * (values[upper][n].to_f64() - values[lower][n].to_f64())
    }

    /// The vertices; lanes beyond `len` hold nothing of use.
    #[inline(always)]
    fn vertices(&self, level: &Level, out: &mut Vertices) {
        let world = level.world_from_index.matrix3.to_cols_array_2d();
        let origin = level.world_from_index.translation.to_array();
        let turn = level.normal_from_gradient.to_cols_array_2d();
        let first = -(level.margin as f64);
        let k = first + self.slice as f64;
        for n in 0..LANES {
            let (lower, upper) = (self.value(0, n), self.value(1, n));
            let [dx, dy, dz] = self.step(n);
            let t = if self.kind[n] < ON_VOXELS as u32 {
                (level.iso - lower) / (upper - lower)
            } else {
                0.0
            };
            let (i, j) = (first + f64::from(self.index[0][n]), first + f64::from(self.index[1][n]));
            out.along[n] = (i * dx + j * dy + k * dz + t) as f32;
            let x = (i + t * dx) as f32;
            let y = (j + t * dy) as f32;
            let z = (k + t * dz) as f32;
            let (x, y, z) = (f64::from(x), f64::from(y), f64::from(z));
            // Terms are added in the order in which VTK adds them.
            for a in 0..3 {
                out.positions[a][n] = (world[0][a] * x + world[1][a] * y + world[2][a] * z + origin[a]) as f32;
            }
            let mut gradient = [0.0; 3];
            for (a, component) in gradient.iter_mut().enumerate() {
                let lower = self.gradient(0, a, n);
                *component = lower + t * (self.gradient(1, a, n) - lower);
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

    /// Writes the vertices, notes those of them that fall on voxels or nowhere, and empties the batch.
    #[inline(always)]
    fn flush(&mut self, level: &Level, vertices: &mut Vertices, sink: &mut VertexSink<'_>) {
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
        if self.any_off_edge(level, vertices) {
            self.note_off_edge(level, vertices, sink);
        }
        sink.written += self.len;
        self.len = 0;
    }
}

impl<T: Voxel> Batch<'_, T> {
    /// Whether any lane's vertex, of use or not, is at an end of its edge or nowhere.
    #[inline(always)]
    fn any_off_edge(&self, level: &Level, vertices: &Vertices) -> bool {
        let first = -(level.margin as f64);
        let k = first + self.slice as f64;
        let mut off = false;
        for n in 0..LANES {
            let [dx, dy, dz] = self.step(n);
            let (i, j) = (first + f64::from(self.index[0][n]), first + f64::from(self.index[1][n]));
            let lower = (i * dx + j * dy + k * dz) as f32;
            let along = vertices.along[n];
            off |= self.kind[n] < ON_VOXELS as u32 && !(along > lower && along < lower + 1.0);
        }
        off
    }

    /// Notes the vertices at ends of edges, and those nowhere.
    fn note_off_edge(&self, level: &Level, vertices: &Vertices, sink: &mut VertexSink<'_>) {
        for n in 0..self.len {
            let axis = self.kind[n] as usize;
            if axis == ON_VOXELS {
                continue;
            }
            let voxel = [self.index[0][n] as usize, self.index[1][n] as usize, self.slice];
            let (along, lower) = (vertices.along[n], level.index(voxel)[axis] as f32);
            let vertex = sink.first + (sink.written + n) as u32;
            if along.is_nan() {
                sink.loose.push(Loose { voxel, axis, vertex });
            } else if along == lower || along == lower + 1.0 {
                let mut on = voxel;
                on[axis] += usize::from(along != lower);
                sink.hits.push(Hit::new(on, self.slices.dims, vertex));
            }
        }
    }
}

/// Adds the vertices that start in slice `k`, in the order of their numbers.
#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512dq+avx512vl+popcnt+bmi1+bmi2",
    "x86_64+avx2+popcnt+bmi1+bmi2"
))]
pub(super) fn interpolate<T: Voxel>(
    slices: Slices<'_, T>,
    crossings: &Crossings,
    k: usize,
    level: &Level,
    sink: &mut VertexSink<'_>,
) {
    if crossings.rows.is_empty() {
        return;
    }
    let mut batch = Batch::new(slices, k);
    let mut vertices = Vertices {
        along: [0.0; LANES],
        positions: [[0.0; LANES]; 3],
        normals: [[0.0; LANES]; 3],
    };
    for j in crossings.rows.clone() {
        let bits = [
            crossings.row(0, j),
            crossings.row(1, j),
            crossings.row(2, j),
            crossings.row(ON_VOXELS, j),
        ];
        let rows = (j, &slices.round(j, k));
        batch.push_row::<0>(bits[0], rows, level, &mut vertices, sink);
        batch.push_row::<1>(bits[1], rows, level, &mut vertices, sink);
        batch.push_row::<2>(bits[2], rows, level, &mut vertices, sink);
        batch.push_row::<ON_VOXELS>(bits[3], rows, level, &mut vertices, sink);
    }
    batch.flush(level, &mut vertices, sink);
}
