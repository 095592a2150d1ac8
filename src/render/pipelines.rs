//! The pipelines of slices, one for each way of drawing them.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::Arc;

use super::frame;
use super::layers::Meeting;
use super::mesh_pieces::VERTEX_INPUT;
use super::pages::Texels;
use super::slices::TARGET_FORMAT;
use crate::gpu::{BindingKind, Depth, Device, GpuError, GraphicsPipeline, PipelineDesc, Topology};
use crate::interface::{MeshData, RectData};
use crate::projection::{FrameSpec, Lens};
use crate::shaders::{CLOSE_FRAG, CLOSE_VERT, MESH_FRAG, MESH_VERT, OPEN_FRAG, SLICES_FRAG, SLICES_VERT};

/// What distinguishes one pipeline from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Variant {
    mode: u32,
    texels: Texels,
    lights: u32,
    shininess_log2: u32,
    perspective: bool,
    meeting: Meeting,
}

/// What distinguishes one pipeline of meshes from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MeshVariant {
    /// `MESH_GOURAUD`, `MESH_PHONG` or `MESH_DEPTH`.
    pub shading: u32,
    /// Whether each vertex has a colour of its own.
    pub own_colors: bool,
    /// 0 is unlit.
    pub lights: u32,
    /// See [`Material`](crate::projection::Material).
    pub shininess_log2: u32,
    /// Or parallel rays.
    pub perspective: bool,
}

/// The pipelines made so far.
#[derive(Default)]
pub struct Pipelines {
    slices: HashMap<Variant, Arc<GraphicsPipeline>>,
    meshes: HashMap<MeshVariant, Arc<GraphicsPipeline>>,
    close: Option<Arc<GraphicsPipeline>>,
    open: Option<Arc<GraphicsPipeline>>,
}

impl Pipelines {
    /// The pipeline that draws slices of pages of `texels` for `spec`.
    pub fn slices(
        &mut self,
        device: &Arc<Device>,
        spec: &FrameSpec,
        texels: Texels,
        meeting: Meeting,
    ) -> Result<Arc<GraphicsPipeline>, GpuError> {
        let variant = variant(spec, texels, meeting);
        made(&mut self.slices, variant, || slices_pipeline(device, &variant))
    }

    /// The pipeline that draws meshes as `variant` says.
    pub fn meshes(&mut self, device: &Arc<Device>, variant: MeshVariant) -> Result<Arc<GraphicsPipeline>, GpuError> {
        made(&mut self.meshes, variant, || mesh_pipeline(device, &variant))
    }

    /// The pipeline that closes pixels of a rectangle, with what is accumulated bound.
    pub fn close(&mut self, device: &Arc<Device>) -> Result<Arc<GraphicsPipeline>, GpuError> {
        made_once(&mut self.close, || close_pipeline(device))
    }

    /// The pipeline that tells which tiles are open, with what is accumulated and a number a tile bound.
    pub fn open(&mut self, device: &Arc<Device>) -> Result<Arc<GraphicsPipeline>, GpuError> {
        made_once(&mut self.open, || open_pipeline(device))
    }
}

/// `pipeline`, created if it is the first time.
fn made_once(
    pipeline: &mut Option<Arc<GraphicsPipeline>>,
    create: impl FnOnce() -> Result<Arc<GraphicsPipeline>, GpuError>,
) -> Result<Arc<GraphicsPipeline>, GpuError> {
    if let Some(pipeline) = pipeline {
        return Ok(Arc::clone(pipeline));
    }
    Ok(Arc::clone(pipeline.insert(create()?)))
}

/// The pipeline under `key`, created if it is the first time.
fn made<K: Copy + Eq + Hash>(
    pipelines: &mut HashMap<K, Arc<GraphicsPipeline>>,
    key: K,
    create: impl FnOnce() -> Result<Arc<GraphicsPipeline>, GpuError>,
) -> Result<Arc<GraphicsPipeline>, GpuError> {
    if let Some(pipeline) = pipelines.get(&key) {
        return Ok(Arc::clone(pipeline));
    }
    let pipeline = create()?;
    pipelines.insert(key, Arc::clone(&pipeline));
    Ok(pipeline)
}

fn variant(spec: &FrameSpec, texels: Texels, meeting: Meeting) -> Variant {
    let shading = spec.shading();
    Variant {
        mode: frame::mode_constant(spec.settings.mode),
        texels,
        lights: shading.map_or(0, |s| s.lights.len() as u32),
        shininess_log2: shading.map_or(0, |s| s.material.shininess_log2),
        perspective: matches!(spec.camera.lens, Lens::Perspective { .. }),
        meeting,
    }
}

const BINDINGS: [BindingKind; 7] = [
    BindingKind::SampledImage,
    BindingKind::SampledImage,
    BindingKind::SampledImage,
    BindingKind::Uniform,
    BindingKind::Storage,
    BindingKind::Storage,
    BindingKind::Storage,
];

fn slices_pipeline(device: &Arc<Device>, variant: &Variant) -> Result<Arc<GraphicsPipeline>, GpuError> {
    GraphicsPipeline::new(
        device,
        &PipelineDesc {
            label: "slices",
            vertex_spirv: SLICES_VERT,
            fragment_spirv: SLICES_FRAG,
            specialization: &[
                (0, variant.mode),
                (1, frame::texels_constant(variant.texels)),
                (2, variant.lights),
                (3, variant.shininess_log2),
                (4, u32::from(variant.perspective)),
                (5, variant.lights.max(1)),
            ],
            color_targets: &[(TARGET_FORMAT, Some(variant.meeting.blend))],
            depth: variant.meeting.stops.then_some(Depth::Test),
            bindings: &BINDINGS,
            ..PipelineDesc::default()
        },
    )
}

fn mesh_pipeline(device: &Arc<Device>, variant: &MeshVariant) -> Result<Arc<GraphicsPipeline>, GpuError> {
    GraphicsPipeline::new(
        device,
        &PipelineDesc {
            label: "meshes",
            vertex_spirv: MESH_VERT,
            fragment_spirv: MESH_FRAG,
            specialization: &[
                (0, variant.shading),
                (1, u32::from(variant.own_colors)),
                (2, variant.lights),
                (3, variant.shininess_log2),
                (4, u32::from(variant.perspective)),
            ],
            color_targets: &[(TARGET_FORMAT, None)],
            depth: Some(Depth::TestAndHold),
            bindings: &[BindingKind::Uniform],
            push_bytes: size_of::<MeshData>() as u32,
            vertex_input: Some(VERTEX_INPUT),
            ..PipelineDesc::default()
        },
    )
}

fn close_pipeline(device: &Arc<Device>) -> Result<Arc<GraphicsPipeline>, GpuError> {
    GraphicsPipeline::new(
        device,
        &PipelineDesc {
            label: "close",
            vertex_spirv: CLOSE_VERT,
            fragment_spirv: CLOSE_FRAG,
            depth: Some(Depth::TestAndHold),
            bindings: &[BindingKind::SampledImage],
            push_bytes: size_of::<RectData>() as u32,
            topology: Topology::TriangleStrip,
            ..PipelineDesc::default()
        },
    )
}

fn open_pipeline(device: &Arc<Device>) -> Result<Arc<GraphicsPipeline>, GpuError> {
    GraphicsPipeline::new(
        device,
        &PipelineDesc {
            label: "open tiles",
            vertex_spirv: CLOSE_VERT,
            fragment_spirv: OPEN_FRAG,
            depth: Some(Depth::Ignore),
            bindings: &[BindingKind::SampledImage, BindingKind::WrittenStorage],
            push_bytes: size_of::<RectData>() as u32,
            topology: Topology::TriangleStrip,
            ..PipelineDesc::default()
        },
    )
}
