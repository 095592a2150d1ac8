//! A plan as the structures that shaders read.

use glam::{DMat3, DVec3};

use super::pages::{PagedTarget, texture_map};
use crate::interface::{
    BoxData, FrameData, MAX_SEGMENTS, MAX_VERTICES, MODE_ADDITIVE, MODE_AVERAGE, MODE_COMPOSITE, MODE_MINIP, MODE_MIP,
    MODE_XRAY, MovingVertexData, TEMPLATE_VERTICES, TemplateData,
};
use crate::projection::{FrameSpec, Lens, Mode, Shading, SlicePlan, Template};

/// One slice, an instance of its box's template, as the vertex shader's input.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct SliceData {
    /// Index of its box.
    pub box_index: u32,
    /// Depth behind the box's nearest corner, millimetres.
    pub t_mm: f32,
}

/// The mode's number in the shaders.
pub fn mode_constant(mode: Mode) -> u32 {
    match mode {
        Mode::Composite => MODE_COMPOSITE,
        Mode::Mip => MODE_MIP,
        Mode::MinIp => MODE_MINIP,
        Mode::Average => MODE_AVERAGE,
        Mode::Additive => MODE_ADDITIVE,
        Mode::XRay => MODE_XRAY,
    }
}

/// What is the same for all slices.
pub fn frame_data(spec: &FrameSpec, plan: &SlicePlan) -> FrameData {
    let map = &plan.eye_from_lattice;
    let row = |a: usize| vec4(map.matrix3.row(a), map.translation[a]);
    let depth = spec.target.lattice.bounds().transformed(map);
    let span = (depth.max.z - depth.min.z).max(f64::MIN_POSITIVE);
    let mut data = FrameData {
        eye_from_lattice: [row(0), row(1), row(2)],
        lens: lens(spec),
        cue: [
            depth.min.z as f32,
            span.recip() as f32,
            spec.settings.depth_cue.strength,
            0.0,
        ],
        ..bytemuck::Zeroable::zeroed()
    };
    if let Some(shading) = spec.shading() {
        light(shading, &spec.camera.eye_from_world.matrix3, &mut data);
    }
    data
}

fn vec4(v: DVec3, w: f64) -> [f32; 4] {
    v.extend(w).as_vec4().to_array()
}

fn lens(spec: &FrameSpec) -> [f32; 4] {
    let pixels = match spec.camera.lens {
        Lens::Orthographic { pixels_per_mm } => pixels_per_mm,
        Lens::Perspective { focal_px, .. } => focal_px,
    };
    let [width, height] = spec.camera.size.map(f64::from);
    [(2.0 * pixels / width) as f32, (2.0 * pixels / height) as f32, 0.0, 0.0]
}

/// Normals are stored in the world frame, so lights go there once instead of every normal to the eye.
fn light(shading: &Shading, eye_from_world: &DMat3, data: &mut FrameData) {
    let world_from_eye = eye_from_world.transpose();
    for (i, light) in shading.lights.iter().take(Shading::MAX_LIGHTS).enumerate() {
        let half_way = (light.towards - DVec3::Z).normalize_or_zero();
        data.lights[i] = vec4(world_from_eye * light.towards, f64::from(light.intensity));
        data.half_ways[i] = vec4(world_from_eye * half_way, 0.0);
    }
    let m = &shading.material;
    data.material = [m.ambient, m.diffuse, m.specular, 0.0];
}

/// The boxes of a plan, with their place in the pages.
pub fn boxes(spec: &FrameSpec, plan: &SlicePlan, paged: &PagedTarget) -> Vec<BoxData> {
    let blocks = &spec.target.blocks;
    plan.boxes
        .iter()
        .map(|b| {
            let slot = paged.slots[b.block as usize];
            let map = texture_map(&blocks[b.block as usize], slot, &paged.pages[slot.page]);
            let bounds = b.cube.bounds(b.extent);
            BoxData {
                origin: vec4(bounds.min, b.nearest_mm),
                size: vec4(bounds.size(), f64::from(b.template)),
                texture_origin: vec4(map.origin + map.step * bounds.min, 0.0),
                texture_size: vec4(map.step * bounds.size(), 0.0),
            }
        })
        .collect()
}

/// The templates of a plan.
pub fn templates(plan: &SlicePlan) -> Vec<TemplateData> {
    plan.templates.iter().map(template).collect()
}

/// Missing segments end at infinity; a polygon of fewer vertices repeats its last one.
fn template(template: &Template) -> TemplateData {
    let mut data = TemplateData {
        ends: [[f32::INFINITY; 4]; 2],
        vertices: [bytemuck::Zeroable::zeroed(); TEMPLATE_VERTICES as usize],
    };
    let last = template.segments.len() - 1;
    for s in 0..MAX_SEGMENTS as usize {
        let segment = &template.segments[s.min(last)];
        if s < last {
            data.ends[s / 4][s % 4] = segment.end_mm as f32;
        }
        for n in 0..MAX_VERTICES as usize {
            let v = segment.vertices[n.min(segment.vertices.len() - 1)];
            data.vertices[s * MAX_VERTICES as usize + n] = MovingVertexData {
                base: vec4(v.base, 0.0),
                slope: vec4(v.slope, 0.0),
            };
        }
    }
    data
}

/// The slices of a plan.
pub fn slices(plan: &SlicePlan) -> Vec<SliceData> {
    plan.slices
        .iter()
        .map(|s| SliceData {
            box_index: s.slice_box,
            t_mm: s.t_mm as f32,
        })
        .collect()
}
