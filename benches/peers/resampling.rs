//! Building the target of a rotated volume against vtkImageReslice on the same lattice.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use vcsg::model::Model;
use vcsg::target::{Lattice, Subdivision, Target, VoxelTarget};
use vcsg::volume::Bricks;

use crate::Outcome;
use crate::bar::{Bar, Limit};
use crate::rows::Rows;
use crate::runs::{Ratios, Summary, timed};
use crate::scene::{self, SIDE};
use crate::vtk::Peer;

/// How many times as fast as vtkImageReslice ours must be.
const BAR: f64 = 4.0;

const ROWS: Rows = Rows(8);

/// What the script says about its turn.
#[derive(Deserialize)]
struct PeerTurn {
    angle_deg: f64,
    axis: [f64; 3],
}

impl PeerTurn {
    /// The place in the source that VTK looks up for a place of the output.
    fn source_from_output(&self) -> DAffine3 {
        let axis = DVec3::from_array(self.axis).normalize();
        DAffine3::from_translation(scene::middle())
            * DAffine3::from_axis_angle(axis, self.angle_deg.to_radians())
            * DAffine3::from_translation(-scene::middle())
    }
}

/// One comparison, done.
#[derive(Serialize)]
pub struct Comparison {
    what: String,
    threads: usize,
    ours: Summary,
    theirs: Summary,
    faster: Ratios,
    /// The bar.
    pub bar: Bar,
    /// The largest difference where both interpolate between voxels; VTK rounds to whole numbers.
    most_apart: f32,
    compared: usize,
}

/// Compares on both volumes; each comparison is printed when it is done.
pub fn compare(repetitions: usize) -> Outcome<Vec<Comparison>> {
    println!(
        "\nA rotated 256³ volume on a lattice of 256³, linear; seconds, and how many times as fast as vtkImageReslice"
    );
    ROWS.head("most apart in the interior");
    let mut done = Vec::new();
    for volume in ["head", "dense"] {
        let comparison = compare_one(volume, repetitions)?;
        comparison.print();
        done.push(comparison);
    }
    Ok(done)
}

fn compare_one(volume: &str, repetitions: usize) -> Outcome<Comparison> {
    let threads = rayon::current_num_threads();
    let resliced = format!("target/bench/{volume}-resliced.raw");
    let arguments = [
        ["--raw", &scene::raw_path(volume)],
        ["--threads", &threads.to_string()],
        ["--output", &resliced],
    ];
    let (mut peer, turn): (Peer, PeerTurn) = Peer::start("tools/peers/vtk_reslice.py", arguments.as_flattened())?;
    let source_from_output = turn.source_from_output();
    let bricks: Arc<Bricks> = scene::bricks(volume)?;
    let model = scene::moved(&bricks, source_from_output.inverse());
    let (most_apart, compared) = most_apart(&model, &source_from_output, &resliced)?;
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    for _ in 0..repetitions {
        let (target, run) = timed(|| built(&model));
        target?;
        ours.push(run);
        theirs.push(peer.run()?);
    }
    let (ours, theirs) = (Summary::of(ours), Summary::of(theirs));
    let faster = Ratios::of(&ours, &theirs);
    Ok(Comparison {
        what: volume.to_owned(),
        threads,
        bar: Bar {
            what: format!("times as fast as vtkImageReslice: {volume}"),
            value: faster.median,
            limit: Limit::AtLeast(BAR),
        },
        ours,
        theirs,
        faster,
        most_apart,
        compared,
    })
}

fn target(model: &Model) -> Outcome<Target> {
    let lattice = Lattice::new([SIDE; 3], DAffine3::IDENTITY);
    Ok(Target::on_lattice(model, lattice, &Subdivision::default())?)
}

/// Subdivides and reconstructs; the number of voxels keeps the work from being left out.
fn built(model: &Model) -> Outcome<usize> {
    let target = target(model)?;
    let voxels = VoxelTarget::new(&target).voxels;
    Ok(voxels.iter().map(|block| block.premultiplied.len()).sum())
}

/// The largest difference from VTK's result, and the number of voxels compared: those that come from between voxels, one
/// away from the volume's faces, where the two treat borders each in their way.
fn most_apart(model: &Model, source_from_output: &DAffine3, resliced: &str) -> Outcome<(f32, usize)> {
    let theirs = std::fs::read(resliced)?;
    let target = target(model)?;
    let ours = VoxelTarget::new(&target);
    let inner = 1.0..=(SIDE - 2) as f64;
    let apart = |n: usize| {
        let at = [n % SIDE, n / SIDE % SIDE, n / (SIDE * SIDE)];
        let place = DVec3::from_array(at.map(|i| i as f64));
        let source = source_from_output.transform_point3(place);
        let inside = source.to_array().iter().all(|x| inner.contains(x));
        let (value, coverage) = ours.voxel(at.map(|i| i as i64));
        inside.then(|| (value - f32::from(theirs[n])).abs() + (1.0 - coverage) * f32::from(u8::MAX))
    };
    let both = |a: (f32, usize), b: (f32, usize)| (a.0.max(b.0), a.1 + b.1);
    Ok((0..theirs.len().min(SIDE * SIDE * SIDE))
        .into_par_iter()
        .filter_map(apart)
        .map(|difference| (difference, 1))
        .reduce(|| (0.0, 0), both))
}

impl Comparison {
    fn print(&self) {
        let behind = format!("{:.3} of {} voxels", self.most_apart, self.compared);
        let bar = self.bar.to_string();
        ROWS.print(&self.what, &self.ours, &self.theirs, &self.faster, &bar, &behind);
    }
}
