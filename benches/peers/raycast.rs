//! Rays cast on the processor against VTK's own ray caster there: the same voxels, table, view, light, number of samples and
//! threads.

use rayon::ThreadPool;
use serde::Serialize;
use vcsg::image::Frame;
use vcsg::projection::raycast::{CastTarget, draw};
use vcsg::projection::{FrameSpec, Settings};
use vcsg::target::{Subdivision, Target};

use crate::Outcome;
use crate::bar::{Bar, Limit};
use crate::frames::{PICTURES, PeerCase};
use crate::picture::{self, Difference};
use crate::pinning;
use crate::runs::{Ratios, Run, Summary, timed};
use crate::scene::{self, Look};
use crate::vtk::Peer;

/// Threads on both sides.
const THREADS: usize = 2;

/// How many times as fast as VTK's ours must be.
const BAR: f64 = 1.5;

/// How many times as fast two threads must be as one.
const SCALING: f64 = 1.8;

/// One comparison.
struct Case {
    volume: &'static str,
    table: &'static str,
    shaded: bool,
    /// Pixels along each side of the frame.
    edge: u32,
}

/// One comparison, done.
#[derive(Serialize)]
pub struct Comparison {
    what: String,
    peer: String,
    ours: Summary,
    ours_on_one_thread: Summary,
    theirs: Summary,
    faster: Ratios,
    /// Reconstructing blocks, with normals if shaded: once for all frames, as VTK makes its own.
    prepare: Run,
    /// The bars.
    pub bars: [Bar; 2],
    difference: Difference,
}

fn cases() -> impl Iterator<Item = Case> {
    let volumes = [("head", "soft"), ("head", "skin"), ("dense", "faint")];
    volumes.into_iter().flat_map(|(volume, table)| {
        let kinds = [(false, 256), (true, 256), (false, 512), (true, 512)];
        kinds.map(|(shaded, edge)| Case {
            volume,
            table,
            shaded,
            edge,
        })
    })
}

/// Compares all frames with `name` in theirs; each comparison is printed when it is done.
pub fn compare(name: &str, runs: usize) -> Outcome<Vec<Comparison>> {
    println!(
        "\nRays cast on the processor: 256³ u8, one sample a voxel, {THREADS} threads; seconds, and how many times as fast as VTK"
    );
    println!(
        "{:<26} {:>8} {:>8} {:>8} | {:>8} {:>8} | {:>7} {:>6} {:>6}  {:<14} | {:>7} {:<14} | 8-bit difference: mean, 99 %, most",
        "", "median", "min", "1 thread", "VTK med", "min", "median", "min", "CPU", "bar", "scaling", "bar"
    );
    let mut done = Vec::new();
    for case in cases().filter(|case| case.what().contains(name)) {
        let comparison = case.compare(runs)?;
        comparison.print();
        done.push(comparison);
    }
    Ok(done)
}

/// Those of frames, but that this mapper adds no ambient light, and that its highlight follows the half-way vector, as ours does: a
/// least-squares fit of its shaded pixels to the sums along their rays gives 0.01 to 0.02 for the one, and leaves least of the other with power 8.
fn settings(shaded: bool) -> Settings {
    let mut settings = scene::settings(shaded);
    if let Some(shading) = &mut settings.shading {
        shading.material.ambient = 0.0;
        shading.material.shininess_log2 = 3;
    }
    settings
}

impl Case {
    fn what(&self) -> String {
        let light = if self.shaded { "shaded" } else { "unshaded" };
        format!("{} {} {light} {}", self.volume, self.table, self.edge)
    }

    fn start_peer(&self) -> Outcome<(Peer, PeerCase)> {
        let (raw, table) = (scene::raw_path(self.volume), scene::table_path(self.table));
        let shade = if self.shaded { "on" } else { "off" };
        let arguments = [
            ["--raw", &raw],
            ["--table", &table],
            ["--mapper", "fixed"],
            ["--shade", shade],
            ["--size", &self.edge.to_string()],
            ["--threads", &THREADS.to_string()],
            ["--png", PICTURES],
        ];
        Peer::start("tools/peers/vtk_render.py", arguments.as_flattened())
    }

    fn compare(&self, runs: usize) -> Outcome<Comparison> {
        let (mut peer, about) = self.start_peer()?;
        let look = Look {
            transfer: scene::transfer(self.table)?,
            camera: about.view.camera(self.edge),
            settings: settings(self.shaded),
        };
        let model = scene::bare(&scene::bricks(self.volume)?);
        let target = Target::build(&model, None, &Subdivision::default())?;
        let spec = FrameSpec {
            target: &target,
            transfer: &look.transfer,
            camera: &look.camera,
            settings: &look.settings,
        };
        let pools = [pinning::pool(1)?, pinning::pool(THREADS)?];
        let (cast, prepare) = timed(|| pools[1].install(|| CastTarget::of(&spec)));
        let frame = |pool: &ThreadPool| -> Outcome<(Frame, Run)> {
            let (frame, run) = pool.install(|| timed(|| draw(&spec, &cast, None)));
            Ok((frame?, run))
        };
        let (picture, _) = frame(&pools[1])?;
        let mut all: [Vec<Run>; 3] = Default::default();
        for _ in 0..runs {
            all[0].push(frame(&pools[0])?.1);
            all[1].push(frame(&pools[1])?.1);
            all[2].push(peer.run()?);
        }
        let [one, ours, theirs] = all.map(Summary::of);
        let faster = Ratios::of(&ours, &theirs);
        let bar = |what: &str, value: f64, least: f64| Bar {
            what: format!("{what}: {}", self.what()),
            value,
            limit: Limit::AtLeast(least),
        };
        Ok(Comparison {
            what: self.what(),
            bars: [
                bar(&format!("times as fast as {}", about.mapper), faster.median, BAR),
                bar("times as fast on two threads", one.median_s / ours.median_s, SCALING),
            ],
            peer: format!("VTK {} {}", about.vtk, about.mapper),
            difference: self.difference(&picture, &about.picture)?,
            faster,
            prepare,
            ours,
            ours_on_one_thread: one,
            theirs,
        })
    }

    fn difference(&self, ours: &Frame, theirs: &str) -> Outcome<Difference> {
        let name = format!("{PICTURES}/raycast-{}.png", self.what().replace(' ', "-"));
        picture::compare(ours, &picture::read(theirs)?, &name)
    }
}

impl Comparison {
    fn print(&self) {
        let (o, t, r, d) = (&self.ours, &self.theirs, &self.faster, &self.difference);
        println!(
            "{:<26} {:8.4} {:8.4} {:8.4} | {:8.4} {:8.4} | {:7.2} {:6.2} {:6.2}  {:<14} | {:7.2} {:<14} | {:.2}, {}, {}",
            self.what,
            o.median_s,
            o.min_s,
            self.ours_on_one_thread.median_s,
            t.median_s,
            t.min_s,
            r.median,
            r.min,
            r.cpu,
            self.bars[0].to_string(),
            self.bars[1].value,
            self.bars[1].to_string(),
            d.mean,
            d.percentile_99,
            d.max
        );
    }
}
