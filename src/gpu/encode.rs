//! From commands to a command buffer.

use ash::vk;

use super::access::Use;
use super::check::check;
use super::pipeline::PUSH_STAGES;
use super::track::{Barriers, Tracker};
use super::uses::track;
use super::{
    Bindings, Buffer, BufferCopy, BufferRole, Command, DepthTarget, Device, Draw, Elements, GpuError, GraphicsPipeline,
    ImageCopy, Load, Push, Recording, RenderPass, Target,
};

/// Writes commands, all in one command buffer that is being recorded.
pub(super) struct Encoder<'a> {
    pub(super) device: &'a Device,
    pub(super) commands: vk::CommandBuffer,
    /// Two timestamps a pass, if the device has them.
    pub(super) times: Option<vk::QueryPool>,
    passes: u32,
}

impl<'a> Encoder<'a> {
    pub(super) fn new(device: &'a Device, commands: vk::CommandBuffer, times: Option<vk::QueryPool>) -> Self {
        Self {
            device,
            commands,
            times,
            passes: 0,
        }
    }

    /// Writes all of `recording`, and notes in `tracker` what it uses.
    pub(super) fn encode(&mut self, recording: &Recording, tracker: &mut Tracker) -> Result<(), GpuError> {
        for command in &recording.commands {
            check(self.device, command)?;
            track(command, tracker)?;
            self.barriers(&tracker.end_command());
            self.command(command);
        }
        // What was copied for the host must be made visible to it.
        let readbacks: Vec<_> = tracker
            .used_buffers()
            .filter(|buffer| buffer.role() == BufferRole::Readback)
            .cloned()
            .collect();
        readbacks
            .iter()
            .for_each(|buffer| tracker.buffer(buffer, Use::ReadOnHost));
        self.barriers(&tracker.end_command());
        Ok(())
    }

    fn barriers(&self, (images, buffers): &Barriers) {
        if images.is_empty() && buffers.is_empty() {
            return;
        }
        let info = vk::DependencyInfo::default()
            .image_memory_barriers(images)
            .buffer_memory_barriers(buffers);
        // SAFETY: recording, outside a pass; the barriers name live objects, held by the tracker.
        unsafe { self.device.raw().cmd_pipeline_barrier2(self.commands, &info) };
    }

    fn command(&mut self, command: &Command) {
        match command {
            Command::Upload(copy) => self.upload(copy),
            Command::ReadBack(copy) => self.read_back(copy),
            Command::CopyBuffer(copy) => self.copy_buffer(copy),
            Command::Render(pass) => self.render(pass),
        }
    }

    fn upload(&self, copy: &ImageCopy) {
        let (buffer, image, layout) = (copy.buffer.raw(), copy.image.raw(), Use::CopyInto.layout());
        // SAFETY: the copy was checked; barriers made the image ready.
        unsafe {
            self.device
                .raw()
                .cmd_copy_buffer_to_image(self.commands, buffer, image, layout, &[texels(copy)])
        };
    }

    fn read_back(&self, copy: &ImageCopy) {
        let (buffer, image, layout) = (copy.buffer.raw(), copy.image.raw(), Use::CopyFrom.layout());
        // SAFETY: the copy was checked; barriers made the image ready.
        unsafe {
            self.device
                .raw()
                .cmd_copy_image_to_buffer(self.commands, image, layout, buffer, &[texels(copy)])
        };
    }

    fn copy_buffer(&self, copy: &BufferCopy) {
        let range = vk::BufferCopy {
            src_offset: copy.source_offset,
            dst_offset: copy.destination_offset,
            size: copy.bytes,
        };
        let (source, destination) = (copy.source.raw(), copy.destination.raw());
        // SAFETY: the copy was checked.
        unsafe {
            self.device
                .raw()
                .cmd_copy_buffer(self.commands, source, destination, &[range])
        };
    }

    fn render(&mut self, pass: &RenderPass) {
        let Some([width, height, _]) = pass.extent().map(|extent| extent.edges()) else {
            return;
        };
        let attachments: Vec<_> = pass.targets.iter().map(attachment).collect();
        let area = vk::Rect2D::default().extent(vk::Extent2D { width, height });
        let info = vk::RenderingInfo::default()
            .render_area(area)
            .layer_count(1)
            .color_attachments(&attachments);
        let depth = pass.depth.as_ref().map(depth_attachment);
        let info = match &depth {
            Some(depth) => info.depth_attachment(depth),
            None => info,
        };
        let viewport = vk::Viewport::default()
            .width(width as f32)
            .height(height as f32)
            .max_depth(1.0);
        let raw = self.device.raw();
        self.timestamp(2 * self.passes, vk::PipelineStageFlags2::TOP_OF_PIPE);
        // SAFETY: the pass was checked and its targets are in the layout for drawing.
        unsafe {
            raw.cmd_begin_rendering(self.commands, &info);
            raw.cmd_set_viewport(self.commands, 0, &[viewport]);
            raw.cmd_set_scissor(self.commands, 0, &[area]);
        }
        let mut bound = Bound::default();
        pass.draws.iter().for_each(|draw| self.draw(draw, &mut bound));
        // SAFETY: a pass was begun.
        unsafe { raw.cmd_end_rendering(self.commands) };
        self.timestamp(2 * self.passes + 1, vk::PipelineStageFlags2::BOTTOM_OF_PIPE);
        self.passes += 1;
    }

    fn timestamp(&self, query: u32, stage: vk::PipelineStageFlags2) {
        let Some(pool) = self.times else { return };
        // SAFETY: the pool has two queries a pass, all reset.
        unsafe {
            self.device
                .raw()
                .cmd_write_timestamp2(self.commands, stage, pool, query)
        };
    }

    fn draw<'d>(&self, draw: &'d Draw, bound: &mut Bound<'d>) {
        self.bind_pipeline(draw, bound);
        self.bind_data(draw, bound);
        let (first, count) = span(&draw.instances);
        let raw = self.device.raw();
        // SAFETY: the draw was checked against its pipeline, targets and buffers; all is bound.
        unsafe {
            match &draw.elements {
                Elements::Vertices(vertices) => {
                    let (first_vertex, vertices) = span(vertices);
                    raw.cmd_draw(self.commands, vertices, count, first_vertex, first);
                }
                Elements::Indices {
                    buffer,
                    range,
                    base_vertex,
                } => {
                    self.bind_indices(buffer, bound);
                    let (first_index, indices) = span(range);
                    raw.cmd_draw_indexed(self.commands, indices, count, first_index, *base_vertex, first);
                }
            }
        }
    }

    fn bind_pipeline<'d>(&self, draw: &'d Draw, bound: &mut Bound<'d>) {
        if bound
            .pipeline
            .is_some_and(|pipeline| std::ptr::eq(pipeline, &*draw.pipeline))
        {
            return;
        }
        // Another pipeline may have another layout, so bindings and push constants are set anew.
        (bound.pipeline, bound.bindings, bound.push) = (Some(&*draw.pipeline), None, None);
        let point = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: the pipeline is of this device and held by the tracker.
        unsafe {
            self.device
                .raw()
                .cmd_bind_pipeline(self.commands, point, draw.pipeline.raw())
        };
    }

    fn bind_data<'d>(&self, draw: &'d Draw, bound: &mut Bound<'d>) {
        let (raw, layout) = (self.device.raw(), draw.pipeline.layout());
        if let Some(bindings) = &draw.bindings
            && !bound.bindings.is_some_and(|last| std::ptr::eq(last, &**bindings))
        {
            bound.bindings = Some(bindings);
            let (point, sets) = (vk::PipelineBindPoint::GRAPHICS, [bindings.set()]);
            // SAFETY: the set is held by the tracker and of the kinds that the layout declares.
            unsafe { raw.cmd_bind_descriptor_sets(self.commands, point, layout, 0, &sets, &[]) };
        }
        if let Some(stream) = &draw.stream
            && bound.stream != Some((stream.buffer.raw(), stream.offset))
        {
            bound.stream = Some((stream.buffer.raw(), stream.offset));
            // SAFETY: the buffer is held by the tracker and may hold vertices.
            unsafe { raw.cmd_bind_vertex_buffers(self.commands, 0, &[stream.buffer.raw()], &[stream.offset]) };
        }
        if !draw.push.bytes().is_empty() && bound.push != Some(&draw.push) {
            bound.push = Some(&draw.push);
            // SAFETY: the bytes are as many as the layout declares.
            unsafe { raw.cmd_push_constants(self.commands, layout, PUSH_STAGES, 0, draw.push.bytes()) };
        }
    }

    fn bind_indices(&self, buffer: &Buffer, bound: &mut Bound) {
        if bound.indices == Some(buffer.raw()) {
            return;
        }
        bound.indices = Some(buffer.raw());
        // SAFETY: the buffer is held by the tracker and may hold indices.
        unsafe {
            self.device
                .raw()
                .cmd_bind_index_buffer(self.commands, buffer.raw(), 0, vk::IndexType::UINT32)
        };
    }
}

/// What is bound in the pass at hand.
#[derive(Default)]
struct Bound<'a> {
    pipeline: Option<&'a GraphicsPipeline>,
    bindings: Option<&'a Bindings>,
    push: Option<&'a Push>,
    stream: Option<(vk::Buffer, u64)>,
    indices: Option<vk::Buffer>,
}

fn span(range: &std::ops::Range<u32>) -> (u32, u32) {
    (range.start, range.end.saturating_sub(range.start))
}

fn attachment(target: &Target) -> vk::RenderingAttachmentInfo<'static> {
    let (load, color) = match target.load {
        Load::Clear(color) => (vk::AttachmentLoadOp::CLEAR, color),
        Load::Keep => (vk::AttachmentLoadOp::LOAD, [0.0; 4]),
    };
    vk::RenderingAttachmentInfo::default()
        .image_view(target.image.view())
        .image_layout(Use::DrawInto.layout())
        .load_op(load)
        .store_op(vk::AttachmentStoreOp::STORE)
        .clear_value(vk::ClearValue {
            color: vk::ClearColorValue { float32: color },
        })
}

fn depth_attachment(target: &DepthTarget) -> vk::RenderingAttachmentInfo<'static> {
    let (load, depth) = match target.load {
        Load::Clear(depth) => (vk::AttachmentLoadOp::CLEAR, depth),
        Load::Keep => (vk::AttachmentLoadOp::LOAD, 1.0),
    };
    vk::RenderingAttachmentInfo::default()
        .image_view(target.image.view())
        .image_layout(Use::TestDepth.layout())
        .load_op(load)
        .store_op(vk::AttachmentStoreOp::STORE)
        .clear_value(vk::ClearValue {
            depth_stencil: vk::ClearDepthStencilValue { depth, stencil: 0 },
        })
}

fn texels(copy: &ImageCopy) -> vk::BufferImageCopy {
    let color = vk::ImageSubresourceLayers::default()
        .aspect_mask(vk::ImageAspectFlags::COLOR)
        .layer_count(1);
    let [x, y, z] = copy.region.offset.map(|edge| i32::try_from(edge).unwrap_or(i32::MAX));
    let [width, height, depth] = copy.region.extent;
    let texels = vk::BufferImageCopy::default()
        .buffer_offset(copy.offset)
        .image_subresource(color);
    texels
        .image_offset(vk::Offset3D { x, y, z })
        .image_extent(vk::Extent3D { width, height, depth })
}
