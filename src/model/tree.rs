//! The tree in one frame, flattened: what a point evaluates to, and the truth that every block's path is held against.
//!
//! *Theory.* A node's value at P is its operation on its children's values at P, with P moved into each child's frame
//! (VCSG §2.2, 2.3).
//! *Changes from the paper.* The transforms on the way from the root to a leaf are composed once into that leaf's
//! `local_from_frame`, and values meet on a stack: the post-order list of steps *is* the tree.
//! *Practice.* A tree bound to a target's lattice evaluates at voxel indices, so that paths, which step along rows of voxels,
//! can agree with it bit for bit.

use std::borrow::Cow;

use glam::{DAffine3, DVec3};

use super::bounds::rounded_out;
use super::deform::{Warp, WarpError};
use super::pool::Pool;
use super::spaces::{Space, space_in};
use super::{Classifier, ColorSample, MaskLeaf, Operator, ValueMap, VolumeLeaf};
use crate::math::{Aabb, Interval, Plane, affine, linear};
use crate::volume::Sample;
use crate::voxelize::Placed;

/// One step of a flattened tree: pushes a sample, or replaces those on top of the stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// Pushes leaf `.0`, testing whether the point lies in its box.
    Leaf(u32),
    /// Pushes leaf `.0`, known to hold the point (VCSG §3.1, criterion 1).
    LeafInside(u32),
    /// Maps the value on top by map `.0`.
    Map(u32),
    /// Empties the top where cut `.0` takes it away.
    Cut(u32),
    /// Makes a colour of the value on top, by classifier `.0`.
    Classify(u32),
    /// Combines the two values on top by operator `.0`.
    Combine(u32),
    /// Combines the two colours on top by operator `.0`.
    Blend(u32),
}

/// What a leaf is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// Voxels; the local frame is the volume's index space.
    Volume(VolumeLeaf),
    /// Voxels that say where something is; the local frame is their index space.
    Mask(MaskLeaf),
    /// Geometry of one value; the local frame is the node's, or the world where that shows it better.
    Primitive(Box<Placed>),
}

/// A leaf and where it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Leaf {
    /// What it is.
    pub source: Source,
    /// The deformation that the leaf stands in.
    pub space: Space,
    /// From the tree's frame, as it is in the leaf's space, to the leaf's own.
    pub local_from_frame: DAffine3,
    /// Its box in its own frame.
    pub local_bounds: Aabb,
    /// A box of the tree's frame, as it is in the leaf's space, that holds the leaf.
    pub frame_bounds: Aabb,
}

/// A plane as a linear form in the tree's frame: taken away where `normal · p + offset > 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FramePlane {
    /// Gradient of the signed distance; not of unit length where the frame is scaled.
    pub normal: DVec3,
    /// Signed distance (millimetres) at the frame's origin.
    pub offset: f64,
}

/// A model flattened in one frame. Parts that are the same are one part: steps with one index.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    pub(super) steps: Vec<Step>,
    pub(super) leaves: Pool<Leaf>,
    pub(super) maps: Pool<ValueMap>,
    pub(super) cuts: Pool<(Space, FramePlane)>,
    pub(super) operators: Pool<Operator>,
    pub(super) classifiers: Pool<Classifier>,
    pub(super) color_unit_mm: Option<f64>,
    pub(super) warps: Vec<Warp>,
}

/// Why a model cannot be flattened.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TreeError {
    /// Shared subtrees multiply out to too much.
    #[error(
        "the tree has over {} nodes once its shared parts are written out; use fewer nested uses",
        Tree::MAX_STEPS
    )]
    TooLarge,
    /// A node that is given colours where it wants values, or the other way round.
    #[error(
        "values and colours are mixed: classify all operands of a set operation or none, and give it a rule for them"
    )]
    Mixed,
    /// A transform that flattens space.
    #[error("a transform cannot be undone: its matrix is singular or not finite; scale by numbers other than 0")]
    Singular,
    /// A deformation that cannot be tabulated.
    #[error(transparent)]
    Warp(#[from] WarpError),
}

impl From<&Plane> for FramePlane {
    fn from(plane: &Plane) -> Self {
        Self {
            normal: plane.normal,
            offset: plane.offset,
        }
    }
}

impl FramePlane {
    /// Signed distance (millimetres) of the frame's point `p`.
    #[inline]
    pub fn distance(&self, p: DVec3) -> f64 {
        linear(self.normal, self.offset, p)
    }

    /// The same plane in another frame.
    pub fn moved(&self, this_from_frame: &DAffine3) -> Self {
        Self {
            normal: this_from_frame.matrix3.transpose() * self.normal,
            offset: self.distance(this_from_frame.translation),
        }
    }
}

impl Leaf {
    pub(super) fn new(source: Source, space: Space, local_from_frame: DAffine3, local_bounds: Aabb) -> Self {
        let local_from_frame = affine::snapped(&local_from_frame);
        let hull = local_bounds.transformed(&local_from_frame.inverse());
        Self {
            source,
            space,
            local_from_frame,
            local_bounds,
            frame_bounds: rounded_out(&hull),
        }
    }

    /// The same leaf in another space.
    fn standing_in(&self, space: Space) -> Cow<'_, Self> {
        if space == self.space {
            return Cow::Borrowed(self);
        }
        Cow::Owned(Self { space, ..self.clone() })
    }

    /// The leaf at `local`, a point of its box in its own frame.
    #[inline]
    pub fn sample_inside(&self, local: DVec3) -> Sample {
        match &self.source {
            Source::Volume(leaf) => leaf.admit(leaf.bricks.sample_index(local)),
            Source::Mask(mask) => mask.sample(local),
            Source::Primitive(placed) => placed.sample(local),
        }
    }
}

impl VolumeLeaf {
    /// Whether no value is kept out; NaN always is.
    pub fn admits_all(&self) -> bool {
        self.window == Interval::ALL && !self.bricks.has_missing()
    }

    /// The sample of an interpolated value: present only where the value lies in the leaf's window (NaN never does).
    #[inline]
    pub fn admit(&self, value: f32) -> Sample {
        if self.window.contains(value) {
            Sample::solid(value)
        } else {
            Sample::EMPTY
        }
    }
}

impl Tree {
    /// For each leaf, map, plane, operator and classifier the index of the same one in `other`, a tree in the same frame. What
    /// is below a deformation is the same only if that is.
    pub(super) fn parts_in(&self, other: &Self) -> [Vec<Option<u32>>; 5] {
        let warps = self.warps_in(other);
        let there = |space| space_in(&warps, space);
        [
            (self.leaves).places_as(&other.leaves, |leaf| Some(leaf.standing_in(there(leaf.space)?))),
            self.maps.places_in(&other.maps),
            (self.cuts).places_as(&other.cuts, |&(space, plane)| Some(Cow::Owned((there(space)?, plane)))),
            self.operators.places_in(&other.operators),
            self.classifiers.places_in(&other.classifiers),
        ]
    }

    /// The steps of the whole tree, in post-order.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Leaf `index` of a [`Step::Leaf`].
    pub fn leaf(&self, index: u32) -> &Leaf {
        &self.leaves.parts()[index as usize]
    }

    /// All leaves.
    pub fn leaves(&self) -> &[Leaf] {
        self.leaves.parts()
    }

    /// Map `index` of a [`Step::Map`].
    pub fn map(&self, index: u32) -> &ValueMap {
        &self.maps.parts()[index as usize]
    }

    /// Plane `index` of a [`Step::Cut`].
    pub fn cut(&self, index: u32) -> &FramePlane {
        &self.cuts.parts()[index as usize].1
    }

    /// The space that plane `index` stands in.
    pub fn cut_space(&self, index: u32) -> Space {
        self.cuts.parts()[index as usize].0
    }

    /// Operator `index` of a [`Step::Combine`].
    pub fn operator(&self, index: u32) -> &Operator {
        &self.operators.parts()[index as usize]
    }

    /// All operators.
    pub fn operators(&self) -> &[Operator] {
        self.operators.parts()
    }

    /// Whether any value is mapped.
    pub fn has_maps(&self) -> bool {
        !self.maps.parts().is_empty()
    }

    /// The model at point `p` of the frame: the truth. The value of a colour is its opacity.
    pub fn sample(&self, p: DVec3) -> Sample {
        self.color_sample(p).sample
    }

    /// The model at point `p` of the frame with its colour, black in a tree of values.
    pub fn color_sample(&self, p: DVec3) -> ColorSample {
        let mut stack = Vec::new();
        for &step in &self.steps {
            self.apply(step, p, &mut stack);
        }
        stack.pop().unwrap_or(ColorSample::EMPTY)
    }

    fn apply(&self, step: Step, p: DVec3, stack: &mut Vec<ColorSample>) {
        match step {
            Step::Leaf(i) | Step::LeafInside(i) => {
                let leaf = self.leaf(i);
                let local = affine::point(&leaf.local_from_frame, self.in_space(leaf.space, p));
                let inside = leaf.local_bounds.contains(local);
                stack.push(ColorSample::of_value(if inside {
                    leaf.sample_inside(local)
                } else {
                    Sample::EMPTY
                }));
            }
            Step::Map(i) => {
                let top = stack.last_mut().expect("a map has an operand");
                *top = ColorSample::of_value(self.map(i).sample(top.sample));
            }
            Step::Classify(i) => {
                let top = stack.last_mut().expect("a classifier has an operand");
                *top = self.classifier(i).apply(top.sample);
            }
            Step::Cut(i) => {
                let top = stack.last_mut().expect("a cut has an operand");
                if self.cut(i).distance(self.in_space(self.cut_space(i), p)) > 0.0 {
                    *top = ColorSample::EMPTY;
                }
            }
            Step::Combine(i) => {
                let second = stack.pop().expect("an operator has two operands");
                let first = stack.last_mut().expect("an operator has two operands");
                *first = ColorSample::of_value(self.operator(i).apply(first.sample, second.sample));
            }
            Step::Blend(i) => {
                let second = stack.pop().expect("an operator has two operands");
                let first = stack.last_mut().expect("an operator has two operands");
                *first = self.operator(i).blend(first, &second);
            }
        }
    }
}
