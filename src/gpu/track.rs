//! From what commands use to the barriers between them.
//!
//! A submission works on copies of the states, which become the objects' own only once the queue has taken it.

use std::collections::HashMap;
use std::sync::Arc;

use ash::vk;

use super::access::{Barrier, State, Use};
use super::{Binding, Bindings, Buffer, GpuError, GraphicsPipeline, Image};

/// What a submission uses, which it must hold, and the states it leaves behind.
#[derive(Default)]
pub(super) struct Tracker {
    images: HashMap<Address, Tracked<Image>>,
    buffers: HashMap<Address, Tracked<Buffer>>,
    /// With the last command that uses them.
    bindings: HashMap<Address, (Arc<Bindings>, usize)>,
    pipelines: HashMap<Address, Arc<GraphicsPipeline>>,
    image_barriers: Vec<vk::ImageMemoryBarrier2<'static>>,
    buffer_barriers: Vec<vk::BufferMemoryBarrier2<'static>>,
    /// The number of the command being tracked.
    command: usize,
}

/// Tells objects apart; each is held, so no other takes its address.
type Address = usize;

fn address<T>(object: &Arc<T>) -> Address {
    Arc::as_ptr(object).addr()
}

struct Tracked<T> {
    object: Arc<T>,
    state: State,
    /// The last use and its command.
    last: Option<(usize, Use)>,
}

/// The barriers to execute before a command.
pub(super) type Barriers = (
    Vec<vk::ImageMemoryBarrier2<'static>>,
    Vec<vk::BufferMemoryBarrier2<'static>>,
);

impl Tracker {
    /// Notes that the command at hand uses `image`.
    pub(super) fn image(&mut self, image: &Arc<Image>, usage: Use) -> Result<(), GpuError> {
        let tracked = self.images.entry(address(image)).or_insert_with(|| {
            let state = *image.state();
            Tracked {
                object: Arc::clone(image),
                state,
                last: None,
            }
        });
        if tracked.last == Some((self.command, usage)) {
            return Ok(());
        }
        if tracked.last.is_some_and(|(command, _)| command == self.command) {
            return Err(GpuError::usage(
                image.label(),
                "one command both reads and draws into the image",
            ));
        }
        if tracked.state.is_undefined() && !usage.writes() {
            return Err(GpuError::usage(
                image.label(),
                "the image is read before anything was written into it",
            ));
        }
        tracked.last = Some((self.command, usage));
        let barrier = tracked.state.use_image(usage);
        self.image_barriers
            .extend(barrier.map(|barrier| image_barrier(image, barrier)));
        Ok(())
    }

    /// Has anything been written into `image`, this recording's commands so far included?
    pub(super) fn is_undefined(&self, image: &Arc<Image>) -> bool {
        let tracked = self.images.get(&address(image));
        tracked.map_or_else(|| image.state().is_undefined(), |tracked| tracked.state.is_undefined())
    }

    /// Notes that the command at hand uses `buffer`.
    pub(super) fn buffer(&mut self, buffer: &Arc<Buffer>, usage: Use) {
        let tracked = self.buffers.entry(address(buffer)).or_insert_with(|| {
            let state = *buffer.state();
            Tracked {
                object: Arc::clone(buffer),
                state,
                last: None,
            }
        });
        if tracked.last == Some((self.command, usage)) {
            return;
        }
        tracked.last = Some((self.command, usage));
        let barrier = tracked.state.use_buffer(usage);
        self.buffer_barriers
            .extend(barrier.map(|barrier| buffer_barrier(buffer, barrier)));
    }

    /// Notes that the command at hand uses `bindings` and all they bind.
    pub(super) fn bindings(&mut self, bindings: &Arc<Bindings>) -> Result<(), GpuError> {
        let seen = self
            .bindings
            .insert(address(bindings), (Arc::clone(bindings), self.command));
        if seen.is_some_and(|(_, command)| command == self.command) {
            return Ok(());
        }
        bindings.entries().iter().try_for_each(|entry| match entry {
            Binding::SampledImage(image, _) => self.image(image, Use::Sample),
            Binding::Uniform(buffer) | Binding::Storage(buffer) | Binding::WrittenStorage(buffer) => {
                self.buffer(buffer, entry.kind().usage());
                Ok(())
            }
        })
    }

    /// Notes that the command at hand uses `pipeline`.
    pub(super) fn pipeline(&mut self, pipeline: &Arc<GraphicsPipeline>) {
        self.pipelines
            .entry(address(pipeline))
            .or_insert_with(|| Arc::clone(pipeline));
    }

    /// Ends the command at hand and returns the barriers it needs before.
    pub(super) fn end_command(&mut self) -> Barriers {
        self.command += 1;
        (
            std::mem::take(&mut self.image_barriers),
            std::mem::take(&mut self.buffer_barriers),
        )
    }

    /// The buffers used, for the host to keep off until the submission is done.
    pub(super) fn used_buffers(&self) -> impl Iterator<Item = &Arc<Buffer>> {
        self.buffers.values().map(|tracked| &tracked.object)
    }

    /// Makes the states the objects' own.
    pub(super) fn commit(&self) {
        self.images
            .values()
            .for_each(|tracked| *tracked.object.state() = tracked.state);
        self.buffers
            .values()
            .for_each(|tracked| *tracked.object.state() = tracked.state);
    }
}

fn image_barrier(image: &Image, barrier: Barrier) -> vk::ImageMemoryBarrier2<'static> {
    vk::ImageMemoryBarrier2::default()
        .src_stage_mask(barrier.from.stage)
        .src_access_mask(barrier.from.access)
        .dst_stage_mask(barrier.to.stage)
        .dst_access_mask(barrier.to.access)
        .old_layout(barrier.old_layout)
        .new_layout(barrier.new_layout)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .image(image.raw())
        .subresource_range(image.whole())
}

fn buffer_barrier(buffer: &Buffer, barrier: Barrier) -> vk::BufferMemoryBarrier2<'static> {
    vk::BufferMemoryBarrier2::default()
        .src_stage_mask(barrier.from.stage)
        .src_access_mask(barrier.from.access)
        .dst_stage_mask(barrier.to.stage)
        .dst_access_mask(barrier.to.access)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .buffer(buffer.raw())
        .size(vk::WHOLE_SIZE)
}
