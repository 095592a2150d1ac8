//! Options that stand in for what a scene says about how it is seen.

use std::path::Path;

use clap::{Args, ValueEnum};
use glam::DVec3;

use super::CliError;
use super::console::note;
use crate::math::Interval;
use crate::projection::presets::{self, Preset};
use crate::projection::rgb_from_hex;
use crate::projection::volume_property;
use crate::projection::{Mode, Projection};
use crate::scene::{Scene, SurfaceSpec, TransferChoice, TransferSpec, parse_size};

/// How samples become a pixel.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum ModeName {
    Composite,
    Mip,
    Minip,
    Average,
    Additive,
    Xray,
}

/// What is changed of how a scene is seen.
#[derive(Debug, Args)]
pub(super) struct Overrides {
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// A preset: transfer function, mode and shading. A name (`vcsg presets` lists them), or 3D Slicer's .vp.json or .vp file
    #[arg(long, value_name = "NAME|FILE")]
    preset: Option<String>,
    /// Draw the surface of this value, in place of the scene's own; may be repeated. The volume is drawn with it only where a
    /// transfer function (--preset) or a --mode other than composite says how
    #[arg(long, value_name = "ISO", value_parser = finite, allow_negative_numbers = true)]
    surface: Vec<f64>,
    /// Width of the range of values that the preset is fitted to
    #[arg(long, value_name = "W", requires = "level", value_parser = positive)]
    window: Option<f64>,
    /// Middle of that range
    #[arg(long, value_name = "L", requires = "window", value_parser = finite, allow_negative_numbers = true)]
    level: Option<f64>,
    /// Degrees round the body's axis, towards the patient's left
    #[arg(long, value_name = "DEG", value_parser = finite, allow_negative_numbers = true)]
    azimuth: Option<f64>,
    /// Degrees above the axial plane
    #[arg(long, value_name = "DEG", value_parser = finite, allow_negative_numbers = true)]
    elevation: Option<f64>,
    /// Degrees about the line of sight
    #[arg(long, value_name = "DEG", value_parser = finite, allow_negative_numbers = true)]
    roll: Option<f64>,
    /// Magnification; 1 fits the model's bounding sphere
    #[arg(long, value_name = "Z", value_parser = positive)]
    zoom: Option<f64>,
    /// See in perspective, with this vertical field of view
    #[arg(long, value_name = "DEG", value_parser = field_of_view)]
    perspective: Option<f64>,
    /// How samples become a pixel
    #[arg(long)]
    mode: Option<ModeName>,
    /// Draw flat colours without light
    #[arg(long)]
    no_shading: bool,
    /// Sampling planes a voxel along the view axis
    #[arg(long, value_name = "N", value_parser = samples)]
    samples_per_voxel: Option<f64>,
    /// "#rrggbb" or "transparent"
    #[arg(long, value_name = "COLOR", value_parser = background)]
    background: Option<[f32; 4]>,
}

impl Overrides {
    /// Says what is not taken of a preset's file: once, however many frames are drawn with it.
    pub fn remark(&self) -> Result<(), CliError> {
        let named = self.preset.as_deref().map(Path::new);
        if let Some(file) = named.filter(|path| volume_property::is_volume_property(path)) {
            for left_out in volume_property::read(file)?.left_out {
                note(&format!("{}: not taken: {left_out}", file.display()));
            }
        }
        Ok(())
    }

    /// Sets in `scene` what was given.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), CliError> {
        self.apply_transfer(scene)?;
        if !self.surface.is_empty() {
            scene.surfaces = self.surface.iter().map(|iso| SurfaceSpec::at(*iso)).collect();
        }
        let set = |to: &mut f64, from: Option<f64>| *to = from.unwrap_or(*to);
        set(&mut scene.view.azimuth_deg, self.azimuth);
        set(&mut scene.view.elevation_deg, self.elevation);
        set(&mut scene.view.roll_deg, self.roll);
        set(&mut scene.view.zoom, self.zoom);
        set(&mut scene.settings.samples_per_voxel, self.samples_per_voxel);
        if let Some(fov_y_deg) = self.perspective {
            scene.view.projection = Projection::Perspective { fov_y_deg };
        }
        if let Some(mode) = self.mode {
            scene.settings.mode = mode.into();
        }
        if self.no_shading {
            scene.settings.shading = None;
        }
        scene.settings.background = self.background.unwrap_or(scene.settings.background);
        scene.frame_size = self.size.or(scene.frame_size);
        Ok(())
    }

    fn apply_transfer(&self, scene: &mut Scene) -> Result<(), CliError> {
        if scene.has_colors() && (self.preset.is_some() || self.window.is_some()) {
            let why = "the scene's samples are colours, by its `classify` nodes: --preset and --window have no values to show";
            return Err(CliError::Usage(why.into()));
        }
        if let Some(name) = &self.preset {
            let transfer = TransferSpec {
                choice: chosen(name)?,
                ..TransferSpec::AUTOMATIC
            };
            if let Some(look) = transfer.look() {
                look.apply(&mut scene.settings);
            }
            scene.transfer = Some(transfer);
        }
        if let (Some(width), Some(level)) = (self.window, self.level) {
            let transfer = scene.transfer.get_or_insert(TransferSpec::AUTOMATIC);
            if matches!(transfer.choice, TransferChoice::Points(_) | TransferChoice::File(_)) {
                let why = "the transfer function has points of its own; give --window with the name of a --preset";
                return Err(CliError::Usage(why.into()));
            }
            let half = 0.5 * width;
            transfer.window = Some(Interval::new((level - half) as f32, (level + half) as f32));
        }
        Ok(())
    }
}

/// The preset called `name`, or what the file of that name holds.
fn chosen(name: &str) -> Result<TransferChoice, CliError> {
    let path = Path::new(name);
    if !volume_property::is_volume_property(path) {
        return Ok(TransferChoice::Preset(preset_named(name)?));
    }
    Ok(TransferChoice::File(volume_property::read(path)?.property))
}

/// The preset called `name`.
pub(super) fn preset_named(name: &str) -> Result<&'static Preset, CliError> {
    presets::named(name).ok_or_else(|| unknown_preset(name))
}

fn unknown_preset(name: &str) -> CliError {
    let line = |p: &Preset| format!("\n  {:<16} {}", p.name(), p.description());
    let list: String = presets::all().iter().map(line).collect();
    CliError::Usage(format!("unknown preset {name:?}; there are:{list}"))
}

impl From<ModeName> for Mode {
    fn from(name: ModeName) -> Self {
        match name {
            ModeName::Composite => Self::Composite,
            ModeName::Mip => Self::Mip,
            ModeName::Minip => Self::MinIp,
            ModeName::Average => Self::Average,
            ModeName::Additive => Self::Additive,
            ModeName::Xray => Self::XRay,
        }
    }
}

fn finite(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|n: &f64| n.is_finite());
    number.ok_or_else(|| "not a finite number".into())
}

pub(super) fn point(text: &str) -> Result<DVec3, String> {
    let numbers: Result<Vec<f64>, String> = text.split(',').map(|number| finite(number.trim())).collect();
    match numbers?[..] {
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        _ => Err("not three numbers X,Y,Z".into()),
    }
}

pub(super) fn single(text: &str) -> Result<f32, String> {
    let number = finite(text)? as f32;
    if number.is_finite() {
        Ok(number)
    } else {
        Err("beyond single precision".into())
    }
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    bounded(text, f64::MIN_POSITIVE, f64::MAX).map_err(|_| "not a number above 0".into())
}

fn field_of_view(text: &str) -> Result<f64, String> {
    bounded(text, 1.0, 170.0)
}

fn samples(text: &str) -> Result<f64, String> {
    bounded(text, 1.0 / 64.0, 64.0)
}

fn bounded(text: &str, lo: f64, hi: f64) -> Result<f64, String> {
    let number = finite(text)?;
    if (lo..=hi).contains(&number) {
        Ok(number)
    } else {
        Err(format!("not in {lo}..{hi}"))
    }
}

fn size(text: &str) -> Result<[u32; 2], String> {
    parse_size(text).ok_or_else(|| "not a size like 1024x768, each side in 1..16384".into())
}

fn background(text: &str) -> Result<[f32; 4], String> {
    if text == "transparent" {
        return Ok([0.0; 4]);
    }
    let [r, g, b] = rgb_from_hex(text).ok_or("neither \"transparent\" nor a colour like #101820")?;
    Ok([r, g, b, 1.0])
}
