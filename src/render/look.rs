//! Looking at what is drawn so far: which tiles of the frame are still open.

use std::sync::Arc;

use super::layers::rectangle;
use super::slices::SliceRenderer;
use crate::gpu::{Binding, Bindings, Buffer, BufferRole, Draw, GpuError, GraphicsPipeline, Image};
use crate::projection::OpenTiles;

/// Looks at one frame, as often as is asked.
pub struct Looks {
    frame: Arc<Image>,
    pipeline: Arc<GraphicsPipeline>,
    size: [u32; 2],
}

/// What was seen, once the device is done with it.
pub struct Look {
    /// Of each tile, in rows: 0 if it is closed.
    tiles: Arc<Buffer>,
    size: [u32; 2],
}

impl Looks {
    /// At what is accumulated in `frame`.
    pub fn new(renderer: &mut SliceRenderer, frame: &Arc<Image>) -> Result<Self, GpuError> {
        let [width, height, _] = frame.extent().edges();
        let device = Arc::clone(&renderer.device);
        Ok(Self {
            frame: Arc::clone(frame),
            pipeline: renderer.pipelines.open(&device)?,
            size: [width, height],
        })
    }

    /// A look, and what is to be drawn for it in a pass of the frame's size with depths: a pixel a tile.
    pub fn look(&self, renderer: &SliceRenderer) -> Result<(Draw, Look), GpuError> {
        let [across, down] = OpenTiles::dims(self.size);
        let bytes = size_of::<u32>() as u64 * u64::from(across) * u64::from(down);
        let tiles = Buffer::new(&renderer.device, "open tiles", BufferRole::Readback, bytes)?;
        let entries = [
            Binding::SampledImage(Arc::clone(&self.frame), Arc::clone(&renderer.nearest)),
            Binding::WrittenStorage(Arc::clone(&tiles)),
        ];
        let bindings = Bindings::new(&renderer.device, "open tiles", &entries)?;
        let [width, height] = self.size;
        let ends = [0.0, 0.0, across as f32 / width as f32, down as f32 / height as f32];
        let size = self.size;
        Ok((rectangle(&self.pipeline, bindings, ends), Look { tiles, size }))
    }
}

impl Look {
    /// The tiles that were open then; waits for the device.
    pub fn open(&self) -> Result<OpenTiles, GpuError> {
        let tiles = self.tiles.read_vec::<u32>()?;
        Ok(OpenTiles::new(self.size, |n| tiles[n] != 0))
    }
}
