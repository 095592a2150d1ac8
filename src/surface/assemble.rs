//! A mesh put together from slices.
//!
//! *Theory.* March through the cells between eight voxels; each makes the triangles of its case, with vertices on the edges
//! that the surface crosses (LC87 §4).
//! *Changes from the paper.* Not cell after cell with the last row's vertices kept, but two passes over slices in parallel:
//! the first counts the vertices and triangles of each row, so that the second knows where to write each of them. Their order
//! does not depend on the number of threads.
//! *Practice.* Slices may come all together or some at a time: a slice's vertices on x and y edges are numbered first, so that
//! the cells below it can name them before the slice above it is known.

use std::ops::Range;

use rayon::prelude::*;

use super::cells::{self, KINDS, RowCount, RowPlan};
use super::extract::{ExtractError, Topology};
use super::inside::InsideRows;
use super::manifold;
use super::mesh::{Mesh, Part};
use super::slices::Slices;
use super::vertices::{Hit, Level, Loose, VertexSink, interpolate};
use super::weld::{Layout, weld};
use crate::volume::Voxel;

/// A mesh that slices are added to.
pub(super) struct Assembly {
    pub mesh: Mesh,
    pub level: Level,
    /// Vertices that are nowhere yet.
    pub loose: Vec<Loose>,
    /// For each slice, the vertices that fall on voxels of it or the next.
    pub hits: Vec<Vec<Hit>>,
    topology: Topology,
    pub dims: [usize; 3],
    /// For each slice and the end: the numbers of vertices and of triangles before it.
    before: Vec<[usize; 2]>,
}

impl Assembly {
    /// A mesh of a lattice of `dims` without slices.
    pub fn new(level: Level, dims: [usize; 3], topology: Topology) -> Self {
        Self {
            mesh: Mesh::default(),
            level,
            loose: Vec::new(),
            hits: Vec::new(),
            topology,
            dims,
            before: vec![[0; 2]],
        }
    }

    /// Adds the vertices that start in slices `layers`, and the triangles of the cells above these. `slices` holds one slice
    /// before and two after them, and `rows` one after, as far as the lattice goes. Layers are added in their order.
    ///
    /// # Errors
    /// [`ExtractError::TooLarge`].
    pub fn add<T: Voxel>(
        &mut self,
        slices: Slices<'_, T>,
        rows: &InsideRows,
        layers: Range<usize>,
    ) -> Result<(), ExtractError> {
        let iso = self.level.iso();
        let plan = match self.topology {
            Topology::Vtk => self.plan(&layers, rows, |k, counts| cells::count(rows, k, counts)),
            Topology::Trilinear => self.plan(&layers, rows, |k, counts| manifold::count(slices, rows, iso, k, counts)),
        }?;
        let (level, topology) = (self.level, self.topology);
        let done = self.fill(&layers, |k, sink, triangles| {
            for kind in 0..plan.edge_kinds(topology) {
                interpolate(slices, rows, plan.slice(k), &level, [kind, k], sink);
            }
            if k + 1 < rows.slices.end {
                let plan = [plan.slice(k), plan.slice(k + 1)];
                match topology {
                    Topology::Vtk => cells::connect(rows, k, plan, triangles),
                    Topology::Trilinear => manifold::connect(slices, rows, &level, k, plan, sink, triangles),
                }
            }
        });
        for (hits, loose) in done {
            self.hits.push(hits);
            self.loose.extend(loose);
        }
        Ok(())
    }

    /// Counts with `count`, and says where everything goes; makes room for it.
    fn plan(
        &mut self,
        layers: &Range<usize>,
        rows: &InsideRows,
        count: impl Fn(usize, &mut [RowCount]) + Sync,
    ) -> Result<Plan, ExtractError> {
        let ny = self.dims[1];
        let planned = layers.start..(layers.end + 1).min(rows.slices.end);
        let mut counts = vec![RowCount::default(); ny * planned.len()];
        let slices = counts.par_chunks_mut(ny).zip(planned.clone());
        slices.for_each(|(counts, k)| count(k, counts));
        let mut plan = Plan {
            rows: vec![RowPlan::default(); counts.len()],
            first_slice: layers.start,
            ny,
        };
        let [vertices, triangles] = self.before[self.before.len() - 1];
        let mut ends = [vertices as u64, triangles as u64];
        for ((counts, rows), k) in counts.chunks(ny).zip(plan.rows.chunks_mut(ny)).zip(planned) {
            number(counts, rows, &mut ends);
            // What belongs to the slice after the layers is numbered, but is not theirs to count.
            if layers.contains(&k) {
                self.before
                    .push([countable(ends[0], "vertices")?, countable(ends[1], "triangles")?]);
            }
        }
        let [vertices, triangles] = self.before[self.before.len() - 1];
        grow(&mut self.mesh.positions, vertices, [0.0; 3]);
        grow(&mut self.mesh.normals, vertices, [0.0; 3]);
        grow(&mut self.mesh.triangles, triangles, [0; 3]);
        Ok(plan)
    }

    /// Has `fill` write each layer's vertices and triangles.
    fn fill(
        &mut self,
        layers: &Range<usize>,
        fill: impl Fn(usize, &mut VertexSink<'_>, &mut [[u32; 3]]) + Send + Sync,
    ) -> Vec<(Vec<Hit>, Vec<Loose>)> {
        let [vertices, triangles] = self.before[layers.start];
        let mut positions = &mut self.mesh.positions[vertices..];
        let mut normals = &mut self.mesh.normals[vertices..];
        let mut triangles = &mut self.mesh.triangles[triangles..];
        let tasks: Vec<_> = layers
            .clone()
            .map(|k| {
                let [start, end] = [self.before[k], self.before[k + 1]];
                let sink = VertexSink {
                    positions: split_off(&mut positions, end[0] - start[0]),
                    normals: split_off(&mut normals, end[0] - start[0]),
                    hits: Vec::new(),
                    loose: Vec::new(),
                    first: start[0] as u32,
                    written: 0,
                };
                (k, sink, split_off(&mut triangles, end[1] - start[1]))
            })
            .collect();
        let filled = |(k, mut sink, triangles): (usize, VertexSink<'_>, &mut [[u32; 3]])| {
            fill(k, &mut sink, triangles);
            (sink.hits, sink.loose)
        };
        tasks.into_par_iter().map(filled).collect()
    }

    /// The numbers that the vertices of slice `k` of the lattice, all of which is held, have got, for each of its rows.
    pub fn rows(&self, rows: &InsideRows, k: usize) -> Vec<RowPlan> {
        let mut counts = vec![RowCount::default(); self.dims[1]];
        let mut plan = vec![RowPlan::default(); counts.len()];
        cells::count(rows, k, &mut counts);
        number(&counts, &mut plan, &mut self.before[k].map(|n| n as u64));
        plan
    }

    /// The mesh.
    pub fn finish(mut self) -> Mesh {
        if self.topology == Topology::Vtk {
            let layout = Layout {
                voxels_a_slice: self.dims[0] * self.dims[1],
                before: &self.before,
            };
            weld(&mut self.mesh, &self.hits, &layout);
        }
        if self.level.is_mirrored() {
            self.mesh.triangles.par_iter_mut().for_each(|t| t.swap(1, 2));
        }
        self.mesh.parts.push(Part {
            label: 0,
            iso: Some(self.level.iso()),
            triangles: 0..self.mesh.triangles.len(),
        });
        self.mesh
    }
}

/// Where each row's vertices and triangles go. A slice's vertices are in the order of their kinds, each row after row.
struct Plan {
    rows: Vec<RowPlan>,
    first_slice: usize,
    ny: usize,
}

impl Plan {
    fn slice(&self, k: usize) -> &[RowPlan] {
        &self.rows[self.ny * (k - self.first_slice)..][..self.ny]
    }

    /// How many kinds of vertices follow from edges and voxels alone.
    fn edge_kinds(&self, topology: Topology) -> usize {
        match topology {
            Topology::Vtk => KINDS,
            Topology::Trilinear => 3,
        }
    }
}

/// Numbers what a slice's rows make from `ends` on, and moves `ends` behind it.
fn number(counts: &[RowCount], rows: &mut [RowPlan], [vertices, triangles]: &mut [u64; 2]) {
    for kind in 0..KINDS {
        for (count, row) in counts.iter().zip(rows.iter_mut()) {
            // Wraps only where there is an error in the end.
            row.first[kind] = *vertices as u32;
            row.any[kind] = count.vertices[kind] > 0;
            *vertices += u64::from(count.vertices[kind]);
        }
    }
    for (count, row) in counts.iter().zip(rows) {
        row.triangles = count.triangles > 0;
        *triangles += u64::from(count.triangles);
    }
}

fn countable(n: u64, what: &'static str) -> Result<usize, ExtractError> {
    match u32::try_from(n) {
        Ok(n) => Ok(n as usize),
        Err(_) => Err(ExtractError::TooLarge { what }),
    }
}

/// Lengthens `values` to `len`. An empty one is made anew: zeros come from the system without being written.
fn grow<T: Clone>(values: &mut Vec<T>, len: usize, zero: T) {
    if values.is_empty() {
        *values = vec![zero; len];
    } else {
        values.resize(len, zero);
    }
}

fn split_off<'a, T>(rest: &mut &'a mut [T], n: usize) -> &'a mut [T] {
    let (front, back) = std::mem::take(rest).split_at_mut(n);
    *rest = back;
    front
}
