//! The plan of a sliced frame: which polygons are drawn, in which order (VCSG §3.3.2).
//!
//! *Theory.* Blocks are visited from back to front, and each is drawn as the polygons in which the Z-planes cut it.
//! *Changes from the paper.* Only the visible boxes of a block are drawn, the planes are shared by all of them
//! ([`Planes`](super::Planes)), and templates are exact ([`Template`](super::Template)).
//! *Practice.* The plan is plain data: a list of boxes with their template, and a list of slices. The device only carries it
//! out, so everything up to the last step is tested without one.

use std::collections::HashMap;

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::{Camera, Planes, Template, Visibility, VisibleBox, eye_from_lattice};
use crate::math::affine;

/// A drawn box.
#[derive(Clone, Debug, PartialEq)]
pub struct SliceBox {
    /// Where it is.
    pub visible: VisibleBox,
    /// Index of its template.
    pub template: u32,
    /// Depth of its nearest corner, millimetres.
    pub nearest_mm: f64,
    /// Fragments of a slice of it, about.
    pub fragments: f64,
    /// The part of the frame that it may be seen in: the least and the greatest column and row, in pixels.
    pub seen_px: [DVec2; 2],
}

/// One polygon: a plane through a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slice {
    /// Index of the box.
    pub slice_box: u32,
    /// Depth of the plane behind the box's nearest corner, millimetres.
    pub t_mm: f64,
}

/// Everything that a sliced frame draws: from back to front, or from the nearest on if it is cut into bands.
#[derive(Clone, Debug, PartialEq)]
pub struct SlicePlan {
    /// From lattice coordinates to the eye frame.
    pub eye_from_lattice: DAffine3,
    /// The sampling planes.
    pub planes: Planes,
    /// The depths that a depth cue spans, millimetres.
    pub cue_mm: [f64; 2],
    /// One template for each distinct shape of box.
    pub templates: Vec<Template>,
    /// The boxes, back to front.
    pub boxes: Vec<SliceBox>,
    /// The slices of all boxes in drawing order: box by box, of each box the farthest plane first; or in bands, all turned round.
    pub slices: Vec<Slice>,
    /// The depths at which bands meet, rising, millimetres; none if all slices are one band. See [`bands`](super::bands).
    pub band_faces_mm: Vec<f64>,
}

impl SlicePlan {
    /// Plans the frame that `camera` sees of what `visibility` shows.
    pub fn new(visibility: &Visibility, camera: &Camera, planes: Planes) -> Self {
        let lattice = &visibility.target.lattice;
        let lattice_from_world = lattice.world_from_lattice.inverse();
        let eye_from_lattice = eye_from_lattice(lattice, camera);
        let depths = lattice.bounds().transformed(&eye_from_lattice);
        let viewpoint = camera.viewpoint().transformed(&lattice_from_world);
        let mut planner = Planner {
            plan: Self {
                eye_from_lattice,
                planes,
                cue_mm: [depths.min.z, depths.max.z],
                templates: Vec::new(),
                boxes: Vec::new(),
                slices: Vec::new(),
                band_faces_mm: Vec::new(),
            },
            template_ids: HashMap::new(),
            camera,
        };
        for visible in visibility.boxes_back_to_front(viewpoint) {
            planner.add(visible);
        }
        planner.plan
    }

    /// Whether it is in several bands.
    pub fn is_cut(&self) -> bool {
        !self.band_faces_mm.is_empty()
    }

    /// The depth of a slice, millimetres.
    pub fn depth_mm(&self, slice: &Slice) -> f64 {
        self.boxes[slice.slice_box as usize].nearest_mm + slice.t_mm
    }

    /// The band that a slice is in, counted from the nearest.
    pub fn band(&self, slice: &Slice) -> usize {
        let depth = self.depth_mm(slice);
        self.band_faces_mm.partition_point(|face| *face < depth)
    }

    /// About how many fragments a slice has.
    pub fn fragments(&self, slice: &Slice) -> f64 {
        self.boxes[slice.slice_box as usize].fragments
    }

    /// The vertices of a slice in lattice coordinates, in order round the polygon.
    pub fn polygon(&self, slice: &Slice) -> Vec<DVec3> {
        let b = &self.boxes[slice.slice_box as usize];
        let bounds = b.visible.bounds();
        let template = &self.templates[b.template as usize];
        let vertices = template.segment(slice.t_mm).map_or(&[][..], |s| &s.vertices);
        vertices
            .iter()
            .map(|v| bounds.min + bounds.size() * v.at(slice.t_mm))
            .collect()
    }
}

struct Planner<'a> {
    plan: SlicePlan,
    template_ids: HashMap<[usize; 3], u32>,
    camera: &'a Camera,
}

impl Planner<'_> {
    fn add(&mut self, visible: VisibleBox) {
        let eye_from_lattice = &self.plan.eye_from_lattice;
        let extent = visible.extent;
        let corners = visible.bounds().corners().map(|c| affine::point(eye_from_lattice, c));
        let depths = corners.map(|c| c.z);
        let nearest_mm = depths.iter().copied().fold(f64::INFINITY, f64::min);
        let farthest_mm = depths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let visible_from = self.camera.near_mm().max(nearest_mm);
        let planes = self.plan.planes.between(visible_from, farthest_mm);
        let seen_px = self.seen_px(&corners);
        if planes.is_empty() || seen_px[0].cmpgt(seen_px[1]).any() {
            return;
        }
        let template = self.template(extent);
        let voxels: f64 = extent.iter().map(|&n| n as f64).product();
        let volume_mm3 = voxels * self.plan.eye_from_lattice.matrix3.determinant().abs();
        let area_px = volume_mm3 / (farthest_mm - nearest_mm) * self.camera.pixels_per_mm(visible_from).powi(2);
        let [width, height] = self.camera.size.map(f64::from);
        let slice_box = self.plan.boxes.len() as u32;
        let global = self.plan.planes;
        self.plan.slices.extend(planes.rev().map(|k| Slice {
            slice_box,
            t_mm: global.depth(k) - nearest_mm,
        }));
        self.plan.boxes.push(SliceBox {
            visible,
            template,
            nearest_mm,
            fragments: area_px.min(width * height),
            seen_px,
        });
    }

    /// The part of the frame in which a box with these eye-space corners may be seen; nothing lies between ends that are crossed.
    fn seen_px(&self, corners: &[DVec3; 8]) -> [DVec2; 2] {
        let size = DVec2::from(self.camera.size.map(f64::from));
        if corners.iter().any(|c| c.z < self.camera.near_mm()) {
            return [DVec2::ZERO, size];
        }
        let places = corners.map(|c| self.camera.project(c));
        let [least, greatest] = [DVec2::min, DVec2::max].map(|end| places.into_iter().reduce(end).unwrap_or_default());
        [least.max(DVec2::ZERO), greatest.min(size)]
    }

    fn template(&mut self, extent: [usize; 3]) -> u32 {
        let plan = &mut self.plan;
        *self.template_ids.entry(extent).or_insert_with(|| {
            let size = DVec3::from_array(extent.map(|n| n as f64));
            let unit = DMat3::from_diagonal(size);
            plan.templates
                .push(Template::new(&(plan.eye_from_lattice.matrix3 * unit)));
            plan.templates.len() as u32 - 1
        })
    }
}
