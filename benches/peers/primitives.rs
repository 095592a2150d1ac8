//! WK94's table 1 today: three primitives, solid and hollow, in the paper's three steps, against supersampling. On one thread.

use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use serde::Serialize;
use vcsg::math::{Aabb, affine};
use vcsg::voxelize::beams::{Run as Beam, Runs, Voxelizer};
use vcsg::voxelize::{Placed, Primitive, Profile, Solid};

use crate::Outcome;
use crate::bar::{Bar, Limit};
use crate::runs::{Ratios, Summary, timed};

/// The longest that a primitive may take, milliseconds.
const LONGEST_MS: f64 = 5.0;

/// How many times as fast as supersampling with 8³ points a voxel it must be.
const BAR: f64 = 20.0;

/// Voxels of the lattice along each axis.
const SIDE: usize = 80;

/// The filter's radius, voxels.
const RADIUS: f64 = 2.0;

/// The shell's thickness, voxels.
const THICKNESS: f64 = 1.0;

/// Points along each axis of the filter's cube, which is four voxels wide: 8³ in all, and 8³ a voxel.
const COARSE: usize = 8;
const FINE: usize = 32;

/// Points of the filter's cube for the truth; their densities are within 3e-4 of the exact ones of a box.
const TRUTH: usize = 1 << 21;

/// Soft voxels at which errors are looked for.
const LOOKED_AT: usize = 200;

#[derive(Clone, Copy, PartialEq)]
enum Shape {
    Sphere,
    Cone,
    Box,
}

/// A primitive of the table, with the paper's seconds for its three steps.
struct Case {
    name: &'static str,
    shape: Shape,
    hollow: bool,
    paper_s: [f64; 3],
}

const CASES: [Case; 6] = {
    const fn case(name: &'static str, shape: Shape, hollow: bool, paper_s: [f64; 3]) -> Case {
        Case {
            name,
            shape,
            hollow,
            paper_s,
        }
    }
    [
        case("sphere", Shape::Sphere, false, [0.07, 0.38, 1.67]),
        case("hollow sphere", Shape::Sphere, true, [0.12, 0.14, 0.65]),
        case("cone", Shape::Cone, false, [0.69, 0.25, 2.84]),
        case("hollow cone", Shape::Cone, true, [1.09, 0.16, 1.70]),
        case("box", Shape::Box, false, [0.07, 0.23, 4.74]),
        case("hollow box", Shape::Box, true, [0.12, 0.16, 2.76]),
    ]
};

/// Supersampling next to ours.
#[derive(Serialize)]
struct Supersampled {
    points_across: usize,
    theirs: Summary,
    faster: Ratios,
    /// Its largest error.
    error: f64,
}

/// One primitive, done.
#[derive(Serialize)]
pub struct Comparison {
    what: &'static str,
    soft_voxels: usize,
    paper_s: [f64; 3],
    /// Depth buffers, beams, densities.
    steps: [Summary; 3],
    ours: Summary,
    /// The first run of the process on this kind, which fills the tables that it needs, seconds.
    first_s: f64,
    /// Our largest error.
    error: f64,
    against: [Supersampled; 2],
    /// The time, how much faster, and how much less wrong.
    pub bars: Vec<Bar>,
}

/// Compares all primitives; each comparison is printed when it is done.
pub fn compare(repetitions: usize) -> Outcome<Vec<Comparison>> {
    println!(
        "\nPrimitives, one thread; milliseconds (medians) of WK94's three steps, its seconds of 1994; supersampling by 8³ points and by 8³ points a voxel; largest errors"
    );
    println!(
        "{:<14} {:>6} | {:>6} {:>6} {:>6} {:>6} {:>6} | {:>5} {:>5} {:>5} | {:>7} {:>6} {:>7} | {:>7} {:>6} {:>7} | {:>7}",
        "",
        "soft",
        "depths",
        "beams",
        "fill",
        "all",
        "first",
        "1994",
        "",
        "",
        "8³",
        "times",
        "error",
        "8³/vox",
        "times",
        "error",
        "error"
    );
    let single = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut done = Vec::new();
    for case in &CASES {
        let comparison = case.compare(repetitions, &single)?;
        comparison.print();
        done.push(comparison);
    }
    Ok(done)
}

fn cone_depth(p: DVec3) -> f64 {
    // The side falls by two for each step outwards.
    (p.z + 32.0).min((32.0 - p.z - 2.0 * p.truncate().length()) / 5f64.sqrt())
}

fn box_depth(p: DVec3) -> f64 {
    (DVec3::new(16.0, 32.0, 16.0) - p.abs()).min_element()
}

impl Case {
    fn primitive(&self) -> Outcome<Primitive> {
        let half = DVec3::new(16.0, 32.0, 16.0);
        let solid = match self.shape {
            Shape::Sphere => Solid::Sphere {
                center: DVec3::ZERO,
                radius: 32.0,
            },
            Shape::Cone => Solid::revolved(Profile::frustum(32.0, 0.0, 64.0)),
            Shape::Box => Solid::Box(Aabb::new(-half, half)),
        };
        let primitive = Primitive::soft(solid, 1.0);
        Ok(match self.hollow {
            true => primitive.shell(THICKNESS)?,
            false => primitive,
        })
    }

    /// The densities by supersampling, of what is inside by the shape's definition: how deep below its surface, or below the
    /// planes of its sides, a point lies.
    fn supersample(&self, lattice: &DAffine3, runs: &Runs, points: &[(DVec3, f64)]) -> Vec<f32> {
        match self.shape {
            Shape::Sphere => self.count(|p| 32.0 - p.length(), lattice, runs, points),
            Shape::Cone => self.count(cone_depth, lattice, runs, points),
            Shape::Box => self.count(box_depth, lattice, runs, points),
        }
    }

    /// The densities of the voxels that `runs` has, as the weight of the points that are inside.
    fn count(
        &self,
        depth: impl Fn(DVec3) -> f64 + Sync,
        lattice: &DAffine3,
        runs: &Runs,
        points: &[(DVec3, f64)],
    ) -> Vec<f32> {
        let most = if self.hollow { THICKNESS } else { f64::INFINITY };
        let mut densities = vec![0.0; SIDE * SIDE * SIDE];
        for run in runs.full.iter().flatten() {
            densities[place(run, run.voxels.start)..place(run, run.voxels.end)].fill(1.0);
        }
        let soft: Vec<(usize, DVec3)> = soft_voxels(runs, lattice).collect();
        let counted = soft.par_iter().map(|(n, p)| {
            let inside = points.iter().map(|(offset, weight)| {
                let depth = depth(*p + *offset);
                if depth > 0.0 && depth < most { *weight } else { 0.0 }
            });
            (*n, inside.sum::<f64>() as f32)
        });
        for (n, density) in counted.collect::<Vec<_>>() {
            densities[n] = density;
        }
        densities
    }

    fn compare(&self, repetitions: usize, single: &rayon::ThreadPool) -> Outcome<Comparison> {
        let placed = self.primitive()?.placed(&DAffine3::IDENTITY, 1.0);
        // No face lies on voxels, or midway between them.
        let lattice = DAffine3::from_translation(DVec3::new(0.37, 0.21, 0.43) - 0.5 * SIDE as f64);
        let voxelizer = Voxelizer::new(&placed, [SIDE; 3], &lattice);
        let first_s = single.install(|| timed(|| voxelizer.voxelize())).1.wall_s;
        let runs = voxelizer.depths().runs(SIDE);
        let peers = [COARSE, FINE].map(|across| weighted(cells(across)));
        let (mut ours, mut steps, mut theirs) = (Vec::new(), [const { Vec::new() }; 3], [const { Vec::new() }; 2]);
        for _ in 0..repetitions {
            single.install(|| {
                let (depths, first) = timed(|| voxelizer.depths());
                let (runs, second) = timed(|| depths.runs(SIDE));
                let (_, third) = timed(|| voxelizer.fill(&runs));
                for (step, run) in steps.iter_mut().zip([first, second, third]) {
                    step.push(run);
                }
                ours.push(timed(|| voxelizer.voxelize()).1);
                for (peer, points) in theirs.iter_mut().zip(&peers) {
                    peer.push(timed(|| self.supersample(&lattice, &runs, points)).1);
                }
            });
        }
        let ours = Summary::of(ours);
        let (error, errors) = self.errors(&placed, &lattice, &runs, &peers);
        let [coarse, fine] = theirs.map(Summary::of);
        let against =
            [(COARSE, coarse, errors[0]), (FINE, fine, errors[1])].map(|(points_across, theirs, error)| Supersampled {
                points_across,
                faster: Ratios::of(&ours, &theirs),
                theirs,
                error,
            });
        Ok(Comparison {
            what: self.name,
            soft_voxels: soft_voxels(&runs, &lattice).count(),
            paper_s: self.paper_s,
            steps: steps.map(Summary::of),
            bars: self.bars(&ours, &against, error),
            ours,
            first_s,
            error,
            against,
        })
    }

    /// The largest errors at some soft voxels, ours and those of both peers.
    fn errors(
        &self,
        placed: &Placed,
        lattice: &DAffine3,
        runs: &Runs,
        peers: &[Vec<(DVec3, f64)>; 2],
    ) -> (f64, [f64; 2]) {
        let soft: Vec<(usize, DVec3)> = soft_voxels(runs, lattice).collect();
        // A step that shares no factor with the rows' lengths.
        let few = |n: usize| soft[n * (soft.len() / LOOKED_AT) + n % 7];
        let looked_at: Vec<(usize, DVec3)> = (0..LOOKED_AT).map(few).collect();
        let some = Runs {
            full: Vec::new(),
            soft: vec![looked_at.iter().map(|(n, _)| one_voxel(*n)).collect()],
        };
        let truth = self.supersample(lattice, &some, &weighted(spread(TRUTH)));
        let most = |density: &dyn Fn(usize, DVec3) -> f32| {
            let errors = looked_at
                .iter()
                .map(|(n, p)| f64::from((density(*n, *p) - truth[*n]).abs()));
            errors.fold(0.0, f64::max)
        };
        let peers = peers.each_ref().map(|points| {
            let found = self.supersample(lattice, &some, points);
            most(&|n, _| found[n])
        });
        (most(&|_, p| placed.coverage(p)), peers)
    }

    fn bars(&self, ours: &Summary, against: &[Supersampled; 2], error: f64) -> Vec<Bar> {
        let [_, fine] = against;
        let bar = |what: &str, value: f64, limit: Limit| Bar {
            what: format!("{what}: {}", self.name),
            value,
            limit,
        };
        vec![
            bar("milliseconds", ours.median_s * 1e3, Limit::AtMost(LONGEST_MS)),
            bar(
                "times as fast as 8³ points a voxel",
                fine.faster.median,
                Limit::AtLeast(BAR),
            ),
            bar(
                "error over that of 8³ points a voxel",
                error / fine.error,
                Limit::AtMost(1.0),
            ),
        ]
    }
}

/// The middles of `across`³ cells of the filter's cube.
fn cells(across: usize) -> impl Iterator<Item = DVec3> {
    let at = move |n: usize| 2.0 * (n as f64 + 0.5) / across as f64 - 1.0;
    (0..across * across * across)
        .map(move |n| DVec3::new(at(n % across), at(n / across % across), at(n / (across * across))))
}

/// Points spread evenly over the filter's cube, no two of them in a plane along it: the additive recurrence with the powers of
/// the inverse of the root of x⁴ = x + 1.
fn spread(count: usize) -> impl Iterator<Item = DVec3> {
    let g = 1.220_744_084_605_759_5_f64;
    let steps = DVec3::new(g.powi(-1), g.powi(-2), g.powi(-3));
    (0..count).map(move |n| (0.5 + steps * n as f64).fract() * 2.0 - 1.0)
}

/// Those of the points that lie in the filter's ball, in voxels, and their part of its weight.
fn weighted(points: impl Iterator<Item = DVec3>) -> Vec<(DVec3, f64)> {
    let inside: Vec<DVec3> = points.filter(|p| p.length() < 1.0).collect();
    let sum: f64 = inside.iter().map(|p| 1.0 - p.length()).sum();
    let weighted = inside.iter().map(|p| (*p * RADIUS, (1.0 - p.length()) / sum));
    weighted.collect()
}

/// Where voxel `i` of a run's beam is among all.
fn place(run: &Beam, i: u32) -> usize {
    i as usize + SIDE * (run.beam[0] as usize + SIDE * run.beam[1] as usize)
}

/// The run of one voxel.
fn one_voxel(n: usize) -> Beam {
    let [i, j, k] = [n % SIDE, n / SIDE % SIDE, n / (SIDE * SIDE)].map(|i| i as u32);
    Beam {
        beam: [j, k],
        voxels: i..i + 1,
    }
}

/// The soft voxels and where they are.
fn soft_voxels<'a>(runs: &'a Runs, lattice: &'a DAffine3) -> impl Iterator<Item = (usize, DVec3)> + 'a {
    runs.soft.iter().flatten().flat_map(move |run| {
        let [j, k] = run.beam.map(f64::from);
        run.voxels
            .clone()
            .map(move |i| (place(run, i), affine::point(lattice, DVec3::new(f64::from(i), j, k))))
    })
}

impl Comparison {
    fn print(&self) {
        print!("{:<14} {:>6} |", self.what, self.soft_voxels);
        for ms in self.steps.iter().chain([&self.ours]).map(|step| step.median_s * 1e3) {
            print!(" {ms:6.2}");
        }
        print!(" {:6.1} |", self.first_s * 1e3);
        for s in self.paper_s {
            print!(" {s:5.2}");
        }
        for a in &self.against {
            print!(
                " | {:7.1} {:6.1} {:7.4}",
                a.theirs.median_s * 1e3,
                a.faster.median,
                a.error
            );
        }
        println!(" | {:7.4}", self.error);
    }
}
