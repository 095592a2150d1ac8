//! The scene or volume that a command works on, and how its target is built.

use std::path::PathBuf;

use clap::Args;

use super::CliError;
use crate::scene::{Scene, VolumeFiles, VolumeLoader};

/// What is read, and what is changed of how its target is built.
#[derive(Debug, Args)]
pub(super) struct SourceArgs {
    /// A scene file (.kdl), or a volume file (.nrrd, .nhdr, .nii, .nii.gz, .hdr)
    #[arg(value_name = "SCENE|VOLUME")]
    pub path: PathBuf,
    /// Distance between samples, millimetres
    #[arg(long, value_name = "MM", value_parser = super::overrides::positive)]
    spacing: Option<f64>,
    /// The most memory for target blocks
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u32).range(1..))]
    budget_mib: Option<u32>,
    /// Make a target beyond the budget coarser instead of refusing it
    #[arg(long)]
    coarsen: bool,
}

impl SourceArgs {
    /// Whether a volume is to be sampled on another lattice than its own.
    pub fn resamples(&self) -> bool {
        self.spacing.is_some()
    }

    /// The scene, with the options that were given in place of its own.
    pub fn load(&self) -> Result<Scene, CliError> {
        self.load_with(&mut VolumeFiles)
    }

    /// The same, with volumes from `loader`.
    pub fn load_with(&self, loader: &mut dyn VolumeLoader) -> Result<Scene, CliError> {
        let mut scene = Scene::open(&self.path, loader)?;
        self.apply(&mut scene);
        Ok(scene)
    }

    /// Sets in `scene` what was given.
    pub fn apply(&self, scene: &mut Scene) {
        scene.target.spacing_mm = self.spacing.or(scene.target.spacing_mm);
        scene.target.budget_mib = self.budget_mib.unwrap_or(scene.target.budget_mib);
        scene.target.coarsen |= self.coarsen;
    }
}
