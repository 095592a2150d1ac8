//! Graphics pipelines.

use std::sync::Arc;

use ash::vk;

use super::bindings::set_layout;
use super::compile::compile;
use super::pipeline_parts::{PipelineDesc, StepRate};
use super::{BindingKind, Device, GpuError};

const SPIRV_MAGIC: u32 = 0x0723_0203;

/// A compiled pipeline, and what draws with it must match.
pub struct GraphicsPipeline {
    device: Arc<Device>,
    raw: vk::Pipeline,
    layout: vk::PipelineLayout,
    set_layout: vk::DescriptorSetLayout,
    label: String,
    targets: Vec<vk::Format>,
    tests_depth: bool,
    bindings: Vec<BindingKind>,
    push_bytes: u32,
    vertex_input: Option<(u32, StepRate)>,
}

impl GraphicsPipeline {
    /// Compiles a pipeline.
    ///
    /// # Errors
    /// [`GpuError::Usage`] if a shader is not SPIR-V or the number of push constant bytes is not possible; or what Vulkan
    /// says.
    pub fn new(device: &Arc<Device>, desc: &PipelineDesc) -> Result<Arc<Self>, GpuError> {
        require_possible(device, desc)?;
        let mut pipeline = Self {
            device: Arc::clone(device),
            raw: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            set_layout: set_layout(device, desc.label, desc.bindings)?,
            label: desc.label.to_owned(),
            targets: desc.color_targets.iter().map(|target| target.0).collect(),
            tests_depth: desc.depth.is_some(),
            bindings: desc.bindings.to_vec(),
            push_bytes: desc.push_bytes,
            vertex_input: desc.vertex_input.map(|input| (input.stride, input.rate)),
        };
        pipeline.layout = pipeline_layout(device, desc, pipeline.set_layout)?;
        pipeline.raw = compile(device, desc, pipeline.layout)?;
        device.name(pipeline.raw, desc.label);
        Ok(Arc::new(pipeline))
    }

    /// Its name in messages.
    pub fn label(&self) -> &str {
        &self.label
    }

    /// The formats of the targets it draws into.
    pub fn targets(&self) -> &[vk::Format] {
        &self.targets
    }

    /// Whether its pass must have depths.
    pub fn tests_depth(&self) -> bool {
        self.tests_depth
    }

    /// The kinds of its bindings.
    pub fn bindings(&self) -> &[BindingKind] {
        &self.bindings
    }

    /// Bytes of its push constants.
    pub fn push_bytes(&self) -> u32 {
        self.push_bytes
    }

    /// Stride and step rate of its vertex buffer.
    pub fn vertex_input(&self) -> Option<(u32, StepRate)> {
        self.vertex_input
    }

    pub(super) fn raw(&self) -> vk::Pipeline {
        self.raw
    }

    pub(super) fn layout(&self) -> vk::PipelineLayout {
        self.layout
    }

    pub(super) fn is_on(&self, device: &Device) -> bool {
        std::ptr::eq(&*self.device, device)
    }
}

impl Drop for GraphicsPipeline {
    fn drop(&mut self) {
        let raw = self.device.raw();
        // SAFETY: submissions hold their pipelines, so the device is done with it; null handles are ignored.
        unsafe {
            raw.destroy_pipeline(self.raw, None);
            raw.destroy_pipeline_layout(self.layout, None);
            raw.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}

fn require_possible(device: &Device, desc: &PipelineDesc) -> Result<(), GpuError> {
    let is_spirv = |words: &[u32]| words.first() == Some(&SPIRV_MAGIC);
    if !is_spirv(desc.vertex_spirv) || !is_spirv(desc.fragment_spirv) {
        return Err(GpuError::usage(desc.label, "a shader is not SPIR-V"));
    }
    let limits = &device.info().limits;
    if !desc.push_bytes.is_multiple_of(4) || desc.push_bytes > limits.push_bytes {
        let problem = format!(
            "{} bytes of push constants (at most {}, in fours)",
            desc.push_bytes, limits.push_bytes
        );
        return Err(GpuError::usage(desc.label, problem));
    }
    if desc.color_targets.len() > limits.color_targets as usize {
        let problem = format!(
            "{} colour targets (at most {})",
            desc.color_targets.len(),
            limits.color_targets
        );
        return Err(GpuError::usage(desc.label, problem));
    }
    Ok(())
}

fn pipeline_layout(
    device: &Device,
    desc: &PipelineDesc,
    set_layout: vk::DescriptorSetLayout,
) -> Result<vk::PipelineLayout, GpuError> {
    let sets = [set_layout];
    let push = vk::PushConstantRange::default()
        .stage_flags(PUSH_STAGES)
        .size(desc.push_bytes);
    let pushes = if desc.push_bytes > 0 { vec![push] } else { Vec::new() };
    let info = vk::PipelineLayoutCreateInfo::default()
        .set_layouts(&sets)
        .push_constant_ranges(&pushes);
    // SAFETY: the set layout is of this device.
    unsafe { device.raw().create_pipeline_layout(&info, None) }.map_err(GpuError::creating(desc.label, 0))
}

/// The stages that see push constants.
pub(super) const PUSH_STAGES: vk::ShaderStageFlags =
    vk::ShaderStageFlags::from_raw(vk::ShaderStageFlags::VERTEX.as_raw() | vk::ShaderStageFlags::FRAGMENT.as_raw());
