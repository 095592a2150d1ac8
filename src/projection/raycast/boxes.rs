//! What is cast of a target: the part of each block in which something shows, from front to back.

use glam::{DVec2, DVec3};

use super::shown::ShownBlock;
use crate::math::{Viewpoint, affine};
use crate::projection::{Camera, FrameSpec, eye_from_lattice};
use crate::target::{Cube, OctreeNode, Target, octants_back_to_front};

/// A box of a block and where it is seen.
pub struct CastBox<'a> {
    /// Index of the block.
    pub block: usize,
    /// What shows of it.
    pub shown: &'a ShownBlock,
    /// The columns and rows of the frame that it may cover.
    pub pixels: [std::ops::Range<u32>; 2],
}

/// The boxes of a frame, from front to back.
pub fn front_to_back<'a>(spec: &FrameSpec, shown: &'a [Option<ShownBlock>]) -> Vec<CastBox<'a>> {
    let lattice = &spec.target.lattice;
    let viewpoint = spec
        .camera
        .viewpoint()
        .transformed(&lattice.world_from_lattice.inverse());
    let eye_from_lattice = eye_from_lattice(lattice, spec.camera);
    let mut blocks = Vec::new();
    visit(spec.target, 0, spec.target.octree.root, viewpoint, &mut blocks);
    let cast = |&block: &u32| {
        let block = block as usize;
        let shown = shown[block].as_ref()?;
        let corners = shown.bounds.corners().map(|c| affine::point(&eye_from_lattice, c));
        let pixels = covered(spec.camera, &corners)?;
        Some(CastBox { block, shown, pixels })
    };
    blocks.iter().filter_map(cast).collect()
}

/// Adds the blocks of a node from front to back.
fn visit(target: &Target, node: usize, cube: Cube, viewpoint: Viewpoint, found: &mut Vec<u32>) {
    match target.octree.nodes[node] {
        OctreeNode::Empty => {}
        OctreeNode::Block(block) => found.push(block),
        OctreeNode::Split(first) => {
            for octant in octants_back_to_front(&cube, viewpoint).into_iter().rev() {
                visit(target, first as usize + octant, cube.octant(octant), viewpoint, found);
            }
        }
    }
}

/// The columns and rows that a box with these corners in the eye frame may cover, if there are any.
fn covered(camera: &Camera, corners: &[DVec3; 8]) -> Option<[std::ops::Range<u32>; 2]> {
    if corners.iter().all(|c| c.z < camera.near_mm()) {
        return None;
    }
    if corners.iter().any(|c| c.z < camera.near_mm()) {
        return Some(camera.size.map(|n| 0..n));
    }
    let places = corners.map(|c| camera.project(c));
    let [least, greatest] = [DVec2::min, DVec2::max].map(|end| places.into_iter().reduce(end).unwrap_or_default());
    // A pixel more on each side, for rounding.
    let range = |axis: usize| {
        let begin = (least[axis] - 1.0).floor() as u32;
        let end = (greatest[axis] + 1.0).ceil() as u32;
        begin..end.min(camera.size[axis])
    };
    let pixels = [range(0), range(1)];
    pixels.iter().all(|range| !range.is_empty()).then_some(pixels)
}
