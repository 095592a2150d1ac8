//! Ours against VTK's and against the device's own limits, in one run, on the same data and views: see docs/BENCHMARKS.md.
//! `cargo bench --bench peers [-- --quick] [--strict]`; `make bench` sets up first.

mod bar;
mod deformation;
mod drawing;
mod editing;
mod frames;
mod layouts;
mod machine;
mod memory;
mod picture;
mod pinning;
mod primitives;
#[path = "../quads/mod.rs"]
mod quads;
mod rates;
mod raycast;
mod reading;
mod resampling;
mod rows;
mod runs;
mod scene;
mod surfaces;
mod volpack;
mod vtk;

use std::error::Error;
use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use bar::Bar;
use clap::Parser;
use frames::Repetitions;
use machine::Machine;
use serde::Serialize;
use vcsg::output::write_whole;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Where all figures go.
const REPORT: &str = "target/bench/peers.json";

/// Measures against VTK and against the device's limits.
#[derive(Parser)]
struct Arguments {
    /// Two repetitions: to see that it runs, not for figures.
    #[arg(long)]
    quick: bool,
    /// Fail if a bar is missed.
    #[arg(long)]
    strict: bool,
    /// Measure frames only, those with this in their names, and write no report.
    #[arg(long, value_name = "NAME", num_args = 0..=1, default_missing_value = "")]
    frames: Option<String>,
    /// Measure rays cast on the processor only, those with this in their names, and write no report.
    #[arg(long, value_name = "NAME", num_args = 0..=1, default_missing_value = "")]
    raycast: Option<String>,
    /// Measure surfaces only, those with this in their names, and write no report.
    #[arg(long, value_name = "NAME", num_args = 0..=1, default_missing_value = "")]
    surfaces: Option<String>,
    /// Measure resampling only, and write no report.
    #[arg(long)]
    resampling: bool,
    /// Measure deformation only, and write no report.
    #[arg(long)]
    deformation: bool,
    /// Measure primitives only, and write no report.
    #[arg(long)]
    primitives: bool,
    /// Measure reading of files only, and write no report.
    #[arg(long)]
    reading: bool,
    /// Measure edits only, and write no report.
    #[arg(long)]
    editing: bool,
    /// Measure layouts of voxels only, and write no report.
    #[arg(long)]
    layouts: bool,
    /// Draw one scene and print what memory it took, as JSON.
    #[arg(long, hide = true)]
    memory_of: Option<memory::Scene>,
    /// Extract one surface and print what memory it took.
    #[arg(long, hide = true)]
    memory_of_surface: Option<String>,
    /// Build and edit a scene of little and print what memory it took.
    #[arg(long, hide = true)]
    memory_of_balls: bool,
    /// Cargo says this.
    #[arg(long, hide = true)]
    bench: bool,
}

/// All figures.
#[derive(Serialize)]
struct Report {
    machine: Machine,
    frames: Vec<frames::Comparison>,
    raycast: Vec<raycast::Comparison>,
    volpack: Vec<volpack::Comparison>,
    rates: rates::Rates,
    resampling: Vec<resampling::Comparison>,
    deformation: Vec<deformation::Comparison>,
    memory: Vec<memory::Measured>,
    surfaces: Vec<surfaces::Comparison>,
    primitives: Vec<primitives::Comparison>,
    editing: Vec<editing::Comparison>,
    reading: Vec<reading::Comparison>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match run(&arguments) {
        Ok(missed) if missed > 0 && arguments.strict => ExitCode::FAILURE,
        Ok(_) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("peers: {error}");
            ExitCode::FAILURE
        }
    }
}

/// The number of bars missed.
fn run(arguments: &Arguments) -> Outcome<usize> {
    if let Some(scene) = arguments.memory_of {
        return memory::print_usage_of(scene).map(|()| 0);
    }
    if let Some(name) = &arguments.memory_of_surface {
        return surfaces::print_growth_of(name).map(|()| 0);
    }
    if arguments.memory_of_balls {
        return editing::print_growth().map(|()| 0);
    }
    if arguments.primitives {
        return primitives::compare(arguments.repetitions().runs).map(|_| 0);
    }
    if arguments.editing {
        return editing::compare(&drawing::open_device()?, arguments.repetitions().runs).map(|_| 0);
    }
    vtk::require_setup()?;
    if arguments.reading {
        return reading::compare(arguments.repetitions().runs).map(|_| 0);
    }
    if let Some(name) = &arguments.surfaces {
        return surfaces::compare(name, arguments.repetitions().runs).map(|_| 0);
    }
    vtk::write_volumes()?;
    if arguments.layouts {
        return layouts::measure(arguments.repetitions().runs).map(|()| 0);
    }
    if let Some(name) = &arguments.frames {
        return frames::compare(&drawing::open_device()?, name, arguments.repetitions()).map(|_| 0);
    }
    if let Some(name) = &arguments.raycast {
        raycast::compare(name, arguments.repetitions().runs)?;
        return volpack::compare(name, arguments.repetitions().runs).map(|_| 0);
    }
    if arguments.resampling {
        return resampling::compare(arguments.repetitions().runs).map(|_| 0);
    }
    if arguments.deformation {
        return deformation::compare(arguments.repetitions().runs).map(|_| 0);
    }
    let report = Report::measure(arguments.repetitions())?;
    write_whole(Path::new(REPORT), |out| {
        serde_json::to_writer_pretty(&mut *out, &report)?;
        out.write_all(b"\n")
    })?;
    let missed: Vec<&Bar> = report.bars().into_iter().filter(|bar| !bar.met()).collect();
    println!("\nAll figures: {REPORT}");
    for bar in &missed {
        println!("MISSED: {}: {:.2}, {bar}", bar.what, bar.value);
    }
    Ok(missed.len())
}

impl Arguments {
    fn repetitions(&self) -> Repetitions {
        match self.quick {
            true => Repetitions { runs: 2, builds: 1 },
            false => Repetitions { runs: 9, builds: 3 },
        }
    }
}

impl Report {
    fn measure(repetitions: Repetitions) -> Outcome<Self> {
        let device = drawing::open_device()?;
        let machine = Machine::now(device.info());
        machine.print();
        Ok(Self {
            machine,
            frames: frames::compare(&device, "", repetitions)?,
            raycast: raycast::compare("", repetitions.runs)?,
            volpack: volpack::compare("", repetitions.runs)?,
            rates: rates::measure(&device, repetitions.runs)?,
            resampling: resampling::compare(repetitions.runs)?,
            deformation: deformation::compare(repetitions.runs)?,
            memory: memory::measure()?,
            surfaces: surfaces::compare("", repetitions.runs)?,
            primitives: primitives::compare(repetitions.runs)?,
            editing: editing::compare(&device, repetitions.runs)?,
            reading: reading::compare(repetitions.runs)?,
        })
    }

    fn bars(&self) -> Vec<&Bar> {
        let frames = self.frames.iter().map(|c| &c.bar);
        let raycast = self.raycast.iter().flat_map(|c| &c.bars);
        let volpack = self.volpack.iter().map(|c| &c.bar);
        let rates = self.rates.rates.iter().filter_map(|r| r.bar.as_ref());
        let resampling = self.resampling.iter().map(|c| &c.bar);
        let deformation = self.deformation.iter().flat_map(|c| &c.bars);
        let memory = self.memory.iter().map(|m| &m.bar);
        let surfaces = self.surfaces.iter().flat_map(|c| &c.bars);
        let primitives = self.primitives.iter().flat_map(|c| &c.bars);
        let editing = self.editing.iter().map(|c| &c.bar);
        let reading = self.reading.iter().map(|c| &c.bar);
        frames
            .chain(raycast)
            .chain(volpack)
            .chain(rates)
            .chain(resampling)
            .chain(deformation)
            .chain(memory)
            .chain(surfaces)
            .chain(primitives)
            .chain(editing)
            .chain(reading)
            .collect()
    }
}
