//! How commands touch memory, and when two touches need a barrier between them.
//!
//! One rule: a write waits for everything since the last write, a read waits for the last write only, and reads of the same
//! write and layout wait for nothing.

use ash::vk::{AccessFlags2 as Access, ImageLayout as Layout, PipelineStageFlags2 as Stage};

/// What a command does with an image or a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    CopyFrom,
    CopyInto,
    Sample,
    ReadUniform,
    ReadStorage,
    /// By fragment shaders.
    WriteStorage,
    ReadVertices,
    ReadIndices,
    DrawInto,
    TestDepth,
    ReadOnHost,
}

impl Use {
    pub(super) fn stage(self) -> Stage {
        match self {
            Self::CopyFrom | Self::CopyInto => Stage::COPY,
            Self::Sample | Self::ReadUniform | Self::ReadStorage => Stage::VERTEX_SHADER | Stage::FRAGMENT_SHADER,
            Self::WriteStorage => Stage::FRAGMENT_SHADER,
            Self::ReadVertices => Stage::VERTEX_ATTRIBUTE_INPUT,
            Self::ReadIndices => Stage::INDEX_INPUT,
            Self::DrawInto => Stage::COLOR_ATTACHMENT_OUTPUT,
            Self::TestDepth => Stage::EARLY_FRAGMENT_TESTS | Stage::LATE_FRAGMENT_TESTS,
            Self::ReadOnHost => Stage::HOST,
        }
    }

    pub(super) fn access(self) -> Access {
        match self {
            Self::CopyFrom => Access::TRANSFER_READ,
            Self::CopyInto => Access::TRANSFER_WRITE,
            Self::Sample => Access::SHADER_SAMPLED_READ,
            Self::ReadUniform => Access::UNIFORM_READ,
            Self::ReadStorage => Access::SHADER_STORAGE_READ,
            Self::WriteStorage => Access::SHADER_STORAGE_WRITE,
            Self::ReadVertices => Access::VERTEX_ATTRIBUTE_READ,
            Self::ReadIndices => Access::INDEX_READ,
            Self::DrawInto => Access::COLOR_ATTACHMENT_READ | Access::COLOR_ATTACHMENT_WRITE,
            Self::TestDepth => Access::DEPTH_STENCIL_ATTACHMENT_READ | Access::DEPTH_STENCIL_ATTACHMENT_WRITE,
            Self::ReadOnHost => Access::HOST_READ,
        }
    }

    /// The layout an image must be in; of no meaning for a buffer.
    pub(super) fn layout(self) -> Layout {
        match self {
            Self::CopyFrom => Layout::TRANSFER_SRC_OPTIMAL,
            Self::CopyInto => Layout::TRANSFER_DST_OPTIMAL,
            Self::DrawInto => Layout::COLOR_ATTACHMENT_OPTIMAL,
            Self::TestDepth => Layout::DEPTH_ATTACHMENT_OPTIMAL,
            _ => Layout::SHADER_READ_ONLY_OPTIMAL,
        }
    }

    pub(super) fn writes(self) -> bool {
        matches!(
            self,
            Self::CopyInto | Self::WriteStorage | Self::DrawInto | Self::TestDepth
        )
    }
}

/// Stages and the accesses they make.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Scope {
    pub(super) stage: Stage,
    pub(super) access: Access,
}

impl Scope {
    fn of(usage: Use) -> Self {
        Self {
            stage: usage.stage(),
            access: usage.access(),
        }
    }

    fn with(self, other: Self) -> Self {
        Self {
            stage: self.stage | other.stage,
            access: self.access | other.access,
        }
    }

    fn contains(self, other: Self) -> bool {
        self.stage.contains(other.stage) && self.access.contains(other.access)
    }
}

/// What must happen before a use: `from` finished and visible to `to`, the image moved between layouts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Barrier {
    pub(super) from: Scope,
    pub(super) to: Scope,
    pub(super) old_layout: Layout,
    pub(super) new_layout: Layout,
}

/// What has happened to an image or a buffer so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct State {
    layout: Layout,
    /// The last write, or change of layout.
    written: Scope,
    /// The reads since then that a barrier has made it visible to.
    read: Scope,
}

impl State {
    /// Records a use of an image and returns the barrier it needs before.
    pub(super) fn use_image(&mut self, usage: Use) -> Option<Barrier> {
        self.apply(usage, usage.layout())
    }

    /// Records a use of a buffer and returns the barrier it needs before.
    pub(super) fn use_buffer(&mut self, usage: Use) -> Option<Barrier> {
        self.apply(usage, Layout::UNDEFINED)
    }

    /// Has nothing ever been written?
    pub(super) fn is_undefined(&self) -> bool {
        self.layout == Layout::UNDEFINED
    }

    fn apply(&mut self, usage: Use, layout: Layout) -> Option<Barrier> {
        let scope = Scope::of(usage);
        let excludes = usage.writes() || layout != self.layout;
        if !excludes && (self.read.contains(scope) || self.written == Scope::default()) {
            self.read = self.read.with(scope);
            return None;
        }
        let from = if excludes { self.before_write() } else { self.written };
        let barrier = Barrier {
            from,
            to: scope,
            old_layout: self.layout,
            new_layout: layout,
        };
        self.after(usage, scope, layout);
        (from != Scope::default() || barrier.old_layout != layout).then_some(barrier)
    }

    /// A write waits for the last write and the reads since; reads have nothing to make visible.
    fn before_write(&self) -> Scope {
        Scope {
            stage: self.written.stage | self.read.stage,
            access: self.written.access,
        }
    }

    fn after(&mut self, usage: Use, scope: Scope, layout: Layout) {
        if usage.writes() {
            (self.written, self.read) = (scope, Scope::default());
        } else if layout != self.layout {
            // The change of layout is itself a write, which later barriers reach through the stage it was done for.
            (self.written, self.read) = (
                Scope {
                    stage: scope.stage,
                    access: Access::NONE,
                },
                scope,
            );
        } else {
            self.read = self.read.with(scope);
        }
        self.layout = layout;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_of_one_write_share_a_barrier() {
        let mut state = State::default();
        assert_eq!(state.use_buffer(Use::CopyInto), None);
        assert!(state.use_buffer(Use::ReadVertices).is_some());
        assert_eq!(state.use_buffer(Use::ReadVertices), None);
        let other = state
            .use_buffer(Use::ReadUniform)
            .expect("a new reader must see the write");
        assert_eq!(other.from, Scope::of(Use::CopyInto));
    }

    #[test]
    fn a_write_waits_for_all_readers() {
        let mut state = State::default();
        state.use_buffer(Use::CopyInto);
        state.use_buffer(Use::ReadVertices);
        state.use_buffer(Use::ReadUniform);
        let barrier = state.use_buffer(Use::CopyInto).expect("write after read");
        assert!(
            barrier
                .from
                .stage
                .contains(Use::ReadVertices.stage() | Use::ReadUniform.stage())
        );
        assert_eq!(barrier.from.access, Access::TRANSFER_WRITE);
    }

    #[test]
    fn the_host_s_data_need_no_barrier_to_be_read() {
        let mut state = State::default();
        assert_eq!(state.use_buffer(Use::CopyFrom), None);
        assert_eq!(state.use_buffer(Use::ReadVertices), None);
    }

    #[test]
    fn what_shaders_wrote_is_made_visible_to_the_host() {
        let mut state = State::default();
        assert_eq!(state.use_buffer(Use::WriteStorage), None);
        let barrier = state.use_buffer(Use::ReadOnHost).expect("read after write");
        assert_eq!(barrier.from, Scope::of(Use::WriteStorage));
        assert_eq!(barrier.to, Scope::of(Use::ReadOnHost));
    }

    #[test]
    fn drawing_on_after_drawing_waits() {
        let mut state = State::default();
        assert_eq!(
            state.use_image(Use::DrawInto).map(|barrier| barrier.old_layout),
            Some(Layout::UNDEFINED)
        );
        let again = state.use_image(Use::DrawInto).expect("write after write");
        assert_eq!(
            (again.old_layout, again.new_layout),
            (Use::DrawInto.layout(), Use::DrawInto.layout())
        );
    }

    #[test]
    fn a_layout_is_changed_once_for_many_reads() {
        let mut state = State::default();
        state.use_image(Use::CopyInto);
        assert!(state.use_image(Use::Sample).is_some());
        assert_eq!(state.use_image(Use::Sample), None);
        let back = state.use_image(Use::CopyFrom).expect("another layout");
        assert_eq!(back.from.stage, Use::Sample.stage());
    }
}
