//! The parts of a tree, each kept once.
//!
//! *Practice.* A subtree that is used twice in one place is made of the same parts, so its steps are the same steps; and two
//! trees can be told apart by looking each part of the one up in the other. A part's key holds the bits of the numbers that
//! reach samples: 0 and −0 are equal, but not the same.

use std::borrow::Cow;
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use super::spaces::Space;
use super::tree::{FramePlane, Leaf, Source};
use super::{Classifier, MaskLeaf, Operator, ValueMap, ValueRule, VolumeLeaf};

/// What can be kept in a [`Pool`]: it writes the bits of what it is made of, or of what tells it from most others.
pub(super) trait Keyed: PartialEq {
    fn write_key(&self, key: &mut DefaultHasher);
}

/// Parts of one kind, in the order in which they came.
#[derive(Clone, Debug)]
pub(super) struct Pool<T> {
    parts: Vec<T>,
    places: HashMap<u64, Vec<u32>>,
}

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Self {
            parts: Vec::new(),
            places: HashMap::new(),
        }
    }
}

impl<T: Keyed> Pool<T> {
    /// The place of `part`, which is added if it is not there.
    pub fn add(&mut self, part: T) -> u32 {
        self.find(&part).unwrap_or_else(|| {
            let place = self.parts.len() as u32;
            self.places.entry(key(&part)).or_default().push(place);
            self.parts.push(part);
            place
        })
    }

    /// The place of a part that is the same as `part`.
    pub fn find(&self, part: &T) -> Option<u32> {
        let places = self.places.get(&key(part))?;
        places.iter().copied().find(|&at| self.parts[at as usize] == *part)
    }

    /// For each part of `self` the place of the same one in `other`.
    pub fn places_in(&self, other: &Self) -> Vec<Option<u32>> {
        self.parts.iter().map(|part| other.find(part)).collect()
    }

    /// For each part of `self` the place in `other` of what it is there, if it is anything.
    pub fn places_as<'a>(&'a self, other: &Self, there: impl Fn(&'a T) -> Option<Cow<'a, T>>) -> Vec<Option<u32>>
    where
        T: Clone,
    {
        let place = |part| other.find(there(part)?.as_ref());
        self.parts.iter().map(place).collect()
    }

    /// All parts.
    pub fn parts(&self) -> &[T] {
        &self.parts
    }
}

fn key<T: Keyed>(part: &T) -> u64 {
    let mut key = DefaultHasher::new();
    part.write_key(&mut key);
    key.finish()
}

fn write_f64(key: &mut DefaultHasher, numbers: &[f64]) {
    numbers.iter().for_each(|n| key.write_u64(n.to_bits()));
}

fn write_f32(key: &mut DefaultHasher, numbers: &[f32]) {
    numbers.iter().for_each(|n| key.write_u32(n.to_bits()));
}

impl Keyed for Leaf {
    fn write_key(&self, key: &mut DefaultHasher) {
        self.space.hash(key);
        write_f64(key, &self.local_from_frame.to_cols_array());
        write_f64(key, &self.local_bounds.min.to_array());
        write_f64(key, &self.local_bounds.max.to_array());
        match &self.source {
            Source::Volume(leaf) => write_f32(key, &[leaf.window.lo, leaf.window.hi]),
            Source::Mask(leaf) => write_f32(key, &[leaf.value]),
            Source::Primitive(placed) => write_f32(key, &[placed.value()]),
        }
    }
}

impl Keyed for ValueMap {
    fn write_key(&self, key: &mut DefaultHasher) {
        match self {
            Self::Linear { scale, offset } => write_f32(key, &[*scale, *offset]),
            Self::Quadratic { a, b, c } => write_f32(key, &[*a, *b, *c]),
            Self::Table(points) => points.iter().for_each(|p| write_f32(key, &[p.0, p.1])),
        }
    }
}

impl Keyed for (Space, FramePlane) {
    fn write_key(&self, key: &mut DefaultHasher) {
        let (space, plane) = self;
        space.hash(key);
        write_f64(key, &plane.normal.to_array());
        write_f64(key, &[plane.offset]);
    }
}

impl Keyed for Operator {
    fn write_key(&self, key: &mut DefaultHasher) {
        key.write_u8(self.op as u8);
        key.write_u8(self.family as u8);
        match &self.rule {
            ValueRule::Blend(t) => write_f32(key, &[*t]),
            ValueRule::Table(lut) => write_f32(key, lut.values()),
            _ => {}
        }
    }
}

impl Keyed for Classifier {
    fn write_key(&self, key: &mut DefaultHasher) {
        write_f64(key, &[self.units]);
        for point in self.transfer.points() {
            write_f32(key, &[point.value, point.opacity]);
            write_f32(key, &point.color);
        }
    }
}

/// The same data, not equal data.
impl PartialEq for MaskLeaf {
    fn eq(&self, other: &Self) -> bool {
        let like = |leaf: &Self| (leaf.admitted, leaf.value);
        std::sync::Arc::ptr_eq(&self.bricks, &other.bricks) && like(self) == like(other)
    }
}

/// The same data, not equal data.
impl PartialEq for VolumeLeaf {
    fn eq(&self, other: &Self) -> bool {
        std::sync::Arc::ptr_eq(&self.bricks, &other.bricks) && self.window == other.window
    }
}
