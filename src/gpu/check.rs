//! Refuses commands that contradict the objects they name, before Vulkan sees them.

use super::{
    BufferCopy, BufferRole, Command, Device, Draw, Elements, Extent, GpuError, ImageCopy, ImageRole, RenderPass,
    StepRate,
};

/// Checks one command.
pub(super) fn check(device: &Device, command: &Command) -> Result<(), GpuError> {
    match command {
        Command::Upload(copy) => image_copy(device, copy, BufferRole::Readback),
        Command::ReadBack(copy) => image_copy(device, copy, BufferRole::Upload),
        Command::CopyBuffer(copy) => buffer_copy(device, copy),
        Command::Render(pass) => render(device, pass),
    }
}

fn require(holds: bool, label: &str, problem: &str) -> Result<(), GpuError> {
    if holds {
        Ok(())
    } else {
        Err(GpuError::usage(label, problem))
    }
}

/// Do `bytes` from `offset` on lie within `limit`?
fn fits(offset: u64, bytes: u64, limit: u64) -> bool {
    offset.checked_add(bytes).is_some_and(|end| end <= limit)
}

fn image_copy(device: &Device, copy: &ImageCopy, unfit: BufferRole) -> Result<(), GpuError> {
    let (image, buffer, region) = (&copy.image, &copy.buffer, copy.region);
    require(
        image.is_on(device) && buffer.is_on(device),
        image.label(),
        "copied with objects of another device",
    )?;
    require(
        image.role() != ImageRole::DepthTarget,
        image.label(),
        "depths are not copied",
    )?;
    require(
        buffer.role() != unfit,
        buffer.label(),
        "the buffer's role does not allow the copy",
    )?;
    let edges = image.extent().edges();
    let inside = |axis: usize| {
        region.offset[axis]
            .checked_add(region.extent[axis])
            .is_some_and(|end| end <= edges[axis])
    };
    let texels = Extent::D3(region.extent[0], region.extent[1], region.extent[2]).texels();
    require(
        (0..3).all(inside) && texels > 0,
        image.label(),
        "the copied region is empty or not within the image",
    )?;
    let aligned = copy.offset.is_multiple_of(4) && copy.offset.is_multiple_of(image.texel_bytes().max(1));
    require(
        aligned,
        buffer.label(),
        "the copy's offset is no multiple of 4 and the texel's size",
    )?;
    let bytes = texels.saturating_mul(image.texel_bytes());
    require(
        fits(copy.offset, bytes, buffer.bytes()),
        buffer.label(),
        "the copied region does not fit the buffer",
    )
}

fn buffer_copy(device: &Device, copy: &BufferCopy) -> Result<(), GpuError> {
    let (from, to) = (&copy.source, &copy.destination);
    require(
        from.is_on(device) && to.is_on(device),
        to.label(),
        "copied with a buffer of another device",
    )?;
    require(
        from.role() != BufferRole::Readback,
        from.label(),
        "a readback buffer cannot be copied from",
    )?;
    require(
        to.role() != BufferRole::Upload,
        to.label(),
        "an upload buffer cannot be copied into",
    )?;
    require(!std::ptr::eq(&**from, &**to), to.label(), "a buffer copied into itself")?;
    require(copy.bytes > 0, to.label(), "a copy of 0 bytes")?;
    require(
        fits(copy.source_offset, copy.bytes, from.bytes()),
        from.label(),
        "the copy reads beyond the buffer",
    )?;
    require(
        fits(copy.destination_offset, copy.bytes, to.bytes()),
        to.label(),
        "the copy writes beyond the buffer",
    )
}

fn render(device: &Device, pass: &RenderPass) -> Result<(), GpuError> {
    let Some(extent) = pass.extent() else {
        return Err(GpuError::usage("a pass", "it has nothing to draw into"));
    };
    for (place, target) in pass.targets.iter().enumerate() {
        let image = &target.image;
        require(image.is_on(device), image.label(), "a target of another device")?;
        require(
            image.role() == ImageRole::ColorTarget,
            image.label(),
            "the image is not a target",
        )?;
        require(
            image.extent() == extent,
            image.label(),
            "targets of one pass differ in size",
        )?;
        let again = pass
            .targets
            .iter()
            .take(place)
            .any(|other| std::ptr::eq(&*other.image, &**image));
        require(!again, image.label(), "the image is a target twice")?;
    }
    if let Some(depth) = &pass.depth {
        let image = &depth.image;
        require(image.is_on(device), image.label(), "depths of another device")?;
        require(
            image.role() == ImageRole::DepthTarget && image.extent() == extent,
            image.label(),
            "the image is not one of depths, or not of the targets' size",
        )?;
    }
    let mut checked: Option<&Draw> = None;
    for draw in &pass.draws {
        if !checked.is_some_and(|before| same_state(before, draw)) {
            state(device, pass, draw)?;
            checked = Some(draw);
        }
        amounts(draw)?;
    }
    Ok(())
}

/// Do two draws share pipeline and bindings?
fn same_state(a: &Draw, b: &Draw) -> bool {
    let bindings = |draw: &Draw| draw.bindings.as_ref().map(std::sync::Arc::as_ptr);
    std::ptr::eq(&*a.pipeline, &*b.pipeline) && bindings(a) == bindings(b)
}

fn state(device: &Device, pass: &RenderPass, draw: &Draw) -> Result<(), GpuError> {
    let label = draw.pipeline.label();
    require(draw.pipeline.is_on(device), label, "a pipeline of another device")?;
    let formats = pass.targets.iter().map(|target| target.image.format());
    require(
        formats.eq(draw.pipeline.targets().iter().copied()),
        label,
        "the targets' formats are not the pipeline's",
    )?;
    require(
        pass.depth.is_some() == draw.pipeline.tests_depth(),
        label,
        "depths that the pipeline does not test, or none to test",
    )?;
    let bindings = draw.bindings.as_ref();
    require(
        bindings.is_none_or(|bindings| bindings.is_on(device)),
        label,
        "bindings of another device",
    )?;
    let kinds = bindings.map_or_else(Vec::new, |bindings| {
        bindings.entries().iter().map(|entry| entry.kind()).collect()
    });
    require(
        kinds == draw.pipeline.bindings(),
        label,
        "the bindings are not those the pipeline declares",
    )
}

fn amounts(draw: &Draw) -> Result<(), GpuError> {
    let (label, pipeline) = (draw.pipeline.label(), &draw.pipeline);
    let push = draw.push.bytes().len();
    require(
        push == pipeline.push_bytes() as usize,
        label,
        "the push constants are not of the pipeline's size",
    )?;
    require(
        draw.stream.is_some() == pipeline.vertex_input().is_some(),
        label,
        "a vertex buffer too few or too many",
    )?;
    if let Elements::Indices { buffer, range, .. } = &draw.elements {
        let within = fits(0, u64::from(range.end) * 4, buffer.bytes());
        require(
            within && buffer.role() != BufferRole::Readback,
            buffer.label(),
            "the draw reads beyond the indices",
        )?;
    }
    let (Some(stream), Some((stride, rate))) = (&draw.stream, pipeline.vertex_input()) else {
        return Ok(());
    };
    let count = match (rate, &draw.elements) {
        (StepRate::Instance, _) => draw.instances.end,
        (StepRate::Vertex, Elements::Vertices(range)) => range.end,
        // Which vertices indices name is not known here; the device's robust access keeps them within the buffer.
        (StepRate::Vertex, Elements::Indices { .. }) => 0,
    };
    let within = fits(
        stream.offset,
        u64::from(count) * u64::from(stride),
        stream.buffer.bytes(),
    );
    let usable = within && stream.offset.is_multiple_of(4) && stream.buffer.role() != BufferRole::Readback;
    require(
        usable,
        stream.buffer.label(),
        "the draw reads beyond the vertices, or from an offset that is no multiple of 4",
    )
}
