//! Looking at what is drawn so far: which tiles of the frame are still open.

use std::sync::Arc;

use super::layers::{over_frame, target};
use super::pipelines::Pipelines;
use super::slices::SliceRenderer;
use crate::gpu::{Buffer, BufferRole, Draw, Extent, Format, GpuError, Image, ImageRole, Load, Recording, RenderPass};
use crate::projection::OpenTiles;

/// The format of pictures of tiles: 0 for what is closed.
pub const TILE_FORMAT: Format = Format::R8_UNORM;

/// Looks at one frame, as often as is asked.
pub struct Looks {
    /// A pixel a tile.
    tiles: Arc<Image>,
    draw: Draw,
    size: [u32; 2],
}

/// What was seen, once the device is done with it.
pub struct Look {
    tiles: Arc<Buffer>,
    size: [u32; 2],
}

impl Looks {
    /// At what is accumulated in `frame`.
    pub fn new(renderer: &mut SliceRenderer, frame: &Arc<Image>) -> Result<Self, GpuError> {
        let [width, height, _] = frame.extent().edges();
        let [across, down] = OpenTiles::dims([width, height]);
        let extent = Extent::D2(across, down);
        let device = Arc::clone(&renderer.device);
        Ok(Self {
            tiles: Image::new(&device, "open tiles", ImageRole::ColorTarget, TILE_FORMAT, extent)?,
            draw: over_frame(renderer, frame, Pipelines::open)?,
            size: [width, height],
        })
    }

    /// Adds a look to `recording`.
    pub fn look(&self, renderer: &SliceRenderer, recording: &mut Recording) -> Result<Look, GpuError> {
        let buffer = Buffer::new(&renderer.device, "open tiles", BufferRole::Readback, self.tiles.bytes())?;
        recording.render(RenderPass {
            targets: vec![target(&self.tiles, Load::Clear([0.0; 4]))],
            depth: None,
            draws: vec![self.draw.clone()],
        });
        recording.read_back(&self.tiles, &buffer);
        Ok(Look {
            tiles: buffer,
            size: self.size,
        })
    }
}

impl Look {
    /// The tiles that were open then; waits for the device.
    pub fn open(&self) -> Result<OpenTiles, GpuError> {
        self.tiles.read(|tiles| OpenTiles::new(self.size, |n| tiles[n] != 0))
    }
}
