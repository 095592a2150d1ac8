//! Frames against VTK's ray caster on the same software device: the same voxels, table, view, light and number of samples.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use serde::{Deserialize, Serialize};
use vcsg::gpu::Device;
use vcsg::image::Frame;
use vcsg::projection::Camera;
use vcsg::render::{SliceRenderer, Timings};
use vcsg::target::Subdivision;

use crate::Outcome;
use crate::bar::{Bar, Limit};
use crate::drawing::{Drawing, Work};
use crate::picture::{self, Difference};
use crate::rows::Rows;
use crate::runs::{Ratios, Run, Summary, median};
use crate::scene::{self, FRAME_EDGE, Look};
use crate::vtk::Peer;

/// Where pictures are left.
pub const PICTURES: &str = "target/bench/pictures";

/// One comparison.
struct Case {
    volume: &'static str,
    table: &'static str,
    shaded: bool,
    /// How many times as fast as VTK's ours must be.
    bar: f64,
}

const fn case(volume: &'static str, table: &'static str, shaded: bool, bar: f64) -> Case {
    Case {
        volume,
        table,
        shaded,
        bar,
    }
}

const CASES: [Case; 6] = [
    case("head", "soft", false, 3.0),
    case("head", "soft", true, 5.0),
    case("head", "skin", false, 3.0),
    case("head", "skin", true, 5.0),
    case("dense", "faint", false, 1.5),
    case("dense", "faint", true, 3.0),
];

/// Where VTK's script looks from.
#[derive(Deserialize)]
pub struct PeerView {
    right: [f64; 3],
    up: [f64; 3],
    toward_eye: [f64; 3],
    centre_mm: [f64; 3],
    half_height_mm: f64,
}

impl PeerView {
    /// The same view as a camera, of a square frame of `edge` pixels.
    pub fn camera(&self, edge: u32) -> Camera {
        let [right, up, back] = [self.right, self.up, self.toward_eye].map(DVec3::from_array);
        let rotation = DMat3::from_cols(right, -up, -back).transpose();
        let centre = DVec3::from_array(self.centre_mm);
        let before = DVec3::Z * 4.0 * self.half_height_mm;
        Camera {
            eye_from_world: DAffine3 {
                matrix3: rotation,
                translation: before - rotation * centre,
            },
            lens: scene::parallel(self.half_height_mm, edge),
            size: [edge; 2],
        }
    }
}

/// What VTK's script says about itself.
#[derive(Deserialize)]
pub struct PeerCase {
    pub vtk: String,
    pub mapper: String,
    device: serde_json::Value,
    pub view: PeerView,
    pub picture: String,
}

const ROWS: Rows = Rows(22);

/// Milliseconds of each stage of ours: medians by the wall clock.
#[derive(Serialize)]
pub struct Stages {
    subdivide_ms: f64,
    reconstruct_and_upload_ms: f64,
    plan_ms: f64,
    prepare_ms: f64,
    draw_ms: f64,
    read_back_ms: f64,
}

/// One comparison, done.
#[derive(Serialize)]
pub struct Comparison {
    what: String,
    peer: String,
    peer_device: serde_json::Value,
    ours: Summary,
    theirs: Summary,
    faster: Ratios,
    /// The bar.
    pub bar: Bar,
    difference: Difference,
    blocks: usize,
    work: Work,
    stages: Stages,
}

/// How often things are done.
#[derive(Clone, Copy)]
pub struct Repetitions {
    /// Runs of ours and theirs that take turns.
    pub runs: usize,
    /// Times that a target is built for the stages' times.
    pub builds: usize,
}

/// Compares all frames with `name` in theirs; each comparison is printed when it is done.
pub fn compare(device: &Arc<Device>, name: &str, repetitions: Repetitions) -> Outcome<Vec<Comparison>> {
    println!(
        "\nFrames of {FRAME_EDGE}² of 256³ u8, one sample a voxel, read back; seconds, and how many times as fast as VTK"
    );
    ROWS.head("8-bit difference: mean, 99 %, most");
    let mut renderer = SliceRenderer::new(device)?;
    let mut done = Vec::new();
    for case in CASES.iter().filter(|case| case.what().contains(name)) {
        let comparison = case.compare(&mut renderer, repetitions)?;
        comparison.print();
        done.push(comparison);
    }
    print_stages(&done);
    Ok(done)
}

impl Case {
    fn what(&self) -> String {
        let light = if self.shaded { "shaded" } else { "unshaded" };
        format!("{} {} {light}", self.volume, self.table)
    }

    fn start_peer(&self) -> Outcome<(Peer, PeerCase)> {
        let (raw, table) = (scene::raw_path(self.volume), scene::table_path(self.table));
        let shade = if self.shaded { "on" } else { "off" };
        let arguments = [
            ["--raw", &raw],
            ["--table", &table],
            ["--mapper", "gpu"],
            ["--shade", shade],
            ["--size", &FRAME_EDGE.to_string()],
            ["--png", PICTURES],
        ];
        Peer::start("tools/peers/vtk_render.py", arguments.as_flattened())
    }

    fn drawing(&self, device: &Arc<Device>, camera: Camera) -> Outcome<Drawing> {
        let model = scene::bare(&scene::bricks(self.volume)?);
        let look = Look {
            transfer: scene::transfer(self.table)?,
            camera,
            settings: scene::settings(self.shaded),
        };
        Drawing::new(device, &model, &Subdivision::default(), look)
    }

    fn compare(&self, renderer: &mut SliceRenderer, repetitions: Repetitions) -> Outcome<Comparison> {
        let (mut peer, about) = self.start_peer()?;
        let device = Arc::clone(renderer.device());
        let mut builds = Vec::new();
        let drawing = loop {
            let drawing = self.drawing(&device, about.view.camera(FRAME_EDGE))?;
            builds.push((drawing.subdivide, drawing.upload));
            if builds.len() >= repetitions.builds {
                break drawing;
            }
        };
        let (frame, ..) = drawing.draw(renderer)?;
        let (mut ours, mut theirs, mut timings) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..repetitions.runs {
            let (_, stages, run) = drawing.draw(renderer)?;
            timings.push(stages);
            ours.push(run);
            theirs.push(peer.run()?);
        }
        let (ours, theirs) = (Summary::of(ours), Summary::of(theirs));
        let faster = Ratios::of(&ours, &theirs);
        Ok(Comparison {
            bar: Bar {
                what: format!("times as fast as {}: {}", about.mapper, self.what()),
                value: faster.median,
                limit: Limit::AtLeast(self.bar),
            },
            difference: self.difference(&frame, &about.picture)?,
            what: self.what(),
            peer: format!("VTK {} {}", about.vtk, about.mapper),
            peer_device: about.device,
            ours,
            theirs,
            faster,
            blocks: drawing.target.blocks.len(),
            work: drawing.work(renderer)?,
            stages: Stages::of(&builds, &timings),
        })
    }

    fn difference(&self, ours: &Frame, theirs: &str) -> Outcome<Difference> {
        let name = self.what().replace(' ', "-");
        picture::compare(ours, &picture::read(theirs)?, &format!("{PICTURES}/{name}.png"))
    }
}

impl Stages {
    fn of(builds: &[(Run, Run)], timings: &[Timings]) -> Self {
        let build = |of: fn(&(Run, Run)) -> f64| 1e3 * median(builds.iter().map(of).collect());
        let stage = |of: fn(&Timings) -> f64| 1e3 * median(timings.iter().map(of).collect());
        Self {
            subdivide_ms: build(|b| b.0.wall_s),
            reconstruct_and_upload_ms: build(|b| b.1.wall_s),
            plan_ms: stage(|t| t.plan.as_secs_f64()),
            prepare_ms: stage(|t| t.prepare.as_secs_f64()),
            draw_ms: stage(|t| t.draw.as_secs_f64()),
            read_back_ms: stage(|t| t.read_back.as_secs_f64()),
        }
    }
}

impl Comparison {
    fn print(&self) {
        let d = &self.difference;
        let behind = format!("{:.2}, {}, {}", d.mean, d.percentile_99, d.max);
        let bar = self.bar.to_string();
        ROWS.print(&self.what, &self.ours, &self.theirs, &self.faster, &bar, &behind);
    }
}

fn print_stages(comparisons: &[Comparison]) {
    println!("\nWhere our time goes, milliseconds (medians)");
    println!(
        "{:<22} {:>9} {:>19} {:>8} {:>8} {:>8} {:>9} {:>7} {:>7} {:>9} {:>11}",
        "",
        "subdivide",
        "reconstruct+upload",
        "plan",
        "prepare",
        "draw",
        "read back",
        "blocks",
        "boxes",
        "polygons",
        "Mfragments"
    );
    for c in comparisons {
        let s = &c.stages;
        println!(
            "{:<22} {:9.1} {:19.1} {:8.1} {:8.1} {:8.1} {:9.1} {:7} {:7} {:9} {:11.1}",
            c.what,
            s.subdivide_ms,
            s.reconstruct_and_upload_ms,
            s.plan_ms,
            s.prepare_ms,
            s.draw_ms,
            s.read_back_ms,
            c.blocks,
            c.work.boxes,
            c.work.polygons,
            c.work.fragments / 1e6
        );
    }
}
