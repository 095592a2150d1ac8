//! `vcsg formats`: what volume files are read and written.

use clap::Args;
use serde_json::json;

use super::CliError;
use super::console::{print, print_json};
use crate::volume::io::{FORMATS, Format};

/// List the formats of volume files that are read and written
#[derive(Debug, Args)]
pub(super) struct Formats {
    /// List them as JSON on stdout
    #[arg(long)]
    json: bool,
}

impl Formats {
    /// Prints the list.
    pub fn run(&self) -> Result<(), CliError> {
        if self.json {
            let formats = FORMATS.map(|format| {
                let writer = format.writer.as_ref();
                json!({
                    "name": format.name,
                    "suffixes": format.suffixes,
                    "reads": format.reads,
                    "written_suffixes": writer.map_or(&[][..], |w| w.suffixes),
                    "writes": writer.map(|w| w.writes),
                })
            });
            return print_json(&json!({ "formats": formats }));
        }
        print(&FORMATS.map(text).join("\n"))
    }
}

fn text(format: &Format) -> String {
    let name = format!("{} ({})", format.name, format.suffixes.join(" "));
    match &format.writer {
        Some(writer) => format!(
            "{name}\n  reads   {}\n  writes  {}: {}",
            format.reads,
            writer.suffixes.join(" "),
            writer.writes
        ),
        None => format!("{name}\n  reads   {}", format.reads),
    }
}
