//! What a frame shows of the samples along a ray.

use super::{DepthCue, Shading};

/// How the samples along a ray become a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Emission and absorption through the transfer function.
    #[default]
    Composite,
    /// Largest value, as a grey of the transfer function's window.
    Mip,
    /// Smallest value, as a grey of the window.
    MinIp,
    /// Mean value over the covered length, as a grey of the window.
    Average,
    /// Emission without absorption.
    Additive,
    /// Absorption of a light behind: `1 − exp(−∫ opacity)`, bright where the model is dense.
    XRay,
}

impl Mode {
    /// All modes.
    pub const ALL: [Self; 6] = [
        Self::Composite,
        Self::Mip,
        Self::MinIp,
        Self::Average,
        Self::Additive,
        Self::XRay,
    ];

    /// The modes' names in scenes, presets and on the command line.
    pub const NAMES: &[(&str, Self)] = &[
        ("composite", Self::Composite),
        ("mip", Self::Mip),
        ("minip", Self::MinIp),
        ("average", Self::Average),
        ("additive", Self::Additive),
        ("xray", Self::XRay),
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        let named = Self::NAMES.iter().find(|(_, mode)| *mode == self);
        named.map_or("composite", |(name, _)| name)
    }
}

/// How a target is drawn, the camera apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// How samples become a pixel.
    pub mode: Mode,
    /// Lights and material; flat colours when `None`. Only [`Mode::Composite`] is shaded.
    pub shading: Option<Shading>,
    /// Darkening with depth.
    pub depth_cue: DepthCue,
    /// Sampling planes for each finest lattice spacing along the view axis, above 0.
    pub samples_per_voxel: f64,
    /// Straight RGBA of what is behind, display-referred, in [0, 1].
    pub background: [f32; 4],
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            mode: Mode::default(),
            shading: Some(Shading::default()),
            depth_cue: DepthCue::default(),
            samples_per_voxel: 1.0,
            background: [0.0, 0.0, 0.0, 1.0],
        }
    }
}
