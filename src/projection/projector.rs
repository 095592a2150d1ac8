//! The trait that every renderer shares, and what it is given.

use super::{Camera, Mode, Planes, Settings, Shading, TransferFunction, TransferTable};
use crate::image::Frame;
use crate::target::Target;

/// What a projector draws. Two projectors given the same draw the same frame (design law 3).
#[derive(Clone, Copy, Debug)]
pub struct FrameSpec<'a> {
    /// The model on its lattice.
    pub target: &'a Target,
    /// Values to colour and opacity.
    pub transfer: &'a TransferFunction,
    /// The eye and the frame's size.
    pub camera: &'a Camera,
    /// The mode, light and sampling.
    pub settings: &'a Settings,
}

/// Why a frame could not be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ProjectError {
    /// The graphics device refused.
    #[error(transparent)]
    Device(Box<dyn std::error::Error + Send + Sync>),
    /// The frame has no pixels, or more than can be drawn.
    #[error("a frame of {width} x {height} pixels cannot be drawn; each side must be in 1..={limit}")]
    FrameSize {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// The longest side possible.
        limit: u32,
    },
}

/// A renderer: target and view in, premultiplied frame out.
pub trait Projector {
    /// Draws one frame, background not included.
    ///
    /// # Errors
    /// If the device fails or the frame is impossible.
    fn project(&mut self, spec: &FrameSpec) -> Result<Frame, ProjectError>;
}

impl FrameSpec<'_> {
    /// The sampling planes.
    pub fn planes(&self) -> Planes {
        Planes::new(&self.target.lattice, self.camera, self.settings.samples_per_voxel)
    }

    /// The transfer function over the target's values for one step of depth.
    pub fn table(&self) -> TransferTable {
        let slab_mm = self.planes().step_mm;
        TransferTable::new(self.transfer, self.target.value_range, slab_mm)
    }

    /// Lights and material, where the mode has any.
    pub fn shading(&self) -> Option<&Shading> {
        match self.settings.mode {
            Mode::Composite => self.settings.shading.as_ref(),
            _ => None,
        }
    }
}
