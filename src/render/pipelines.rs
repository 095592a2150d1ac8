//! The pipelines of slices, one for each way of drawing them.

use std::collections::HashMap;
use std::sync::Arc;

use super::frame::{self, SliceData};
use super::slices::TARGET_FORMAT;
use crate::gpu::{
    Attribute, BindingKind, Blend, Device, Format, GpuError, GraphicsPipeline, PipelineDesc, StepRate, Topology,
    VertexInput,
};
use crate::projection::composite::Blending;
use crate::projection::{FrameSpec, Lens};
use crate::shaders::{SLICES_FRAG, SLICES_VERT};

/// What distinguishes one pipeline from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Variant {
    mode: u32,
    mixed: bool,
    lights: u32,
    shininess_log2: u32,
    perspective: bool,
}

/// The pipelines made so far.
#[derive(Default)]
pub struct Pipelines {
    made: HashMap<Variant, Arc<GraphicsPipeline>>,
}

impl Pipelines {
    /// The pipeline that draws slices of `mixed` or covered pages for `spec`.
    pub fn get(
        &mut self,
        device: &Arc<Device>,
        spec: &FrameSpec,
        mixed: bool,
    ) -> Result<Arc<GraphicsPipeline>, GpuError> {
        let variant = variant(spec, mixed);
        if let Some(pipeline) = self.made.get(&variant) {
            return Ok(Arc::clone(pipeline));
        }
        let pipeline = create_pipeline(device, &variant, spec.settings.mode.blending())?;
        self.made.insert(variant, Arc::clone(&pipeline));
        Ok(pipeline)
    }
}

fn variant(spec: &FrameSpec, mixed: bool) -> Variant {
    let shading = spec.shading();
    Variant {
        mode: frame::mode_constant(spec.settings.mode),
        mixed,
        lights: shading.map_or(0, |s| s.lights.len() as u32),
        shininess_log2: shading.map_or(0, |s| s.material.shininess_log2),
        perspective: matches!(spec.camera.lens, Lens::Perspective { .. }),
    }
}

const BINDINGS: [BindingKind; 6] = [
    BindingKind::SampledImage,
    BindingKind::SampledImage,
    BindingKind::SampledImage,
    BindingKind::Uniform,
    BindingKind::Storage,
    BindingKind::Storage,
];

fn create_pipeline(
    device: &Arc<Device>,
    variant: &Variant,
    blending: Blending,
) -> Result<Arc<GraphicsPipeline>, GpuError> {
    let blend = match blending {
        Blending::Over => Blend::Over,
        Blending::Add => Blend::Add,
        Blending::Max => Blend::Max,
    };
    GraphicsPipeline::new(
        device,
        &PipelineDesc {
            label: "slices",
            vertex_spirv: SLICES_VERT,
            fragment_spirv: SLICES_FRAG,
            specialization: &[
                (0, variant.mode),
                (1, u32::from(variant.mixed)),
                (2, variant.lights),
                (3, variant.shininess_log2),
                (4, u32::from(variant.perspective)),
            ],
            color_targets: &[(TARGET_FORMAT, Some(blend))],
            bindings: &BINDINGS,
            push_bytes: 0,
            topology: Topology::Triangles,
            vertex_input: Some(VertexInput {
                stride: size_of::<SliceData>() as u32,
                rate: StepRate::Instance,
                attributes: &[
                    Attribute {
                        location: 0,
                        format: Format::R32_UINT,
                        offset: 0,
                    },
                    Attribute {
                        location: 1,
                        format: Format::R32_SFLOAT,
                        offset: 4,
                    },
                ],
            }),
        },
    )
}
