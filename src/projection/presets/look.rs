//! What a preset says beside its transfer function.

use crate::projection::{Material, Mode, Settings, Shading};

/// How samples become a pixel, and how they answer to light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// How samples become a pixel.
    pub mode: Mode,
    /// The material; `None` without shading.
    pub material: Option<Material>,
}

impl Look {
    /// Sets it in `settings`; their lights stay.
    pub fn apply(&self, settings: &mut Settings) {
        settings.mode = self.mode;
        let shaded = |material| Shading {
            material,
            ..settings.shading.clone().unwrap_or_default()
        };
        settings.shading = self.material.map(shaded);
    }
}
