//! What an edit changes: which parts of a tree are still there, and where samples may differ.
//!
//! *Theory.* A subtree is nothing outside the boxes of its leaves. So where two trees differ by a subtree, they are the same
//! outside the boxes of its leaves in both; and a union with, or a subtraction of, what is nowhere leaves an operand as it is.
//! Below a deformation a leaf may be anywhere in the deformed box; where the deformation differs, all leaves below it do.
//! *Changes from the paper.* VCSG builds a target for one tree. Here trees are compared by what they are made of, whatever was
//! done to get from one to the other; so undoing an edit is an edit.
//! *Practice.* Steps in post-order say what the tree is, so subtrees are compared as stretches of steps. Stretches before the
//! first difference and after the last are known to be the same without looking.

use super::{BooleanOp, Step, Tree};
use crate::math::Aabb;

/// What became of one tree's parts in another, flattened in the same frame.
#[derive(Clone, Debug)]
pub struct Changes {
    leaves: Vec<Option<u32>>,
    maps: Vec<Option<u32>>,
    cuts: Vec<Option<u32>>,
    operators: Vec<Option<u32>>,
    classifiers: Vec<Option<u32>>,
    /// Boxes of the frame outside which both trees give the same samples, by the same steps.
    pub boxes: Vec<Aabb>,
}

impl Changes {
    /// The changes from `old` to `new`.
    pub fn between(old: &Tree, new: &Tree) -> Self {
        let [leaves, maps, cuts, operators, classifiers] = old.parts_in(new);
        let mut changes = Self {
            leaves,
            maps,
            cuts,
            operators,
            classifiers,
            boxes: Vec::new(),
        };
        let steps = old.steps().iter().map(|&step| changes.step(step)).collect();
        let sides = [
            Side::new(old, steps),
            Side::new(new, new.steps().iter().copied().map(Some).collect()),
        ];
        changes.boxes = Comparison::new(sides).boxes();
        changes
    }

    /// A step of the old tree as one of the new; `None` if its part is gone.
    pub fn step(&self, step: Step) -> Option<Step> {
        Some(match step {
            Step::Leaf(i) => Step::Leaf(self.leaves[i as usize]?),
            Step::LeafInside(i) => Step::LeafInside(self.leaves[i as usize]?),
            Step::Map(i) => Step::Map(self.maps[i as usize]?),
            Step::Cut(i) => Step::Cut(self.cuts[i as usize]?),
            Step::Classify(i) => Step::Classify(self.classifiers[i as usize]?),
            Step::Combine(i) => Step::Combine(self.operators[i as usize]?),
            Step::Blend(i) => Step::Blend(self.operators[i as usize]?),
        })
    }

    /// A path of the old tree as one of the new; `None` if a part of it is gone.
    pub fn path(&self, path: &[Step]) -> Option<Vec<Step>> {
        path.iter().map(|&step| self.step(step)).collect()
    }
}

/// A tree whose steps are said in terms of the new one; a step that the new one lacks is `None`.
struct Side<'a> {
    tree: &'a Tree,
    steps: Vec<Option<Step>>,
    /// Where the subtree that ends with each step begins.
    starts: Vec<usize>,
}

impl<'a> Side<'a> {
    fn new(tree: &'a Tree, steps: Vec<Option<Step>>) -> Self {
        let mut starts = Vec::with_capacity(steps.len());
        for (at, step) in tree.steps().iter().enumerate() {
            let start = match step {
                Step::Leaf(_) | Step::LeafInside(_) => at,
                Step::Map(_) | Step::Cut(_) | Step::Classify(_) => starts[at - 1],
                Step::Combine(_) | Step::Blend(_) => starts[starts[at - 1] - 1],
            };
            starts.push(start);
        }
        Self { tree, steps, starts }
    }

    /// The last steps of the operands of the subtree that ends at `root`.
    fn operands(&self, root: usize) -> Vec<usize> {
        match self.tree.steps()[root] {
            Step::Leaf(_) | Step::LeafInside(_) => vec![],
            Step::Map(_) | Step::Cut(_) | Step::Classify(_) => vec![root - 1],
            Step::Combine(_) | Step::Blend(_) => vec![self.starts[root - 1] - 1, root - 1],
        }
    }

    /// What the subtree at `root` adds to, or takes from, the operand that `is_same`, if it is such a combination.
    fn beside(&self, root: usize, is_same: impl Fn(usize) -> bool) -> Option<usize> {
        let (Step::Combine(index) | Step::Blend(index)) = self.tree.steps()[root] else {
            return None;
        };
        let op = self.tree.operator(index).op;
        let (first, second) = (self.starts[root - 1] - 1, root - 1);
        if op != BooleanOp::Intersection && is_same(first) {
            Some(second)
        } else if op == BooleanOp::Union && is_same(second) {
            Some(first)
        } else {
            None
        }
    }

    /// The steps of the subtree at `root`.
    fn stretch(&self, root: usize) -> &[Option<Step>] {
        &self.steps[self.starts[root]..=root]
    }

    /// The boxes of the leaves of the subtree at `root`.
    fn leaf_boxes(&self, root: usize) -> impl Iterator<Item = Aabb> {
        let steps = &self.tree.steps()[self.starts[root]..=root];
        steps.iter().filter_map(|step| match step {
            Step::Leaf(i) | Step::LeafInside(i) => Some(self.tree.reach_of_leaf(*i)),
            _ => None,
        })
    }
}

/// Finds where two trees differ, from their roots down.
struct Comparison<'a> {
    old: Side<'a>,
    new: Side<'a>,
    /// Steps that both begin with.
    prefix: usize,
    /// Steps that both end with.
    suffix: usize,
}

impl<'a> Comparison<'a> {
    fn new([old, new]: [Side<'a>; 2]) -> Self {
        let equal = |(a, b): &(&Option<Step>, &Option<Step>)| a == b;
        let prefix = old.steps.iter().zip(&new.steps).take_while(equal).count();
        let suffix = old
            .steps
            .iter()
            .rev()
            .zip(new.steps.iter().rev())
            .take_while(equal)
            .count();
        Self {
            old,
            new,
            prefix,
            suffix,
        }
    }

    fn boxes(&self) -> Vec<Aabb> {
        let roots = [&self.old, &self.new].map(|side| side.steps.len().checked_sub(1));
        let mut boxes = Vec::new();
        let mut pending = Vec::new();
        match roots {
            [Some(old), Some(new)] => pending.push((old, new)),
            [old, new] => {
                boxes.extend(old.into_iter().flat_map(|root| self.old.leaf_boxes(root)));
                boxes.extend(new.into_iter().flat_map(|root| self.new.leaf_boxes(root)));
            }
        }
        while let Some((old, new)) = pending.pop() {
            self.compare(old, new, &mut pending, &mut boxes);
        }
        boxes.retain(|b| !b.is_empty());
        boxes
    }

    /// Compares two subtrees; what is to be compared of them goes to `pending`.
    fn compare(&self, old: usize, new: usize, pending: &mut Vec<(usize, usize)>, boxes: &mut Vec<Aabb>) {
        if self.known_same(old, new) {
            return;
        }
        if let Some(added) = self.new.beside(new, |operand| self.same(old, operand)) {
            boxes.extend(self.new.leaf_boxes(added));
        } else if let Some(removed) = self.old.beside(old, |operand| self.same(operand, new)) {
            boxes.extend(self.old.leaf_boxes(removed));
        } else if self.old.steps[old] == self.new.steps[new] {
            pending.extend(self.old.operands(old).into_iter().zip(self.new.operands(new)));
        } else {
            boxes.extend(self.old.leaf_boxes(old));
            boxes.extend(self.new.leaf_boxes(new));
        }
    }

    /// Whether two subtrees are the same. In a chain that has grown by a link, stretches of one length differ near their ends.
    fn same(&self, old: usize, new: usize) -> bool {
        let [before, after] = [self.old.stretch(old), self.new.stretch(new)];
        self.known_same(old, new) || (before.len() == after.len() && before.iter().rev().eq(after.iter().rev()))
    }

    /// Whether two subtrees lie in what both trees begin or end with.
    fn known_same(&self, old: usize, new: usize) -> bool {
        let from_end = |side: &Side, at: usize| side.steps.len() - at;
        let before_change = old == new && old < self.prefix;
        let behind_change = from_end(&self.old, old) == from_end(&self.new, new)
            && from_end(&self.old, self.old.starts[old]) <= self.suffix;
        before_change || behind_change
    }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DVec3};

    use super::*;
    use crate::model::{Family, Model, Node, ValueRule};
    use crate::voxelize::{Primitive, Solid};

    /// The union of balls at these places along x.
    fn balls(places: &[f64]) -> Tree {
        let mut model = Model::default();
        let ball = |&x: &f64| {
            let center = DVec3::X * x;
            model.push(Node::Primitive(Primitive::crisp(
                Solid::Sphere { center, radius: 1.0 },
                5.0,
            )))
        };
        let ids: Vec<_> = places.iter().map(ball).collect();
        model.fold(BooleanOp::Union, ValueRule::First, Family::MinMax, ids);
        Tree::new(&model, &DAffine3::IDENTITY).expect("a small tree")
    }

    /// The places of the balls whose boxes have changed, rounded.
    fn changed(old: &[f64], new: &[f64]) -> Vec<i32> {
        let boxes = Changes::between(&balls(old), &balls(new)).boxes;
        let mut places: Vec<i32> = boxes.iter().map(|b| b.center().x.round() as i32).collect();
        places.sort_unstable();
        places.dedup();
        places
    }

    #[test]
    fn a_tree_has_not_changed_from_itself() {
        assert!(changed(&[0.0, 5.0, 9.0], &[0.0, 5.0, 9.0]).is_empty());
        assert!(changed(&[], &[]).is_empty());
    }

    #[test]
    fn what_moves_changes_where_it_was_and_where_it_is() {
        assert_eq!(changed(&[0.0, 5.0, 9.0], &[0.0, 6.0, 9.0]), [5, 6]);
        assert_eq!(changed(&[0.0], &[3.0]), [0, 3]);
    }

    #[test]
    fn what_comes_or_goes_changes_only_where_it_is() {
        for (with, without, place) in [
            (vec![0.0, 5.0, 9.0, 20.0], vec![0.0, 5.0, 9.0], 20),
            (vec![-20.0, 0.0, 5.0, 9.0], vec![0.0, 5.0, 9.0], -20),
        ] {
            assert_eq!(changed(&without, &with), [place]);
            assert_eq!(changed(&with, &without), [place]);
        }
        assert_eq!(changed(&[], &[4.0]), [4]);
    }

    #[test]
    fn parts_are_found_wherever_they_have_moved_to() {
        let (old, new) = (balls(&[0.0, 5.0]), balls(&[5.0, 7.0]));
        let changes = Changes::between(&old, &new);
        assert_eq!(
            changes.path(&[Step::Leaf(1), Step::LeafInside(1)]),
            Some(vec![Step::Leaf(0), Step::LeafInside(0)])
        );
        assert_eq!(changes.step(Step::Leaf(0)), None);
        assert_eq!(changes.step(Step::Combine(0)), Some(Step::Combine(0)));
    }
}
