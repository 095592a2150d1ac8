//! Marching cubes against other programs' ways to a surface, on the same voxels; normals included where they have them.

use std::path::Path;

use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use vcsg::output::write_whole;
use vcsg::surface::marching_cubes;
use vcsg::volume::{Grid, Voxels};

use crate::Outcome;
use crate::bar::{Bar, Limit};
use crate::memory;
use crate::pinning;
use crate::runs::{Ratios, Summary, timed};
use crate::vtk::Peer;

/// Methods of the peers, and how many times as fast as each ours must be.
const METHODS: [(&str, Option<f64>); 4] = [
    ("flying-edges", Some(2.0)),
    ("marching-cubes", Some(8.0)),
    ("scikit-image", None),
    ("pymcubes", None),
];

/// The largest volume for methods without a bar, which are slow.
const LARGEST_WITHOUT_BAR: usize = 256;

/// How many times as fast two threads must be as one.
const TWO_THREADS: f64 = 1.7;

/// The most that the resident memory may grow by, in sizes of the mesh.
const MEMORY: f64 = 1.5;

/// Free memory that is touched before each run, ours or a peer's: bytes, and more in sizes of the mesh.
const TOUCHED: [usize; 2] = [256 << 20, 4];

/// The value whose surface is extracted, as a fraction of a type's range of values.
const ISO: f64 = 0.5;

/// Voxels of one field.
struct Case {
    field: &'static str,
    side: usize,
    voxels: &'static str,
}

const CASES: [Case; 8] = {
    const fn case(field: &'static str, side: usize, voxels: &'static str) -> Case {
        Case { field, side, voxels }
    }
    [
        case("ball", 256, "f32"),
        case("ball", 256, "u8"),
        case("gyroid", 256, "f32"),
        case("gyroid", 256, "u8"),
        case("ball", 512, "f32"),
        case("ball", 512, "u8"),
        case("gyroid", 512, "f32"),
        case("gyroid", 512, "u8"),
    ]
};

/// What the script says about its surface.
#[derive(Deserialize)]
struct PeerSurface {
    triangles: usize,
    points: usize,
}

/// Our times next to one method's.
#[derive(Serialize)]
struct Against {
    method: &'static str,
    triangles: usize,
    points: usize,
    theirs: Summary,
    faster: Ratios,
}

/// One comparison, done.
#[derive(Serialize)]
pub struct Comparison {
    what: String,
    triangles: usize,
    vertices: usize,
    /// The growth of resident memory over the mesh's size.
    memory: f64,
    ours: Summary,
    one_thread: Summary,
    against: Vec<Against>,
    /// Two threads against one, ours against each method, and memory.
    pub bars: Vec<Bar>,
}

/// Compares on all volumes with `name` in theirs; each comparison is printed when it is done.
pub fn compare(name: &str, repetitions: usize) -> Outcome<Vec<Comparison>> {
    println!(
        "\nSurfaces with normals; milliseconds, and how many times as fast as one thread and as peers; memory over the mesh's"
    );
    println!(
        "{:<16} {:>10} {:>8} {:>8} {:>8} | {:>8} {:>7} | {:>6}{}",
        "",
        "triangles",
        "median",
        "min",
        "CPU",
        "1 thread",
        "times",
        "memory",
        METHODS
            .map(|(method, _)| format!(" | {method:>14} {:>7} {:>6}", "times", "CPU"))
            .concat()
    );
    let mut done = Vec::new();
    for case in CASES.iter().filter(|case| case.name().contains(name)) {
        let comparison = case.compare(repetitions)?;
        comparison.print();
        done.push(comparison);
    }
    Ok(done)
}

/// Prints by how many bytes the memory grows at most while the surface of the case called `name` is extracted.
pub fn print_growth_of(name: &str) -> Outcome<()> {
    let case = CASES.iter().find(|case| case.name() == name);
    let case = case.ok_or_else(|| format!("there is no surface {name}"))?;
    // The code's own pages and the threads' stacks are not the surface's.
    let small = Case { side: 16, ..*case };
    marching_cubes(&small.grid()?, case.iso())?;
    let grid = case.grid()?;
    let (mesh, grown) = memory::growth(|| marching_cubes(&grid, case.iso()))?;
    mesh?;
    println!("{grown}");
    Ok(())
}

impl Case {
    fn name(&self) -> String {
        format!("{} {}³ {}", self.field, self.side, self.voxels)
    }

    /// The field at a place of the cube [−1, 1]³, from 0 to 1.
    fn value(&self, p: DVec3) -> f64 {
        let value = match self.field {
            "ball" => 0.5 + (0.7 - p.length()),
            _ => {
                let q = p * (8.0 * std::f64::consts::PI);
                0.5 + (q.x.sin() * q.y.cos() + q.y.sin() * q.z.cos() + q.z.sin() * q.x.cos()) / 3.0
            }
        };
        value.clamp(0.0, 1.0)
    }

    fn grid(&self) -> Outcome<Grid> {
        let side = self.side;
        let at = |n: usize| 2.0 * n as f64 / (side - 1) as f64 - 1.0;
        let voxel = |n: usize| self.value(DVec3::new(at(n % side), at(n / side % side), at(n / (side * side))));
        let all = (0..side * side * side).into_par_iter();
        let voxels = match self.voxels {
            "u8" => Voxels::U8(all.map(|n| (255.0 * voxel(n)).round() as u8).collect()),
            _ => Voxels::F32(all.map(|n| voxel(n) as f32).collect()),
        };
        Ok(Grid::new([side; 3], DAffine3::IDENTITY, voxels)?)
    }

    /// A whole number for bytes, so that many voxels have the isovalue itself.
    fn iso(&self) -> f64 {
        if self.voxels == "u8" {
            (255.0 * ISO).round()
        } else {
            ISO
        }
    }

    fn compare(&self, repetitions: usize) -> Outcome<Comparison> {
        let grid = self.grid()?;
        let path = format!("target/bench/{}-{}.{}", self.field, self.side, self.voxels);
        write_whole(Path::new(&path), |out| {
            std::io::Write::write_all(out, bytes(grid.voxels()))
        })?;
        let mut peers = self.peers(&path)?;
        let (single, all) = (pinning::pool(1)?, pinning::pool(rayon::current_num_threads())?);
        let extract = || marching_cubes(&grid, self.iso());
        let mesh = extract()?;
        let (triangles, vertices) = (mesh.triangles.len(), mesh.positions.len());
        let grown: u64 = memory::from_own_process(["--memory-of-surface", &self.name()])?;
        let memory = grown as f64 / (12 * triangles + 24 * vertices) as f64;
        drop(mesh);
        let (mut ours, mut one, mut theirs) = (Vec::new(), Vec::new(), vec![Vec::new(); peers.len()]);
        let touch = || memory::touch_free(TOUCHED[0] + TOUCHED[1] * (12 * triangles + 24 * vertices));
        for _ in 0..repetitions {
            touch();
            ours.push(timed(|| all.install(extract)).1);
            touch();
            one.push(timed(|| single.install(extract)).1);
            for ((peer, _), runs) in peers.iter_mut().zip(&mut theirs) {
                touch();
                runs.push(peer.run()?);
            }
        }
        let (ours, one_thread) = (Summary::of(ours), Summary::of(one));
        let against: Vec<Against> = METHODS
            .iter()
            .zip(peers)
            .zip(theirs)
            .map(|(((method, _), (_, surface)), runs)| {
                let theirs = Summary::of(runs);
                Against {
                    method,
                    triangles: surface.triangles,
                    points: surface.points,
                    faster: Ratios::of(&ours, &theirs),
                    theirs,
                }
            })
            .collect();
        let mut bars = self.bars(&Ratios::of(&ours, &one_thread), &against);
        bars.push(Bar {
            what: format!("memory over the mesh: {}", self.name()),
            value: memory,
            limit: Limit::AtMost(MEMORY),
        });
        Ok(Comparison {
            what: self.name(),
            triangles,
            vertices,
            memory,
            ours,
            one_thread,
            against,
            bars,
        })
    }

    /// Those that have a bar, and for volumes that are not too large for them the others too.
    fn peers(&self, path: &str) -> Outcome<Vec<(Peer, PeerSurface)>> {
        let measured = METHODS
            .iter()
            .filter(|(_, limit)| limit.is_some() || self.side <= LARGEST_WITHOUT_BAR);
        measured.map(|(method, _)| self.peer(path, method)).collect()
    }

    fn peer(&self, path: &str, method: &str) -> Outcome<(Peer, PeerSurface)> {
        let arguments = [
            ["--raw", path],
            ["--side", &self.side.to_string()],
            ["--iso", &self.iso().to_string()],
            ["--method", method],
            ["--threads", &rayon::current_num_threads().to_string()],
        ];
        let (peer, surface) = Peer::start("tools/peers/surface.py", arguments.as_flattened())?;
        peer.pin()?;
        Ok((peer, surface))
    }

    fn bars(&self, threads: &Ratios, against: &[Against]) -> Vec<Bar> {
        let bar = |what: &str, value: f64, limit: f64| Bar {
            what: format!("times as fast as {what}: {}", self.name()),
            value,
            limit: Limit::AtLeast(limit),
        };
        let peers = against
            .iter()
            .zip(METHODS)
            .filter_map(|(a, (method, limit))| Some(bar(method, a.faster.median, limit?)));
        peers.chain([bar("one thread", threads.median, TWO_THREADS)]).collect()
    }
}

fn bytes(voxels: &Voxels) -> &[u8] {
    match voxels {
        Voxels::U8(v) => v,
        Voxels::F32(v) => bytemuck::cast_slice(v),
        _ => &[],
    }
}

impl Comparison {
    fn print(&self) {
        let (o, one) = (&self.ours, &self.one_thread);
        print!(
            "{:<16} {:>10} {:8.1} {:8.1} {:8.1} | {:8.1} {:7.2} | {:6.2}",
            self.what,
            self.triangles,
            o.median_s * 1e3,
            o.min_s * 1e3,
            o.cpu_min_s * 1e3,
            one.median_s * 1e3,
            one.median_s / o.median_s,
            self.memory,
        );
        for a in &self.against {
            print!(
                " | {:14.1} {:7.2} {:6.2}",
                a.theirs.median_s * 1e3,
                a.faster.median,
                a.faster.cpu
            );
        }
        println!();
    }
}
