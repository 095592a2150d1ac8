//! How voxels lie in memory: the trilinear samples of a frame's rays, in the order in which a ray caster takes them, fetched from rows,
//! from bricks and in Morton's order. Places, fetches and sums alone, on one thread.

use glam::{DVec3, dvec3};
use vcsg::math::affine;

use crate::Outcome;
use crate::runs::{Summary, timed};
use crate::scene::{self, FRAME_EDGE, SIDE};

/// Pixels along a tile's edge, and planes that all of its pixels are sampled at before the next ones are: those of the ray caster.
const TILE: u32 = 16;
const SLAB: usize = 32;

/// Edge of a brick, voxels.
const BRICK: usize = 8;

/// A brick with one more voxel along each axis: all corners of its cells.
const CLOSED: usize = BRICK + 1;

/// Voxels, and where those with such coordinates are: the sum of a place for each.
struct Layout {
    name: &'static str,
    voxels: Vec<u16>,
    places: [Vec<u32>; 3],
    /// Where the corners of a cell are, given that of its first one, unless each is asked for.
    corners: Option<[u32; 8]>,
}

/// Rays of a frame in voxels: the place at column 0, row 0 and plane 0, and a step of each.
struct View {
    first: DVec3,
    steps: [DVec3; 3],
    planes: usize,
}

/// Prints what a sample takes in each layout.
pub fn measure(runs: usize) -> Outcome<()> {
    println!(
        "\nLayouts: places, fetches and sums of a frame of {FRAME_EDGE}², one thread; nanoseconds a sample, of median and least"
    );
    for volume in ["head", "dense"] {
        let bytes = std::fs::read(scene::raw_path(volume))?;
        let [row, plane] = [SIDE, SIDE * SIDE];
        let layouts = [
            rows("rows along x", [1, row, plane], &bytes),
            rows("rows along y", [plane, 1, row], &bytes),
            rows("rows along z", [row, plane, 1], &bytes),
            bricks(&bytes),
            closed_bricks(&bytes),
            morton(&bytes),
        ];
        let view = View::new();
        let mut taken: Vec<Vec<_>> = layouts.iter().map(|_| Vec::new()).collect();
        let mut found = Vec::new();
        for _ in 0..runs + 1 {
            for (layout, taken) in layouts.iter().zip(&mut taken) {
                let (sum, run) = timed(|| view.sum(layout));
                taken.push(run);
                found.push(sum);
            }
        }
        if found.iter().any(|sum| *sum != found[0]) {
            return Err(format!("layouts differ: {found:?}").into());
        }
        for (layout, runs) in layouts.iter().zip(taken) {
            let summary = Summary::of(runs[1..].to_vec());
            let each = |seconds: f64| 1e9 * seconds / found[0].samples as f64;
            println!(
                "{volume:<6} {:<22} {:>6.2} {:>6.2}",
                layout.name,
                each(summary.median_s),
                each(summary.min_s)
            );
        }
    }
    Ok(())
}

/// What a frame's samples come to.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Sum {
    samples: usize,
    values: f64,
}

impl View {
    fn new() -> Self {
        let camera = scene::camera(&scene::bounds());
        let voxel_from_eye = camera.eye_from_world.inverse();
        let first = camera.point_at_depth(0, 0, 0.0);
        let along = |x, y| voxel_from_eye.matrix3 * (camera.point_at_depth(x, y, 0.0) - first);
        let place = affine::point(&voxel_from_eye, first);
        let depth = voxel_from_eye.matrix3 * DVec3::Z;
        let far = (scene::middle() - place).dot(depth) - SIDE as f64;
        Self {
            first: place + far * depth,
            steps: [along(1, 0), along(0, 1), depth],
            planes: 2 * SIDE,
        }
    }

    /// Takes all samples that lie between voxels, tile by tile, slab by slab, ray by ray.
    fn sum(&self, layout: &Layout) -> Sum {
        let mut sum = Sum {
            samples: 0,
            values: 0.0,
        };
        for tile in 0..(FRAME_EDGE / TILE).pow(2) {
            let [left, top] = [tile % (FRAME_EDGE / TILE), tile / (FRAME_EDGE / TILE)].map(|n| TILE * n);
            for slab in (0..self.planes).step_by(SLAB) {
                for pixel in 0..TILE * TILE {
                    let [x, y] = [left + pixel % TILE, top + pixel / TILE].map(f64::from);
                    let begin = self.first + x * self.steps[0] + y * self.steps[1] + slab as f64 * self.steps[2];
                    let (samples, values) = ray(layout, begin.as_vec3(), self.steps[2].as_vec3());
                    sum.samples += samples;
                    sum.values += f64::from(values);
                }
            }
        }
        sum
    }
}

/// The samples of a ray in a slab: how many, and what they come to.
fn ray(layout: &Layout, begin: glam::Vec3, step: glam::Vec3) -> (usize, f32) {
    let last = (SIDE - 1) as f32;
    let (mut samples, mut values) = (0, 0.0);
    for n in 0..SLAB {
        let at = begin + n as f32 * step;
        if at.min_element() >= 0.0 && at.max_element() < last {
            samples += 1;
            values += layout.sample(at);
        }
    }
    (samples, values)
}

impl Layout {
    /// Of `bytes`, x fastest, at the sum of three places for each voxel.
    fn new(name: &'static str, bytes: &[u8], place: impl Fn(usize, usize) -> usize) -> Self {
        let places = [0, 1, 2].map(|axis| (0..SIDE).map(|n| place(axis, n) as u32).collect::<Vec<_>>());
        let at = |n: usize| {
            let [x, y, z] = [n % SIDE, n / SIDE % SIDE, n / (SIDE * SIDE)];
            (places[0][x] + places[1][y] + places[2][z]) as usize
        };
        let mut voxels = vec![0; (0..SIDE.pow(3)).map(at).max().unwrap_or(0) + 1];
        bytes
            .iter()
            .enumerate()
            .for_each(|(n, byte)| voxels[at(n)] = u16::from(*byte) * 257);
        Self {
            name,
            voxels,
            places,
            corners: None,
        }
    }

    #[inline]
    fn sample(&self, at: glam::Vec3) -> f32 {
        let cell = at.as_usizevec3();
        let t = at - cell.as_vec3();
        let place = |axis: usize, n: usize| self.places[axis][n];
        let v = match &self.corners {
            Some(corners) => {
                let first = place(0, cell.x) + place(1, cell.y) + place(2, cell.z);
                corners.map(|corner| self.voxels[(first + corner) as usize])
            }
            None => {
                let [x, y, z] = [0, 1, 2].map(|axis| [place(axis, cell[axis]), place(axis, cell[axis] + 1)]);
                let corner = |n: usize| self.voxels[(x[n & 1] + y[n >> 1 & 1] + z[n >> 2]) as usize];
                std::array::from_fn(corner)
            }
        };
        let v = v.map(f32::from);
        let along_x: [f32; 4] = std::array::from_fn(|n| v[2 * n] + t.x * (v[2 * n + 1] - v[2 * n]));
        let [a, b] = [0, 2].map(|n| along_x[n] + t.y * (along_x[n + 1] - along_x[n]));
        a + t.z * (b - a)
    }
}

/// The corners of a cell where neighbours along each axis are so far apart.
fn corners(strides: [usize; 3]) -> Option<[u32; 8]> {
    Some(std::array::from_fn(|n| {
        (0..3).map(|axis| strides[axis] * (n >> axis & 1)).sum::<usize>() as u32
    }))
}

/// Rows along one axis, in planes across another.
fn rows(name: &'static str, strides: [usize; 3], bytes: &[u8]) -> Layout {
    Layout {
        corners: corners(strides),
        ..Layout::new(name, bytes, |axis, n| strides[axis] * n)
    }
}

fn bricks(bytes: &[u8]) -> Layout {
    let (inside, outside) = (strides(BRICK), strides(SIDE / BRICK));
    Layout::new("bricks of 8³", bytes, |axis, n| {
        n % BRICK * inside[axis] + n / BRICK * outside[axis] * BRICK.pow(3)
    })
}

/// Bricks in which a voxel on a face is in each brick that it is a corner of a cell of.
fn closed_bricks(bytes: &[u8]) -> Layout {
    let (inside, outside) = (strides(CLOSED), strides(SIDE / BRICK));
    let mut layout = Layout {
        corners: corners(inside),
        ..Layout::new("bricks of 8³, closed", bytes, |axis, n| {
            n % BRICK * inside[axis] + n / BRICK * outside[axis] * CLOSED.pow(3)
        })
    };
    layout.voxels.resize((SIDE / BRICK * CLOSED).pow(3), 0);
    let brick = |n: usize| dvec3((n % 32) as f64, (n / 32 % 32) as f64, (n / 1024) as f64).as_usizevec3() * BRICK;
    for n in 0..(SIDE / BRICK).pow(3) {
        for at in 0..CLOSED.pow(3) {
            let voxel = brick(n) + glam::USizeVec3::new(at % CLOSED, at / CLOSED % CLOSED, at / (CLOSED * CLOSED));
            let [x, y, z] = voxel.to_array().map(|n| n.min(SIDE - 1));
            layout.voxels[n * CLOSED.pow(3) + at] = u16::from(bytes[x + SIDE * (y + SIDE * z)]) * 257;
        }
    }
    layout
}

/// Each third bit of a place is a coordinate's.
fn morton(bytes: &[u8]) -> Layout {
    Layout::new("Morton's order", bytes, |axis, n| {
        (0..8).map(|bit| (n >> bit & 1) << (3 * bit + axis)).sum()
    })
}

fn strides(edge: usize) -> [usize; 3] {
    [1, edge, edge * edge]
}
