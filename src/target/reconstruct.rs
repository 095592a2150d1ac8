//! Reconstruction: every voxel of a block through the block's path (VCSG §3.1).
//!
//! *Theory.* For each voxel, fetch its values in the path's leaves and combine them by the path's operations.
//! *Changes from the paper.* A path runs once for a row of voxels, not once for a voxel: leaves fill rows of samples, and
//! operations combine whole rows. Bit for bit the result is the tree's at each voxel (design law 1). Below a deformation a row is
//! bent: its points are found once, cell by cell of the deformation's table, and leaves are sampled at them.

use std::ops::Range;

use glam::DVec3;

use super::program::{Instruction, program};
use super::{Lattice, Target};
use crate::math::{Aabb, Overlap, affine};
use crate::model::deform::Points;
use crate::model::{Classifier, ColorSample, Leaf, MaskLeaf, Source, Step, Tree, VolumeLeaf};
use crate::volume::Sample;

/// The grid's points `(x, y, z)`, `(x + 1, y, z)`, … as many as `len`.
#[derive(Clone, Copy, PartialEq)]
struct Voxels {
    x: f64,
    y: f64,
    z: f64,
    len: usize,
}

impl Voxels {
    fn new(DVec3 { x, y, z }: DVec3, len: usize) -> Self {
        Self { x, y, z, len }
    }

    /// Those of `part`.
    fn part(&self, part: &Range<usize>) -> Self {
        Self {
            x: self.x + part.start as f64,
            len: part.len(),
            ..*self
        }
    }

    /// Where each is in the leaf's own frame.
    fn in_leaf(&self, leaf: &Leaf) -> impl Fn(usize) -> DVec3 {
        let (map, x) = (leaf.local_from_frame, self.x);
        let row = affine::row(&map, self.y, self.z);
        move |n| affine::step(&map, row, x + n as f64)
    }

    /// Those in the leaf's box. Along a row each coordinate is monotone, rounding included, so they are one interval: all if
    /// both ends are, and none if both ends lie beyond one face.
    fn inside(&self, leaf: &Leaf) -> Range<usize> {
        let local = self.in_leaf(leaf);
        let ends = [local(0), local(self.len.saturating_sub(1))];
        let bounds = &leaf.local_bounds;
        if ends.iter().all(|&p| bounds.contains(p)) {
            return 0..self.len;
        }
        if Aabb::of_points(ends).overlap(bounds) == Overlap::Outside {
            return 0..0;
        }
        let inside = |n: &usize| bounds.contains(local(*n));
        let first = (0..self.len).find(inside).unwrap_or(self.len);
        let beyond = (first..self.len).rev().find(inside).map_or(first, |last| last + 1);
        first..beyond
    }

    /// Their values in a volume that holds them all.
    fn sample(&self, leaf: &Leaf, volume: &VolumeLeaf, values: &mut [f32]) {
        let map = &leaf.local_from_frame;
        let row = affine::row(map, self.y, self.z);
        volume.bricks.sample_row(map, row, self.x, values);
    }
}

/// Where the points of a row of voxels are below one deformation.
#[derive(Default)]
struct WarpedRow {
    points: Points,
    /// The row that they are of.
    of: Option<Voxels>,
}

/// A row of samples, as separate values and coverages.
#[derive(Default)]
struct Row {
    value: Vec<f32>,
    coverage: Vec<f32>,
    /// Of colours, whose value is their opacity; empty of values.
    rgb: Vec<[f32; 3]>,
}

/// Runs paths over rows of voxels; keeps its rows between calls.
pub struct RowEvaluator<'a> {
    tree: &'a Tree,
    lattice: &'a Lattice,
    rows: Vec<Row>,
    depth: usize,
    kept: Vec<Row>,
    /// The path that was run last, and how.
    path: Vec<Step>,
    program: Vec<Instruction>,
    warped: Vec<WarpedRow>,
}

impl<'a> RowEvaluator<'a> {
    /// An evaluator of paths of `target`.
    pub fn new(target: &'a Target) -> Self {
        let tree = &target.tree;
        Self {
            tree,
            lattice: &target.lattice,
            rows: Vec::new(),
            depth: 0,
            kept: Vec::new(),
            path: Vec::new(),
            program: Vec::new(),
            warped: (0..tree.warp_count()).map(|_| WarpedRow::default()).collect(),
        }
    }

    /// Brings near what `path` reads of its volumes in a box of the lattice.
    pub fn fetch(&self, path: &[Step], bounds: &Aabb) {
        let bounds = self.lattice.grid_box(bounds);
        for step in path {
            let (Step::LeafInside(index) | Step::Leaf(index)) = step else {
                continue;
            };
            let leaf = self.tree.leaf(*index);
            match &leaf.source {
                Source::Volume(VolumeLeaf { bricks, .. }) | Source::Mask(MaskLeaf { bricks, .. }) => {
                    let region = self.tree.region_in(leaf.space, &bounds);
                    bricks.fetch(&region.hull.transformed(&leaf.local_from_frame));
                }
                Source::Primitive(_) => {}
            }
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
        let start = DVec3::new(columns.start as f64, j as f64, k as f64);
        let voxels = Voxels::new(self.lattice.grid_point(start), columns.len());
        if let Some((leaf, volume, inside)) = self.lone_volume(path, &voxels) {
            fill_outside(premultiplied, &inside);
            voxels
                .part(&inside)
                .sample(leaf, volume, &mut premultiplied[inside.clone()]);
            if let Some(coverage) = coverage {
                fill_outside(coverage, &inside);
                coverage[inside].fill(1.0);
            }
            return;
        }
        let row = self.run(path, &voxels);
        for (out, (v, c)) in premultiplied.iter_mut().zip(row.value.iter().zip(&row.coverage)) {
            *out = v * c;
        }
        if let Some(coverage) = coverage {
            coverage.copy_from_slice(&row.coverage);
        }
    }

    /// The row that a path leaves. Apart, so that the short rows of a lone volume do not pay for what a path may need.
    #[inline(never)]
    fn run(&mut self, path: &[Step], voxels: &Voxels) -> &Row {
        self.depth = 0;
        if self.path != path {
            self.path = path.to_vec();
            self.program = program(path);
        }
        for n in 0..self.program.len() {
            match self.program[n] {
                Instruction::Step(step) => self.apply(step, voxels),
                Instruction::Keep(slot) => self.keep(slot as usize),
                Instruction::Again(slot) => self.again(slot as usize, voxels.len),
            }
        }
        if self.depth == 0 {
            self.push(voxels.len);
        }
        &self.rows[0]
    }

    /// Colours times coverage at the voxels evaluated last.
    pub fn premultiplied_rgb(&self, out: &mut [[f32; 3]]) {
        let colored = self.rows.first().filter(|row| row.rgb.len() == out.len());
        let Some(row) = colored else {
            out.fill([0.0; 3]);
            return;
        };
        for (n, out) in out.iter_mut().enumerate() {
            *out = row.color(n).premultiplied_rgb();
        }
    }

    /// The volume that a path consists of, if that is all of it and no value of it is kept out, and the voxels that it
    /// covers: most blocks of most scenes.
    fn lone_volume(&self, path: &[Step], voxels: &Voxels) -> Option<(&'a Leaf, &'a VolumeLeaf, Range<usize>)> {
        let &[Step::LeafInside(index) | Step::Leaf(index)] = path else {
            return None;
        };
        let leaf = self.tree.leaf(index);
        let Source::Volume(volume) = &leaf.source else {
            return None;
        };
        if leaf.space.is_some() {
            return None;
        }
        let inside = match path {
            [Step::Leaf(_)] => voxels.inside(leaf),
            _ => 0..voxels.len,
        };
        volume.admits_all().then_some((leaf, volume, inside))
    }

    /// A new top row of `len` empty samples.
    fn push(&mut self, len: usize) -> &mut Row {
        if self.depth == self.rows.len() {
            self.rows.push(Row::default());
        }
        let row = &mut self.rows[self.depth];
        self.depth += 1;
        row.rgb.clear();
        for part in [&mut row.value, &mut row.coverage] {
            part.clear();
            part.resize(len, 0.0);
        }
        row
    }

    fn top(&mut self) -> &mut Row {
        &mut self.rows[self.depth - 1]
    }

    /// Keeps a copy of the top row.
    fn keep(&mut self, slot: usize) {
        if self.kept.len() <= slot {
            self.kept.resize_with(slot + 1, Row::default);
        }
        let top = &self.rows[self.depth - 1];
        self.kept[slot].value.clone_from(&top.value);
        self.kept[slot].coverage.clone_from(&top.coverage);
        self.kept[slot].rgb.clone_from(&top.rgb);
    }

    /// Pushes a row that was kept.
    fn again(&mut self, slot: usize, len: usize) {
        let kept = std::mem::take(&mut self.kept[slot]);
        let top = self.push(len);
        top.value.copy_from_slice(&kept.value);
        top.coverage.copy_from_slice(&kept.coverage);
        top.rgb.clone_from(&kept.rgb);
        self.kept[slot] = kept;
    }

    /// Pushes a row of a leaf, which may be known to hold it.
    fn leaf(&mut self, leaf: &Leaf, voxels: &Voxels, holds: bool) {
        let Some(warp) = leaf.space else {
            let row = self.push(voxels.len);
            return match holds {
                true => row.fill_inside(leaf, voxels),
                false => row.fill(leaf, voxels, voxels.inside(leaf)),
            };
        };
        self.push(voxels.len);
        self.warp(warp, voxels);
        let (row, points) = (&mut self.rows[self.depth - 1], &self.warped[warp as usize].points);
        match holds {
            true => row.fill_inside_at(leaf, points),
            false => row.fill_at(leaf, points),
        }
    }

    /// Finds where the row is below deformation `warp`, unless that is known.
    fn warp(&mut self, warp: u32, voxels: &Voxels) {
        if self.warped[warp as usize].of == Some(*voxels) {
            return;
        }
        let (outer, table) = (self.tree.space_around(warp), self.tree.table(warp));
        let mut row = std::mem::take(&mut self.warped[warp as usize]);
        row.points.resize(voxels.len);
        match outer {
            None => table.row(DVec3::new(voxels.x, voxels.y, voxels.z), &mut row.points),
            Some(outer) => {
                self.warp(outer, voxels);
                let before = &self.warped[outer as usize].points;
                (0..voxels.len).for_each(|n| row.points.set(n, table.point(before.get(n))));
            }
        }
        row.of = Some(*voxels);
        self.warped[warp as usize] = row;
    }

    fn apply(&mut self, step: Step, voxels: &Voxels) {
        let tree = self.tree;
        match step {
            Step::LeafInside(i) => self.leaf(tree.leaf(i), voxels, true),
            Step::Leaf(i) => self.leaf(tree.leaf(i), voxels, false),
            Step::Map(i) => {
                let map = tree.map(i);
                self.top().update(|_, s| map.sample(s));
            }
            Step::Classify(i) => self.top().classify(tree.classifier(i)),
            Step::Cut(i) => {
                let cut = tree.cut(i);
                let away = |p: DVec3| cut.distance(p) > 0.0;
                match tree.cut_space(i) {
                    None => self
                        .top()
                        .cut_away(|n| away(DVec3::new(voxels.x + n as f64, voxels.y, voxels.z))),
                    Some(warp) => {
                        self.warp(warp, voxels);
                        let points = &self.warped[warp as usize].points;
                        self.rows[self.depth - 1].cut_away(|n| away(points.get(n)));
                    }
                }
            }
            Step::Combine(i) => {
                let operator = tree.operator(i);
                self.depth -= 1;
                let (below, above) = self.rows.split_at_mut(self.depth);
                let (first, second) = (&mut below[self.depth - 1], &above[0]);
                first.update(|n, s| operator.apply(s, second.sample(n)));
            }
            Step::Blend(i) => {
                let operator = tree.operator(i);
                self.depth -= 1;
                let (below, above) = self.rows.split_at_mut(self.depth);
                let (first, second) = (&mut below[self.depth - 1], &above[0]);
                first.update_colors(|n, c| operator.blend(&c, &second.color(n)));
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

    /// The colour at a voxel; black where the row holds values.
    fn color(&self, n: usize) -> ColorSample {
        ColorSample {
            sample: self.sample(n),
            rgb: self.rgb.get(n).copied().unwrap_or_default(),
        }
    }

    /// Makes what is `away` nothing.
    fn cut_away(&mut self, away: impl Fn(usize) -> bool) {
        self.update(|n, s| if away(n) { Sample::EMPTY } else { s });
        let colors = self.rgb.iter_mut().enumerate();
        colors.filter(|(n, _)| away(*n)).for_each(|(_, rgb)| *rgb = [0.0; 3]);
    }

    fn classify(&mut self, classifier: &Classifier) {
        self.rgb.resize(self.value.len(), [0.0; 3]);
        self.update_colors(|_, c| classifier.apply(c.sample));
    }

    fn update_colors(&mut self, f: impl Fn(usize, ColorSample) -> ColorSample) {
        for n in 0..self.value.len() {
            let c = f(n, self.color(n));
            (self.value[n], self.coverage[n], self.rgb[n]) = (c.sample.value, c.sample.coverage, c.rgb);
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
    fn fill_inside(&mut self, leaf: &Leaf, voxels: &Voxels) {
        match &leaf.source {
            Source::Volume(_) | Source::Mask(_) => self.fill(leaf, voxels, 0..voxels.len),
            Source::Primitive(placed) => {
                self.value.fill(placed.value());
                self.coverage.fill(1.0);
            }
        }
    }

    /// [`Self::fill_inside`] with voxels at `points` of the leaf's space.
    fn fill_inside_at(&mut self, leaf: &Leaf, points: &Points) {
        match &leaf.source {
            Source::Volume(volume) => self.fill_from(leaf, volume, points),
            Source::Mask(_) => {
                let local = |n: usize| affine::point(&leaf.local_from_frame, points.get(n));
                self.update(|n, _| leaf.sample_inside(local(n)));
            }
            Source::Primitive(placed) => {
                self.value.fill(placed.value());
                self.coverage.fill(1.0);
            }
        }
    }

    /// Fills the row from a volume, at points of it.
    fn fill_from(&mut self, leaf: &Leaf, volume: &VolumeLeaf, points: &Points) {
        volume
            .bricks
            .sample_points(&leaf.local_from_frame, points.columns(), &mut self.value);
        self.coverage.fill(1.0);
        if !volume.admits_all() {
            self.update(|_, s| volume.admit(s.value));
        }
    }

    /// Fills the row from a leaf whose box some of `points` may lie beyond.
    fn fill_at(&mut self, leaf: &Leaf, points: &Points) {
        let local = |n: usize| affine::point(&leaf.local_from_frame, points.get(n));
        let is_inside = |p: DVec3| leaf.local_bounds.contains(p);
        match &leaf.source {
            Source::Volume(volume) => {
                self.fill_from(leaf, volume, points);
                self.update(|n, s| if is_inside(local(n)) { s } else { Sample::EMPTY });
            }
            Source::Mask(_) | Source::Primitive(_) => self.update(|n, _| match local(n) {
                p if is_inside(p) => leaf.sample_inside(p),
                _ => Sample::EMPTY,
            }),
        }
    }

    /// Fills a part of the row that lies in the leaf's box.
    fn fill(&mut self, leaf: &Leaf, voxels: &Voxels, part: Range<usize>) {
        let voxels = voxels.part(&part);
        let (values, coverages) = (&mut self.value[part.clone()], &mut self.coverage[part]);
        match &leaf.source {
            Source::Volume(volume) => {
                voxels.sample(leaf, volume, values);
                coverages.fill(1.0);
                if volume.admits_all() {
                    return;
                }
                for (v, c) in values.iter_mut().zip(coverages) {
                    let s = volume.admit(*v);
                    (*v, *c) = (s.value, s.coverage);
                }
            }
            Source::Mask(_) | Source::Primitive(_) => {
                let local = voxels.in_leaf(leaf);
                for (n, (v, c)) in values.iter_mut().zip(coverages).enumerate() {
                    let s = leaf.sample_inside(local(n));
                    (*v, *c) = (s.value, s.coverage);
                }
            }
        }
    }
}

/// Fills what is outside a part of a row with nothing.
fn fill_outside(row: &mut [f32], part: &Range<usize>) {
    row[..part.start].fill(0.0);
    row[part.end..].fill(0.0);
}
