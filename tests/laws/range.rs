//! Ranges hold every sample, and what pruning leaves of a path gives the same samples.

use glam::DVec3;
use proptest::prelude::*;
use vcsg::math::{Aabb, Interval, affine};
use vcsg::model::{Boundary, ColorSample, Pruned, Source, Step, Tree};
use vcsg::target::{Block, BlockVoxels, Target};
use vcsg::volume::{Sample, SampleRange};

use crate::path::{same_bits, voxels};
use crate::support::cases;
use crate::support::scenes::{deformed_scene, scene, subdivision};

/// `path` at `p`, believing what it says: a leaf known to hold the point is not tested again.
fn run(tree: &Tree, path: &[Step], p: DVec3) -> Sample {
    let mut stack: Vec<ColorSample> = Vec::new();
    for &step in path {
        let value = |stack: &mut Vec<ColorSample>| stack.pop().expect("an operand").sample;
        let sample = match step {
            Step::LeafInside(i) => {
                let leaf = tree.leaf(i);
                match &leaf.source {
                    Source::Primitive(placed) => Sample::solid(placed.value()),
                    Source::Volume(_) | Source::Mask(_) => {
                        leaf.sample_inside(affine::point(&leaf.local_from_frame, tree.in_space(leaf.space, p)))
                    }
                }
            }
            Step::Leaf(i) => {
                let leaf = tree.leaf(i);
                let local = affine::point(&leaf.local_from_frame, tree.in_space(leaf.space, p));
                match leaf.local_bounds.contains(local) {
                    true => leaf.sample_inside(local),
                    false => Sample::EMPTY,
                }
            }
            Step::Map(i) => tree.map(i).sample(value(&mut stack)),
            Step::Combine(i) => {
                let second = value(&mut stack);
                tree.operator(i).apply(value(&mut stack), second)
            }
            Step::Classify(i) => {
                let operand = value(&mut stack);
                stack.push(tree.classifier(i).apply(operand));
                continue;
            }
            Step::Blend(i) => {
                let second = stack.pop().expect("two operands");
                let first = stack.pop().expect("two operands");
                stack.push(tree.operator(i).blend(&first, &second));
                continue;
            }
            Step::Cut(i) => {
                let removed = tree.cut(i).distance(tree.in_space(tree.cut_space(i), p)) > 0.0;
                let operand = stack.pop().expect("an operand");
                stack.push(if removed { ColorSample::EMPTY } else { operand });
                continue;
            }
        };
        stack.push(ColorSample::of_value(sample));
    }
    stack.pop().map_or(Sample::EMPTY, |c| c.sample)
}

/// Whether `range` allows `sample`. A value that overflow made NaN is in no interval, and no range speaks of it.
fn allows(range: &SampleRange, sample: Sample) -> bool {
    match sample.value.is_nan() {
        true => range.coverage.contains(sample.coverage),
        false => range.contains(sample),
    }
}

/// At each point, `pruned` gives the tree's sample, and its range allows it.
fn pruned_holds(tree: &Tree, pruned: &Pruned, points: &[DVec3]) -> Result<(), String> {
    for &p in points {
        let (truth, found) = (tree.sample(p), run(tree, &pruned.steps, p));
        if !same_bits(truth.value, found.value) || truth.coverage != found.coverage {
            return Err(format!("{found:?} at {p}, not {truth:?}, by {:?}", pruned.steps));
        }
        if !allows(&pruned.range, truth) {
            return Err(format!("{truth:?} at {p} is not in {:?}", pruned.range));
        }
    }
    Ok(())
}

/// All samples of each block and of its reach are in the block's range, and those are in the target's.
fn block_ranges_hold(target: &Target) -> Result<(), String> {
    for block in &target.blocks {
        let stored = BlockVoxels::reconstruct(target, block, Block::REACH);
        for n in 0..voxels(stored.dims).count() {
            let coverage = stored.coverage.as_ref().map_or(1.0, |c| c[n]);
            // Stored is the product of value and coverage; it and this quotient each round by half a unit.
            let soft = 0.0 < coverage && coverage < 1.0;
            let value = stored.premultiplied[n];
            let sample = Sample {
                value: if soft { value / coverage } else { value },
                coverage,
            };
            let widened = |range: Interval| if soft { range.widen_ulps(1.0) } else { range };
            let range = SampleRange {
                value: widened(block.range.value),
                ..block.range
            };
            if !allows(&range, sample) {
                return Err(format!("{sample:?} in {block:?}"));
            }
            let unbounded = sample.coverage == 0.0 || sample.value.is_nan();
            if !unbounded && !widened(target.value_range).contains(sample.value) {
                return Err(format!("{sample:?} in {:?}", target.value_range));
            }
        }
    }
    Ok(())
}

/// A box between two points of the unit cube, and points of it, among them its corners.
fn region() -> impl Strategy<Value = (Aabb, Vec<DVec3>)> {
    let fraction = || prop::array::uniform3(0.0f64..=1.0).prop_map(DVec3::from);
    let large = (fraction(), fraction()).prop_map(|(a, b)| Aabb::of_points([a, b]));
    let small = (fraction(), fraction()).prop_map(|(a, b)| Aabb::new(a, a + b * 0.15));
    let within = prop::collection::vec(fraction(), 60);
    (prop_oneof![large, small], within).prop_map(|(region, within)| {
        let points = within.into_iter().map(|f| region.min + region.size() * f);
        let points = points.chain(region.corners()).collect();
        (region, points)
    })
}

/// From the unit cube to the box round a lattice and a tenth more on each side.
fn in_lattice(bounds: &Aabb, fraction: DVec3) -> DVec3 {
    bounds.min + bounds.size() * (fraction * 1.2 - 0.1)
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn pruned_paths_and_their_ranges_hold(scene in prop_oneof![scene(), deformed_scene()], regions in prop::collection::vec(region(), 4)) {
        let tree = Tree::new(&scene.model, &scene.lattice.world_from_lattice).expect("a small tree");
        let bounds = scene.lattice.bounds();
        for (region, points) in regions {
            let map = |p| in_lattice(&bounds, p);
            // Points are clamped, since mapping may round them out of the mapped box.
            let region = Aabb::new(map(region.min), map(region.max));
            let points: Vec<DVec3> = points.into_iter().map(|p| map(p).clamp(region.min, region.max)).collect();
            let pruned = tree.prune(tree.steps(), &region, None);
            prop_assert_eq!(pruned_holds(&tree, &pruned, &points), Ok(()));
            // A path that was pruned before, as a block's is from its parent's.
            let part = Aabb::new(region.min, region.center());
            let inner: Vec<DVec3> = points.iter().map(|p| region.min.lerp(*p, 0.5).clamp(part.min, part.max)).collect();
            let again = tree.prune(&pruned.steps, &part, None);
            prop_assert_eq!(pruned_holds(&tree, &again, &inner), Ok(()));
        }
    }
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn block_ranges_hold_their_samples(scene in scene(), subdivision in subdivision(Boundary::Exact)) {
        prop_assert_eq!(block_ranges_hold(&scene.target(&subdivision)), Ok(()));
    }

    #[test]
    fn block_ranges_hold_their_samples_by_the_centre_too(scene in scene(), subdivision in subdivision(Boundary::Centre)) {
        prop_assert_eq!(block_ranges_hold(&scene.target(&subdivision)), Ok(()));
    }
}

mod mistakes {
    use super::*;
    use crate::support::scenes::Scene;
    use crate::support::seeded;

    /// The first of some scenes' results that is an error.
    fn seen(check: impl Fn(&Scene, u64) -> Result<(), String>) -> bool {
        (0..60).any(|seed| check(&seeded(&scene(), seed), seed).is_err())
    }

    fn pruned_with(scene: &Scene, seed: u64, mutate: impl Fn(&mut Pruned)) -> Result<(), String> {
        let tree = Tree::new(&scene.model, &scene.lattice.world_from_lattice).expect("a small tree");
        let (region, points) = seeded(&region(), seed);
        let map = |p| in_lattice(&scene.lattice.bounds(), p);
        let region = Aabb::new(map(region.min), map(region.max));
        let points: Vec<DVec3> = points
            .into_iter()
            .map(|p| map(p).clamp(region.min, region.max))
            .collect();
        let mut pruned = tree.prune(tree.steps(), &region, None);
        mutate(&mut pruned);
        pruned_holds(&tree, &pruned, &points)
    }

    #[test]
    fn an_untested_leaf_is_seen() {
        let untested = |step: &mut Step| {
            if let Step::Leaf(i) = *step {
                *step = Step::LeafInside(i);
            }
        };
        assert!(!seen(|s, seed| pruned_with(s, seed, |_| ())));
        assert!(seen(|s, seed| pruned_with(s, seed, |p| p
            .steps
            .iter_mut()
            .for_each(untested))));
    }

    #[test]
    fn narrowed_ranges_are_seen() {
        assert!(seen(|s, seed| pruned_with(s, seed, |p| p.range.coverage.hi = 0.5)));
        assert!(seen(|s, seed| pruned_with(s, seed, |p| {
            p.range.value.hi -= 0.1 * p.range.value.width() + 1.0;
        })));
        assert!(seen(|scene, seed| {
            let mut target = scene.target(&seeded(&subdivision(Boundary::Exact), seed));
            target.blocks.iter_mut().for_each(|b| b.range.value.lo += 1.0);
            block_ranges_hold(&target)
        }));
    }
}
