//! What goes to stdout and stderr.

use std::io::{self, Write};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use super::CliError;

/// Prints `text` and a line end to stdout.
///
/// # Errors
/// If stdout cannot be written, for one because its reader went away.
pub(super) fn print(text: &str) -> Result<(), CliError> {
    let mut out = io::stdout().lock();
    writeln!(out, "{text}")
        .and_then(|()| out.flush())
        .map_err(CliError::Stdout)
}

/// Prints `value` as indented JSON to stdout.
///
/// # Errors
/// If stdout cannot be written.
pub(super) fn print_json(value: &impl Serialize) -> Result<(), CliError> {
    let text = serde_json::to_string_pretty(value).map_err(|e| CliError::Stdout(e.into()))?;
    print(&text)
}

/// Writes a remark to stderr.
pub(super) fn note(text: &str) {
    // What cannot be said there cannot be said anywhere.
    let _ = writeln!(io::stderr(), "note: {text}");
}

/// Says that the surface at `iso` is empty, and where there might be one.
pub(super) fn note_empty(iso: f64, min: f64, max: f64) {
    note(&format!("the surface at {iso} is empty: values go from {min} to {max}"));
}

/// A bar on stderr for `length` steps of `what`; nothing where stderr is no terminal.
pub(super) fn progress(what: &'static str, length: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{prefix:>12} {bar:40} {percent:>3} %  {elapsed}");
    let bar = ProgressBar::new(length).with_prefix(what);
    match style {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// A bar on stderr for `bytes` of voxels, with how many come a second; nothing where stderr is no terminal.
pub(super) fn loading_progress(bytes: u64) -> ProgressBar {
    let bar = ProgressBar::new(bytes).with_prefix("load");
    match ProgressStyle::with_template("{prefix:>12} {bar:40} {percent:>3} %  {elapsed}, {binary_bytes_per_sec}") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// A bar on stderr for `length` frames, with the time that is left; nothing where stderr is no terminal.
pub(super) fn frames_progress(length: u64) -> ProgressBar {
    let bar = ProgressBar::new(length).with_prefix("frames");
    match ProgressStyle::with_template("{prefix:>12} {bar:40} {pos}/{len}  {elapsed}, {eta} left") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// How long each stage of a command took, in order.
#[derive(Debug, Default)]
pub(super) struct Stages(Vec<(&'static str, Duration)>);

impl Stages {
    /// Does `work` as the stage `name`.
    pub fn time<T>(&mut self, name: &'static str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let done = work();
        self.add(name, start.elapsed());
        done
    }

    /// Adds a stage that was timed elsewhere, or to the time of one that has been there before.
    pub fn add(&mut self, name: &'static str, time: Duration) {
        match self.0.iter_mut().find(|stage| stage.0 == name) {
            Some(stage) => stage.1 += time,
            None => self.0.push((name, time)),
        }
    }

    /// Each stage's milliseconds, for `--json`.
    pub fn to_json(&self) -> serde_json::Value {
        let milliseconds = |t: &Duration| serde_json::Value::from(t.as_secs_f64() * 1e3);
        self.0
            .iter()
            .map(|(name, time)| ((*name).to_owned(), milliseconds(time)))
            .collect()
    }

    /// Writes the stages to stderr.
    pub fn show(&self) {
        let total = self.0.iter().map(|(_, time)| *time).sum();
        for (name, time) in self.0.iter().copied().chain([("total", total)]) {
            let line = format!("{name:>12} {:>9.1} ms\n", time.as_secs_f64() * 1e3);
            let _ = io::stderr().write_all(line.as_bytes());
        }
    }
}
