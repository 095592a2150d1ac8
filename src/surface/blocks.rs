//! The surface of a model, from its target's blocks (VCSG §3 and LC87 §4).
//!
//! *Theory.* The solid is where the model holds something and its value is not below the isovalue. Marching cubes runs over
//! the target's lattice; a sample that the model does not cover is outside whatever the isovalue.
//! *Changes from the papers.* No grid of the whole lattice is made: blocks give a few slices at a time. Where an edge leads
//! out of what the model covers there is no second value to interpolate with. Its vertex is found on the model itself, by
//! halving the edge, so that a cut plane is a plane, and a crisp ball round, however coarse the lattice.
//! *Practice.* The lattice is widened by one voxel on each side that nothing covers, so that the mesh is closed even where the
//! model goes on. Where the solid is covered all round, the mesh is that of a grid of the same samples: the same for any
//! subdivision into blocks. Normals are the data's; on a cut, where data ends, they are those of the triangles round the vertex.
//! Vertices on a cut carry the value that was cut through (LC87 §5.2, texture mapping), all others the isovalue.

use std::ops::Range;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::assemble::Assembly;
use super::extract::{ExtractError, Topology};
use super::inside::{Classifier, Ties};
use super::mesh::Mesh;
use super::slices::Slices;
use super::vertices::{Hit, Level, Loose};
use crate::target::{RowEvaluator, Target};

/// Slices whose vertices are made together.
const LAYERS: usize = 32;

/// Voxels on each side that the lattice is widened by.
const MARGIN: usize = 1;

/// The least coverage of a sample that is there.
const COVERED: f32 = 0.5;

/// The surface of the solid where `target`'s model is covered and its value not below `iso`. It is closed; a model that
/// reaches beyond the lattice is cut off at most one voxel outside it. `done` is told of slices as they are finished.
///
/// # Errors
/// Those of [`extract`](super::extract()).
pub fn extract_target(
    target: &Target,
    iso: f64,
    topology: Topology,
    done: &mut dyn FnMut(usize),
) -> Result<Mesh, ExtractError> {
    let mut level = Level::new(iso, target.lattice.world_from_lattice)?;
    level.margin = MARGIN;
    let mut window = Window::new(target);
    let nz = window.dims[2];
    let mut assembly = Assembly::new(level, window.dims, topology);
    for start in (0..nz).step_by(LAYERS) {
        let layers = start..(start + LAYERS).min(nz);
        window.move_to(start.saturating_sub(1)..(layers.end + 2).min(nz));
        assembly.add(&Classifier::new(window.slices(), iso, Ties::Apart), layers.clone())?;
        done(layers.len());
    }
    fasten(&mut assembly, target);
    let mut mesh = assembly.finish();
    fill_normals(&mut mesh);
    Ok(mesh)
}

/// Some slices of a target's widened lattice: values, and NaN where the model does not cover the sample.
struct Window<'a> {
    target: &'a Target,
    dims: [usize; 3],
    voxels: Vec<f32>,
    held: Range<usize>,
}

impl<'a> Window<'a> {
    fn new(target: &'a Target) -> Self {
        Self {
            target,
            dims: target.lattice.dims.map(|n| n + 2 * MARGIN),
            voxels: Vec::new(),
            held: 0..0,
        }
    }

    fn slices(&self) -> Slices<'_, f32> {
        Slices {
            voxels: &self.voxels,
            first_slice: self.held.start,
            dims: self.dims,
        }
    }

    /// Holds `slices`, which start in or after those held before; what is held already is kept.
    fn move_to(&mut self, slices: Range<usize>) {
        let plane = self.dims[0] * self.dims[1];
        let kept = slices.start.max(self.held.start)..self.held.end.max(slices.start);
        self.voxels
            .drain(..(kept.start - self.held.start).min(self.held.len()) * plane);
        let fresh = self.voxels.len();
        self.voxels.resize(slices.len() * plane, f32::NAN);
        let first = slices.start + fresh / plane;
        let (target, inner) = (self.target, MARGIN..self.dims[2] - MARGIN);
        self.voxels[fresh..]
            .par_chunks_mut(plane)
            .zip(first..slices.end)
            .filter(|(_, k)| inner.contains(k))
            .for_each(|(voxels, k)| fill_slice(target, k - MARGIN, voxels));
        self.held = slices;
    }
}

/// Writes the covered samples of slice `k` of the lattice to their places in the widened one.
fn fill_slice(target: &Target, k: usize, voxels: &mut [f32]) {
    let width = target.lattice.dims[0] + 2 * MARGIN;
    let mut rows = RowEvaluator::new(target);
    let mut coverage = vec![0.0; width];
    let crosses = |origin: usize, extent: usize| (origin..origin + extent).contains(&k);
    for block in target.blocks.iter().filter(|b| crosses(b.origin[2], b.extent[2])) {
        let columns = block.origin[0]..block.origin[0] + block.extent[0];
        let coverage = &mut coverage[..columns.len()];
        for j in block.origin[1]..block.origin[1] + block.extent[1] {
            let values = &mut voxels[width * (j + MARGIN) + MARGIN..][columns.clone()];
            rows.evaluate(target.path(block), columns.clone(), [j, k], values, Some(coverage));
            for (value, coverage) in values.iter_mut().zip(&*coverage) {
                *value = if *coverage >= COVERED {
                    *value / coverage
                } else {
                    f32::NAN
                };
            }
        }
    }
}

/// Halvings of an edge: its vertex is then found to 2⁻²⁰ of a voxel.
const HALVINGS: u32 = 20;

/// Puts the vertices on edges out of the model's coverage where the model ends.
fn fasten(assembly: &mut Assembly, target: &Target) {
    let iso = assembly.level.iso();
    let found: Vec<(Loose, End)> = assembly
        .loose
        .par_iter()
        .map(|loose| (*loose, End::of_solid(target, &assembly.level, loose)))
        .collect();
    assembly.mesh.values = vec![iso as f32; assembly.mesh.positions.len()];
    for (loose, end) in found {
        let index = end.index.as_vec3().to_array();
        assembly.mesh.positions[loose.vertex as usize] = assembly.level.position(index);
        assembly.mesh.values[loose.vertex as usize] = end.value;
        let lower = assembly.level.index(loose.voxel)[loose.axis] as f32;
        let along = index[loose.axis];
        if along == lower || along == lower + 1.0 {
            let mut voxel = loose.voxel;
            voxel[loose.axis] += usize::from(along != lower);
            assembly.hits[loose.voxel[2]].push(Hit::new(voxel, assembly.dims, loose.vertex));
        }
    }
}

/// Where the solid ends on an edge.
struct End {
    /// The place, in the lattice.
    index: DVec3,
    /// The model's value just within.
    value: f32,
}

impl End {
    /// Halves an edge of which one end lies in the solid.
    fn of_solid(target: &Target, level: &Level, loose: &Loose) -> Self {
        let solid = |p: DVec3| {
            let sample = target.sample(p);
            sample.coverage >= COVERED && f64::from(sample.value) >= level.iso()
        };
        let lower = DVec3::from_array(level.index(loose.voxel));
        let upper = lower + DVec3::AXES[loose.axis];
        let (mut within, mut beyond) = if solid(lower) { (lower, upper) } else { (upper, lower) };
        for _ in 0..HALVINGS {
            let middle = 0.5 * (within + beyond);
            if solid(middle) {
                within = middle;
            } else {
                beyond = middle;
            }
        }
        Self {
            index: 0.5 * (within + beyond),
            value: target.sample(within).value,
        }
    }
}

/// Gives vertices without a normal that of the triangles round them, weighted by area.
fn fill_normals(mesh: &mut Mesh) {
    let missing: Vec<bool> = mesh.normals.iter().map(|n| *n == [0.0; 3]).collect();
    let mut sums = vec![Vec3::ZERO; mesh.normals.len()];
    for triangle in &mesh.triangles {
        if triangle.iter().any(|v| missing[*v as usize]) {
            let [a, b, c] = triangle.map(|v| Vec3::from_array(mesh.positions[v as usize]));
            let area = (b - a).cross(c - a);
            for v in triangle {
                sums[*v as usize] += area;
            }
        }
    }
    let normals = mesh.normals.iter_mut().zip(missing).zip(sums);
    for ((normal, _), sum) in normals.filter(|((_, missing), _)| *missing) {
        *normal = sum.normalize_or_zero().to_array();
    }
}
