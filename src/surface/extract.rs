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

use super::cells::{self, RowCount, RowFirst, RowsRound};
use super::inside::{self, InsideRows};
use super::mesh::{Mesh, Part};
use super::vertices::{Hit, Interpolator, Slices, VertexSink, interpolate};
use super::weld::weld;
use crate::volume::{Grid, Voxel, Voxels, for_type};

/// Why a surface could not be extracted.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ExtractError {
    /// The isovalue is not a number.
    #[error("the isovalue is not a number")]
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
/// If `iso` is NaN, or the mesh has more vertices or triangles than `u32` counts.
pub fn marching_cubes(grid: &Grid, iso: f64) -> Result<Mesh, ExtractError> {
    for_type!(Voxels, grid.voxels(), voxels => extract(voxels, grid.dims(), grid.world_from_index(), iso))
}

fn extract<T: Voxel>(
    voxels: &[T],
    dims: [usize; 3],
    world_from_index: &DAffine3,
    iso: f64,
) -> Result<Mesh, ExtractError> {
    if iso.is_nan() {
        return Err(ExtractError::NoIsovalue);
    }
    let smallest_inside = T::not_below(iso).filter(|_| dims.iter().all(|n| *n > 1));
    let Some(smallest_inside) = smallest_inside else {
        return Ok(Mesh::default());
    };
    let slices = Slices {
        voxels,
        first_slice: 0,
        dims,
    };
    let rows = Rows::classified(slices, smallest_inside);
    let plan = Plan::new(&rows)?;
    let mut mesh = Mesh {
        positions: vec![[0.0; 3]; plan.vertices()],
        normals: vec![[0.0; 3]; plan.vertices()],
        triangles: vec![[0; 3]; plan.triangles()],
        ..Mesh::default()
    };
    let interpolator = Interpolator::new(slices, iso, *world_from_index);
    let hits = fill(&mut mesh, &rows, &plan, &interpolator);
    weld(&mut mesh, hits);
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

/// The bits of all voxels of a lattice.
struct Rows {
    inside: InsideRows,
    dims: [usize; 3],
}

impl Rows {
    fn classified<T: Voxel>(slices: Slices<'_, T>, smallest_inside: T) -> Self {
        let dims @ [nx, ny, nz] = slices.dims;
        let mut inside = InsideRows::new(nx, ny * nz);
        inside
            .runs_mut(ny)
            .enumerate()
            .for_each(|(k, words)| inside::classify(slices.slice(k), nx, smallest_inside, words));
        Self { inside, dims }
    }

    /// The rows round the row of cells at row `j` of slice `k`.
    fn round(&self, j: usize, k: usize) -> RowsRound<'_> {
        let [width, ny, nz] = self.dims;
        let row = |j: usize, k: usize| self.inside.row(j.min(ny - 1) + ny * k.min(nz - 1));
        RowsRound {
            rows: [row(j, k), row(j + 1, k), row(j, k + 1), row(j + 1, k + 1)],
            width,
        }
    }

    /// Counts for each row of each slice.
    fn counts(&self) -> Vec<RowCount> {
        let [_, ny, nz] = self.dims;
        (0..ny * nz)
            .into_par_iter()
            .with_min_len(ny)
            .map(|n| {
                let (j, k) = (n % ny, n / ny);
                let count = cells::count(self.round(j, k));
                let has_cells = j + 1 < ny && k + 1 < nz;
                RowCount {
                    triangles: if has_cells { count.triangles } else { 0 },
                    ..count
                }
            })
            .collect()
    }
}

/// Where each row's vertices and triangles go. A slice's vertices on x and y edges come before those on its z edges, and row
/// after row in both.
struct Plan {
    rows: Vec<RowFirst>,
    /// For each slice and the end: the numbers of vertices and triangles before it.
    before: Vec<[usize; 2]>,
}

impl Plan {
    fn new(rows: &Rows) -> Result<Self, ExtractError> {
        let ny = rows.dims[1];
        let counts = rows.counts();
        let mut plan = Self {
            rows: vec![[0; 3]; counts.len()],
            before: vec![[0; 2]],
        };
        let [mut vertices, mut triangles] = [0_u64; 2];
        for (counts, firsts) in counts.chunks(ny).zip(plan.rows.chunks_mut(ny)) {
            for axes in [0..2, 2..3] {
                for (count, first) in counts.iter().zip(firsts.iter_mut()) {
                    for axis in axes.clone() {
                        first[axis] = vertices as u32;
                        vertices += u64::from(count.edges[axis]);
                    }
                }
            }
            triangles += counts.iter().map(|c| u64::from(c.triangles)).sum::<u64>();
            plan.before.push([countable(vertices, "vertices")?, countable(triangles, "triangles")?]);
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

/// Writes all vertices and triangles, and returns the vertices that fall on voxels.
fn fill<T: Voxel>(mesh: &mut Mesh, rows: &Rows, plan: &Plan, interpolator: &Interpolator<'_, T>) -> Vec<Hit> {
    let mut positions = mesh.positions.as_mut_slice();
    let mut normals = mesh.normals.as_mut_slice();
    let mut triangles = mesh.triangles.as_mut_slice();
    let tasks: Vec<SliceTask<'_>> = (0..rows.dims[2])
        .map(|k| {
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
        })
        .collect();
    let hits: Vec<Vec<Hit>> = tasks
        .into_par_iter()
        .map(|task| fill_slice(task, rows, plan, interpolator))
        .collect();
    hits.concat()
}

fn split_off<'a, T>(rest: &mut &'a mut [T], n: usize) -> &'a mut [T] {
    let (front, back) = std::mem::take(rest).split_at_mut(n);
    *rest = back;
    front
}

fn fill_slice<T: Voxel>(task: SliceTask<'_>, rows: &Rows, plan: &Plan, interpolator: &Interpolator<'_, T>) -> Vec<Hit> {
    let [_, ny, nz] = rows.dims;
    let SliceTask { k, mut sink, mut triangles } = task;
    for axes in [&[0, 1][..], &[2]] {
        for j in 0..ny {
            interpolate(interpolator, rows.round(j, k), [j, k], axes, &mut sink);
        }
    }
    if k + 1 < nz {
        let first = |j: usize, k: usize| plan.rows[j + ny * k];
        for j in 0..ny - 1 {
            let firsts = [first(j, k), first(j + 1, k), first(j, k + 1), first(j + 1, k + 1)];
            let written = cells::connect(rows.round(j, k), firsts, triangles);
            split_off(&mut triangles, written);
        }
    }
    sink.hits
}
