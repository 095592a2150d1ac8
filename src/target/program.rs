//! A path as it is run: what it says twice is done once.
//!
//! *Theory.* A subtree that is used twice in one place has the same samples twice (VCSG §2.1 lets a subtree be named).
//! *Changes from the paper.* VCSG evaluates a tree. Here equal parts of a tree are one part ([`Tree`](crate::model::Tree)), so a
//! subtree that is used again, with all transforms above it composed to the same, is the same stretch of steps: it is run once for
//! a row of voxels, and its row is kept.
//! *Practice.* Only whole subtrees are looked for, the largest first. A path without a leaf that is there twice has none.

use std::collections::{HashMap, HashSet};

use crate::model::Step;

/// What is done with the stack of rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Instruction {
    /// A step of the path.
    Step(Step),
    /// Keeps a copy of the row on top as `.0`.
    Keep(u32),
    /// Pushes the row kept as `.0`.
    Again(u32),
}

/// The instructions of `path`.
pub(super) fn program(path: &[Step]) -> Vec<Instruction> {
    if !has_leaf_twice(path) {
        return path.iter().copied().map(Instruction::Step).collect();
    }
    let subtrees = Subtrees::of(path);
    let reused = subtrees.reused();
    let mut slots = HashMap::new();
    let mut program = Vec::with_capacity(path.len());
    subtrees.walk(|visit| match visit {
        Visit::New(root) => {
            program.push(Instruction::Step(path[root]));
            let subtree = subtrees.ids[root];
            if reused.contains(&subtree) {
                let slot = slots.len() as u32;
                slots.insert(subtree, slot);
                program.push(Instruction::Keep(slot));
            }
        }
        Visit::Known(root) => program.push(Instruction::Again(slots[&subtrees.ids[root]])),
    });
    program
}

fn has_leaf_twice(path: &[Step]) -> bool {
    let mut seen = HashSet::new();
    let mut leaves = path
        .iter()
        .filter(|step| matches!(step, Step::Leaf(_) | Step::LeafInside(_)));
    !leaves.all(|leaf| seen.insert(leaf))
}

/// The subtrees of a path, by their last steps.
struct Subtrees<'a> {
    path: &'a [Step],
    /// Where each begins.
    starts: Vec<usize>,
    /// One number for all that are alike.
    ids: Vec<usize>,
}

/// A subtree on the way through a path.
enum Visit {
    /// Its operands have been met, none like it has.
    New(usize),
    /// One like it has been met.
    Known(usize),
}

impl<'a> Subtrees<'a> {
    fn of(path: &'a [Step]) -> Self {
        let mut subtrees = Self {
            path,
            starts: Vec::with_capacity(path.len()),
            ids: Vec::with_capacity(path.len()),
        };
        let mut known: HashMap<(Step, [Option<usize>; 2]), usize> = HashMap::new();
        for (root, &step) in path.iter().enumerate() {
            let operands = subtrees.operands(root);
            let first = operands[0].or(operands[1]);
            subtrees
                .starts
                .push(first.map_or(root, |operand| subtrees.starts[operand]));
            let next = known.len();
            let parts = operands.map(|operand| operand.map(|at| subtrees.ids[at]));
            subtrees.ids.push(*known.entry((step, parts)).or_insert(next));
        }
        subtrees
    }

    /// The last steps of the operands of the subtree at `root`; of one alone, the second.
    fn operands(&self, root: usize) -> [Option<usize>; 2] {
        match self.path[root] {
            Step::Leaf(_) | Step::LeafInside(_) => [None, None],
            Step::Map(_) | Step::Cut(_) | Step::Classify(_) => [None, Some(root - 1)],
            Step::Combine(_) | Step::Blend(_) => [Some(self.starts[root - 1] - 1), Some(root - 1)],
        }
    }

    /// Goes through the path in order, past what has been met before.
    fn walk(&self, mut visit: impl FnMut(Visit)) {
        let mut met = HashSet::new();
        let mut pending: Vec<(usize, bool)> = self
            .path
            .len()
            .checked_sub(1)
            .map(|root| (root, false))
            .into_iter()
            .collect();
        while let Some((root, operands_met)) = pending.pop() {
            if operands_met {
                met.insert(self.ids[root]);
                visit(Visit::New(root));
            } else if met.contains(&self.ids[root]) {
                visit(Visit::Known(root));
            } else {
                pending.push((root, true));
                pending.extend(
                    self.operands(root)
                        .into_iter()
                        .rev()
                        .flatten()
                        .map(|operand| (operand, false)),
                );
            }
        }
    }

    /// The subtrees that are met again.
    fn reused(&self) -> HashSet<usize> {
        let mut reused = HashSet::new();
        self.walk(|visit| {
            if let Visit::Known(root) = visit {
                reused.insert(self.ids[root]);
            }
        });
        reused
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::Instruction::{Again, Keep};
    use super::*;
    use crate::model::Step::{Combine, Cut, Leaf, Map};

    fn steps(steps: &[Step]) -> Vec<Instruction> {
        steps.iter().copied().map(Instruction::Step).collect()
    }

    #[test]
    fn a_path_without_repetition_is_its_steps() {
        let path = [Leaf(0), Leaf(1), Combine(0), Leaf(2), Combine(0)];
        assert_eq!(program(&path), steps(&path));
        assert_eq!(program(&[]), []);
    }

    #[test]
    fn what_is_said_twice_is_done_once() {
        // (a ∪ b) − cut(a ∪ b)
        let path = [
            Leaf(0),
            Leaf(1),
            Combine(0),
            Leaf(0),
            Leaf(1),
            Combine(0),
            Cut(0),
            Combine(1),
        ];
        let mut expected = steps(&path[..3]);
        expected.extend([Keep(0), Again(0)]);
        expected.extend(steps(&[Cut(0), Combine(1)]));
        assert_eq!(program(&path), expected);
    }

    #[test]
    fn parts_of_what_is_done_once_are_not_kept() {
        // a, then (a ∪ b) twice.
        let path = [
            Leaf(0),
            Leaf(0),
            Leaf(1),
            Combine(0),
            Combine(1),
            Leaf(0),
            Leaf(1),
            Combine(0),
            Combine(2),
        ];
        let program = program(&path);
        let kept = program.iter().filter(|i| matches!(i, Keep(_))).count();
        let leaves = program
            .iter()
            .filter(|i| matches!(i, Instruction::Step(Leaf(_))))
            .count();
        assert_eq!((kept, leaves), (2, 2), "{program:?}");
    }

    #[test]
    fn operands_that_change_places_are_not_alike() {
        let path = [Leaf(0), Leaf(1), Combine(0), Leaf(1), Leaf(0), Combine(0), Combine(1)];
        let combines = program(&path)
            .iter()
            .filter(|i| matches!(i, Instruction::Step(Combine(_))))
            .count();
        assert_eq!(combines, 3);
    }

    /// The steps that a program runs, with those of what is kept written out.
    fn written_out(program: &[Instruction]) -> Vec<Step> {
        let mut stack: Vec<Vec<Step>> = Vec::new();
        let mut kept: HashMap<u32, Vec<Step>> = HashMap::new();
        for &instruction in program {
            match instruction {
                Instruction::Step(step) => {
                    let operands = match step {
                        Step::Leaf(_) | Step::LeafInside(_) => 0,
                        Step::Map(_) | Step::Cut(_) | Step::Classify(_) => 1,
                        Step::Combine(_) | Step::Blend(_) => 2,
                    };
                    let mut steps = stack.split_off(stack.len() - operands).concat();
                    steps.push(step);
                    stack.push(steps);
                }
                Keep(slot) => drop(kept.insert(slot, stack.last().cloned().unwrap_or_default())),
                Again(slot) => stack.push(kept[&slot].clone()),
            }
        }
        stack.concat()
    }

    proptest! {
        #[test]
        fn a_program_runs_its_path_and_nothing_twice(choices in prop::collection::vec(0u32..6, 1..60)) {
            let (mut path, mut depth) = (vec![Leaf(0)], 1);
            for choice in choices {
                let step = match choice {
                    0 | 1 => Leaf(choice),
                    2 => Map(0),
                    _ if depth < 2 => Leaf(2),
                    _ => Combine(choice % 2),
                };
                depth = match step { Leaf(_) => depth + 1, Combine(_) => depth - 1, _ => depth };
                path.push(step);
            }
            path.extend((1..depth).map(|_| Combine(0)));
            let program = program(&path);
            prop_assert_eq!(written_out(&program), path);
            let leaves: Vec<_> = program.iter().filter(|i| matches!(i, Instruction::Step(Leaf(_)))).collect();
            prop_assert!(leaves.len() <= 3, "{:?}", program);
        }
    }
}
