//! `vcsg presets`: what presets there are, one's text, a sheet of pictures, and files for 3D Slicer.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use super::CliError;
use super::console::{note, print, print_json};
use super::job::{model_bounds, statistics};
use super::overrides::preset_named;
use super::swatch;
use crate::gpu::DeviceSelector;
use crate::image::FileFormat;
use crate::projection::presets::{self, Preset, Scale};
use crate::projection::volume_property::{self, VolumeProperty};
use crate::projection::{Mode, TransferFunction};
use crate::scene::{Scene, VolumeFiles};
use crate::volume::io::ReadOptions;

/// List the presets, print one, draw a sheet of them, or write one for 3D Slicer
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  vcsg presets
  vcsg presets ct-bone
  vcsg presets ct-bone --write bone.vp.json
  vcsg presets mr-t1-brain --write brain.vp.json --volume head.nii.gz
  vcsg presets --swatch presets.png --volume ct.nrrd --volume head.nii.gz")]
pub(super) struct Presets {
    /// The preset that is meant; all of them unless said
    #[arg(value_name = "NAME")]
    name: Option<String>,
    /// Describe the presets as JSON on stdout
    #[arg(long, conflicts_with_all = ["write", "swatch"])]
    json: bool,
    /// Write the preset as 3D Slicer's .vp.json
    #[arg(long, value_name = "FILE", requires = "name", conflicts_with = "swatch")]
    write: Option<PathBuf>,
    /// Draw each preset's colours and opacities (as high as the square root), and a picture with it
    #[arg(long, value_name = "FRAME")]
    swatch: Option<PathBuf>,
    /// What presets are fitted to and pictures show: of several the first that suits a preset. A phantom unless said
    #[arg(long, value_name = "VOLUME")]
    volume: Vec<PathBuf>,
    /// The Vulkan device that draws
    #[arg(long, value_name = "DEVICE", default_value = "default", requires = "swatch")]
    device: DeviceSelector,
}

impl Presets {
    /// Does what was asked for.
    pub fn run(&self) -> Result<(), CliError> {
        let chosen: Vec<&Preset> = match &self.name {
            Some(name) => vec![preset_named(name)?],
            None => presets::all().iter().collect(),
        };
        match (&self.swatch, &self.write, &chosen[..]) {
            (Some(picture), ..) => {
                FileFormat::of(picture)?;
                swatch::write(picture, &chosen, &self.volume, &self.device)
            }
            (None, Some(file), [preset, ..]) => self.write(preset, file),
            _ if self.json => {
                print_json(&json!({ "presets": chosen.iter().map(|p| described(p)).collect::<Vec<_>>() }))
            }
            (None, None, [preset]) => print(preset.text().trim_end()),
            _ => print(&chosen.iter().map(|p| line(p)).collect::<Vec<_>>().join("\n")),
        }
    }

    fn write(&self, preset: &Preset, file: &Path) -> Result<(), CliError> {
        let function = match self.volume.first() {
            Some(volume) => fitted(preset, volume)?,
            None => preset.own_function().clone(),
        };
        if self.volume.is_empty() && preset.scale() != Scale::Absolute {
            note(&format!(
                "{}: its values are fitted to data: give the data as --volume, or move the points in 3D Slicer",
                preset.name()
            ));
        }
        let look = preset.look();
        if look.mode != Mode::Composite {
            let mode = look.mode.name();
            note(&format!("the mode {mode} has no place in {}", file.display()));
        }
        let property = VolumeProperty {
            function,
            material: look.material,
        };
        Ok(volume_property::write(file, &property)?)
    }
}

/// `preset` for the values of `volume`.
fn fitted(preset: &Preset, volume: &Path) -> Result<TransferFunction, CliError> {
    let scene = Scene::open(volume, &ReadOptions::default(), &mut VolumeFiles)?;
    let target = scene.target.build(&scene.model)?;
    let unit_mm = preset.unit_for(model_bounds(&scene).size().length());
    Ok(preset.fitted(&statistics(&target), unit_mm))
}

fn line(preset: &Preset) -> String {
    let look = preset.look();
    let light = if look.material.is_some() { "shaded" } else { "flat" };
    format!(
        "{:<17} {:<3} {:<9} {light:<6} {}",
        preset.name(),
        preset.kind().name(),
        look.mode.name(),
        preset.description()
    )
}

fn described(preset: &Preset) -> serde_json::Value {
    let look = preset.look();
    let material = look.material.map(|m| {
        json!({
            "ambient": m.ambient,
            "diffuse": m.diffuse,
            "specular": m.specular,
            "shininess": 1u32 << m.shininess_log2,
        })
    });
    let point =
        |p: &crate::projection::ControlPoint| json!({ "value": p.value, "opacity": p.opacity, "color": p.color });
    let function = preset.own_function();
    json!({
        "name": preset.name(),
        "kind": preset.kind().name(),
        "scale": preset.scale().name(),
        "mode": look.mode.name(),
        "material": material,
        "unit_mm": function.unit_mm(),
        "range": [preset.range().lo, preset.range().hi],
        "description": preset.description(),
        "points": function.points().iter().map(point).collect::<Vec<_>>(),
    })
}
