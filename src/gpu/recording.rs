//! A frame as a value: a list of commands.
//!
//! Commands say what they read and write, and nothing about when: the barriers between them follow from the list.

use std::ops::Range;
use std::sync::Arc;

use super::{Bindings, Buffer, Extent, GraphicsPipeline, Image};

/// Commands in the order of their effects. One recording may be submitted many times.
#[derive(Clone, Default)]
pub struct Recording {
    /// The commands.
    pub commands: Vec<Command>,
}

/// One step.
#[derive(Clone)]
pub enum Command {
    /// Buffer to image.
    Upload(ImageCopy),
    /// Image to buffer.
    ReadBack(ImageCopy),
    /// Buffer to buffer.
    CopyBuffer(BufferCopy),
    /// Draws.
    Render(RenderPass),
}

/// A box of texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// The first texel.
    pub offset: [u32; 3],
    /// The number of texels along each axis.
    pub extent: [u32; 3],
}

/// A copy between texels and tightly packed bytes, x fastest.
#[derive(Clone)]
pub struct ImageCopy {
    /// The bytes.
    pub buffer: Arc<Buffer>,
    /// Where they begin; a multiple of 4 and of the texel's size.
    pub offset: u64,
    /// The texels.
    pub image: Arc<Image>,
    /// Which of them.
    pub region: Region,
}

/// A copy between different buffers.
#[derive(Clone)]
pub struct BufferCopy {
    /// Where the bytes are.
    pub source: Arc<Buffer>,
    /// Their first.
    pub source_offset: u64,
    /// Where they go.
    pub destination: Arc<Buffer>,
    /// The first's new place.
    pub destination_offset: u64,
    /// How many.
    pub bytes: u64,
}

/// What a target holds when a pass begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load<T = [f32; 4]> {
    /// This, everywhere.
    Clear(T),
    /// What it held; a pass may so be split into several.
    Keep,
}

/// An image to draw into.
#[derive(Clone)]
pub struct Target {
    /// The image.
    pub image: Arc<Image>,
    /// What it begins with.
    pub load: Load,
}

/// An image of depths to test against.
#[derive(Clone)]
pub struct DepthTarget {
    /// The image.
    pub image: Arc<Image>,
    /// What it begins with.
    pub load: Load<f32>,
}

/// Draws into the same targets, in order.
#[derive(Clone)]
pub struct RenderPass {
    /// The targets, of one size; none if depths alone are drawn.
    pub targets: Vec<Target>,
    /// The depths, of the same size, for pipelines that test against them.
    pub depth: Option<DepthTarget>,
    /// The draws.
    pub draws: Vec<Draw>,
}

impl RenderPass {
    /// The size of what is drawn into.
    pub(super) fn extent(&self) -> Option<Extent> {
        let depths = self.depth.iter().map(|depth| &depth.image);
        let mut images = self.targets.iter().map(|target| &target.image).chain(depths);
        images.next().map(|image| image.extent())
    }
}

/// A vertex buffer from some byte on.
#[derive(Clone)]
pub struct Stream {
    /// The buffer.
    pub buffer: Arc<Buffer>,
    /// The first element's place; a multiple of 4.
    pub offset: u64,
}

/// Which vertices to draw.
#[derive(Clone)]
pub enum Elements {
    /// These.
    Vertices(Range<u32>),
    /// Those that 32-bit indices name.
    Indices {
        /// The indices.
        buffer: Arc<Buffer>,
        /// Which of them.
        range: Range<u32>,
        /// Added to each.
        base_vertex: i32,
    },
}

/// One draw. Equal neighbours in pipeline, bindings and buffers cost nothing to switch.
#[derive(Clone)]
pub struct Draw {
    /// How.
    pub pipeline: Arc<GraphicsPipeline>,
    /// What shaders read.
    pub bindings: Option<Arc<Bindings>>,
    /// The push constants.
    pub push: Push,
    /// The vertex buffer, where the pipeline has one.
    pub stream: Option<Stream>,
    /// The vertices.
    pub elements: Elements,
    /// The instances; `gl_InstanceIndex` runs over this range.
    pub instances: Range<u32>,
}

/// Push constants by value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Push {
    bytes: [u8; Self::LIMIT],
    size: u8,
}

impl Push {
    /// The most bytes, which every device has.
    pub const LIMIT: usize = 128;
    /// No push constants.
    pub const NONE: Self = Self {
        bytes: [0; Self::LIMIT],
        size: 0,
    };

    /// The bytes of `value`. A type that is too large or no multiple of 4 does not compile.
    pub fn of<T: bytemuck::NoUninit>(value: &T) -> Self {
        const { assert!(size_of::<T>() <= Self::LIMIT && size_of::<T>().is_multiple_of(4)) };
        let mut push = Self {
            size: size_of::<T>() as u8,
            ..Self::NONE
        };
        push.bytes[..size_of::<T>()].copy_from_slice(bytemuck::bytes_of(value));
        push
    }

    /// The bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..usize::from(self.size)]
    }
}

impl Recording {
    /// Nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Fills all of `image` from the beginning of `buffer`.
    pub fn upload(&mut self, buffer: &Arc<Buffer>, image: &Arc<Image>) {
        self.commands.push(Command::Upload(whole(buffer, image)));
    }

    /// Fills the beginning of `buffer` from all of `image`.
    pub fn read_back(&mut self, image: &Arc<Image>, buffer: &Arc<Buffer>) {
        self.commands.push(Command::ReadBack(whole(buffer, image)));
    }

    /// Draws.
    pub fn render(&mut self, pass: RenderPass) {
        self.commands.push(Command::Render(pass));
    }
}

fn whole(buffer: &Arc<Buffer>, image: &Arc<Image>) -> ImageCopy {
    ImageCopy {
        buffer: Arc::clone(buffer),
        offset: 0,
        image: Arc::clone(image),
        region: image.region(),
    }
}
