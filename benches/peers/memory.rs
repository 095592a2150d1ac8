//! The most memory that a scene takes from its file to its frame, in a process of its own.

use std::process::{Command, Stdio};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use vcsg::array::Array;
use vcsg::render::SliceRenderer;
use vcsg::target::Subdivision;

use crate::Outcome;
use crate::bar::{Bar, Limit};
use crate::drawing::{self, Drawing};
use crate::scene::{self, Look};

/// The most that the peak may be over what there is before a scene, in sizes of the target's blocks and the leaves.
const BAR: f64 = 3.0;

/// What a process of its own measures.
#[derive(Clone, Copy, PartialEq, Eq, Debug, clap::ValueEnum)]
pub enum Scene {
    /// The head, flat.
    Head,
    /// The head, lit.
    HeadLit,
    /// The head, cut and carved, flat.
    Carved,
    /// The head, cut and carved, lit.
    CarvedLit,
}

/// The scenes by their names on the command line, and what they are.
const SCENES: [(&str, &str); 4] = [
    ("head", "head"),
    ("head-lit", "head, lit"),
    ("carved", "cut and carved head"),
    ("carved-lit", "cut and carved head, lit"),
];

/// Bytes.
#[derive(Deserialize, Serialize)]
pub struct Usage {
    /// Resident once the device is open.
    baseline: u64,
    /// Resident at most.
    peak: u64,
    /// Of the target's blocks on the device.
    blocks: u64,
    /// Of the leaves.
    leaves: u64,
}

/// A scene's usage with its bar.
#[derive(Serialize)]
pub struct Measured {
    what: &'static str,
    usage: Usage,
    /// The bar.
    pub bar: Bar,
}

/// Measures all scenes, each in a process of its own, and prints them.
pub fn measure() -> Outcome<Vec<Measured>> {
    println!("\nMost memory from file to frame, MiB");
    println!(
        "{:<26} {:>8} {:>8} {:>8} {:>8} {:>26}  bar",
        "", "device", "peak", "blocks", "leaves", "(peak-device)/(bl.+leaves)"
    );
    let mut all = Vec::new();
    for (name, what) in SCENES {
        let measured = in_own_process(name, what)?;
        measured.print();
        all.push(measured);
    }
    Ok(all)
}

fn in_own_process(name: &str, what: &'static str) -> Outcome<Measured> {
    let usage: Usage = from_own_process(["--memory-of", name])?;
    let held = (usage.blocks + usage.leaves) as f64;
    let bar = Bar {
        what: format!("peak memory over blocks and leaves: {what}"),
        value: usage.peak.saturating_sub(usage.baseline) as f64 / held,
        limit: Limit::AtMost(BAR),
    };
    Ok(Measured { what, usage, bar })
}

/// What this program prints, as JSON, when it is run once more with `arguments`.
pub fn from_own_process<T: DeserializeOwned>(arguments: [&str; 2]) -> Outcome<T> {
    let output = Command::new(std::env::current_exe()?)
        .args(arguments)
        .stderr(Stdio::inherit())
        .output()?;
    if !output.status.success() {
        return Err(format!("{}: {}", arguments.join(" "), output.status).into());
    }
    Ok(serde_json::from_slice(&output.stdout)?)
}

/// Loads, builds, uploads and draws `scene` once, and prints what that took.
pub fn print_usage_of(scene: Scene) -> Outcome<()> {
    let device = drawing::open_device()?;
    let baseline = status_bytes("VmRSS")?;
    let bricks = scene::bricks("head")?;
    let model = match scene {
        Scene::Head | Scene::HeadLit => scene::bare(&bricks),
        Scene::Carved | Scene::CarvedLit => scene::cut_and_carved(&bricks)?,
    };
    let look = Look {
        transfer: scene::transfer("soft")?,
        camera: scene::camera(&scene::bounds()),
        settings: scene::settings(matches!(scene, Scene::HeadLit | Scene::CarvedLit)),
    };
    let drawing = Drawing::new(&device, &model, &Subdivision::default(), look)?;
    drawing.draw(&mut SliceRenderer::new(&device)?)?;
    let usage = Usage {
        baseline,
        peak: status_bytes("VmHWM")?,
        blocks: drawing.paged.bytes(),
        leaves: bricks.bytes() as u64,
    };
    println!("{}", serde_json::to_string(&usage)?);
    Ok(())
}

/// What `run` returns, and by how many bytes the resident memory grew at most meanwhile.
pub fn growth<T>(run: impl FnOnce() -> T) -> Outcome<(T, u64)> {
    // Linux: forgets the highest resident size so far.
    std::fs::write("/proc/self/clear_refs", "5")?;
    let before = status_bytes("VmRSS")?;
    let result = run();
    Ok((result, status_bytes("VmHWM")?.saturating_sub(before)))
}

/// Writes to `bytes` of free memory and frees them. The host of a virtual machine may have taken memory that was free for seconds;
/// it is slow to give it back, and that is nobody's speed.
pub fn touch_free(bytes: usize) {
    let mut memory = Array::<u8>::zeroed(bytes);
    memory.chunks_mut(4096).for_each(|page| page[0] = 1);
    std::hint::black_box(&memory);
}

/// A field of /proc/self/status, bytes.
fn status_bytes(field: &str) -> Outcome<u64> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix(field));
    let kibibytes = line.and_then(|rest| rest.trim_start_matches(':').split_whitespace().next());
    let number = kibibytes.ok_or_else(|| format!("/proc/self/status has no {field}"))?;
    Ok(number.parse::<u64>()? << 10)
}

impl Measured {
    fn print(&self) {
        let mebi = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        let u = &self.usage;
        println!(
            "{:<26} {:8.1} {:8.1} {:8.1} {:8.1} {:26.2}  {}",
            self.what,
            mebi(u.baseline),
            mebi(u.peak),
            mebi(u.blocks),
            mebi(u.leaves),
            self.bar.value,
            self.bar
        );
    }
}
