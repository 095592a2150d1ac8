//! Which transfer function a scene asks for.

use crate::math::Interval;
use crate::projection::TransferFunction;
use crate::projection::presets::{self, DataStatistics, Preset};

/// Where control points come from.
#[derive(Clone, Debug, PartialEq)]
pub enum TransferChoice {
    /// The preset that suits the data.
    Automatic,
    /// This preset.
    Preset(&'static Preset),
    /// These points.
    Points(TransferFunction),
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

    /// The transfer function for data with these statistics in a model whose bounds have this diagonal.
    pub fn function(&self, data: &DataStatistics, diagonal_mm: f64) -> TransferFunction {
        let preset = match &self.choice {
            TransferChoice::Points(function) => return function.clone(),
            TransferChoice::Preset(preset) => preset,
            TransferChoice::Automatic => presets::suited_to(data),
        };
        let window = self.window.unwrap_or_else(|| preset.window_for(data));
        let unit_mm = self.unit_mm.unwrap_or_else(|| preset.unit_for(diagonal_mm));
        preset.transfer_function(window, unit_mm)
    }
}
