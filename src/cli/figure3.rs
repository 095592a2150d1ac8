//! `vcsg bench figure3`: what tracing WK94's figure 3 takes, beside what the paper says.

use std::path::Path;
use std::time::Instant;

use serde::Serialize;

use super::CliError;
use super::job::model_bounds;
use super::trace::world;
use crate::projection::trace::{Progressive, Sampling};
use crate::scene::{Scene, VolumeFiles};

/// Edges of a frame, pixels, and the seconds that the paper gives for it: an SGI Indigo 2 of 1994, one generation of mirrored rays,
/// one light.
const PUBLISHED: [(u32, f64); 2] = [(300, 35.0), (600, 141.0)];

/// A frame's figures: medians.
#[derive(Serialize)]
pub(super) struct Row {
    pixels: u32,
    trace_ms: f64,
    published_s: f64,
}

/// Measures both frames of the paper.
pub(super) fn measure(scenes: &Path, repetitions: u16) -> Result<Vec<Row>, CliError> {
    let scene = Scene::load(&scenes.join("wk94-figure3.kdl"), &mut VolumeFiles)?;
    let row = |(pixels, published_s)| {
        Ok(Row {
            pixels,
            trace_ms: trace_ms(&scene, pixels, repetitions)?,
            published_s,
        })
    };
    PUBLISHED.into_iter().map(row).collect()
}

fn trace_ms(scene: &Scene, pixels: u32, repetitions: u16) -> Result<f64, CliError> {
    let camera = scene.view.camera(&model_bounds(scene), [pixels; 2]);
    let world = world(scene, &camera, &mut Vec::new())?;
    let mut times = Vec::new();
    for _ in 0..repetitions {
        let start = Instant::now();
        let mut progressive = Progressive::new(
            &world,
            &camera,
            Sampling {
                samples: 1,
                ..scene.trace.sampling
            },
        )?;
        progressive.pass(&|_| {});
        times.push(start.elapsed());
    }
    times.sort();
    Ok(times[times.len() / 2].as_secs_f64() * 1e3)
}

/// The rows as a table.
pub(super) fn table(rows: &[Row]) -> String {
    let row = |row: &Row| {
        let Row {
            pixels,
            trace_ms,
            published_s,
        } = row;
        format!("{pixels:>4} x {pixels:<4} {trace_ms:>9.1} ms | {published_s:>6.0} s")
    };
    let rows: Vec<String> = rows.iter().map(row).collect();
    format!("Milliseconds here | seconds in WK94\n{}", rows.join("\n"))
}
