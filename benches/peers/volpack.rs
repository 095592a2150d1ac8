//! Rays cast on the processor against VolPack's shear-warp, on VolPack's own volume: one thread each, classified and shaded.

mod causes;
mod differences;
mod model;
mod normals;
mod slices;

use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use serde::{Deserialize, Serialize};
use vcsg::image::Frame;
use vcsg::projection::raycast::{CastTarget, draw};
use vcsg::projection::{Camera, ControlPoint, FrameSpec, Light, Material, Settings, Shading, TransferFunction};
use vcsg::target::{Subdivision, Target};
use vcsg::volume::{Bricks, Grid, Voxels, io};

use self::causes::{END, FAINT};
use self::differences::{Pictures, Table};
use crate::Outcome;
use crate::bar::{Bar, Limit};
use crate::frames::PICTURES;
use crate::picture::{self, Difference};
use crate::pinning;
use crate::runs::{Ratios, Run, Summary, timed};
use crate::scene;
use crate::vtk::Peer;

/// Frames a repetition, since they are short.
const FRAMES: usize = 9;

/// How many times as fast as VolPack ours must be: no slower than twice.
const BAR: f64 = 0.5;

const SOURCE: &str = "tools/peers/volpack.c";
const VOLUME: &str = "target/deps/data/brainsmall.den";
const LIBRARY: &str = "target/deps/volpack";

/// VolPack's least opacity of a voxel and largest one of a ray: its own, and those of our rays, which drop nothing and end where slices
/// close a pixel.
const THRESHOLDS: [(&str, [f64; 2]); 2] = [("", [FAINT, END]), (", nothing dropped", [0.0, 1.0 - 1.0 / 1024.0])];

/// What is made for the peer.
const PROGRAM: &str = "target/bench/volpack";
const RAW: &str = "target/bench/brainsmall.raw";

/// What VolPack says of itself.
#[derive(Deserialize)]
struct About {
    version: String,
}

/// One comparison.
#[derive(Serialize)]
pub struct Comparison {
    what: String,
    peer: String,
    ours: Summary,
    theirs: Summary,
    faster: Ratios,
    /// The bar.
    pub bar: Bar,
    difference: Difference,
    /// What the difference comes of.
    causes: Vec<Table>,
}

/// Compares the frames with `name` in theirs; each comparison is printed when it is done.
pub fn compare(name: &str, runs: usize) -> Outcome<Vec<Comparison>> {
    let mut done = Vec::new();
    for edge in [256, 512] {
        for (which, thresholds) in THRESHOLDS {
            let what = format!("brainsmall shaded {edge}{which}");
            if what.contains(name) {
                let comparison = compare_one(what, edge, thresholds, runs)?;
                comparison.print();
                done.push(comparison);
            }
        }
    }
    Ok(done)
}

fn compare_one(what: String, edge: u32, thresholds: [f64; 2], runs: usize) -> Outcome<Comparison> {
    let grid = io::read(Path::new(VOLUME))?.grid;
    let values = bytes(&grid)?;
    build(values)?;
    let theirs_path = format!("{PICTURES}/volpack-{edge}.raw");
    std::fs::create_dir_all(PICTURES)?;
    let mut program = program(&grid, edge, thresholds, &theirs_path);
    let (mut peer, about): (Peer, About) = Peer::serve(&mut program, PROGRAM)?;
    // Of the processors one may be shared with others' work: ours and theirs have the same.
    peer.pin()?;
    let model = scene::bare(&Arc::new(Bricks::new(&grid)));
    let target = Target::build(&model, None, &Subdivision::default())?;
    let spec = FrameSpec {
        target: &target,
        transfer: &transfer()?,
        camera: &camera(grid.dims(), edge),
        settings: &settings(),
    };
    let pool = pinning::pool(1)?;
    let cast = pool.install(|| CastTarget::of(&spec));
    let frame = || -> Outcome<(Frame, Run)> {
        let (frame, run) = pool.install(|| timed(|| draw(&spec, &cast, None)));
        Ok((frame?, run))
    };
    let (picture, _) = frame()?;
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    for _ in 0..runs * FRAMES {
        ours.push(frame()?.1);
        theirs.push(peer.run()?);
    }
    let [ours, theirs] = [ours, theirs].map(Summary::of);
    let faster = Ratios::of(&ours, &theirs);
    let panels = format!("{PICTURES}/raycast-{}.png", what.replace(' ', "-"));
    Ok(Comparison {
        bar: Bar {
            what: format!("times as fast as VolPack: {what}"),
            value: faster.median,
            limit: Limit::AtLeast(BAR),
        },
        peer: format!("VolPack {}", about.version),
        difference: picture::compare(&picture, &grey(&theirs_path, edge)?, &panels)?,
        causes: match thresholds {
            [FAINT, END] => Pictures {
                values,
                spec: &spec,
                ours: &picture,
                theirs: &|thresholds| theirs_with(&grid, edge, thresholds),
            }
            .tables()?,
            _ => Vec::new(),
        },
        what,
        faster,
        ours,
        theirs,
    })
}

fn bytes(grid: &Grid) -> Outcome<&[u8]> {
    match grid.voxels() {
        Voxels::U8(voxels) => Ok(voxels),
        _ => Err(format!("{VOLUME}: its voxels are not bytes").into()),
    }
}

/// Compiles the peer, and writes its volume.
fn build(voxels: &[u8]) -> Outcome<()> {
    let library = format!("{LIBRARY}/libvolpack.a");
    if !Path::new(&library).exists() {
        return Err(format!("{library} is missing: run make setup").into());
    }
    std::fs::create_dir_all("target/bench")?;
    std::fs::write(RAW, voxels)?;
    let include = format!("-I{LIBRARY}");
    let arguments = ["-O2", &include, "-o", PROGRAM, SOURCE, &library, "-lm"];
    let status = Command::new("cc").args(arguments).status()?;
    match status.success() {
        true => Ok(()),
        false => Err(format!("cc {SOURCE}: {status}").into()),
    }
}

/// The peer, which leaves its picture at `path`.
fn program(grid: &Grid, edge: u32, [faint, end]: [f64; 2], path: &str) -> Command {
    let [width, height, depth] = grid.dims().map(|n| n.to_string());
    let [edge, faint, end] = [edge.to_string(), faint.to_string(), end.to_string()];
    let mut program = Command::new(PROGRAM);
    program.args([RAW, &width, &height, &depth, &edge, &faint, &end, path]);
    program
}

/// The peer's picture, with these thresholds.
fn theirs_with(grid: &Grid, edge: u32, thresholds: [f64; 2]) -> Outcome<Frame> {
    let path = format!("{PICTURES}/volpack-thresholds.raw");
    let mut program = program(grid, edge, thresholds, &path);
    let status = program.stdin(Stdio::null()).stdout(Stdio::null()).status()?;
    match status.success() {
        true => grey(&path, edge),
        false => Err(format!("{program:?}: {status}").into()),
    }
}

/// The ramp of tools/peers/volpack.c.
fn transfer() -> Outcome<TransferFunction> {
    let point = |(value, opacity)| ControlPoint {
        value,
        color: [1.0; 3],
        opacity,
    };
    let ramp = [(0.0, 0.0), (30.0, 0.0), (60.0, 1.0), (255.0, 1.0)];
    Ok(TransferFunction::new(ramp.map(point).to_vec(), 1.0)?)
}

/// Its view, as it puts single voxels: turned about y, then x, the longest edge as wide as the frame.
fn camera(dims: [usize; 3], edge: u32) -> Camera {
    let longest = dims.into_iter().max().unwrap_or(1) as f64;
    // Its middle is a voxel, and of the four pixels round the frame's middle the upper right one shows it.
    let middle = DVec3::from_array(dims.map(|n| n as f64 / 2.0));
    let half_pixel = 0.5 * longest / f64::from(edge);
    // Its angles go the other way round, its y is up, and its z goes away from the eye: what it shows is a mirror image.
    let turned = DMat3::from_rotation_x(15f64.to_radians()) * DMat3::from_rotation_y((-130f64).to_radians());
    let rotation = DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0)) * turned;
    let place = DVec3::new(half_pixel, -half_pixel, 2.0 * longest);
    Camera {
        eye_from_world: DAffine3 {
            matrix3: rotation,
            translation: place - rotation * middle,
        },
        lens: scene::parallel(longest / 2.0, edge),
        size: [edge; 2],
    }
}

/// Its material and light.
fn settings() -> Settings {
    Settings {
        shading: Some(Shading {
            lights: vec![Light {
                towards: DVec3::new(-0.3, 0.3, -1.0).normalize(),
                intensity: 1.0,
            }],
            material: Material {
                ambient: 0.18,
                diffuse: 0.35,
                specular: 0.39,
                shininess_log2: 3,
            },
            soft_gradient: 0.002,
        }),
        ..Settings::default()
    }
}

/// A square of grey bytes, the lowest row first, as an opaque frame.
fn grey(path: &str, edge: u32) -> Outcome<Frame> {
    let shade = |byte: u8| {
        let c = f32::from(byte) / 255.0;
        [c, c, c, 1.0]
    };
    let bytes = std::fs::read(path)?;
    let rows = bytes.chunks_exact(edge as usize).rev();
    let pixels = rows.flatten().copied().map(shade).collect();
    Ok(Frame::from_pixels(edge, edge, pixels)?)
}

impl Comparison {
    fn print(&self) {
        let (o, t, r, d) = (&self.ours, &self.theirs, &self.faster, &self.difference);
        println!(
            "{:<26} {:>8} {:>8} {:8.4} | {:8.4} {:8.4} | {:7.2} {:6.2} {:6.2}  {:<14} | {} | {:.2}, {}, {}",
            self.what,
            "",
            "",
            o.median_s,
            t.median_s,
            t.min_s,
            r.median,
            r.min,
            r.cpu,
            self.bar.to_string(),
            self.peer,
            d.mean,
            d.percentile_99,
            d.max
        );
        self.causes.iter().for_each(Table::print);
    }
}
