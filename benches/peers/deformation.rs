//! Building the target of a deformed volume against vtkImageReslice with the same spline on the same lattice.

use std::path::Path;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use vcsg::model::deform::files::write_pairs;
use vcsg::model::deform::{Landmark, Morph, Smoothness, Spline};
use vcsg::model::{Model, Node};
use vcsg::target::{Lattice, Subdivision, Target, VoxelTarget};
use vcsg::volume::Bricks;

use crate::Outcome;
use crate::bar::{Bar, Limit};
use crate::rows::Rows;
use crate::runs::{Ratios, Summary, timed};
use crate::scene::{self, SIDE};
use crate::vtk::Peer;

/// How many times as fast as vtkImageReslice ours must be.
const BAR: f64 = 15.0;

/// What samples may be displaced by, in voxels.
const ERROR_VOXELS: f64 = 0.1;

/// Landmarks, and how far they go along each axis at most, millimetres.
const LANDMARKS: u32 = 30;
const FARTHEST_MM: f64 = 8.0;

/// Where both sides have them from.
const TABLE: &str = "target/bench/landmarks.txt";

const ROWS: Rows = Rows(14);

/// What VTK does.
#[derive(Clone, Copy, PartialEq)]
enum Peers {
    /// The same map: the inverse of the spline.
    Same,
    /// A spline through the swapped landmarks, which is another map, and needs no iteration.
    Swapped,
}

/// What the script says of itself.
#[derive(Deserialize)]
struct About {
    landmarks: u32,
}

/// One comparison, done.
#[derive(Serialize)]
pub struct Comparison {
    what: String,
    threads: usize,
    ours: Summary,
    theirs: Summary,
    faster: Ratios,
    /// The bars.
    pub bars: Vec<Bar>,
    /// Cells of the tabulated inverse.
    cells: usize,
    /// The largest error that building the table measured, voxels.
    measured_voxels: f64,
    /// The largest error of all voxels, against the spline itself, voxels.
    worst_voxels: f64,
    /// Of the differences from VTK's values: the mean, and the largest. VTK rounds to whole numbers.
    apart: [f64; 2],
}

/// Compares on both volumes, and on one with the map that is cheaper for VTK; each comparison is printed when it is done.
pub fn compare(repetitions: usize) -> Outcome<Vec<Comparison>> {
    println!(
        "\nA 256³ volume deformed by {LANDMARKS} landmarks on a lattice of 256³, linear; seconds, and how many times as fast as vtkImageReslice"
    );
    ROWS.head("cells, error measured and of all voxels, mean and most apart from VTK");
    write_pairs(Path::new(TABLE), &landmarks())?;
    let mut done = Vec::new();
    for (volume, peers) in [("head", Peers::Same), ("dense", Peers::Same), ("head", Peers::Swapped)] {
        let comparison = compare_one(volume, peers, repetitions)?;
        comparison.print();
        done.push(comparison);
    }
    Ok(done)
}

/// Landmarks spread evenly over the volume (Halton's sequence), each of which goes another way.
fn landmarks() -> Vec<Landmark> {
    let landmark = |n: u32| {
        let from = 20.0 + 215.0 * DVec3::from([2, 3, 5].map(|base| radical_inverse(n, base)));
        let n = f64::from(n);
        let by = DVec3::new((2.1 * n).sin(), (3.7 * n + 1.0).sin(), (1.3 * n + 2.0).sin());
        Landmark {
            name: format!("L{n}"),
            from,
            to: from + FARTHEST_MM * by,
        }
    };
    (1..=LANDMARKS).map(landmark).collect()
}

/// The digits of `n` to `base` behind the point, in reverse.
fn radical_inverse(mut n: u32, base: u32) -> f64 {
    let (mut value, mut place) = (0.0, 1.0);
    while n > 0 {
        place /= f64::from(base);
        value += place * f64::from(n % base);
        n /= base;
    }
    value
}

/// The volume deformed, from the landmarks on.
fn deformed(bricks: &Arc<Bricks>) -> Outcome<(Model, Arc<Morph>)> {
    let spline = Spline::new(&landmarks(), &Smoothness::default())?;
    let morph = Arc::new(Morph::new(spline, scene::bounds())?);
    let mut model = scene::bare(bricks);
    let child = model.root().ok_or("a volume")?;
    model.push(Node::Deform {
        child,
        morph: Arc::clone(&morph),
        error_voxels: ERROR_VOXELS,
    });
    Ok((model, morph))
}

fn compare_one(volume: &str, peers: Peers, repetitions: usize) -> Outcome<Comparison> {
    let threads = rayon::current_num_threads();
    let resliced = format!("target/bench/{volume}-deformed.raw");
    let pairs = [
        ["--raw", &scene::raw_path(volume)],
        ["--threads", &threads.to_string()],
        ["--output", &resliced],
        ["--landmarks", TABLE],
    ];
    let mut arguments = pairs.as_flattened().to_vec();
    if peers == Peers::Swapped {
        arguments.push("--swapped");
    }
    let (mut peer, about): (Peer, About) = Peer::start("tools/peers/vtk_deform.py", &arguments)?;
    let bricks = scene::bricks(volume)?;
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    for _ in 0..repetitions {
        let (voxels, run) = timed(|| built(&bricks));
        voxels?;
        ours.push(run);
        theirs.push(peer.run()?);
    }
    let (ours, theirs) = (Summary::of(ours), Summary::of(theirs));
    let faster = Ratios::of(&ours, &theirs);
    let held = Held::new(&bricks, &resliced)?;
    let name = if peers == Peers::Same {
        volume.to_owned()
    } else {
        format!("{volume}, swapped")
    };
    Ok(Comparison {
        threads,
        // The other map is a figure and no bar.
        bars: match peers {
            Peers::Same => bars(&name, about.landmarks, &faster, &held).to_vec(),
            Peers::Swapped => Vec::new(),
        },
        what: name,
        ours,
        theirs,
        faster,
        cells: held.cells,
        measured_voxels: held.measured_voxels,
        worst_voxels: held.worst_voxels,
        apart: held.apart,
    })
}

fn bars(name: &str, landmarks: u32, faster: &Ratios, held: &Held) -> [Bar; 2] {
    [
        Bar {
            what: format!(
                "times as fast as vtkImageReslice with a spline of {}: {name}",
                landmarks
            ),
            value: faster.median,
            limit: Limit::AtLeast(BAR),
        },
        Bar {
            what: format!("voxels of error of a deformation: {name}"),
            value: held.worst_voxels,
            limit: Limit::AtMost(ERROR_VOXELS),
        },
    ]
}

fn target(model: &Model) -> Outcome<Target> {
    let lattice = Lattice::new([SIDE; 3], DAffine3::IDENTITY);
    Ok(Target::on_lattice(model, lattice, &Subdivision::default())?)
}

/// Fits, proves, tabulates, subdivides and reconstructs; the number of voxels keeps the work from being left out.
fn built(bricks: &Arc<Bricks>) -> Outcome<usize> {
    let target = target(&deformed(bricks)?.0)?;
    let voxels = VoxelTarget::new(&target).voxels;
    Ok(voxels.iter().map(|block| block.premultiplied.len()).sum())
}

/// The result held against the spline and against VTK's.
struct Held {
    cells: usize,
    measured_voxels: f64,
    worst_voxels: f64,
    apart: [f64; 2],
}

impl Held {
    fn new(bricks: &Arc<Bricks>, resliced: &str) -> Outcome<Self> {
        let (model, morph) = deformed(bricks)?;
        let target = target(&model)?;
        let (_, report) = target.tree.deformations().next().ok_or("a deformation")?;
        let ours = VoxelTarget::new(&target);
        let theirs = std::fs::read(resliced)?;
        let inner = 1.0..=(SIDE - 2) as f64;
        let at = |n: usize| [n % SIDE, n / SIDE % SIDE, n / (SIDE * SIDE)];
        let each = |n: usize| {
            let seen = DVec3::from(at(n).map(|i| i as f64));
            let source = target.tree.in_space(Some(0), seen);
            // One voxel away from the volume's faces, where the two treat borders each in their way.
            let inside = source.to_array().iter().all(|x| inner.contains(x));
            let (value, _) = ours.voxel(at(n).map(|i| i as i64));
            let apart = f64::from((value - f32::from(theirs[n])).abs());
            inside.then(|| [off(morph.spline(), source, seen), apart, apart, 1.0])
        };
        let both = |a: [f64; 4], b: [f64; 4]| [a[0].max(b[0]), a[1].max(b[1]), a[2] + b[2], a[3] + b[3]];
        let count = theirs.len().min(SIDE * SIDE * SIDE);
        let [worst_voxels, most, sum, compared] = (0..count).into_par_iter().filter_map(each).reduce(|| [0.0; 4], both);
        Ok(Self {
            cells: report.cells,
            measured_voxels: report.measured_voxels,
            worst_voxels,
            apart: [sum / compared, most],
        })
    }
}

/// How far `source` is from what goes to `seen`, by Newton's iteration from there.
fn off(spline: &Spline, source: DVec3, seen: DVec3) -> f64 {
    let step = |x: DVec3| {
        let (value, jacobian) = spline.point_and_jacobian(x);
        x + jacobian.inverse() * (seen - value)
    };
    step(step(source)).distance(source)
}

impl Comparison {
    fn print(&self) {
        let bar = self.bars.first().map_or_else(String::new, Bar::to_string);
        let (measured, worst, [mean, most]) = (self.measured_voxels, self.worst_voxels, self.apart);
        let behind = format!("{} {measured:.3} {worst:.3} {mean:.3} {most:.1}", self.cells);
        ROWS.print(&self.what, &self.ours, &self.theirs, &self.faster, &bar, &behind);
    }
}
