//! The hierarchy of bounding boxes (VCSG §2.4).
//!
//! *Theory.* A leaf's box is that of its data. A transfer keeps its child's box, a cut clips it, union and intersection
//! unite and intersect their children's, a subtraction keeps its first child's.
//! *Changes from the paper.* A transform node's box is stated in its parent's frame, as the axis-aligned box of its child's
//! moved corners; the paper keeps the child's and moves the tested block instead, which is what [`Tree`](super::Tree) does
//! for leaves, where it decides. A subtraction that keeps the first operand's extent is bounded in the same way. A deformed
//! box is not estimated from the images of samples of its faces: each is a patch, whose image is bounded.

use glam::{DAffine3, DVec3};

use super::{BooleanOp, FramePlane, Leaf, Model, Node, NodeId, Source, Space, Step, Tree};
use crate::math::Aabb;
use crate::voxelize::{Placed, Solid};

impl Model {
    /// The box of every node, in the frame of its parent, by node index; empty where the node is nowhere, infinite where it
    /// is unbounded. Soft surfaces reach beyond it by their filter's radius, which only a lattice gives a length.
    pub fn bounds(&self) -> Vec<Aabb> {
        let mut boxes: Vec<Aabb> = Vec::with_capacity(self.nodes().len());
        for node in self.nodes() {
            boxes.push(node_bounds(node, &boxes));
        }
        boxes
    }

    /// The box of node `id` in the frame of its parent, as [`Self::bounds`] has it.
    ///
    /// # Panics
    /// If the node is not in the model.
    pub fn bounds_of(&self, id: NodeId) -> Aabb {
        self.rooted_at(id).bounds().pop().unwrap_or(Aabb::EMPTY)
    }
}

fn node_bounds(node: &Node, boxes: &[Aabb]) -> Aabb {
    match node {
        Node::Volume(leaf) => leaf.bricks.index_bounds().transformed(leaf.bricks.world_from_index()),
        Node::Mask(leaf) => leaf.bricks.index_bounds().transformed(leaf.bricks.world_from_index()),
        Node::Primitive(primitive) => solid_bounds(&primitive.solid),
        Node::Transform {
            child,
            parent_from_child,
        } => boxes[child.index()].transformed(parent_from_child),
        Node::Deform { child, morph, .. } => morph.image_bounds(&boxes[child.index()]),
        Node::Transfer { child, .. } | Node::Classify { child, .. } => boxes[child.index()],
        Node::Cut { child, plane } => clip(&boxes[child.index()], &FramePlane::from(plane)),
        Node::Combine(c) => combined(c.op, &boxes[c.first.index()], &boxes[c.second.index()]),
    }
}

fn combined(op: BooleanOp, first: &Aabb, second: &Aabb) -> Aabb {
    match op {
        BooleanOp::Union => first.hull(second),
        BooleanOp::Intersection => first.intersect(second),
        BooleanOp::Subtraction | BooleanOp::SubtractionWithRule => *first,
    }
}

impl Tree {
    /// The box of the whole tree in another frame: each leaf's own box is moved there at once, so it is never larger than
    /// [`Model::bounds`] makes it of boxes of boxes.
    pub fn bounds_in(&self, tree_from_frame: &DAffine3) -> Aabb {
        self.bounds_of(self.steps(), None, tree_from_frame)
    }

    /// The box of what `steps` give in `space`, in a frame from which `space_from_frame` leads there.
    pub(super) fn bounds_of(&self, steps: &[Step], space: Space, space_from_frame: &DAffine3) -> Aabb {
        let mut stack: Vec<Aabb> = Vec::new();
        for &step in steps {
            match step {
                Step::Leaf(i) | Step::LeafInside(i) => stack.push(self.leaf_bounds(i, space, space_from_frame)),
                Step::Map(_) | Step::Classify(_) => {}
                // What a deformation holds is bounded as a whole.
                Step::Cut(i) if self.cut_space(i) != space => {}
                Step::Cut(i) => {
                    let top = stack.pop().unwrap_or(Aabb::EMPTY);
                    stack.push(clip(&top, &self.cut(i).moved(space_from_frame)));
                }
                Step::Combine(i) | Step::Blend(i) => {
                    let second = stack.pop().unwrap_or(Aabb::EMPTY);
                    let first = stack.pop().unwrap_or(Aabb::EMPTY);
                    stack.push(combined(self.operator(i).op, &first, &second));
                }
            }
        }
        stack.pop().unwrap_or(Aabb::EMPTY)
    }

    /// The box of the frame beyond which leaf `index` surely gives nothing.
    pub(super) fn reach_of_leaf(&self, index: u32) -> Aabb {
        let leaf = self.leaf(index);
        match self.outermost_below(None, leaf.space) {
            None => leaf.frame_bounds,
            Some(warp) => rounded_out(&warp.domain),
        }
    }

    fn leaf_bounds(&self, index: u32, space: Space, space_from_frame: &DAffine3) -> Aabb {
        let leaf = self.leaf(index);
        match self.outermost_below(space, leaf.space) {
            None => leaf.bounds_in(space_from_frame),
            Some(warp) => warp.domain.transformed(&space_from_frame.inverse()),
        }
    }
}

impl Leaf {
    fn bounds_in(&self, tree_from_frame: &DAffine3) -> Aabb {
        let local_from_frame = self.local_from_frame * *tree_from_frame;
        match &self.source {
            Source::Primitive(placed) => match placed.as_half_space() {
                Some(plane) => clip(&Aabb::ALL, &FramePlane::from(&plane).moved(&local_from_frame)),
                None => self.local_bounds.transformed(&local_from_frame.inverse()),
            },
            Source::Volume(_) | Source::Mask(_) => self.local_bounds.transformed(&local_from_frame.inverse()),
        }
    }
}

/// A box expanded by far more than the rounding of a mapped point, and far less than a voxel.
pub(super) fn rounded_out(bounds: &Aabb) -> Aabb {
    let slack = 1e-9 * (1.0 + bounds.min.abs().max(bounds.max.abs()).max_element());
    bounds.expand(DVec3::splat(slack))
}

/// The box of a solid in its own frame.
fn solid_bounds(solid: &Solid) -> Aabb {
    match solid {
        Solid::HalfSpace(plane) => clip(&Aabb::ALL, &FramePlane::from(plane)),
        _ => solid.bounds(),
    }
}

/// A box of its own frame outside which a primitive is nothing.
pub(super) fn placed_bounds(placed: &Placed) -> Aabb {
    match placed.as_half_space() {
        Some(plane) => clip(&Aabb::ALL, &FramePlane::from(&plane)),
        None => placed.local_bounds(),
    }
}

/// The box of what a plane leaves of a box.
fn clip(bounds: &Aabb, plane: &FramePlane) -> Aabb {
    if bounds.is_empty() {
        return *bounds;
    }
    if !bounds.is_finite() {
        return clip_unbounded(bounds, plane);
    }
    let corners = bounds.corners();
    let distance = corners.map(|c| plane.distance(c));
    let kept = (0..8).filter(|&i| distance[i] <= 0.0).map(|i| corners[i]);
    let crossings = edges().filter_map(|(a, b)| {
        let (da, db) = (distance[a], distance[b]);
        ((da <= 0.0) != (db <= 0.0)).then(|| corners[a].lerp(corners[b], da / (da - db)))
    });
    let clipped = Aabb::of_points(kept.chain(crossings));
    // A crossing is rounded; no point may be lost for it.
    clipped.expand(bounds.size() * 1e-12).intersect(bounds)
}

/// Only a plane across an axis, but for rounding, bounds a box that is infinite along it.
fn clip_unbounded(bounds: &Aabb, plane: &FramePlane) -> Aabb {
    let mut clipped = *bounds;
    for axis in 0..3 {
        let n = plane.normal[axis];
        let mut others = plane.normal;
        others[axis] = 0.0;
        if others.abs().max_element() > 1e-12 * n.abs() {
            continue;
        }
        let face = -plane.offset / n;
        if n > 0.0 {
            clipped.max[axis] = clipped.max[axis].min(face);
        } else {
            clipped.min[axis] = clipped.min[axis].max(face);
        }
    }
    clipped
}

/// The twelve edges of a box as pairs of corner indices.
fn edges() -> impl Iterator<Item = (usize, usize)> {
    (0..8usize).flat_map(|a| {
        [1, 2, 4]
            .into_iter()
            .filter_map(move |bit| (a & bit == 0).then_some((a, a | bit)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Plane;
    use glam::DVec3;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_clipped_box_loses_no_kept_point(
            n in [-1.0f64..1.0, -1.0..1.0, -1.0..1.0],
            at in [-4.0f64..4.0, -4.0..4.0, -4.0..4.0],
            t in [0.0f64..=1.0, 0.0..=1.0, 0.0..=1.0],
        ) {
            let bounds = Aabb::new(DVec3::new(-3.0, -2.0, -1.0), DVec3::new(3.0, 2.5, 4.0));
            let Some(plane) = Plane::through(at.into(), n.into()) else { return Ok(()) };
            let p = bounds.min + bounds.size() * DVec3::from(t);
            let clipped = clip(&bounds, &FramePlane::from(&plane));
            if plane.distance(p) <= 0.0 {
                prop_assert!(clipped.contains(p), "{p} of {clipped:?}");
            }
        }
    }

    #[test]
    fn a_clip_is_tight() {
        let bounds = Aabb::new(DVec3::ZERO, DVec3::ONE);
        let plane = Plane::through(DVec3::splat(0.25), DVec3::ONE).unwrap();
        let clipped = clip(&bounds, &FramePlane::from(&plane));
        assert!((clipped.max - DVec3::splat(0.75)).length() < 1e-9, "{clipped:?}");
        let axis = Plane::through(DVec3::X * 0.5, -DVec3::X).unwrap();
        assert_eq!(clip(&Aabb::ALL, &FramePlane::from(&axis)).min.x, 0.5);
    }
}
