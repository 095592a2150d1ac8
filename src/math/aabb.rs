//! Axis-aligned boxes.

use glam::{DAffine3, DVec3};

use super::affine;

/// A closed axis-aligned box; empty when `min > max` on some axis. The unit is that of the frame it is used in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Smallest corner.
    pub min: DVec3,
    /// Largest corner.
    pub max: DVec3,
}

/// Where one box lies with respect to another (VCSG §3.1, criteria 1 and 2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overlap {
    /// No point in common.
    Outside,
    /// Some points in common.
    Partial,
    /// Entirely within.
    Inside,
}

impl Aabb {
    /// The box that holds nothing.
    pub const EMPTY: Self = Self {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };

    /// All of space.
    pub const ALL: Self = Self {
        min: DVec3::NEG_INFINITY,
        max: DVec3::INFINITY,
    };

    /// The box between two corners.
    pub const fn new(min: DVec3, max: DVec3) -> Self {
        Self { min, max }
    }

    /// The smallest box that holds `points`.
    pub fn of_points(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self {
            min: b.min.min(p),
            max: b.max.max(p),
        })
    }

    /// Whether it holds no point.
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// Whether every coordinate is finite.
    pub fn is_finite(&self) -> bool {
        self.min.is_finite() && self.max.is_finite()
    }

    /// Edge lengths.
    pub fn size(&self) -> DVec3 {
        self.max - self.min
    }

    /// The middle.
    pub fn center(&self) -> DVec3 {
        (self.min + self.max) * 0.5
    }

    /// Whether `p` lies in it, faces included.
    pub fn contains(&self, p: DVec3) -> bool {
        p.cmpge(self.min).all() && p.cmple(self.max).all()
    }

    /// The points in both.
    pub fn intersect(&self, other: &Self) -> Self {
        Self {
            min: self.min.max(other.min),
            max: self.max.min(other.max),
        }
    }

    /// The smallest box that holds both.
    pub fn hull(&self, other: &Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// Moved outwards by `by` on each axis.
    pub fn expand(&self, by: DVec3) -> Self {
        Self {
            min: self.min - by,
            max: self.max + by,
        }
    }

    /// The eight corners; bit `a` of the index says that axis `a` is at `max`.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            DVec3::new(
                if i & 1 == 0 { self.min.x } else { self.max.x },
                if i & 2 == 0 { self.min.y } else { self.max.y },
                if i & 4 == 0 { self.min.z } else { self.max.z },
            )
        })
    }

    /// The smallest box in the destination frame that holds this one mapped by `dst_from_src`.
    pub fn transformed(&self, dst_from_src: &DAffine3) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        if !self.is_finite() {
            return Self::ALL;
        }
        Self::of_points(self.corners().map(|c| affine::point(dst_from_src, c)))
    }

    /// Where this box lies with respect to `other`.
    pub fn overlap(&self, other: &Self) -> Overlap {
        if self.intersect(other).is_empty() {
            Overlap::Outside
        } else if other.min.cmple(self.min).all() && other.max.cmpge(self.max).all() {
            Overlap::Inside
        } else {
            Overlap::Partial
        }
    }
}
