//! A plan as the structures that shaders read.

use glam::{DAffine3, DMat3, DVec3};

use super::depths::DepthScale;
use super::pages::{PagedTarget, Texels, texture_map};
use crate::interface::{
    BoxData, FrameData, MAX_VERTICES, MODE_ADDITIVE, MODE_AVERAGE, MODE_COMPOSITE, MODE_MINIP, MODE_MIP, MODE_XRAY,
    MovingVertexData, SliceData, TEXELS_COLORS, TEXELS_MIXED, TEXELS_VALUES,
};
use crate::projection::{Camera, FrameSpec, Lens, Mode, Shading, SlicePlan};
use crate::surface::SurfaceView;

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

/// The number of the texels' kind in the shaders.
pub fn texels_constant(texels: Texels) -> u32 {
    match texels {
        Texels::Values => TEXELS_VALUES,
        Texels::Mixed => TEXELS_MIXED,
        Texels::Colors => TEXELS_COLORS,
    }
}

/// What is the same for all that is seen in `view` and placed by `eye_from_model`, lit by `shading`.
pub fn frame_data(
    view: &SurfaceView,
    eye_from_model: &DAffine3,
    depths: &DepthScale,
    shading: Option<&Shading>,
) -> FrameData {
    let row = |a: usize| vec4(eye_from_model.matrix3.row(a), eye_from_model.translation[a]);
    let [near, far] = view.cue_mm;
    let span = (far - near).max(f64::MIN_POSITIVE);
    let mut data = FrameData {
        eye_from_model: [row(0), row(1), row(2)],
        lens: lens(view.camera, depths),
        cue: [near as f32, span.recip() as f32, view.settings.depth_cue.strength, 0.0],
        ..bytemuck::Zeroable::zeroed()
    };
    if let Some(shading) = shading {
        light(shading, &view.camera.eye_from_world.matrix3, &mut data);
    }
    data
}

fn vec4(v: DVec3, w: f64) -> [f32; 4] {
    v.extend(w).as_vec4().to_array()
}

fn lens(camera: &Camera, depths: &DepthScale) -> [f32; 4] {
    let pixels = match camera.lens {
        Lens::Orthographic { pixels_per_mm } => pixels_per_mm,
        Lens::Perspective { focal_px, .. } => focal_px,
    };
    let [width, height] = camera.size.map(f64::from);
    [
        2.0 * pixels / width,
        2.0 * pixels / height,
        depths.factor,
        depths.summand,
    ]
    .map(|number| number as f32)
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
            let slot = paged.slots[b.visible.block as usize];
            let map = texture_map(&blocks[b.visible.block as usize], slot, &paged.pages[slot.page]);
            let bounds = b.visible.bounds();
            BoxData {
                origin: vec4(bounds.min, b.nearest_mm),
                size: vec4(bounds.size(), 0.0),
                texture_origin: vec4(map.origin + map.step * bounds.min, 0.0),
                texture_size: vec4(map.step * bounds.size(), 0.0),
            }
        })
        .collect()
}

/// The moving vertices of a plan's templates, [`MAX_VERTICES`] a segment: a polygon of fewer repeats its last one.
pub fn vertices(plan: &SlicePlan) -> Vec<MovingVertexData> {
    let segments = plan.templates.iter().flat_map(|template| &template.segments);
    segments
        .flat_map(|segment| {
            (0..MAX_VERTICES as usize).map(|n| {
                let v = segment.vertices[n.min(segment.vertices.len() - 1)];
                MovingVertexData {
                    base: vec4(v.base, 0.0),
                    slope: vec4(v.slope, 0.0),
                }
            })
        })
        .collect()
}

/// Slices whose vertices are numbered from one base: every device takes numbers of 24 bits.
pub const BASE_SLICES: usize = 1 << 20;

const _: () = assert!(BASE_SLICES * (MAX_VERTICES as usize) < 1 << 24);

/// The triangles of a plan's slices, a fan for each: the vertices of all, of which each slice has [`MAX_VERTICES`] numbers from the
/// base of [`BASE_SLICES`] on, and where those of each slice begin and the last ones end.
pub fn fans(plan: &SlicePlan) -> (Vec<u32>, Vec<u32>) {
    let mut indices = Vec::with_capacity(3 * (MAX_VERTICES as usize - 2) * plan.slices.len());
    let mut begins = vec![0];
    for (n, slice) in plan.slices.iter().enumerate() {
        let template = &plan.templates[plan.boxes[slice.slice_box as usize].template as usize];
        let corners = template.segment(slice.t_mm).map_or(0, |segment| segment.vertices.len()) as u32;
        let first = (n % BASE_SLICES) as u32 * MAX_VERTICES;
        indices.extend((2..corners).flat_map(|corner| [first, first + corner - 1, first + corner]));
        begins.push(indices.len() as u32);
    }
    (indices, begins)
}

/// The slices of a plan.
pub fn slices(plan: &SlicePlan) -> Vec<SliceData> {
    let counts = plan.templates.iter().map(|template| template.segments.len());
    let first_segments: Vec<usize> = counts
        .scan(0, |next, count| Some(std::mem::replace(next, *next + count)))
        .collect();
    plan.slices
        .iter()
        .map(|slice| {
            let template = plan.boxes[slice.slice_box as usize].template as usize;
            let segment = first_segments[template] + plan.templates[template].segment_index(slice.t_mm);
            SliceData {
                box_index: slice.slice_box,
                t_mm: slice.t_mm as f32,
                first_vertex: segment as u32 * MAX_VERTICES,
            }
        })
        .collect()
}
