//! Voxelisation between depth buffers (WK94, *volume-sampled models* and figure 2).
//!
//! *Theory.* Along a beam of voxels the expanded surface is entered at front1 and left at back1, and the shrunken one at front2
//! and back2. Voxels between the two surfaces are soft and get their density; those within the inner one are full; a beam that
//! misses the inner surface is soft from front1 to back1. No other voxel is visited.
//! *Changes from the paper.* A beam has as many layers of depths as the solid has parts along it, so tori, threads and shells
//! need no care of their own. Depths are found by the distance to the surface, which says how many voxels can be skipped,
//! instead of point-sampling both surfaces.
//! *Practice.* Beams run along x, so that what is filled lies together. The three steps are three functions, as in WK94's table 1.

use std::ops::Range;

use glam::{DAffine3, DVec3};
use rayon::prelude::*;

use super::primitive::Placed;
use super::solid::TOGETHER;
use crate::math::{Aabb, affine};

/// A stretch of a beam that the primitive touches: soft from `front1` to `front2` and from `back2` to `back1`, full between; in
/// voxels, with the ends of ranges. Without full voxels `front2` and `back2` are both `back1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layer {
    /// Where the expanded surface is entered.
    pub front1: u32,
    /// Where the shrunken surface is entered.
    pub front2: u32,
    /// Where the shrunken surface is left.
    pub back2: u32,
    /// Where the expanded surface is left.
    pub back1: u32,
}

/// Where the surface is more voxels away than this, voxels are looked at one by one.
const FEW: usize = 16;

/// A primitive on a lattice.
pub struct Voxelizer<'a> {
    placed: &'a Placed,
    dims: [usize; 3],
    local_from_lattice: DAffine3,
    /// Distance between voxels along a beam, in the primitive's frame.
    step: f64,
}

/// The depths of all beams that the primitive touches.
pub struct DepthBuffers {
    /// One for each k that is reached, rising.
    slabs: Vec<Slab>,
}

/// The layers of a row of beams, those of one k.
struct Slab {
    k: usize,
    rows: Range<usize>,
    /// Where the layers of each beam begin, and where those of the last end.
    starts: Vec<u32>,
    layers: Vec<Layer>,
}

/// A stretch of voxels of one beam: `j`, `k`, and the range of `i`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Run {
    /// The beam.
    pub beam: [u32; 2],
    /// Its voxels.
    pub voxels: Range<u32>,
}

/// What is to be filled, for each k: soft stretches and full ones.
pub struct Runs {
    /// Voxels whose density is to be found.
    pub soft: Vec<Vec<Run>>,
    /// Voxels of density 1.
    pub full: Vec<Vec<Run>>,
}

impl<'a> Voxelizer<'a> {
    /// `placed` on a lattice of `dims` voxels at `world_from_lattice`, which is invertible.
    pub fn new(placed: &'a Placed, dims: [usize; 3], world_from_lattice: &DAffine3) -> Self {
        let local_from_lattice = placed.local_from_world * *world_from_lattice;
        Self {
            placed,
            dims,
            local_from_lattice,
            step: local_from_lattice.matrix3.x_axis.length(),
        }
    }

    /// The voxels that can be touched.
    fn reached(&self) -> [Range<usize>; 3] {
        let bounds = self
            .placed
            .local_bounds()
            .transformed(&self.local_from_lattice.inverse());
        let lattice = Aabb::new(DVec3::ZERO, DVec3::from_array(self.dims.map(|n| n as f64 - 1.0)));
        let reached = bounds.intersect(&lattice);
        std::array::from_fn(|a| match reached.is_empty() {
            true => 0..0,
            false => reached.min[a].ceil() as usize..reached.max[a].floor() as usize + 1,
        })
    }

    /// The first step: where each beam enters and leaves both surfaces.
    pub fn depths(&self) -> DepthBuffers {
        let [columns, rows, slices] = self.reached();
        let slab = |k: usize| {
            let mut slab = Slab {
                k,
                rows: rows.clone(),
                starts: vec![0],
                layers: Vec::new(),
            };
            for j in rows.clone() {
                self.beam(columns.clone(), j, k, &mut slab.layers);
                slab.starts.push(slab.layers.len() as u32);
            }
            slab
        };
        DepthBuffers {
            slabs: slices.into_par_iter().map(slab).collect(),
        }
    }

    /// Adds the layers of one beam, stepping over voxels that the distance to the surface shows to be like the last. Near a
    /// surface, where there are few, the distances of several voxels are found together.
    fn beam(&self, columns: Range<usize>, j: usize, k: usize, layers: &mut Vec<Layer>) {
        let row = affine::row(&self.local_from_lattice, j as f64, k as f64);
        let reach = self.placed.reach();
        let mut open: Option<Layer> = None;
        let (mut points, mut distances) = ([DVec3::ZERO; TOGETHER], [0.0; TOGETHER]);
        let (mut i, mut count) = (columns.start, 1);
        while i < columns.end {
            count = count.min(columns.end - i);
            for (n, point) in points[..count].iter_mut().enumerate() {
                *point = affine::step(&self.local_from_lattice, row, (i + n) as f64);
            }
            self.placed.distances(&points[..count], &mut distances[..count]);
            for (n, &distance) in distances[..count - 1].iter().enumerate() {
                add(&mut open, i + n..i + n + 1, distance, reach, layers);
            }
            let distance = distances[count - 1];
            let alike = ((distance.abs() - reach).abs() / self.step) as usize;
            let last = i + count - 1;
            i = last.saturating_add(alike.max(1)).min(columns.end);
            add(&mut open, last..i, distance, reach, layers);
            count = if alike > FEW { 1 } else { TOGETHER };
        }
        layers.extend(open);
    }

    /// The third step: the densities of all voxels, x fastest.
    pub fn fill(&self, runs: &Runs) -> Vec<f32> {
        let plane = self.dims[0] * self.dims[1];
        let mut densities = vec![0.0; plane * self.dims[2]];
        let slices = densities.par_chunks_mut(plane.max(1));
        slices
            .zip(&runs.soft)
            .zip(&runs.full)
            .for_each(|((slice, soft), full)| {
                for run in full {
                    slice[self.place(run)].fill(1.0);
                }
                for run in soft {
                    self.soften(run, &mut slice[self.place(run)]);
                }
            });
        densities
    }

    /// A run's voxels in its slice.
    fn place(&self, run: &Run) -> Range<usize> {
        let row = self.dims[0] * run.beam[0] as usize;
        row + run.voxels.start as usize..row + run.voxels.end as usize
    }

    fn soften(&self, run: &Run, densities: &mut [f32]) {
        let [j, k] = run.beam.map(f64::from);
        let row = affine::row(&self.local_from_lattice, j, k);
        let mut points = [DVec3::ZERO; TOGETHER];
        for (densities, start) in densities.chunks_mut(TOGETHER).zip(run.voxels.clone().step_by(TOGETHER)) {
            let points = &mut points[..densities.len()];
            for (point, i) in points.iter_mut().zip(start..) {
                *point = affine::step(&self.local_from_lattice, row, f64::from(i));
            }
            self.placed.coverages(points, densities);
        }
    }

    /// All three steps.
    pub fn voxelize(&self) -> Vec<f32> {
        self.fill(&self.depths().runs(self.dims[2]))
    }
}

/// Adds voxels at this distance from the surface to the layer that is open, or closes it.
fn add(open: &mut Option<Layer>, voxels: Range<usize>, distance: f64, reach: f64, layers: &mut Vec<Layer>) {
    if distance >= reach {
        layers.extend(open.take());
    } else if distance > -reach {
        open.get_or_insert(Layer::from(voxels.start)).add_soft(voxels.end);
    } else {
        // A shell may be full again behind its hollow.
        layers.extend(open.take_if(|layer| layer.is_left()));
        open.get_or_insert(Layer::from(voxels.start))
            .add_full(voxels.start, voxels.end);
    }
}

impl Layer {
    /// A layer that begins at voxel `i` and holds nothing yet.
    fn from(i: usize) -> Self {
        let i = i as u32;
        Self {
            front1: i,
            front2: i,
            back2: i,
            back1: i,
        }
    }

    fn has_full(&self) -> bool {
        self.front2 < self.back2
    }

    /// Whether the shrunken surface has been entered and left.
    fn is_left(&self) -> bool {
        self.has_full() && self.back2 < self.back1
    }

    /// Adds soft voxels up to `end`.
    fn add_soft(&mut self, end: usize) {
        self.back1 = end as u32;
        if !self.has_full() {
            (self.front2, self.back2) = (self.back1, self.back1);
        }
    }

    /// Adds full voxels from `start` to `end`.
    fn add_full(&mut self, start: usize, end: usize) {
        if !self.has_full() {
            self.front2 = start as u32;
        }
        (self.back2, self.back1) = (end as u32, end as u32);
    }
}

impl DepthBuffers {
    /// The layers of beam `(j, k)`, rising.
    pub fn layers(&self, j: usize, k: usize) -> &[Layer] {
        let slab = self.slabs.iter().find(|slab| slab.k == k && slab.rows.contains(&j));
        slab.map_or(&[], |slab| slab.of(j))
    }

    /// The second step: which voxels are soft and which are full, for each of `slices` slices.
    pub fn runs(&self, slices: usize) -> Runs {
        let mut runs = Runs {
            soft: vec![Vec::new(); slices],
            full: vec![Vec::new(); slices],
        };
        for slab in &self.slabs {
            for j in slab.rows.clone() {
                for layer in slab.of(j) {
                    let add = |to: &mut Vec<Run>, voxels: Range<u32>| {
                        let beam = [j as u32, slab.k as u32];
                        to.extend((!voxels.is_empty()).then_some(Run { beam, voxels }));
                    };
                    add(&mut runs.soft[slab.k], layer.front1..layer.front2);
                    add(&mut runs.full[slab.k], layer.front2..layer.back2);
                    add(&mut runs.soft[slab.k], layer.back2..layer.back1);
                }
            }
        }
        runs
    }
}

impl Slab {
    fn of(&self, j: usize) -> &[Layer] {
        let n = j - self.rows.start;
        &self.layers[self.starts[n] as usize..self.starts[n + 1] as usize]
    }
}
