//! What is cast of a target: the boxes inside its blocks in which something shows, from front to back.

use glam::DVec2;

use super::template::Template;
use super::voxels::CastTarget;
use crate::math::affine;
use crate::projection::{
    Camera, DrawCost, FrameSpec, Planes, ShownCells, Visibility, VisibleBox, VisibleValues, eye_from_lattice,
};
use crate::target::CELL;

/// A box and where it is seen.
pub struct CastBox {
    /// Index of the block that holds its voxels.
    pub block: usize,
    /// Its template.
    pub template: Template,
    /// The columns and rows of the frame that it may cover.
    pub pixels: [std::ops::Range<u32>; 2],
}

/// The boxes of a frame that is sampled at `planes`, from front to back.
pub fn front_to_back(spec: &FrameSpec, target: &CastTarget, planes: &Planes) -> Vec<CastBox> {
    let visibility = Visibility {
        target: spec.target,
        shown: &ShownCells::new(&target.cells, &VisibleValues::in_frame(spec)),
        min_cube: 2 * CELL,
        remaining: None,
        cost: DrawCost::of_rays(&spec.target.lattice, spec.camera, planes),
    };
    let lattice = &spec.target.lattice;
    let lattice_from_world = lattice.world_from_lattice.inverse();
    let viewpoint = spec.camera.viewpoint().transformed(&lattice_from_world);
    let eye_from_lattice = eye_from_lattice(lattice, spec.camera);
    let cast = |visible: &VisibleBox| {
        let bounds = visible.bounds();
        let corners = bounds.corners().map(|c| affine::point(&eye_from_lattice, c));
        let pixels = covered(spec.camera, &corners)?;
        Some(CastBox {
            block: visible.block as usize,
            template: Template {
                low: bounds.min.to_array(),
                high: bounds.max.to_array(),
            },
            pixels,
        })
    };
    visibility
        .boxes_back_to_front(viewpoint)
        .iter()
        .rev()
        .filter_map(cast)
        .collect()
}

/// The columns and rows that a box with these corners in the eye frame may cover, if there are any.
fn covered(camera: &Camera, corners: &[glam::DVec3; 8]) -> Option<[std::ops::Range<u32>; 2]> {
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
