//! Graphics pipelines.

use std::sync::Arc;

use ash::vk;

use super::bindings::set_layout;
use super::pipeline_parts::{PipelineDesc, StepRate, blend_state};
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
            bindings: desc.bindings.to_vec(),
            push_bytes: desc.push_bytes,
            vertex_input: desc.vertex_input.map(|input| (input.stride, input.rate)),
        };
        pipeline.layout = pipeline_layout(device, desc, pipeline.set_layout)?;
        let vertex = Shader::new(device, desc.label, desc.vertex_spirv)?;
        let fragment = Shader::new(device, desc.label, desc.fragment_spirv)?;
        pipeline.raw = compile(device, desc, pipeline.layout, &vertex, &fragment)?;
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

/// A shader module, needed only while its pipeline is compiled.
struct Shader<'a> {
    device: &'a Device,
    raw: vk::ShaderModule,
}

impl<'a> Shader<'a> {
    fn new(device: &'a Device, label: &str, spirv: &[u32]) -> Result<Self, GpuError> {
        let info = vk::ShaderModuleCreateInfo::default().code(spirv);
        // SAFETY: the words are SPIR-V from a compiler, as `PipelineDesc` asks; its magic number was checked.
        let raw = unsafe { device.raw().create_shader_module(&info, None) }
            .map_err(GpuError::creating(label, 0))?;
        Ok(Self { device, raw })
    }

    fn stage<'b>(
        &self,
        stage: vk::ShaderStageFlags,
        constants: &'b vk::SpecializationInfo<'b>,
    ) -> vk::PipelineShaderStageCreateInfo<'b> {
        let info = vk::PipelineShaderStageCreateInfo::default()
            .stage(stage)
            .module(self.raw)
            .name(c"main");
        info.specialization_info(constants)
    }
}

impl Drop for Shader<'_> {
    fn drop(&mut self) {
        // SAFETY: a module may go once the pipeline is compiled.
        unsafe { self.device.raw().destroy_shader_module(self.raw, None) };
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
    if desc.color_targets.is_empty() || desc.color_targets.len() > limits.color_targets as usize {
        let problem = format!(
            "{} colour targets (1 to {})",
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
    let pushes = if desc.push_bytes > 0 {
        vec![push]
    } else {
        Vec::new()
    };
    let info = vk::PipelineLayoutCreateInfo::default()
        .set_layouts(&sets)
        .push_constant_ranges(&pushes);
    // SAFETY: the set layout is of this device.
    unsafe { device.raw().create_pipeline_layout(&info, None) }
        .map_err(GpuError::creating(desc.label, 0))
}

/// The stages that see push constants.
pub(super) const PUSH_STAGES: vk::ShaderStageFlags = vk::ShaderStageFlags::from_raw(
    vk::ShaderStageFlags::VERTEX.as_raw() | vk::ShaderStageFlags::FRAGMENT.as_raw(),
);

fn compile(
    device: &Device,
    desc: &PipelineDesc,
    layout: vk::PipelineLayout,
    vertex: &Shader,
    fragment: &Shader,
) -> Result<vk::Pipeline, GpuError> {
    let entry = |((id, _), place): (&(u32, u32), u32)| {
        vk::SpecializationMapEntry::default()
            .constant_id(*id)
            .offset(4 * place)
            .size(4)
    };
    let entries: Vec<_> = desc.specialization.iter().zip(0..).map(entry).collect();
    let values: Vec<u32> = desc
        .specialization
        .iter()
        .map(|constant| constant.1)
        .collect();
    let constants = vk::SpecializationInfo::default()
        .map_entries(&entries)
        .data(bytemuck::cast_slice(&values));
    let stages = [
        vertex.stage(vk::ShaderStageFlags::VERTEX, &constants),
        fragment.stage(vk::ShaderStageFlags::FRAGMENT, &constants),
    ];
    let (buffers, attributes) = vertex_descriptions(desc);
    let vertex_input = vk::PipelineVertexInputStateCreateInfo::default()
        .vertex_binding_descriptions(&buffers)
        .vertex_attribute_descriptions(&attributes);
    let assembly =
        vk::PipelineInputAssemblyStateCreateInfo::default().topology(desc.topology.raw());
    let viewport = vk::PipelineViewportStateCreateInfo::default()
        .viewport_count(1)
        .scissor_count(1);
    let rasterization = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
    let samples = vk::PipelineMultisampleStateCreateInfo::default()
        .rasterization_samples(vk::SampleCountFlags::TYPE_1);
    let blends: Vec<_> = desc
        .color_targets
        .iter()
        .map(|target| blend_state(target.1))
        .collect();
    let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
    let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
    let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
    let formats: Vec<_> = desc.color_targets.iter().map(|target| target.0).collect();
    let mut rendering =
        vk::PipelineRenderingCreateInfo::default().color_attachment_formats(&formats);
    let info = vk::GraphicsPipelineCreateInfo::default()
        .stages(&stages)
        .vertex_input_state(&vertex_input)
        .input_assembly_state(&assembly)
        .viewport_state(&viewport)
        .rasterization_state(&rasterization)
        .multisample_state(&samples)
        .color_blend_state(&blend)
        .dynamic_state(&dynamic)
        .layout(layout)
        .push_next(&mut rendering);
    // SAFETY: modules and layout are of this device; all that `info` points to lives until the call returns.
    let made = unsafe {
        device
            .raw()
            .create_graphics_pipelines(vk::PipelineCache::null(), &[info], None)
    };
    let pipelines = made.map_err(|(_, result)| GpuError::creating(desc.label, 0)(result))?;
    Ok(pipelines.first().copied().unwrap_or_default())
}

type VertexDescriptions = (
    Vec<vk::VertexInputBindingDescription>,
    Vec<vk::VertexInputAttributeDescription>,
);

fn vertex_descriptions(desc: &PipelineDesc) -> VertexDescriptions {
    let Some(input) = desc.vertex_input else {
        return VertexDescriptions::default();
    };
    let buffer = vk::VertexInputBindingDescription::default()
        .stride(input.stride)
        .input_rate(input.rate.raw());
    let attributes = input.attributes.iter().map(|attribute| {
        let described = vk::VertexInputAttributeDescription::default().location(attribute.location);
        described.format(attribute.format).offset(attribute.offset)
    });
    (vec![buffer], attributes.collect())
}
