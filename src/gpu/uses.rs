//! What each command reads and writes.

use std::sync::Arc;

use super::access::Use;
use super::track::Tracker;
use super::{Command, DepthTarget, Elements, GpuError, Image, Load, RenderPass, Target};

/// Notes what `command` uses.
pub(super) fn track(command: &Command, tracker: &mut Tracker) -> Result<(), GpuError> {
    match command {
        Command::Upload(copy) => {
            tracker.buffer(&copy.buffer, Use::CopyFrom);
            tracker.image(&copy.image, Use::CopyInto)
        }
        Command::ReadBack(copy) => {
            tracker.buffer(&copy.buffer, Use::CopyInto);
            tracker.image(&copy.image, Use::CopyFrom)
        }
        Command::CopyBuffer(copy) => {
            tracker.buffer(&copy.source, Use::CopyFrom);
            tracker.buffer(&copy.destination, Use::CopyInto);
            Ok(())
        }
        Command::Render(pass) => track_pass(pass, tracker),
    }
}

fn track_pass(pass: &RenderPass, tracker: &mut Tracker) -> Result<(), GpuError> {
    for Target { image, load } in &pass.targets {
        require_kept(tracker, image, *load == Load::Keep)?;
        tracker.image(image, Use::DrawInto)?;
    }
    if let Some(DepthTarget { image, load }) = &pass.depth {
        require_kept(tracker, image, *load == Load::Keep)?;
        tracker.image(image, Use::TestDepth)?;
    }
    for draw in &pass.draws {
        tracker.pipeline(&draw.pipeline);
        draw.bindings
            .as_ref()
            .map_or(Ok(()), |bindings| tracker.bindings(bindings))?;
        if let Some(stream) = &draw.stream {
            tracker.buffer(&stream.buffer, Use::ReadVertices);
        }
        if let Elements::Indices { buffer, .. } = &draw.elements {
            tracker.buffer(buffer, Use::ReadIndices);
        }
    }
    Ok(())
}

/// What a pass keeps must be there.
fn require_kept(tracker: &Tracker, image: &Arc<Image>, kept: bool) -> Result<(), GpuError> {
    if kept && tracker.is_undefined(image) {
        return Err(GpuError::usage(image.label(), "a pass keeps what was never drawn"));
    }
    Ok(())
}
