//! From a pipeline's description to Vulkan's object.

use ash::vk;

use super::image::DEPTH_FORMAT;
use super::pipeline_parts::{PipelineDesc, blend_state, depth_state};
use super::{Device, GpuError};

/// A shader module, needed only while its pipeline is compiled.
struct Shader<'a> {
    device: &'a Device,
    raw: vk::ShaderModule,
}

impl<'a> Shader<'a> {
    fn new(device: &'a Device, label: &str, spirv: &[u32]) -> Result<Self, GpuError> {
        let info = vk::ShaderModuleCreateInfo::default().code(spirv);
        // SAFETY: the words are SPIR-V from a compiler, as `PipelineDesc` asks; its magic number was checked.
        let raw = unsafe { device.raw().create_shader_module(&info, None) }.map_err(GpuError::creating(label, 0))?;
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

/// The lists that Vulkan's description points to.
struct Lists {
    constants: Vec<vk::SpecializationMapEntry>,
    values: Vec<u32>,
    vertices: VertexDescriptions,
    blends: Vec<vk::PipelineColorBlendAttachmentState>,
    formats: Vec<vk::Format>,
}

impl Lists {
    fn new(desc: &PipelineDesc) -> Self {
        let constant = |(constant, place): (&(u32, u32), u32)| {
            let entry = vk::SpecializationMapEntry::default().constant_id(constant.0);
            entry.offset(4 * place).size(4)
        };
        Self {
            constants: desc.specialization.iter().zip(0..).map(constant).collect(),
            values: desc.specialization.iter().map(|constant| constant.1).collect(),
            vertices: vertex_descriptions(desc),
            blends: desc.color_targets.iter().map(|target| blend_state(target.1)).collect(),
            formats: desc.color_targets.iter().map(|target| target.0).collect(),
        }
    }
}

/// Compiles `desc` for `layout`.
pub(super) fn compile(
    device: &Device,
    desc: &PipelineDesc,
    layout: vk::PipelineLayout,
) -> Result<vk::Pipeline, GpuError> {
    let lists = Lists::new(desc);
    let constants = vk::SpecializationInfo::default().map_entries(&lists.constants);
    let constants = constants.data(bytemuck::cast_slice(&lists.values));
    let vertex = Shader::new(device, desc.label, desc.vertex_spirv)?;
    let fragment = Shader::new(device, desc.label, desc.fragment_spirv)?;
    let stages = [
        vertex.stage(vk::ShaderStageFlags::VERTEX, &constants),
        fragment.stage(vk::ShaderStageFlags::FRAGMENT, &constants),
    ];
    let vertices = vk::PipelineVertexInputStateCreateInfo::default()
        .vertex_binding_descriptions(&lists.vertices.0)
        .vertex_attribute_descriptions(&lists.vertices.1);
    let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&lists.blends);
    let mut rendering = vk::PipelineRenderingCreateInfo::default().color_attachment_formats(&lists.formats);
    if desc.depth.is_some() {
        rendering = rendering.depth_attachment_format(DEPTH_FORMAT);
    }
    let info = vk::GraphicsPipelineCreateInfo::default()
        .stages(&stages)
        .vertex_input_state(&vertices)
        .color_blend_state(&blend)
        .layout(layout)
        .push_next(&mut rendering);
    with_fixed_states(device, desc, info)
}

/// Completes `info` with what all pipelines share, and compiles it.
fn with_fixed_states(
    device: &Device,
    desc: &PipelineDesc,
    info: vk::GraphicsPipelineCreateInfo,
) -> Result<vk::Pipeline, GpuError> {
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(desc.topology.raw());
    let viewport = vk::PipelineViewportStateCreateInfo::default()
        .viewport_count(1)
        .scissor_count(1);
    let rasterization = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
    let depth = depth_state(desc.depth);
    let samples = vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
    let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
    let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
    let info = info
        .input_assembly_state(&assembly)
        .viewport_state(&viewport)
        .rasterization_state(&rasterization)
        .multisample_state(&samples)
        .depth_stencil_state(&depth)
        .dynamic_state(&dynamic);
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
