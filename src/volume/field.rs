//! Samples, and the trait of all that can be sampled in the world.
//!
//! *Practice.* Bricks and closed-form truths are [`Field`]s, so that what is sampled can be held against what is known. A
//! [`Tree`](crate::model::Tree) gives [`Sample`]s too, but at points of a frame of its own.

use glam::DVec3;

use crate::math::{Aabb, Interval};

/// What a model is at a point: design §3's pair of value and coverage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// The data's value; meaningful only where `coverage > 0`, and 0 where it is 0.
    pub value: f32,
    /// WK94's filtered density in `[0, 1]`; where it is 0 or 1 it is VCSG's `P ∈ S`.
    pub coverage: f32,
}

impl Sample {
    /// Nothing is there.
    pub const EMPTY: Self = Self {
        value: 0.0,
        coverage: 0.0,
    };

    /// A fully covered point of value `value`.
    pub const fn solid(value: f32) -> Self {
        Self { value, coverage: 1.0 }
    }

    /// `value · coverage`: what is filtered and differentiated, so that empty space lends no value to an object.
    pub fn premultiplied(self) -> f32 {
        self.value * self.coverage
    }
}

/// What a [`Field`] can be over a box: every sample there lies in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleRange {
    /// Values of the points whose coverage is above 0; empty when there are none.
    pub value: Interval,
    /// Coverages.
    pub coverage: Interval,
}

impl SampleRange {
    /// Nothing is anywhere in the box.
    pub const EMPTY: Self = Self {
        value: Interval::EMPTY,
        coverage: Interval::point(0.0),
    };

    /// Whether `sample` is one of those that the range allows.
    pub fn contains(&self, sample: Sample) -> bool {
        self.coverage.contains(sample.coverage) && (sample.coverage == 0.0 || self.value.contains(sample.value))
    }
}

/// A density field in space. All positions are world millimetres (LPS).
pub trait Field: Send + Sync {
    /// A box outside which coverage is 0.
    fn bounds(&self) -> Aabb;

    /// The field at `p`.
    fn sample(&self, p: DVec3) -> Sample;

    /// The gradient of `value · coverage` at `p`, per millimetre.
    fn gradient(&self, p: DVec3) -> DVec3;

    /// A conservative range over `region`: it holds every sample that [`Field::sample`] returns there.
    fn range(&self, region: &Aabb) -> SampleRange;
}
