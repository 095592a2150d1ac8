//! Reconstruction: every voxel of a block through the block's path (VCSG §3.1).
//!
//! *Theory.* For each voxel, fetch its values in the path's leaves and combine them by the path's operations.
//! *Changes from the paper.* A path runs once for a row of voxels, not once for a voxel: leaves fill rows of samples, and
//! operations combine whole rows. Bit for bit the result is the tree's at each voxel (design law 1).

use std::ops::Range;

use glam::DVec3;

use crate::math::affine;
use crate::model::{Leaf, Source, Step, Tree, VolumeLeaf};
use crate::volume::Sample;

/// A volume leaf that fills rows with its values.
struct VolumeRow<'a> {
    leaf: &'a Leaf,
    volume: &'a VolumeLeaf,
}

impl VolumeRow<'_> {
    /// Values at the voxels from `(x, y, z)` on along x, all in the volume's box.
    fn fill(&self, x: f64, y: f64, z: f64, values: &mut [f32]) {
        let map = &self.leaf.local_from_frame;
        self.volume.bricks.sample_row(map, affine::row(map, y, z), x, values);
    }
}

/// A row of samples, as separate values and coverages.
#[derive(Default)]
struct Row {
    value: Vec<f32>,
    coverage: Vec<f32>,
}

/// Runs paths over rows of voxels; keeps its rows between calls.
pub struct RowEvaluator<'a> {
    tree: &'a Tree,
    rows: Vec<Row>,
    depth: usize,
}

impl<'a> RowEvaluator<'a> {
    /// An evaluator of paths of `tree`.
    pub fn new(tree: &'a Tree) -> Self {
        Self {
            tree,
            rows: Vec::new(),
            depth: 0,
        }
    }

    /// Evaluates `path` at the voxels `(i, j, k)` for `i` in `columns`: value times coverage, and coverage where it is asked
    /// for. Both rows are as long as `columns`.
    pub fn evaluate(
        &mut self,
        path: &[Step],
        columns: Range<usize>,
        [j, k]: [usize; 2],
        premultiplied: &mut [f32],
        coverage: Option<&mut [f32]>,
    ) {
        let (y, z) = (j as f64, k as f64);
        if let Some(volume) = self.lone_volume(path) {
            volume.fill(columns.start as f64, y, z, premultiplied);
            if let Some(coverage) = coverage {
                coverage.fill(1.0);
            }
            return;
        }
        self.depth = 0;
        for &step in path {
            self.apply(step, &columns, y, z);
        }
        if self.depth == 0 {
            self.push(columns.len());
        }
        let row = &self.rows[0];
        for (out, (v, c)) in premultiplied.iter_mut().zip(row.value.iter().zip(&row.coverage)) {
            *out = v * c;
        }
        if let Some(coverage) = coverage {
            coverage.copy_from_slice(&row.coverage);
        }
    }

    /// The volume that a path consists of, if that is all of it and it is present throughout: most blocks of most scenes.
    fn lone_volume(&self, path: &[Step]) -> Option<VolumeRow<'a>> {
        let &[Step::LeafInside(index)] = path else {
            return None;
        };
        let leaf = self.tree.leaf(index);
        match &leaf.source {
            Source::Volume(volume) if volume.admits_all() => Some(VolumeRow { leaf, volume }),
            _ => None,
        }
    }

    /// A new top row of `len` empty samples.
    fn push(&mut self, len: usize) -> &mut Row {
        if self.depth == self.rows.len() {
            self.rows.push(Row::default());
        }
        let row = &mut self.rows[self.depth];
        self.depth += 1;
        for part in [&mut row.value, &mut row.coverage] {
            part.clear();
            part.resize(len, 0.0);
        }
        row
    }

    fn top(&mut self) -> &mut Row {
        &mut self.rows[self.depth - 1]
    }

    fn apply(&mut self, step: Step, columns: &Range<usize>, y: f64, z: f64) {
        let tree = self.tree;
        let x0 = columns.start as f64;
        match step {
            Step::LeafInside(i) => self.push(columns.len()).fill_inside(tree.leaf(i), x0, y, z),
            Step::Leaf(i) => self.push(columns.len()).fill_tested(tree.leaf(i), x0, y, z),
            Step::Map(i) => {
                let map = tree.map(i);
                self.top().update(|_, s| map.sample(s));
            }
            Step::Cut(i) => {
                let cut = tree.cut(i);
                self.top().update(|n, s| {
                    let p = DVec3::new(x0 + n as f64, y, z);
                    if cut.distance(p) > 0.0 { Sample::EMPTY } else { s }
                });
            }
            Step::Combine(i) => {
                let operator = tree.operator(i);
                self.depth -= 1;
                let (below, above) = self.rows.split_at_mut(self.depth);
                let (first, second) = (&mut below[self.depth - 1], &above[0]);
                first.update(|n, s| operator.apply(s, second.sample(n)));
            }
        }
    }
}

impl Row {
    fn sample(&self, n: usize) -> Sample {
        Sample {
            value: self.value[n],
            coverage: self.coverage[n],
        }
    }

    fn update(&mut self, f: impl Fn(usize, Sample) -> Sample) {
        let pairs = self.value.iter_mut().zip(&mut self.coverage);
        for (n, (value, coverage)) in pairs.enumerate() {
            let s = f(
                n,
                Sample {
                    value: *value,
                    coverage: *coverage,
                },
            );
            (*value, *coverage) = (s.value, s.coverage);
        }
    }

    /// Fills the row from a leaf that holds all of it.
    fn fill_inside(&mut self, leaf: &Leaf, x0: f64, y: f64, z: f64) {
        match &leaf.source {
            Source::Volume(_) => self.fill(leaf, 0..self.value.len(), x0, y, z),
            Source::Primitive(placed) => {
                self.value.fill(placed.value());
                self.coverage.fill(1.0);
            }
        }
    }

    /// Fills the part of the row that lies in the leaf's box. Along a row each coordinate is monotone, rounding included, so
    /// that part is one interval.
    fn fill_tested(&mut self, leaf: &Leaf, x0: f64, y: f64, z: f64) {
        let row = affine::row(&leaf.local_from_frame, y, z);
        let inside = |n: &usize| {
            let local = affine::step(&leaf.local_from_frame, row, x0 + *n as f64);
            leaf.local_bounds.contains(local)
        };
        let len = self.value.len();
        let Some(first) = (0..len).find(inside) else {
            return;
        };
        let last = (first..len).rev().find(inside).unwrap_or(first);
        self.fill(leaf, first..last + 1, x0, y, z);
    }

    fn fill(&mut self, leaf: &Leaf, part: Range<usize>, x0: f64, y: f64, z: f64) {
        let x = x0 + part.start as f64;
        let (values, coverages) = (&mut self.value[part.clone()], &mut self.coverage[part]);
        match &leaf.source {
            Source::Volume(volume) => {
                VolumeRow { leaf, volume }.fill(x, y, z, values);
                coverages.fill(1.0);
                if volume.admits_all() {
                    return;
                }
                for (v, c) in values.iter_mut().zip(coverages) {
                    let s = volume.admit(*v);
                    (*v, *c) = (s.value, s.coverage);
                }
            }
            Source::Primitive(placed) => {
                let row = affine::row(&leaf.local_from_frame, y, z);
                for (n, (v, c)) in values.iter_mut().zip(coverages).enumerate() {
                    let local = affine::step(&leaf.local_from_frame, row, x + n as f64);
                    let s = placed.sample(local);
                    (*v, *c) = (s.value, s.coverage);
                }
            }
        }
    }
}
