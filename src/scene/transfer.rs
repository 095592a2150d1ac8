//! Which transfer function a scene asks for.

use crate::math::Interval;
use crate::projection::TransferFunction;
use crate::projection::presets::{self, DataStatistics, Look, Preset};
use crate::projection::volume_property::VolumeProperty;

/// Where control points come from.
#[derive(Clone, Debug, PartialEq)]
pub enum TransferChoice {
    /// The preset that suits the data.
    Automatic,
    /// This preset.
    Preset(&'static Preset),
    /// These points.
    Points(TransferFunction),
    /// What a file says.
    File(VolumeProperty),
}

/// A scene's `transfer` node.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferSpec {
    /// Where control points come from.
    pub choice: TransferChoice,
    /// The values that a preset is fitted to.
    pub window: Option<Interval>,
    /// The length that a preset's opacities hold for, millimetres; the preset's own when `None`.
    pub unit_mm: Option<f64>,
}

impl TransferSpec {
    /// The preset that suits the data, fitted to it.
    pub const AUTOMATIC: Self = Self {
        choice: TransferChoice::Automatic,
        window: None,
        unit_mm: None,
    };

    /// The mode and the shading that come with it: those of a preset or a file. The preset that suits the data brings the usual ones.
    pub fn look(&self) -> Option<Look> {
        match &self.choice {
            TransferChoice::Preset(preset) => Some(preset.look()),
            TransferChoice::File(property) => Some(property.look()),
            TransferChoice::Automatic | TransferChoice::Points(_) => None,
        }
    }

    /// The transfer function for data with these statistics in a model whose bounds have this diagonal.
    pub fn function(&self, data: &DataStatistics, diagonal_mm: f64) -> TransferFunction {
        let preset = match &self.choice {
            TransferChoice::Points(function) => return function.clone(),
            TransferChoice::File(property) => return self.with_unit(&property.function),
            TransferChoice::Preset(preset) => preset,
            TransferChoice::Automatic => presets::suited_to(data),
        };
        let unit_mm = self.unit_mm.unwrap_or_else(|| preset.unit_for(diagonal_mm));
        match self.window {
            Some(window) => preset.transfer_function(window, unit_mm),
            None => preset.fitted(data, unit_mm),
        }
    }

    /// `function` with opacities that hold for the length that is asked for, if one is.
    pub(super) fn with_unit(&self, function: &TransferFunction) -> TransferFunction {
        let unit_mm = self.unit_mm.unwrap_or(function.unit_mm());
        TransferFunction::new(function.points().to_vec(), unit_mm).unwrap_or_else(|_| function.clone())
    }
}
