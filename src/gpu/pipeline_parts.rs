//! What a graphics pipeline is made of, as data.

use ash::vk;

use super::BindingKind;

/// How a fragment meets what is already in the target. Colours are premultiplied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Blend {
    /// `source + (1 − source alpha) · target`, in all four components.
    Over,
    /// `source + target`.
    Add,
    /// The larger of both, component by component.
    Max,
    /// The smaller of both, component by component.
    Min,
    /// `target + (1 − target alpha) · source`, in all four components.
    Under,
}

/// How a fragment meets the depth that is held for its pixel; smaller is nearer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// It is drawn anyhow, and what is held stays.
    Ignore,
    /// It is drawn where it is nearer.
    Test,
    /// It is drawn where it is nearer, and its depth is held from then on.
    TestAndHold,
}

/// What vertices form.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Topology {
    /// Each three a triangle.
    #[default]
    Triangles,
    /// Each with the two before it a triangle.
    TriangleStrip,
    /// Each two a line.
    Lines,
}

/// When a vertex buffer moves on to its next element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepRate {
    /// With each vertex.
    Vertex,
    /// With each instance.
    Instance,
}

/// One input of the vertex shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attribute {
    /// Its `layout(location = …)`.
    pub location: u32,
    /// Its format in the buffer.
    pub format: vk::Format,
    /// Its place in the element, bytes.
    pub offset: u32,
}

/// The one vertex buffer of a pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VertexInput<'a> {
    /// Bytes from one element to the next.
    pub stride: u32,
    /// When it moves on.
    pub rate: StepRate,
    /// What an element consists of.
    pub attributes: &'a [Attribute],
}

/// All that a pipeline is.
#[derive(Clone, Copy, Debug, Default)]
pub struct PipelineDesc<'a> {
    /// Its name in messages.
    pub label: &'a str,
    /// The vertex shader, entry point `main`. Vulkan trusts that SPIR-V is valid, so take what a compiler made.
    pub vertex_spirv: &'a [u32],
    /// The fragment shader, entry point `main`; likewise.
    pub fragment_spirv: &'a [u32],
    /// Specialization constants of both shaders: id and the bits of a 32-bit value (a `bool` is 0 or 1).
    pub specialization: &'a [(u32, u32)],
    /// The targets' formats, and how to blend into each (`None`: replace).
    pub color_targets: &'a [(vk::Format, Option<Blend>)],
    /// How it uses the depths of its pass (`None`: the pass has none).
    pub depth: Option<Depth>,
    /// The bindings 0, 1, 2, … of set 0.
    pub bindings: &'a [BindingKind],
    /// Bytes of push constants, seen by both shaders; a multiple of 4.
    pub push_bytes: u32,
    /// What the vertices form.
    pub topology: Topology,
    /// The vertex buffer, if there is one.
    pub vertex_input: Option<VertexInput<'a>>,
}

impl Topology {
    pub(super) fn raw(self) -> vk::PrimitiveTopology {
        match self {
            Self::Triangles => vk::PrimitiveTopology::TRIANGLE_LIST,
            Self::TriangleStrip => vk::PrimitiveTopology::TRIANGLE_STRIP,
            Self::Lines => vk::PrimitiveTopology::LINE_LIST,
        }
    }
}

impl StepRate {
    pub(super) fn raw(self) -> vk::VertexInputRate {
        match self {
            Self::Vertex => vk::VertexInputRate::VERTEX,
            Self::Instance => vk::VertexInputRate::INSTANCE,
        }
    }
}

/// The fixed-function state of `blend`.
pub(super) fn blend_state(blend: Option<Blend>) -> vk::PipelineColorBlendAttachmentState {
    use vk::{BlendFactor as Factor, BlendOp as Op};
    let state = vk::PipelineColorBlendAttachmentState::default().color_write_mask(vk::ColorComponentFlags::RGBA);
    let Some(blend) = blend else { return state };
    let (source_factor, target_factor, op) = match blend {
        Blend::Over => (Factor::ONE, Factor::ONE_MINUS_SRC_ALPHA, Op::ADD),
        Blend::Under => (Factor::ONE_MINUS_DST_ALPHA, Factor::ONE, Op::ADD),
        Blend::Add => (Factor::ONE, Factor::ONE, Op::ADD),
        Blend::Max => (Factor::ONE, Factor::ONE, Op::MAX),
        Blend::Min => (Factor::ONE, Factor::ONE, Op::MIN),
    };
    let state = state.blend_enable(true).color_blend_op(op).alpha_blend_op(op);
    let state = state
        .src_color_blend_factor(source_factor)
        .src_alpha_blend_factor(source_factor);
    state
        .dst_color_blend_factor(target_factor)
        .dst_alpha_blend_factor(target_factor)
}

/// The fixed-function state of `depth`.
pub(super) fn depth_state(depth: Option<Depth>) -> vk::PipelineDepthStencilStateCreateInfo<'static> {
    vk::PipelineDepthStencilStateCreateInfo::default()
        .depth_test_enable(matches!(depth, Some(Depth::Test | Depth::TestAndHold)))
        .depth_write_enable(depth == Some(Depth::TestAndHold))
        .depth_compare_op(vk::CompareOp::LESS)
}
