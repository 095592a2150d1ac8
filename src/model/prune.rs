//! A block's optimal computational path: the part of the tree that reaches it (VCSG §3.1).
//!
//! *Theory.* A block entirely within a node's box needs no test of that box any more; one entirely outside skips the node's
//! subtree; one that is partly inside must be split, and its parts go on from what is already known.
//! *Changes from the paper.* The block is tested at the leaves, by their own shape, and at the cuts; what becomes of inner nodes
//! follows from their operands, so no node's box is tested that is only the hull of others. Nodes that cannot matter for
//! another reason go too: a full operand hides what is united behind it, subtracting it leaves nothing, a value window may
//! admit nothing. Ranges of value and coverage are computed on the way. Every rule keeps the samples' bits (design law 1).
//! *Practice.* The path is pruned from the parent block's path, never from the whole tree again.

use glam::DVec3;

use super::deform::Region;
use super::tree::Leaf;
use super::{BooleanOp, Operator, Source, Space, Step, Tree, ValueRule};
use crate::math::{Aabb, Interval, Overlap, affine};
use crate::volume::SampleRange;

/// What happens to a leaf or cut whose boundary crosses a block that is not split further (VCSG §3.1, criterion 4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Boundary {
    /// It stays in the path and every voxel is tested.
    #[default]
    Exact,
    /// The block's centre decides for the whole block, as in the paper.
    Centre,
}

/// What is left of a path in a block.
#[derive(Clone, Debug, PartialEq)]
pub struct Pruned {
    /// The steps that matter; none when nothing is there.
    pub steps: Vec<Step>,
    /// What samples in the block can be.
    pub range: SampleRange,
    /// Whether splitting the block may prune more: a boundary crosses it, or its coverage is not known.
    pub undecided: bool,
}

impl Tree {
    /// The part of `path` that matters in `block`, a box of this tree's frame. The point `decider`, if there is one, assigns
    /// what crosses the block (see [`Boundary::Centre`]).
    pub fn prune(&self, path: &[Step], block: &Aabb, decider: Option<DVec3>) -> Pruned {
        let mut pruner = Pruner {
            tree: self,
            block,
            decider,
            regions: vec![None; self.warp_count()],
            steps: Vec::with_capacity(path.len()),
            operands: Vec::new(),
        };
        for &step in path {
            pruner.visit(step);
        }
        pruner.finish()
    }
}

/// An operand on the stack: where its steps begin, and its range. An empty operand has no steps.
#[derive(Clone, Copy)]
struct Operand {
    start: usize,
    range: SampleRange,
}

impl Operand {
    fn is_empty(&self) -> bool {
        self.range.coverage.hi <= 0.0
    }

    fn is_full(&self) -> bool {
        self.range.coverage.lo >= 1.0
    }
}

struct Pruner<'a> {
    tree: &'a Tree,
    block: &'a Aabb,
    decider: Option<DVec3>,
    /// Where the block is below each deformation, as far as it was asked.
    regions: Vec<Option<Region>>,
    steps: Vec<Step>,
    operands: Vec<Operand>,
}

impl Pruner<'_> {
    fn visit(&mut self, step: Step) {
        match step {
            Step::Leaf(i) => {
                let overlap = self.leaf_overlap(i);
                self.leaf(i, overlap);
            }
            Step::LeafInside(i) => self.leaf(i, Overlap::Inside),
            Step::Map(i) => self.map(i),
            Step::Cut(i) => self.cut(i),
            Step::Classify(i) => self.classify(i),
            Step::Combine(i) | Step::Blend(i) => self.combine(i, step),
        }
    }

    fn finish(mut self) -> Pruned {
        let range = self.operands.pop().map_or(SampleRange::EMPTY, |o| o.range);
        // What was dropped stays dropped however the block is split, so only boundaries that are left count.
        let crosses = |step: &Step| matches!(step, Step::Leaf(_) | Step::Cut(_));
        let crossed = self.steps.iter().any(crosses);
        Pruned {
            undecided: crossed || (!self.steps.is_empty() && !range.coverage.is_point()),
            steps: self.steps,
            range,
        }
    }

    fn push(&mut self, range: SampleRange, step: Step) {
        let start = self.steps.len();
        self.operands.push(Operand { start, range });
        if range.coverage.hi > 0.0 {
            self.steps.push(step);
        }
    }

    /// Replaces the operand on top by nothing.
    fn clear_top(&mut self) {
        if let Some(top) = self.operands.last_mut() {
            top.range = SampleRange::EMPTY;
            self.steps.truncate(top.start);
        }
    }

    /// Where the block is in `space`.
    fn region(&mut self, space: Space) -> Region {
        let find = || self.tree.region_in(space, self.block);
        match space {
            None => find(),
            Some(warp) => {
                let region = self.regions[warp as usize].unwrap_or_else(find);
                self.regions[warp as usize] = Some(region);
                region
            }
        }
    }

    fn leaf(&mut self, index: u32, overlap: Overlap) {
        let step = match overlap {
            Overlap::Inside => Step::LeafInside(index),
            Overlap::Partial => Step::Leaf(index),
            Overlap::Outside => return self.push(SampleRange::EMPTY, Step::Leaf(index)),
        };
        let leaf = self.tree.leaf(index);
        let block = self.region(leaf.space).hull;
        let mut range = leaf.range(&block.transformed(&leaf.local_from_frame));
        match (overlap, &leaf.source) {
            (Overlap::Partial, _) => range.coverage.lo = 0.0,
            (_, Source::Primitive(_)) => range.coverage = Interval::point(1.0),
            (_, Source::Volume(_) | Source::Mask(_)) => {}
        }
        self.push(range, step);
    }

    fn leaf_overlap(&mut self, index: u32) -> Overlap {
        let leaf = self.tree.leaf(index);
        let region = self.region(leaf.space);
        let overlap = match leaf.overlap(&region.hull) {
            Overlap::Inside if region.beyond => Overlap::Partial,
            overlap => overlap,
        };
        match (overlap, self.decider) {
            // Where nothing is deformed to, nothing can be filled.
            (Overlap::Partial, Some(point)) if !region.beyond => leaf.side_of(self.tree.in_space(leaf.space, point)),
            (overlap, _) => overlap,
        }
    }

    fn map(&mut self, index: u32) {
        let top = self.operands.last_mut().expect("a map has an operand");
        if !top.is_empty() {
            top.range.value = self.tree.map(index).range(top.range.value);
            self.steps.push(Step::Map(index));
        }
    }

    fn classify(&mut self, index: u32) {
        let top = self.operands.last_mut().expect("a classifier has an operand");
        if !top.is_empty() {
            top.range.value = self.tree.classifier(index).range(top.range.value);
            self.steps.push(Step::Classify(index));
        }
    }

    fn cut(&mut self, index: u32) {
        let top = self.operands.last().expect("a cut has an operand");
        if top.is_empty() {
            return;
        }
        match self.cut_overlap(index) {
            Overlap::Inside => {}
            Overlap::Outside => self.clear_top(),
            Overlap::Partial => {
                self.steps.push(Step::Cut(index));
                if let Some(top) = self.operands.last_mut() {
                    top.range.coverage.lo = 0.0;
                }
            }
        }
    }

    fn cut_overlap(&mut self, index: u32) -> Overlap {
        let (cut, space) = (self.tree.cut(index), self.tree.cut_space(index));
        let region = self.region(space);
        if region.hull.is_empty() {
            return Overlap::Outside;
        }
        let distances = region.hull.corners().map(|c| cut.distance(c));
        let is_kept = |point| cut.distance(self.tree.in_space(space, point)) <= 0.0;
        match (side(&distances), self.decider) {
            (Overlap::Partial, Some(point)) if is_kept(point) => Overlap::Inside,
            (Overlap::Partial, Some(_)) => Overlap::Outside,
            (overlap, _) => overlap,
        }
    }

    fn combine(&mut self, index: u32, step: Step) {
        let operator = self.tree.operator(index);
        let second = self.operands.pop().expect("an operator has two operands");
        let first = self.operands.pop().expect("an operator has two operands");
        self.operands.push(first);
        match kept(operator, &first, &second) {
            Kept::Neither => self.clear_top(),
            Kept::First => self.steps.truncate(second.start),
            Kept::Second => {
                self.steps.drain(first.start..second.start);
                self.replace_top(second.range);
            }
            Kept::Both => {
                self.replace_top(operator.range(&first.range, &second.range));
                self.steps.push(step);
            }
        }
    }

    fn replace_top(&mut self, range: SampleRange) {
        if let Some(top) = self.operands.last_mut() {
            top.range = range;
        }
    }
}

/// Which operands of a combination can show in a block.
enum Kept {
    Neither,
    First,
    Second,
    Both,
}

fn kept(operator: &Operator, first: &Operand, second: &Operand) -> Kept {
    let takes_first = operator.rule == ValueRule::First;
    let takes_second = operator.rule == ValueRule::Second;
    match operator.op {
        BooleanOp::Union => {
            if first.is_empty() || (takes_second && second.is_full()) {
                Kept::Second
            } else if second.is_empty() || (takes_first && first.is_full()) {
                Kept::First
            } else {
                Kept::Both
            }
        }
        BooleanOp::Intersection => {
            if first.is_empty() || second.is_empty() {
                Kept::Neither
            } else if takes_first && second.is_full() {
                Kept::First
            } else if takes_second && first.is_full() {
                Kept::Second
            } else {
                Kept::Both
            }
        }
        BooleanOp::Subtraction => {
            if first.is_empty() || second.is_full() {
                Kept::Neither
            } else if second.is_empty() {
                Kept::First
            } else {
                Kept::Both
            }
        }
        BooleanOp::SubtractionWithRule => {
            if first.is_empty() {
                Kept::Neither
            } else if second.is_empty() || takes_first {
                Kept::First
            } else {
                Kept::Both
            }
        }
    }
}

/// Where a box lies of a plane, from its corners' signed distances. Points of the box round differently from its corners, so
/// a corner within rounding of the plane counts as crossing.
fn side(distances: &[f64; 8]) -> Overlap {
    let largest = distances.iter().fold(0.0f64, |m, d| m.max(d.abs()));
    let margin = ROUNDING * (1.0 + largest);
    if distances.iter().all(|&d| d <= -margin) {
        Overlap::Inside
    } else if distances.iter().all(|&d| d > margin) {
        Overlap::Outside
    } else {
        Overlap::Partial
    }
}

/// Mapped points err by a few ulps of their coordinates; coordinates up to 1e6 then err by less than this times themselves.
const ROUNDING: f64 = 1e-12;

impl Leaf {
    /// Where a box of the tree's frame lies with respect to this leaf (VCSG §3.1: the block is moved into the leaf's frame).
    /// Exact for the box's corners, and on the safe side of rounding.
    fn overlap(&self, block: &Aabb) -> Overlap {
        if self.frame_bounds.intersect(block).is_empty() {
            return Overlap::Outside;
        }
        let hull = block.transformed(&self.local_from_frame);
        let scale = hull.min.abs().max(hull.max.abs()).max_element();
        let margin = DVec3::splat(ROUNDING * (1.0 + scale));
        let hull = hull.expand(margin);
        match &self.source {
            Source::Volume(_) | Source::Mask(_) => hull.overlap(&self.local_bounds),
            Source::Primitive(placed) => placed.overlap(&hull, margin.x),
        }
    }

    /// On which side of the leaf's boundary a point of the tree's frame lies, as the tree tells it.
    fn side_of(&self, point: DVec3) -> Overlap {
        let local = affine::point(&self.local_from_frame, point);
        if !self.local_bounds.contains(local) {
            return Overlap::Outside;
        }
        match &self.source {
            Source::Volume(_) | Source::Mask(_) => Overlap::Inside,
            // Within a soft surface a block is neither, however small it is.
            Source::Primitive(placed) => match placed.coverage(local) {
                0.0 => Overlap::Outside,
                1.0 => Overlap::Inside,
                _ => Overlap::Partial,
            },
        }
    }

    /// What the leaf can be at points of `local`, a box of its own frame, that lie inside it.
    fn range(&self, local: &Aabb) -> SampleRange {
        match &self.source {
            Source::Volume(leaf) => {
                let value = leaf.bricks.range_index(&local.intersect(&self.local_bounds));
                let admitted = value.intersect(leaf.window);
                if admitted.is_empty() {
                    return SampleRange::EMPTY;
                }
                let all = leaf.window.encloses(value) && !leaf.bricks.has_missing();
                SampleRange {
                    value: admitted,
                    coverage: Interval::new(if all { 1.0 } else { 0.0 }, 1.0),
                }
            }
            Source::Mask(mask) => mask.range(local),
            Source::Primitive(placed) => SampleRange {
                value: Interval::point(placed.value()),
                coverage: placed.coverage_range(local),
            },
        }
    }
}
