//! Law 2: one block or many, one thread or more, the same bits.

use proptest::prelude::*;
use vcsg::model::Boundary;
use vcsg::target::{OctreeNode, Subdivision};

use super::picture::{picture, same};
use crate::support::scenes::{scene, subdivision};
use crate::support::{cases, seeded};

fn blocks_of(edge: usize) -> Subdivision {
    Subdivision {
        min_block: edge,
        max_block: edge,
        ..Subdivision::default()
    }
}

proptest! {
    #![proptest_config(cases(160))]

    #[test]
    fn one_block_or_many(scene in scene(), subdivision in subdivision(Boundary::Exact), picture in picture()) {
        let (one, many) = (scene.target(&blocks_of(64)), scene.target(&subdivision));
        prop_assert!(one.blocks.len() <= 1);
        prop_assert_eq!(same(&picture.cast(&one), &picture.cast(&many)), Ok(()));
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    for seed in 0..24 {
        let target = seeded(&scene(), seed).target(&blocks_of(8));
        let picture = seeded(&picture(), seed);
        let [one, two, three] =
            [1, 2, 3].map(|threads| pool(threads).expect("threads").install(|| picture.cast(&target)));
        assert_eq!(same(&one, &two), Ok(()), "seed {seed}");
        assert_eq!(same(&one, &three), Ok(()), "seed {seed}");
    }
}

/// A comparator that cannot fail holds nothing.
#[test]
fn dropped_blocks_are_seen() {
    let differs = |seed: &u64| {
        let whole = seeded(&scene(), *seed).target(&blocks_of(8));
        let picture = seeded(&picture(), *seed);
        let mut part = whole.clone();
        let half = part.blocks.len() as u32 / 2;
        for node in &mut part.octree.nodes {
            if matches!(*node, OctreeNode::Block(b) if b >= half) {
                *node = OctreeNode::Empty;
            }
        }
        same(&picture.cast(&whole), &picture.cast(&part)).is_err()
    };
    let seen = (0..48).filter(differs).count();
    assert!(seen > 8, "{seen} of 48");
}
