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
    /// Values are to be seen, and there are colours.
    #[error(
        "the mode {mode:?} shows values, and the scene's samples are colours: take a mode that shows colours, or classify nothing"
    )]
    NoValues {
        /// The mode.
        mode: Mode,
    },
    /// A mode that rays are not traced in.
    #[error("the mode {mode:?} cannot be traced: take composite, or another renderer")]
    NotTraced {
        /// The mode.
        mode: Mode,
    },
    /// More objects than can be traced.
    #[error(transparent)]
    Objects(#[from] super::trace::TooManyObjects),
    /// A light that cannot be.
    #[error(transparent)]
    Light(#[from] super::trace::SourceError),
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
    /// Samples are too close.
    #[error("{samples_per_voxel} samples a voxel are more than {limit} along a ray: take fewer")]
    Planes {
        /// What was asked for.
        samples_per_voxel: f64,
        /// The most samples along a ray.
        limit: i64,
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

    /// The thickness of a slab in the unit lengths that the opacities of a target of colours hold for; `None` for a target of
    /// values, which the transfer function classifies.
    pub fn slab_units(&self) -> Option<f64> {
        let unit_mm = self.target.tree.color_unit_mm()?;
        Some(self.planes().step_mm / unit_mm)
    }

    /// Whether the mode shows what the target holds.
    ///
    /// # Errors
    /// If the mode shows values, and the target holds colours.
    pub fn check(&self) -> Result<(), ProjectError> {
        match self.settings.mode {
            mode if !mode.classifies() && self.target.tree.has_colors() => Err(ProjectError::NoValues { mode }),
            _ => Ok(()),
        }
    }

    /// Lights and material, where the mode has any.
    pub fn shading(&self) -> Option<&Shading> {
        match self.settings.mode {
            Mode::Composite => self.settings.shading.as_ref(),
            _ => None,
        }
    }
}
