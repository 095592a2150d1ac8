//! A mesh put together from slices.
//!
//! *Theory.* March through the cells between eight voxels; each makes the triangles of its case, with vertices on the edges
//! that the surface crosses (LC87 §4).
//! *Changes from the paper.* Not cell after cell with the last row's vertices kept, but two passes over runs of slices in
//! parallel: the first counts each slice's vertices and triangles, so that the second knows where to write them. Their order
//! does not depend on the number of threads.
//! *Practice.* The first pass is all that reads every voxel, and leaves only the words through which the surface goes; the
//! second reads the voxels round its vertices. A run goes a few slices at a time, whose bits then stay in the processor's caches. Slices may
//! come all together or some at a time.

use std::ops::Range;

use bytemuck::Pod;
use rayon::prelude::*;

use super::cells::{self, Cells};
use super::crossings::Crossings;
use super::extract::{ExtractError, Topology};
use super::inside::{Classifier, InsideRows};
use super::manifold;
use super::mesh::{Mesh, Part};
use super::slices::Slices;
use super::vertices::{Hit, Level, Loose, VertexSink, interpolate};
use super::weld::{Layout, weld};
use super::words::{Known, SliceWords};
use crate::array::Array;
use crate::volume::Voxel;

/// Slices whose bits are made together: few enough for a cache, many beside the four more that are held for their sake.
const TOGETHER: usize = 8;

/// The most slices in a run, and the runs for each thread that fewer are made for: so that threads end together.
const LONGEST_RUN: usize = 32;
const RUNS_A_THREAD: usize = 4;

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

    /// Adds the vertices that start in slices `layers`, and the triangles of the cells above these. The classifier's slices
    /// reach from one before these to two after them, or three where it finds ties, as far as the lattice goes. Layers are
    /// added in their order.
    ///
    /// # Errors
    /// [`ExtractError::TooLarge`].
    pub fn add<T: Voxel>(&mut self, classifier: &Classifier<'_, T>, layers: Range<usize>) -> Result<(), ExtractError> {
        let longest = layers.len().div_ceil(RUNS_A_THREAD * rayon::current_num_threads());
        let length = longest.clamp(1, LONGEST_RUN);
        let words = self.count(classifier, &layers, length)?;
        let [vertices, triangles] = self.before[layers.end];
        grow(&mut self.mesh.positions, vertices);
        grow(&mut self.mesh.normals, vertices);
        grow(&mut self.mesh.triangles, triangles);
        let known = Known {
            first_slice: layers.start,
            slices: &words,
        };
        for done in self.fill(classifier, &layers, length, known).into_iter().flatten() {
            self.hits.push(done.hits);
            self.loose.extend(done.loose);
        }
        Ok(())
    }

    /// Counts what starts in each of the layers, and returns what is known of the words of their rows.
    fn count<T: Voxel>(
        &mut self,
        classifier: &Classifier<'_, T>,
        layers: &Range<usize>,
        length: usize,
    ) -> Result<Vec<SliceWords>, ExtractError> {
        let mut words = vec![SliceWords::default(); layers.len()];
        let mut counts = vec![[0; 2]; layers.len()];
        let runs = words.par_chunks_mut(length).zip(counts.par_chunks_mut(length));
        runs.enumerate().for_each(|(n, (words, counts))| {
            let first = layers.start + n * length;
            let mut crossings = Crossings::new(classifier.slices.dims);
            let mut cells = Cells::default();
            walk(classifier, first..first + counts.len(), Known::default(), |rows, k| {
                words[k - first] = rows.words_of(k);
                crossings.find(rows, k);
                counts[k - first] = [crossings.count(), 0];
                if rows.slices.contains(&(k + 1)) {
                    cells.find(rows, k);
                    let within = self.count_within(classifier.slices, rows, k, &cells);
                    counts[k - first][0] += within[0];
                    counts[k - first][1] = within[1];
                }
            });
        });
        let [mut vertices, mut triangles] = self.before[layers.start].map(|n| n as u64);
        for count in counts {
            vertices += count[0];
            triangles += count[1];
            self.before
                .push([countable(vertices, "vertices")?, countable(triangles, "triangles")?]);
        }
        Ok(words)
    }

    /// How many vertices lie within the `cells` above slice `k`, and how many triangles these have.
    fn count_within<T: Voxel>(&self, slices: Slices<'_, T>, rows: &InsideRows, k: usize, cells: &Cells) -> [u64; 2] {
        match self.topology {
            Topology::Vtk => [0, cells::count(rows, k, cells)],
            Topology::Trilinear => {
                let active = &cells.active;
                manifold::Layer { slices, k, active }.count(self.level.iso())
            }
        }
    }

    /// Writes each layer's vertices and triangles.
    fn fill<T: Voxel>(
        &mut self,
        classifier: &Classifier<'_, T>,
        layers: &Range<usize>,
        length: usize,
        known: Known<'_>,
    ) -> Vec<Vec<Done>> {
        let [vertices, triangles] = self.before[layers.start];
        let mut room = Room {
            positions: &mut self.mesh.positions[vertices..],
            normals: &mut self.mesh.normals[vertices..],
            triangles: &mut self.mesh.triangles[triangles..],
        };
        let filler = Filler {
            classifier,
            known,
            before: &self.before,
            level: self.level,
            topology: self.topology,
        };
        let starts = layers.clone().step_by(length);
        let runs = starts.map(|start| start..(start + length).min(layers.end));
        let runs: Vec<_> = runs
            .map(|run| (run.clone(), room.split_off(&self.before, run)))
            .collect();
        runs.into_par_iter().map(|(run, room)| filler.fill(run, room)).collect()
    }

    /// The vertices that start in slice `k`, with the numbers they have got.
    pub fn crossings(&self, rows: &InsideRows, k: usize) -> Crossings {
        let mut crossings = Crossings::new(self.dims);
        crossings.find(rows, k);
        crossings.number(self.before[k][0] as u32);
        crossings
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

/// Shows `visit` the bits round each of the layers in their order: those of one slice before it and three after it, as far
/// as there are any.
fn walk<T: Voxel>(
    classifier: &Classifier<'_, T>,
    layers: Range<usize>,
    known: Known<'_>,
    mut visit: impl FnMut(&InsideRows, usize),
) {
    let there = classifier.slices.held();
    let mut rows = InsideRows::new(classifier.slices.dims);
    for start in layers.clone().step_by(TOGETHER) {
        let end = (start + TOGETHER).min(layers.end);
        let held = there.start.max(start.saturating_sub(1))..there.end.min(end + 3);
        rows.move_to(classifier, held, known);
        (start..end).for_each(|k| visit(&rows, k));
    }
}

/// Where some slices' vertices and triangles go.
struct Room<'a> {
    positions: &'a mut [[f32; 3]],
    normals: &'a mut [[f32; 3]],
    triangles: &'a mut [[u32; 3]],
}

impl<'a> Room<'a> {
    /// Takes the room of `slices` from the front; `before` is [`Assembly::before`].
    fn split_off(&mut self, before: &[[usize; 2]], slices: Range<usize>) -> Room<'a> {
        let [start, end] = [before[slices.start], before[slices.end]];
        let [vertices, triangles] = [end[0] - start[0], end[1] - start[1]];
        Room {
            positions: split_off(&mut self.positions, vertices),
            normals: split_off(&mut self.normals, vertices),
            triangles: split_off(&mut self.triangles, triangles),
        }
    }
}

/// What is left to do after a slice.
struct Done {
    hits: Vec<Hit>,
    loose: Vec<Loose>,
}

/// Writes vertices and triangles that are counted.
struct Filler<'a, T> {
    classifier: &'a Classifier<'a, T>,
    known: Known<'a>,
    before: &'a [[usize; 2]],
    level: Level,
    topology: Topology,
}

impl<T: Voxel> Filler<'_, T> {
    /// Writes what a run of layers makes.
    fn fill(&self, run: Range<usize>, mut room: Room<'_>) -> Vec<Done> {
        let slices = self.classifier.slices;
        let [mut lower, mut upper] = [Crossings::new(slices.dims), Crossings::new(slices.dims)];
        let mut cells = Cells::default();
        let mut done = Vec::with_capacity(run.len());
        walk(self.classifier, run.clone(), self.known, |rows, k| {
            if k == run.start {
                self.find(rows, k, &mut lower);
            }
            let room = room.split_off(self.before, k..k + 1);
            let mut sink = VertexSink {
                positions: room.positions,
                normals: room.normals,
                hits: Vec::new(),
                loose: Vec::new(),
                first: self.before[k][0] as u32,
                written: 0,
            };
            interpolate(slices, &lower, k, &self.level, &mut sink);
            if k + 1 < slices.dims[2] {
                self.find(rows, k + 1, &mut upper);
                cells.find(rows, k);
                let crossings = [&lower, &upper];
                match self.topology {
                    Topology::Vtk => cells::connect(rows, k, crossings, &cells, room.triangles),
                    Topology::Trilinear => {
                        let layer = manifold::Layer {
                            slices,
                            k,
                            active: &cells.active,
                        };
                        layer.connect(crossings, &self.level, &mut sink, room.triangles);
                    }
                }
                std::mem::swap(&mut lower, &mut upper);
            }
            done.push(Done {
                hits: sink.hits,
                loose: sink.loose,
            });
        });
        done
    }

    /// Finds and numbers the vertices that start in slice `k`.
    fn find(&self, rows: &InsideRows, k: usize, crossings: &mut Crossings) {
        crossings.find(rows, k);
        crossings.number(self.before[k][0] as u32);
    }
}

fn countable(n: u64, what: &'static str) -> Result<usize, ExtractError> {
    match u32::try_from(n) {
        Ok(n) => Ok(n as usize),
        Err(_) => Err(ExtractError::TooLarge { what }),
    }
}

/// Lengthens `values` to `len`. An empty one is made anew: zeros come from the system without being written.
fn grow<T: Pod + Send + Sync>(values: &mut Array<T>, len: usize) {
    if values.is_empty() {
        *values = Array::zeroed(len);
    } else {
        let more = len - values.len();
        values.to_mut().par_extend(rayon::iter::repeat_n(T::zeroed(), more));
    }
}

fn split_off<'a, T>(rest: &mut &'a mut [T], n: usize) -> &'a mut [T] {
    let (front, back) = std::mem::take(rest).split_at_mut(n);
    *rest = back;
    front
}
