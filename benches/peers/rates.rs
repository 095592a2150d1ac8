//! Fragments a second: what the device gives at best, what one block takes of it, and what being cut into blocks costs.

use std::sync::Arc;

use serde::Serialize;
use vcsg::gpu::{Device, Filter, Format};
use vcsg::model::Model;
use vcsg::projection::TransferTable;
use vcsg::render::SliceRenderer;
use vcsg::target::Subdivision;

use crate::Outcome;
use crate::bar::{Bar, Limit};
use crate::drawing::{Drawing, Work};
use crate::quads::{self, SAMPLES};
use crate::runs::{Run, Summary};
use crate::scene::{self, Look, SIDE};

/// What a frame is held against.
#[derive(Clone, Copy)]
enum Against {
    /// Nothing: it is what others are held against.
    Nothing,
    /// The rate of an earlier frame, by its place, and the least fraction of it.
    Earlier(usize, f64),
}

/// One thing whose rate is measured.
struct Subject {
    what: &'static str,
    drawing: Drawing,
    work: Work,
    against: Against,
    runs: Vec<Run>,
}

/// A rate.
#[derive(Serialize)]
pub struct Rate {
    what: String,
    blocks: usize,
    work: Work,
    /// Of the draw stage by the wall clock; processor time is the whole frame's.
    seconds: Summary,
    /// Fragments a second, by the median.
    per_s: f64,
    /// Of the full-screen quads' rate, by medians and by least times.
    of_device: [f64; 2],
    /// Of the rate it is held against, by medians and by least times.
    of_one_block: Option<[f64; 2]>,
    /// The bar, if it has one.
    pub bar: Option<Bar>,
}

/// All rates.
#[derive(Serialize)]
pub struct Rates {
    /// Samples of full-screen quads.
    quads_per_s: f64,
    quads_per_s_at_best: f64,
    /// The models' rates.
    pub rates: Vec<Rate>,
}

/// Blocks of one size, or one block of the whole.
fn cubes(edge: usize) -> Subdivision {
    Subdivision {
        min_block: edge,
        max_block: edge,
        ..Subdivision::default()
    }
}

fn subject(
    device: &Arc<Device>,
    what: &'static str,
    (model, table): (&Model, &str),
    subdivision: &Subdivision,
    against: Against,
) -> Outcome<Subject> {
    let look = Look {
        transfer: scene::transfer(table)?,
        camera: scene::camera(&scene::bounds()),
        settings: scene::settings(false),
    };
    let drawing = Drawing::new(device, model, subdivision, look)?;
    Ok(Subject {
        what,
        work: drawing.work(&mut SliceRenderer::new(device)?)?,
        drawing,
        against,
        runs: Vec::new(),
    })
}

fn subjects(device: &Arc<Device>) -> Outcome<Vec<Subject>> {
    let dense = scene::bare(&scene::bricks("dense")?);
    let carved = scene::cut_and_carved(&scene::bricks("head")?)?;
    let (dense, carved) = ((&dense, "faint"), (&carved, "soft"));
    let whole = cubes(SIDE);
    let own = Subdivision::default();
    use Against::{Earlier, Nothing};
    [
        ("dense, one block", dense, whole, Nothing),
        ("dense, blocks of 64³", dense, cubes(64), Earlier(0, 0.8)),
        ("dense, blocks of 32³", dense, cubes(32), Earlier(0, 0.6)),
        ("cut and carved head, one block", carved, whole, Nothing),
        ("cut and carved head, as it is", carved, own, Earlier(3, 0.9)),
    ]
    .into_iter()
    .map(|(what, model, subdivision, against)| subject(device, what, model, &subdivision, against))
    .collect()
}

/// The quads that do what an unshaded slice does: fetch, look up, blend.
fn quads_case() -> quads::Case {
    quads::case("fetch + table + over", |case| {
        case.table = Format::R32G32B32A32_SFLOAT;
        case.values = Format::R16_UNORM;
        (case.table_width, case.table_filter) = (TransferTable::LEN as u32, Filter::Nearest);
        // The table is sampled: see shaders/layers.frag.
        case.constants = vec![(1, 1)];
    })
}

/// Measures all rates, all subjects taking turns, and prints them.
pub fn measure(device: &Arc<Device>, repetitions: usize) -> Outcome<Rates> {
    let mut renderer = SliceRenderer::new(device)?;
    let mut limit = quads::Scene::new(device).rounds(&quads_case())?;
    let mut subjects = subjects(device)?;
    for subject in &subjects {
        subject.drawing.draw(&mut renderer)?;
    }
    for _ in 0..repetitions {
        limit.round()?;
        for subject in &mut subjects {
            let (_, stages, run) = subject.drawing.draw(&mut renderer)?;
            subject.runs.push(Run {
                wall_s: stages.draw.as_secs_f64(),
                ..run
            });
        }
    }
    let times = limit.times();
    let per_s = |milliseconds: f64| f64::from(SAMPLES) * 1e3 / milliseconds;
    let mut rates = Rates {
        quads_per_s: per_s(times.median),
        quads_per_s_at_best: per_s(times.least),
        rates: Vec::new(),
    };
    for subject in subjects {
        rates.add(subject);
    }
    rates.print(per_s(times.processor));
    Ok(rates)
}

impl Rates {
    fn add(&mut self, subject: Subject) {
        let seconds = Summary::of(subject.runs);
        let per_s = subject.work.fragments / seconds.median_s;
        let (of_one_block, bar) = match subject.against {
            Against::Nothing => (None, None),
            Against::Earlier(place, least) => {
                let other = &self.rates[place];
                let at_best = subject.work.fragments / seconds.min_s;
                let theirs_at_best = other.work.fragments / other.seconds.min_s;
                let ratios = [per_s / other.per_s, at_best / theirs_at_best];
                let bar = Bar {
                    what: format!("rate of {} to that of {}", subject.what, other.what),
                    value: ratios[0],
                    limit: Limit::AtLeast(least),
                };
                (Some(ratios), Some(bar))
            }
        };
        self.rates.push(Rate {
            what: subject.what.to_owned(),
            blocks: subject.drawing.target.blocks.len(),
            work: subject.work,
            of_device: [
                per_s / self.quads_per_s,
                subject.work.fragments / seconds.min_s / self.quads_per_s_at_best,
            ],
            seconds,
            per_s,
            of_one_block,
            bar,
        });
    }

    fn print(&self, quads_by_processor: f64) {
        println!("\nMillions of fragments a second, drawing alone (unshaded)");
        println!(
            "{:<32} {:>7} {:>9} {:>11} {:>7} {:>7} {:>8} {:>10} {:>6} {:>13} {:>6}  bar",
            "",
            "blocks",
            "polygons",
            "Mfragments",
            "median",
            "best",
            "a CPU s",
            "of device",
            "best",
            "of one block",
            "best"
        );
        println!(
            "{:<32} {:>7} {:>9} {:11.1} {:7.1} {:7.1} {:8.1}",
            "full-screen quads",
            "",
            "",
            f64::from(SAMPLES) / 1e6,
            self.quads_per_s / 1e6,
            self.quads_per_s_at_best / 1e6,
            quads_by_processor / 1e6
        );
        self.rates.iter().for_each(Rate::print);
    }
}

impl Rate {
    fn print(&self) {
        let [one, best] = self
            .of_one_block
            .map_or([String::new(), String::new()], |r| r.map(|r| format!("{r:.2}")));
        let bar = self.bar.as_ref().map_or(String::new(), Bar::to_string);
        println!(
            "{:<32} {:7} {:9} {:11.1} {:7.1} {:7.1} {:8.1} {:10.2} {:6.2} {one:>13} {best:>6}  {bar}",
            self.what,
            self.blocks,
            self.work.polygons,
            self.work.fragments / 1e6,
            self.per_s / 1e6,
            self.work.fragments / self.seconds.min_s / 1e6,
            self.work.fragments / self.seconds.cpu_min_s / 1e6,
            self.of_device[0],
            self.of_device[1]
        );
    }
}
