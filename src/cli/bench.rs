//! `vcsg bench`: what drawing takes, stage by stage.
//!
//! [`figure3`] and [`figure8`] are of WK94's figures; what follows is of VCSG's.
//!
//! *Theory.* VCSG's table 1 has for scenes of its figure 6 what the target takes to build, and what each rendering takes after
//! that. This is the same table for our scenes of the figure.
//! *Changes from the paper.* All scenes are drawn by slices, and no texture is loaded again for a rendering: that is part of
//! building. Peers are measured in `benches/peers`.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use serde::Serialize;

use super::CliError;
use super::console::{print, print_json};
use super::job::{Renderer, model_bounds, transfer_function};
use super::render::DEFAULT_SIZE;
use super::{figure3, figure8};
use crate::gpu::{DeviceSelector, Validation};
use crate::model::Node;
use crate::projection::FrameSpec;
use crate::render::{PagedTarget, soft_normals};
use crate::scene::{Scene, VolumeFiles};

/// Measure what drawing takes, stage by stage
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  vcsg bench figure6
  vcsg bench figure3
  vcsg bench figure8 --picture errors.png
  vcsg bench figure6 --repetitions 9 --json > figure6.json")]
pub(super) struct Bench {
    /// What is measured: the scenes of VCSG's figure 6, beside its table 1; tracing WK94's figure 3, beside its times; errors of surfaces
    /// and normals as in WK94's figure 8
    name: Name,
    /// The folder of the scenes
    #[arg(long, value_name = "FOLDER", default_value = "assets/scenes")]
    scenes: PathBuf,
    /// Where figure 8 is written
    #[arg(long, value_name = "FRAME")]
    picture: Option<PathBuf>,
    /// How often each scene is built and drawn; medians are shown
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..))]
    repetitions: u16,
    /// The Vulkan device: an index, part of a name, or uuid:…
    #[arg(long, value_name = "DEVICE", default_value = "default")]
    device: DeviceSelector,
    /// Print the table as JSON on stdout
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Name {
    Figure6,
    Figure3,
    Figure8,
}

/// A row of VCSG's table 1: seconds on an SGI R4400 of 1998 with five lights and depth cue. The first four figures are of
/// ray casting but for (c), the last two and (c) of 3D textures. What the table says of building and memory is left out: the
/// text that we have does not tell its two columns apart.
struct Published {
    part: &'static str,
    template_s: f64,
    total_s: f64,
}

const fn published(part: &'static str, template_s: f64, total_s: f64) -> Published {
    Published {
        part,
        template_s,
        total_s,
    }
}

const TABLE_1: [Published; 7] = [
    published("b", 0.019, 10.639),
    published("c", 0.025, 0.447),
    published("d", 0.016, 6.902),
    published("f", 0.021, 4.36),
    published("h", 0.027, 12.797),
    published("j", 0.026, 0.856),
    published("k", 0.023, 1.66),
];

/// A scene's figures: medians.
#[derive(Serialize)]
struct Row {
    scene: String,
    blocks: usize,
    /// Volumes and blocks.
    memory_mib: f64,
    build_ms: f64,
    templates_ms: f64,
    projection_ms: f64,
    read_back_ms: f64,
    rendering_ms: f64,
    published_templates_s: f64,
    published_rendering_s: f64,
}

/// What one repetition took.
struct Times {
    build: Duration,
    templates: Duration,
    projection: Duration,
    read_back: Duration,
}

impl Bench {
    /// Measures, and prints a table.
    pub fn run(&self) -> Result<(), CliError> {
        match self.name {
            Name::Figure6 => self.figure6(),
            Name::Figure3 => {
                let rows = figure3::measure(&self.scenes, self.repetitions)?;
                self.print(&rows, figure3::table(&rows))
            }
            Name::Figure8 => {
                let errors = figure8::measure(self.picture.as_deref())?;
                self.print(&errors, errors.table())
            }
        }
    }

    fn figure6(&self) -> Result<(), CliError> {
        let mut renderer = Renderer::on_device(&self.device, Validation::Off)?;
        let rows: Vec<Row> = TABLE_1
            .iter()
            .map(|published| self.measure(published, &mut renderer))
            .collect::<Result<_, _>>()?;
        self.print(&rows, table(&rows))
    }

    fn print(&self, figures: &impl Serialize, table: String) -> Result<(), CliError> {
        if self.json { print_json(figures) } else { print(&table) }
    }

    fn measure(&self, published: &Published, renderer: &mut Renderer) -> Result<Row, CliError> {
        let name = format!("figure6-{}.kdl", published.part);
        let scene = Scene::load(&self.scenes.join(&name), &mut VolumeFiles)?;
        let mut blocks = 0;
        let mut bytes = 0;
        let mut times = Vec::new();
        for _ in 0..self.repetitions {
            let (paged, took) = draw(&scene, renderer)?;
            blocks = paged.slots.len();
            bytes = volume_bytes(&scene) as u64 + paged.bytes();
            times.push(took);
        }
        let median = |of: fn(&Times) -> Duration| {
            let mut sorted: Vec<Duration> = times.iter().map(of).collect();
            sorted.sort();
            sorted[sorted.len() / 2].as_secs_f64() * 1e3
        };
        Ok(Row {
            scene: name,
            blocks,
            memory_mib: bytes as f64 / f64::from(1 << 20),
            build_ms: median(|t| t.build),
            templates_ms: median(|t| t.templates),
            projection_ms: median(|t| t.projection),
            read_back_ms: median(|t| t.read_back),
            rendering_ms: median(|t| t.templates + t.projection + t.read_back),
            published_templates_s: published.template_s,
            published_rendering_s: published.total_s,
        })
    }
}

/// Builds the target of a scene anew and draws it once.
fn draw(scene: &Scene, renderer: &mut Renderer) -> Result<(PagedTarget, Times), CliError> {
    let Renderer::Slices(renderer) = renderer else {
        return Err(CliError::Usage("only slices are measured".into()));
    };
    let device = Arc::clone(renderer.device());
    let size = scene.frame_size.unwrap_or(DEFAULT_SIZE);
    let camera = scene.view.camera(&model_bounds(scene), size);
    let start = Instant::now();
    let target = scene.target.build(&scene.model)?;
    let transfer = transfer_function(scene, &target);
    let spec = FrameSpec {
        target: &target,
        transfer: &transfer,
        camera: &camera,
        settings: &scene.settings,
    };
    let normals = soft_normals(&spec);
    let paged = PagedTarget::new(&device, &target, normals.as_ref(), &mut |_| {})?;
    let build = start.elapsed();
    let (_, timings) = renderer.draw(&spec, &paged, &[])?;
    let times = Times {
        build,
        templates: timings.plan,
        projection: timings.prepare + timings.draw,
        read_back: timings.read_back,
    };
    Ok((paged, times))
}

/// The bytes of a scene's volumes, each counted once.
fn volume_bytes(scene: &Scene) -> usize {
    let mut volumes: Vec<_> = scene
        .model
        .nodes()
        .iter()
        .filter_map(|node| match node {
            Node::Volume(leaf) => Some(&leaf.bricks),
            Node::Mask(leaf) => Some(&leaf.bricks),
            _ => None,
        })
        .collect();
    volumes.sort_by_key(|bricks| Arc::as_ptr(bricks));
    volumes.dedup_by_key(|bricks| Arc::as_ptr(bricks));
    volumes.iter().map(|bricks| bricks.bytes()).sum()
}

fn table(rows: &[Row]) -> String {
    let head = format!(
        "{:<16} {:>7} {:>8} {:>9} {:>10} {:>11} {:>9} {:>10} | {:>10} {:>10}",
        "", "blocks", "MiB", "build ms", "templates", "projection", "read back", "rendering", "templates", "rendering"
    );
    let rows = rows.iter().map(|r| {
        format!(
            "{:<16} {:>7} {:>8.1} {:>9.1} {:>10.2} {:>11.1} {:>9.1} {:>10.1} | {:>8.3} s {:>8.3} s",
            r.scene,
            r.blocks,
            r.memory_mib,
            r.build_ms,
            r.templates_ms,
            r.projection_ms,
            r.read_back_ms,
            r.rendering_ms,
            r.published_templates_s,
            r.published_rendering_s
        )
    });
    let lines: Vec<String> = std::iter::once(head).chain(rows).collect();
    format!("Milliseconds here | seconds in VCSG's table 1\n{}", lines.join("\n"))
}
