//! Repeated runs and what they come to.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use crate::quads::processor;

/// One run of something.
#[derive(Clone, Copy, Deserialize, Serialize)]
pub struct Run {
    /// By the wall clock, seconds.
    pub wall_s: f64,
    /// Processor time of all threads, seconds.
    pub cpu_s: f64,
}

/// What `action` gives, and what it took.
pub fn timed<T>(action: impl FnOnce() -> T) -> (T, Run) {
    let (start, used) = (Instant::now(), processor::used_ms());
    let result = action();
    let run = Run {
        wall_s: start.elapsed().as_secs_f64(),
        cpu_s: (processor::used_ms() - used) / 1e3,
    };
    (result, run)
}

/// Several runs of one thing.
#[derive(Serialize)]
pub struct Summary {
    /// Median by the wall clock, seconds.
    pub median_s: f64,
    /// Least by the wall clock, seconds.
    pub min_s: f64,
    /// Least processor time, seconds.
    pub cpu_min_s: f64,
    /// All of them.
    pub runs: Vec<Run>,
}

impl Summary {
    /// The summary of at least one run.
    pub fn of(runs: Vec<Run>) -> Self {
        let least = |of: fn(&Run) -> f64| runs.iter().map(of).fold(f64::INFINITY, f64::min);
        Self {
            median_s: median(runs.iter().map(|r| r.wall_s).collect()),
            min_s: least(|r| r.wall_s),
            cpu_min_s: least(|r| r.cpu_s),
            runs,
        }
    }
}

/// The middle number, or the mean of the two in the middle; NaN of none.
pub fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    let middle = numbers.len() / 2;
    match numbers.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => numbers[middle],
        _ => 0.5 * (numbers[middle - 1] + numbers[middle]),
    }
}

/// How many times as fast one of two things is, which took turns.
#[derive(Serialize)]
pub struct Ratios {
    /// By medians of the wall clock: what bars are held against.
    pub median: f64,
    /// By least wall clock times.
    pub min: f64,
    /// By least processor times.
    pub cpu: f64,
}

impl Ratios {
    /// How many times as fast `ours` is as `theirs`.
    pub fn of(ours: &Summary, theirs: &Summary) -> Self {
        Self {
            median: theirs.median_s / ours.median_s,
            min: theirs.min_s / ours.min_s,
            cpu: theirs.cpu_min_s / ours.cpu_min_s,
        }
    }
}
