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
use crate::math::{Viewpoint, affine};
use crate::target::Lattice;

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
        Planner::new(&visibility.target.lattice, camera, planes).plan(visibility)
    }

    /// Adds a plan of the same frame whose slices all lie behind those of this one, in a band of its own that begins at `face_mm`.
    pub fn append(&mut self, face_mm: f64, mut behind: Self) {
        let (boxes, templates) = (self.boxes.len() as u32, self.templates.len() as u32);
        behind.boxes.iter_mut().for_each(|b| b.template += templates);
        behind.slices.iter_mut().for_each(|slice| slice.slice_box += boxes);
        self.templates.append(&mut behind.templates);
        self.boxes.append(&mut behind.boxes);
        self.slices.append(&mut behind.slices);
        self.band_faces_mm.push(face_mm);
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

/// What plans of one view have in common.
pub struct Planner<'a> {
    camera: &'a Camera,
    /// From lattice coordinates to the eye frame.
    eye_from_lattice: DAffine3,
    planes: Planes,
    viewpoint: Viewpoint,
    /// The depths of the lattice, millimetres.
    depths_mm: [f64; 2],
    /// Of the boxes so far, by their extent.
    templates: HashMap<[usize; 3], Template>,
}

impl<'a> Planner<'a> {
    /// For boxes of `lattice` that `camera` sees on `planes`.
    pub fn new(lattice: &Lattice, camera: &'a Camera, planes: Planes) -> Self {
        let eye_from_lattice = eye_from_lattice(lattice, camera);
        let depths = lattice.bounds().transformed(&eye_from_lattice);
        let lattice_from_world = lattice.world_from_lattice.inverse();
        Self {
            camera,
            eye_from_lattice,
            planes,
            viewpoint: camera.viewpoint().transformed(&lattice_from_world),
            depths_mm: [depths.min.z, depths.max.z],
            templates: HashMap::new(),
        }
    }

    /// A plan without slices.
    pub fn empty(&self) -> SlicePlan {
        SlicePlan {
            eye_from_lattice: self.eye_from_lattice,
            planes: self.planes,
            cue_mm: self.depths_mm,
            templates: Vec::new(),
            boxes: Vec::new(),
            slices: Vec::new(),
            band_faces_mm: Vec::new(),
        }
    }

    /// Plans what `visibility` shows, between the depths that remain if it says which do.
    pub fn plan(&mut self, visibility: &Visibility) -> SlicePlan {
        let all = [f64::NEG_INFINITY, f64::INFINITY];
        let depths_mm = visibility.remaining.map_or(all, |remaining| remaining.depths_mm);
        let mut plan = self.empty();
        let mut template_ids = HashMap::new();
        for visible in visibility.boxes_back_to_front(self.viewpoint) {
            self.add(visible, depths_mm, &mut template_ids, &mut plan);
        }
        plan
    }

    fn add(
        &mut self,
        visible: VisibleBox,
        [from_mm, before_mm]: [f64; 2],
        template_ids: &mut HashMap<[usize; 3], u32>,
        plan: &mut SlicePlan,
    ) {
        let corners = visible
            .bounds()
            .corners()
            .map(|c| affine::point(&self.eye_from_lattice, c));
        let depths = corners.map(|c| c.z);
        let nearest_mm = depths.iter().copied().fold(f64::INFINITY, f64::min);
        let farthest_mm = depths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let visible_from = self.camera.near_mm().max(nearest_mm);
        let planes = self
            .planes
            .between(visible_from.max(from_mm), farthest_mm.min(before_mm));
        let seen_px = self.seen_px(&corners);
        if planes.is_empty() || seen_px[0].cmpgt(seen_px[1]).any() {
            return;
        }
        let template = *template_ids.entry(visible.extent).or_insert_with(|| {
            plan.templates.push(self.template(visible.extent));
            plan.templates.len() as u32 - 1
        });
        let voxels: f64 = visible.extent.iter().map(|&n| n as f64).product();
        let volume_mm3 = voxels * self.eye_from_lattice.matrix3.determinant().abs();
        let area_px = volume_mm3 / (farthest_mm - nearest_mm) * self.camera.pixels_per_mm(visible_from).powi(2);
        let [width, height] = self.camera.size.map(f64::from);
        let slice_box = plan.boxes.len() as u32;
        plan.slices.extend(planes.rev().map(|k| Slice {
            slice_box,
            t_mm: self.planes.depth(k) - nearest_mm,
        }));
        plan.boxes.push(SliceBox {
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

    fn template(&mut self, extent: [usize; 3]) -> Template {
        let of_extent = || {
            let unit = DMat3::from_diagonal(DVec3::from_array(extent.map(|n| n as f64)));
            Template::new(&(self.eye_from_lattice.matrix3 * unit))
        };
        self.templates.entry(extent).or_insert_with(of_extent).clone()
    }
}
