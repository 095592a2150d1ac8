//! Random scenes, views and subdivisions, and the slow truth that they are held against.

pub mod landmarks;
pub mod parts;
pub mod scenes;
pub mod truth;
pub mod views;

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};

/// `cases` random cases, or more where the environment's `PROPTEST_CASES` is above its default of 256: 2560 makes ten times
/// as many. Failures are shown in full, so none are kept in files.
pub fn cases(cases: u32) -> ProptestConfig {
    let default = ProptestConfig::default();
    ProptestConfig {
        cases: (cases * default.cases).div_ceil(256),
        failure_persistence: None,
        max_shrink_iters: 400,
        ..default
    }
}

/// What `strategy` makes of `seed`: the plain generator.
pub fn seeded<S: Strategy>(strategy: &S, seed: u64) -> S::Value {
    let mut bytes = [0; 32];
    bytes[..8].copy_from_slice(&seed.to_le_bytes());
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &bytes);
    let mut runner = TestRunner::new_with_rng(cases(1), rng);
    strategy
        .new_tree(&mut runner)
        .expect("a strategy that rejects nothing")
        .current()
}
