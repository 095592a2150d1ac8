//! Bars: the figures that this project promises.

use std::fmt;

use serde::Serialize;

/// What a figure is held against.
#[derive(Clone, Copy, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Limit {
    /// No less than this.
    AtLeast(f64),
    /// No more than this.
    AtMost(f64),
}

/// A figure with its bar.
#[derive(Clone, Serialize)]
pub struct Bar {
    /// What is measured.
    pub what: String,
    /// What was measured.
    pub value: f64,
    /// What it is held against.
    pub limit: Limit,
}

impl Bar {
    /// Whether the figure keeps to the bar; NaN does not.
    pub fn met(&self) -> bool {
        match self.limit {
            Limit::AtLeast(limit) => self.value >= limit,
            Limit::AtMost(limit) => self.value <= limit,
        }
    }
}

impl fmt::Display for Bar {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let verdict = if self.met() { "met" } else { "MISSED" };
        match self.limit {
            Limit::AtLeast(limit) => write!(f, "≥ {limit} {verdict}"),
            Limit::AtMost(limit) => write!(f, "≤ {limit} {verdict}"),
        }
    }
}
