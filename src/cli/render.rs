//! `vcsg render`: a frame to a file.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde_json::json;

use super::CliError;
use super::console::{Stages, print_json};
use super::frames::FrameArgs;
use super::job::{Renderer, model_bounds, no_surfaces, transfer_function};
use super::levels;
use super::overrides::Overrides;
use super::source::SourceArgs;
use super::surfaces::Surface;
use super::trace::{self, TraceArgs};
use crate::gpu::{DeviceSelector, Validation};
use crate::image::{FileFormat, Frame, save};
use crate::projection::trace::Progressive;
use crate::projection::{Camera, FrameSpec};
use crate::scene::Scene;
use crate::target::Target;

/// Draw a scene or a volume into a picture
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  vcsg render head.nii.gz -o head.png
  vcsg render scene.kdl -o scene.png --size 1920x1080 --azimuth 30 --elevation 15
  vcsg render ct.nrrd -o bone.png --preset ct-bone --background transparent
  vcsg render head.nii.gz -o skin.png --surface 60
  vcsg render mra.nii.gz -o mip.exr --mode mip --perspective 30
  vcsg render scene.kdl -o cast.png --renderer raycast
  vcsg render mirror.kdl -o traced.png --renderer trace --samples 16 --progressive
  vcsg render scene.kdl -o truth.png --renderer reference --size 320x240
  vcsg render scene.kdl -o frame-%04d.png --frames 0..119 --video scene.mp4")]
pub(super) struct Render {
    #[command(flatten)]
    pub source: SourceArgs,
    /// The picture: .png (8 bits, straight alpha) or .exr (float, premultiplied); with --frames its name has %d or %04d for the
    /// frame's number
    #[arg(short, long, value_name = "FRAME")]
    pub output: PathBuf,
    #[command(flatten)]
    frames: FrameArgs,
    /// What draws: slices on a Vulkan device, rays cast or traced on the processor, or the slow reference there; tracing where the
    /// scene needs it, else slices unless there is no device
    #[arg(long)]
    renderer: Option<RendererName>,
    /// The Vulkan device: an index, part of a name, or uuid:…; `vcsg devices` lists them
    #[arg(long, value_name = "DEVICE", default_value = "default")]
    device: DeviceSelector,
    /// Have Vulkan's validation layer watch; any message is an error
    #[arg(long)]
    validation: bool,
    #[command(flatten)]
    pub overrides: Overrides,
    #[command(flatten)]
    tracing: TraceArgs,
    /// Print how long each stage took
    #[arg(long)]
    pub timings: bool,
    /// Describe the frame as JSON on stdout
    #[arg(long)]
    pub json: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum RendererName {
    Slices,
    Raycast,
    Trace,
    Reference,
}

/// The size of a frame that nobody gave one.
pub(super) const DEFAULT_SIZE: [u32; 2] = [1024, 768];

impl Render {
    /// Loads, draws, writes.
    pub fn run(&self) -> Result<(), CliError> {
        // A name that cannot be written is known before the work is done.
        FileFormat::of(&self.output)?;
        self.overrides.remark()?;
        if let Some(range) = self.frames.frames {
            return self.frames.draw(self, range);
        }
        let mut stages = Stages::default();
        let mut scene = stages.time("load", || self.source.load())?;
        self.overrides.apply(&mut scene)?;
        let mut renderer = stages.time("device", || self.renderer(&scene))?;
        let size = scene.frame_size.unwrap_or(DEFAULT_SIZE);
        let camera = scene.view.camera(&model_bounds(&scene), size);
        let (frame, shown) = match &mut renderer {
            Renderer::Tracer(sampling) => {
                let between = &mut |passes: &Progressive| match self.tracing.progressive {
                    true => self.write(&over_background(passes.frame(), &scene)),
                    false => Ok(()),
                };
                trace::draw(&scene, &camera, *sampling, &mut stages, between)?
            }
            renderer if scene.target.levels > 1 => {
                let (frame, zones) = levels::draw(&scene, &camera, renderer, &mut stages)?;
                (frame, levels::description(&zones))
            }
            renderer => draw(&scene, &camera, renderer, &mut stages)?,
        };
        let frame = over_background(frame, &scene);
        stages.time("write", || self.write(&frame))?;
        if self.timings {
            stages.show();
        }
        if self.json {
            print_json(&self.description(&frame, shown, &renderer, &stages))
        } else {
            Ok(())
        }
    }

    /// Writes the picture, whole or not at all.
    fn write(&self, frame: &Frame) -> Result<(), CliError> {
        Ok(save(frame, &self.output, &[("Software", "vcsg")])?)
    }

    /// What draws `scene`.
    pub fn renderer(&self, scene: &Scene) -> Result<Renderer, CliError> {
        let validation = if self.validation {
            Validation::On
        } else {
            Validation::Off
        };
        let on_device = || Renderer::on_device(&self.device, validation);
        let traced = match self.renderer {
            None => scene.trace.is_needed(),
            Some(renderer) => matches!(renderer, RendererName::Trace),
        };
        self.check_tracing(scene, traced)?;
        match self.renderer {
            None if traced => Ok(Renderer::Tracer(self.tracing.sampling(scene))),
            None if self.device == DeviceSelector::default() => Renderer::or_ray_caster(on_device()),
            None | Some(RendererName::Slices) => on_device(),
            Some(RendererName::Raycast) => Ok(Renderer::RayCaster),
            Some(_) if !scene.surfaces.is_empty() => Err(no_surfaces()),
            Some(RendererName::Trace) => Ok(Renderer::Tracer(self.tracing.sampling(scene))),
            Some(RendererName::Reference) => Ok(Renderer::Reference),
        }
    }

    /// Refuses what goes with tracing alone where rays are not traced, and the other way round.
    fn check_tracing(&self, scene: &Scene, traced: bool) -> Result<(), CliError> {
        let why = match traced {
            true if !scene.surfaces.is_empty() => return Err(no_surfaces()),
            false if scene.trace.is_needed() => {
                "the scene has objects, optics or lights that only tracing shows: take --renderer trace"
            }
            false if self.tracing.given() => "--samples, --depth, --seed and --progressive go with --renderer trace",
            _ => return Ok(()),
        };
        Err(CliError::Usage(why.into()))
    }

    /// What was drawn: `shown`, a JSON object, and what holds for any frame.
    fn description(
        &self,
        frame: &Frame,
        shown: serde_json::Value,
        renderer: &Renderer,
        stages: &Stages,
    ) -> serde_json::Value {
        let mut description = json!({
            "frame": self.output,
            "size": [frame.width(), frame.height()],
            "device": renderer.device_name(),
            "milliseconds": stages.to_json(),
        });
        if let (Some(all), serde_json::Value::Object(shown)) = (description.as_object_mut(), shown) {
            all.extend(shown);
        }
        description
    }
}

/// `frame` before the scene's background, if it has one.
pub(super) fn over_background(frame: Frame, scene: &Scene) -> Frame {
    let [r, g, b, alpha] = scene.settings.background;
    if alpha > 0.0 { frame.over([r, g, b]) } else { frame }
}

/// What `scene` shows: its surfaces, its samples, or both; and what that is made of, for `--json`.
fn draw(
    scene: &Scene,
    camera: &Camera,
    renderer: &mut Renderer,
    stages: &mut Stages,
) -> Result<(Frame, serde_json::Value), CliError> {
    let target = stages.time("subdivide", || scene.target.build(&scene.model))?;
    let surfaces = Surface::extract_all(&scene.surfaces, &target, stages)?;
    let frame = if scene.shows_samples() {
        let transfer = stages.time("transfer", || transfer_function(scene, &target));
        let spec = FrameSpec {
            target: &target,
            transfer: &transfer,
            camera,
            settings: &scene.settings,
        };
        renderer.draw(&spec, &surfaces, stages)?
    } else {
        renderer.draw_surfaces(camera, &scene.settings, &surfaces, stages)?
    };
    Ok((frame, described(&target, &surfaces)))
}

fn described(target: &Target, surfaces: &[Surface]) -> serde_json::Value {
    json!({
        "lattice": target.lattice.dims,
        "spacing_mm": target.lattice.spacing_mm().to_array(),
        "blocks": target.blocks.len(),
        "value_range": [target.value_range.lo, target.value_range.hi],
        "surfaces": surfaces.iter().map(Surface::description).collect::<Vec<_>>(),
    })
}
