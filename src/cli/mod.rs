//! The command line: one file a subcommand.
//!
//! Machine output goes to stdout with `--json`, messages and progress to stderr; the exit code is 0 only on success.

mod bake;
mod bench;
mod console;
mod convert;
mod devices;
mod error;
mod figure3;
mod figure8;
mod formats;
mod frames;
mod info;
mod job;
mod levels;
mod loading;
mod mesh;
mod overrides;
mod presets;
mod render;
mod sequence;
mod source;
mod surfaces;
mod swatch;
mod trace;
mod video;

use std::panic;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

pub use error::CliError;

use crate::volume::io::is_caught;

/// Model with volumes: combine scans and solids in a Volumetric CSG tree, and draw it with Vulkan.
#[derive(Debug, Parser)]
#[command(name = "vcsg", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Render(Box<render::Render>),
    Info(info::Info),
    Bake(bake::Bake),
    Convert(convert::Convert),
    Formats(formats::Formats),
    Mesh(mesh::MeshCommand),
    Devices(devices::Devices),
    Presets(presets::Presets),
    Bench(bench::Bench),
}

/// Runs the command that the process was started with.
pub fn run() -> ExitCode {
    tell_panics();
    let result = match Cli::parse().command {
        Command::Render(render) => render.run(),
        Command::Info(info) => info.run(),
        Command::Bake(bake) => bake.run(),
        Command::Convert(convert) => convert.run(),
        Command::Formats(formats) => formats.run(),
        Command::Mesh(mesh) => mesh.run(),
        Command::Devices(devices) => devices.run(),
        Command::Presets(presets) => presets.run(),
        Command::Bench(bench) => bench.run(),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            error.show();
            ExitCode::FAILURE
        }
    }
}

/// Has Rust tell of a panic as ever, but of one that a reader makes an error of its file.
fn tell_panics() {
    let tell = panic::take_hook();
    panic::set_hook(Box::new(move |panic| {
        if !is_caught() {
            tell(panic);
        }
    }));
}
