//! From a scene to a frame by ray tracing.

use clap::Args;
use serde_json::json;

use super::CliError;
use super::console::{Stages, progress};
use super::job::{object_transfer, transfer_function};
use crate::image::Frame;
use crate::projection::trace::{self, Object, Optics, Progressive, Sampling, World};
use crate::projection::{Camera, TransferFunction};
use crate::scene::{ObjectSpec, Scene, TargetOptions};
use crate::target::{Levels, Target};

/// How a scene is traced.
#[derive(Debug, Args)]
#[command(next_help_heading = "Ray tracing")]
pub(super) struct TraceArgs {
    /// Samples of each pixel
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(Sampling::MAX_SAMPLES)))]
    samples: Option<u32>,
    /// Generations of mirrored and transmitted rays
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=i64::from(trace::Bounds::MAX_DEPTH)))]
    depth: Option<u32>,
    /// What random numbers depend on
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Write the picture after each sample of its pixels, so that a viewer shows it getting better; what is there is always a
    /// whole picture, and the last one is that without this option
    #[arg(long, conflicts_with = "frames")]
    pub progressive: bool,
}

impl TraceArgs {
    /// Whether anything was given.
    pub fn given(&self) -> bool {
        self.samples.is_some() || self.depth.is_some() || self.seed.is_some() || self.progressive
    }

    /// What was given, in place of what `scene` says.
    pub fn sampling(&self, scene: &Scene) -> Sampling {
        let mut sampling = scene.trace.sampling;
        sampling.samples = self.samples.unwrap_or(sampling.samples);
        sampling.seed = self.seed.unwrap_or(sampling.seed);
        sampling.bounds.depth = self.depth.unwrap_or(sampling.bounds.depth);
        sampling
    }
}

/// The frame of `scene` that `camera` sees, and what it is made of, for `--json`; `between` passes it sees what there is.
pub(super) fn draw(
    scene: &Scene,
    camera: &Camera,
    sampling: Sampling,
    stages: &mut Stages,
    between: &mut dyn FnMut(&Progressive) -> Result<(), CliError>,
) -> Result<(Frame, serde_json::Value), CliError> {
    let mut lattices = Vec::new();
    let world = stages.time("reconstruct", || world(scene, camera, &mut lattices))?;
    let mut progressive = Progressive::new(&world, camera, sampling)?;
    let pixels = camera.size.map(u64::from).iter().product::<u64>();
    let bar = progress("trace", pixels * u64::from(sampling.samples));
    for pass in 1..=sampling.samples {
        stages.time("trace", || progressive.pass(&|n| bar.inc(n)));
        if pass < sampling.samples {
            between(&progressive)?;
        }
    }
    bar.finish_and_clear();
    let shown = json!({ "objects": lattices, "samples": sampling.samples, "depth": sampling.bounds.depth });
    Ok((progressive.frame(), shown))
}

/// What is traced of `scene`; what lattices there are goes to `lattices`.
pub(super) fn world(scene: &Scene, camera: &Camera, lattices: &mut Vec<serde_json::Value>) -> Result<World, CliError> {
    trace::check_mode(scene.settings.mode)?;
    let mut settings = scene.settings.clone();
    if let Some(shading) = settings.shading.as_mut().filter(|_| !scene.trace.far_lights) {
        shading.lights.clear();
    }
    let objects = objects(scene, lattices)?;
    Ok(World::of(objects, &scene.trace.lights, camera, &settings)?)
}

/// The scene's own model, and its other objects; what their lattices are goes to `lattices`.
fn objects(scene: &Scene, lattices: &mut Vec<serde_json::Value>) -> Result<Vec<Object>, CliError> {
    let own = Traced {
        model: &scene.model,
        options: &scene.target,
        optics: scene.trace.optics,
    };
    let mut objects = vec![own.object(&|target| transfer_function(scene, target), lattices)?];
    for spec in &scene.trace.objects {
        let ObjectSpec {
            model, target, optics, ..
        } = spec;
        let traced = Traced {
            model,
            options: target,
            optics: *optics,
        };
        objects.push(traced.object(&|target| object_transfer(scene, spec, target), lattices)?);
    }
    Ok(objects)
}

/// A model that is traced.
struct Traced<'a> {
    model: &'a crate::model::Model,
    options: &'a TargetOptions,
    optics: Option<Optics>,
}

impl Traced<'_> {
    fn object(
        &self,
        transfer: &dyn Fn(&Target) -> TransferFunction,
        lattices: &mut Vec<serde_json::Value>,
    ) -> Result<Object, CliError> {
        let targets = self.targets()?;
        let [finest, coarser @ ..] = &targets[..] else {
            return Err(CliError::Usage("there is nothing to trace".into()));
        };
        for target in &targets {
            lattices.push(json!({
                "lattice": target.lattice.dims,
                "spacing_mm": target.lattice.spacing_mm().to_array(),
                "blocks": target.blocks.len(),
            }));
        }
        let object = Object::new(finest, &transfer(finest), self.optics);
        Ok(coarser.iter().fold(object, Object::with_level))
    }

    /// All levels, from the finest to the coarsest.
    fn targets(&self) -> Result<Vec<Target>, CliError> {
        let options = self.options;
        if options.levels <= 1 {
            return Ok(vec![options.build(self.model)?]);
        }
        let levels = Levels::new(self.model, options.spacing_mm, options.levels)?;
        let level = |level| {
            let mut target = Target::on_lattice(self.model, levels.whole(level)?, &options.subdivision())?;
            target.value_range = levels.value_range;
            Ok(target)
        };
        (0..levels.count).map(level).collect()
    }
}
