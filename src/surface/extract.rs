//! From voxels to a mesh (LC87 §4).
//!
//! *Theory.* March through the cells between eight voxels; each makes the triangles of its case, with vertices on the edges
//! that the surface crosses.
//! *Changes from the paper.* Not cell after cell with the last row's vertices kept, but two passes over slices in parallel:
//! the first counts the vertices and triangles of each row, so that the second knows where to write each of them. Their order
//! does not depend on the number of threads.
//! *Practice.* The mesh is that of vtkMarchingCubes, triangle for triangle. Memory beyond the mesh is one bit a voxel, and
//! 16 bytes a row.

use std::ops::Range;

use glam::DAffine3;
use rayon::prelude::*;
use thiserror::Error;

use super::cells::{self, KINDS, RowCount, RowPlan};
use super::inside::InsideRows;
use super::mesh::{Mesh, Part};
use super::slices::Slices;
use super::vertices::{Hit, Level, VertexSink, interpolate};
use super::weld::{Layout, weld};
use crate::volume::{Grid, Voxel, Voxels, for_type};

/// Why a surface could not be extracted.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ExtractError {
    /// The isovalue is NaN or infinite.
    #[error("the isovalue is not a finite number")]
    NoIsovalue,
    /// More vertices or triangles than 32 bits count.
    #[error("the surface has more than {} {what}: reduce the volume, or cut it", u32::MAX)]
    TooLarge {
        /// Vertices or triangles.
        what: &'static str,
    },
}

/// The surface where the values of `grid` are `iso`: the triangles of vtkMarchingCubes. It is empty where `iso` is beyond the
/// values, or the grid has an axis of one voxel.
///
/// A voxel is inside where its value is not below `iso`, and NaN is outside; an edge with an end that is NaN has its vertex at
/// NaN. Where `world_from_index` is a reflection, triangles are turned over, so that they always face lower values.
///
/// # Errors
/// If `iso` is not finite, or the mesh has more vertices or triangles than `u32` counts.
pub fn marching_cubes(grid: &Grid, iso: f64) -> Result<Mesh, ExtractError> {
    for_type!(Voxels, grid.voxels(), voxels => extract(voxels, grid.dims(), grid.world_from_index(), iso))
}

fn extract<T: Voxel>(
    voxels: &[T],
    dims: [usize; 3],
    world_from_index: &DAffine3,
    iso: f64,
) -> Result<Mesh, ExtractError> {
    if !iso.is_finite() {
        return Err(ExtractError::NoIsovalue);
    }
    let slices = Slices {
        voxels,
        first_slice: 0,
        dims,
    };
    let has_cells = dims.iter().all(|n| *n > 1);
    let Some(rows) = InsideRows::of(slices, iso).filter(|_| has_cells) else {
        return Ok(Mesh::default());
    };
    let unwelded = Unwelded::new(slices, rows, &Level::new(iso, *world_from_index))?;
    let Unwelded {
        mut mesh, hits, plan, ..
    } = unwelded;
    let layout = Layout {
        voxels_a_slice: dims[0] * dims[1],
        before: &plan.before,
    };
    weld(&mut mesh, &hits, &layout);
    if world_from_index.matrix3.determinant() < 0.0 {
        mesh.triangles.par_iter_mut().for_each(|t| t.swap(1, 2));
    }
    mesh.parts.push(Part {
        label: 0,
        iso: Some(iso),
        triangles: 0..mesh.triangles.len(),
    });
    Ok(mesh)
}

/// A surface whose vertices are still numbered by the edges they lie on, and wound for a lattice that is no reflection.
pub(super) struct Unwelded {
    pub mesh: Mesh,
    pub rows: InsideRows,
    /// For each slice, the vertices that fall on voxels.
    pub hits: Vec<Vec<Hit>>,
    plan: Plan,
}

impl Unwelded {
    /// The surface of a grid with cells at `iso`, which is finite.
    pub fn of(grid: &Grid, iso: f64) -> Result<Self, ExtractError> {
        let dims = grid.dims();
        let level = Level::new(iso, *grid.world_from_index());
        for_type!(Voxels, grid.voxels(), voxels => {
            let slices = Slices { voxels, first_slice: 0, dims };
            let rows = InsideRows::of(slices, iso).unwrap_or_else(|| InsideRows::outside(dims));
            Self::new(slices, rows, &level)
        })
    }

    fn new<T: Voxel>(slices: Slices<'_, T>, rows: InsideRows, level: &Level) -> Result<Self, ExtractError> {
        let plan = Plan::new(&rows)?;
        let mut mesh = Mesh {
            positions: vec![[0.0; 3]; plan.vertices()],
            normals: vec![[0.0; 3]; plan.vertices()],
            triangles: vec![[0; 3]; plan.triangles()],
            ..Mesh::default()
        };
        let hits = fill(&mut mesh, &plan, |task| fill_slice(task, slices, &rows, &plan, level));
        Ok(Self { mesh, rows, hits, plan })
    }

    /// The numbers of the first vertices in the four rows round row `j` of cells above slice `k`.
    pub fn first(&self, j: usize, k: usize) -> [[u32; KINDS]; 4] {
        let row = |j: usize, k: usize| self.plan.rows[self.rows.dims[1] * k + j].first;
        [row(j, k), row(j + 1, k), row(j, k + 1), row(j + 1, k + 1)]
    }
}

/// Where each row's vertices and triangles go. A slice's vertices are in the order of their kinds, each row after row.
struct Plan {
    rows: Vec<RowPlan>,
    /// For each slice and the end: the numbers of vertices and triangles before it.
    before: Vec<[usize; 2]>,
}

impl Plan {
    fn new(rows: &InsideRows) -> Result<Self, ExtractError> {
        let [_, ny, nz] = rows.dims;
        let mut counts = vec![RowCount::default(); ny * nz];
        let slices = counts.par_chunks_mut(ny).enumerate();
        slices.for_each(|(k, counts)| cells::count(rows, k, counts));
        let mut plan = Self {
            rows: vec![RowPlan::default(); counts.len()],
            before: vec![[0; 2]],
        };
        let [mut vertices, mut triangles] = [0_u64; 2];
        for (counts, rows) in counts.chunks(ny).zip(plan.rows.chunks_mut(ny)) {
            for kind in 0..KINDS {
                for (count, row) in counts.iter().zip(rows.iter_mut()) {
                    row.first[kind] = vertices as u32;
                    row.any[kind] = count.vertices[kind] > 0;
                    vertices += u64::from(count.vertices[kind]);
                }
            }
            for (count, row) in counts.iter().zip(rows) {
                row.triangles = count.triangles > 0;
                triangles += u64::from(count.triangles);
            }
            plan.before
                .push([countable(vertices, "vertices")?, countable(triangles, "triangles")?]);
        }
        Ok(plan)
    }

    fn vertices(&self) -> usize {
        self.before[self.before.len() - 1][0]
    }

    fn triangles(&self) -> usize {
        self.before[self.before.len() - 1][1]
    }

    /// The numbers of the vertices (`what` 0) or triangles (1) of slice `k`.
    fn of_slice(&self, k: usize, what: usize) -> Range<usize> {
        self.before[k][what]..self.before[k + 1][what]
    }
}

fn countable(n: u64, what: &'static str) -> Result<usize, ExtractError> {
    match u32::try_from(n) {
        Ok(n) => Ok(n as usize),
        Err(_) => Err(ExtractError::TooLarge { what }),
    }
}

/// One slice's places in the mesh.
struct SliceTask<'a> {
    k: usize,
    sink: VertexSink<'a>,
    triangles: &'a mut [[u32; 3]],
}

/// Has `fill` write each slice's vertices and triangles, and returns each slice's vertices that fall on voxels.
fn fill(mesh: &mut Mesh, plan: &Plan, fill: impl Fn(SliceTask<'_>) -> Vec<Hit> + Send + Sync) -> Vec<Vec<Hit>> {
    let mut positions = mesh.positions.as_mut_slice();
    let mut normals = mesh.normals.as_mut_slice();
    let mut triangles = mesh.triangles.as_mut_slice();
    let mut task = |k: usize| {
        let vertices = plan.of_slice(k, 0);
        SliceTask {
            k,
            sink: VertexSink {
                positions: split_off(&mut positions, vertices.len()),
                normals: split_off(&mut normals, vertices.len()),
                hits: Vec::new(),
                first: vertices.start as u32,
                written: 0,
            },
            triangles: split_off(&mut triangles, plan.of_slice(k, 1).len()),
        }
    };
    let tasks: Vec<SliceTask<'_>> = (0..plan.before.len() - 1).map(&mut task).collect();
    tasks.into_par_iter().map(fill).collect()
}

fn split_off<'a, T>(rest: &mut &'a mut [T], n: usize) -> &'a mut [T] {
    let (front, back) = std::mem::take(rest).split_at_mut(n);
    *rest = back;
    front
}

fn fill_slice<T: Voxel>(
    task: SliceTask<'_>,
    slices: Slices<'_, T>,
    rows: &InsideRows,
    plan: &Plan,
    level: &Level,
) -> Vec<Hit> {
    let [_, ny, nz] = rows.dims;
    let SliceTask { k, mut sink, triangles } = task;
    let plan = |k: usize| &plan.rows[ny * k..][..ny];
    for kind in 0..KINDS {
        interpolate(slices, rows, plan(k), level, [kind, k], &mut sink);
    }
    if k + 1 < nz {
        cells::connect(rows, k, [plan(k), plan(k + 1)], triangles);
    }
    sink.hits
}
