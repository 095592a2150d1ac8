//! Where everything behind is hidden, known before anything is drawn.
//!
//! *Theory.* In a tile of the frame let α be the least opacity of all cells that the tile's part of a plane touches. No ray of the
//! tile lets more than 1 − α pass there, and of several planes no more than the product. Where that is less than one part in
//! [`HIDES_ALL_BUT`], nothing behind can show: that depth is the tile's horizon.
//! *Changes from the paper.* VCSG draws all slices, hidden or not. [`bands`](super::bands) end rays pixel by pixel, but the polygons
//! behind are still sent; here the boxes that lie behind every horizon in front of them are left out of the plan.
//! *Practice.* Planes are taken several at a time: as many as half a cell holds. A tile is about as wide as a cell, and its search
//! begins with the first cell in it that is opaque throughout. Path lengths of perspective only make slabs more opaque.

use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3A};
use rayon::prelude::*;

use super::table::TakenEntries;
use super::{Camera, FrameSpec, Planes, TransferTable, eye_from_lattice};
use crate::interface::HIDES_ALL_BUT;
use crate::math::{Aabb, Interval, affine};
use crate::target::{CELL, CellRanges, Target, VoxelBox};

/// Cells are taken to reach this far beyond their faces, voxels, and tiles this many pixels: where a device samples is rounded.
const UNSURE: f64 = 1.0 / 32.0;

/// The depths behind which nothing shows, tile by tile.
#[derive(Clone, Debug)]
pub struct Horizon {
    tiles: Tiles,
    /// Of each tile, millimetres; infinite if something may show at any depth.
    behind_mm: Vec<f64>,
    camera: Camera,
    eye_from_lattice: DAffine3,
    /// How far a step along each lattice axis reaches along each axis of the eye frame.
    eye_reach: DMat3,
}

impl Horizon {
    /// Of what is drawn of a target with these cells.
    pub fn new(spec: &FrameSpec, cells: &[CellRanges]) -> Self {
        let opacities = Opacities::new(spec, cells);
        let tiles = Tiles::new(spec);
        let eye_from_lattice = eye_from_lattice(&spec.target.lattice, spec.camera);
        let axes = eye_from_lattice.matrix3;
        let mut horizon = Self {
            behind_mm: vec![f64::INFINITY; tiles.count()],
            tiles,
            camera: *spec.camera,
            eye_from_lattice,
            eye_reach: DMat3::from_cols(axes.x_axis.abs(), axes.y_axis.abs(), axes.z_axis.abs()),
        };
        let nearest = horizon.nearest(&opacities);
        let search = Search::new(spec, &opacities, &horizon.eye_from_lattice);
        horizon.behind_mm = (0..horizon.tiles.count())
            .into_par_iter()
            .with_min_len(64)
            .map(|tile| search.behind_mm(&horizon.tiles.place(tile), nearest[tile]))
            .collect();
        horizon
    }

    /// Whether nothing in a box of the lattice shows.
    pub fn hides(&self, bounds: &Aabb) -> bool {
        let Some((tiles, nearest_mm)) = self.seen(bounds) else {
            return false;
        };
        self.tiles.within(tiles).all(|tile| self.behind_mm[tile] < nearest_mm)
    }

    /// The part of the frame that a box may be seen in, and its least depth; `None` if the eye may be in it.
    fn seen(&self, bounds: &Aabb) -> Option<([DVec2; 2], f64)> {
        let middle = affine::point(&self.eye_from_lattice, bounds.center());
        let reach = self.eye_reach * (0.5 * bounds.size());
        let eye = Aabb::new(middle - reach, middle + reach);
        if eye.min.z <= self.camera.near_mm() {
            return None;
        }
        // What is nearer lies farther from the middle of the frame, on either side of it.
        let ends = [eye.min, eye.max].map(|end| [eye.min.z, eye.max.z].map(|z| self.camera.project(end.with_z(z))));
        Some(([ends[0][0].min(ends[0][1]), ends[1][0].max(ends[1][1])], eye.min.z))
    }

    /// About the depth in each tile of the first cell that is at all opaque throughout: of cells one behind another along a lattice
    /// axis only the first counts. (Where a search begins too late, it finds the horizon late.)
    fn nearest(&self, opacities: &Opacities) -> Vec<f64> {
        let mut nearest = vec![f64::INFINITY; self.tiles.count()];
        for cell in opacities.first_along(self.eye_from_lattice.matrix3.row(2)) {
            match self.seen(&opacities.cell(cell)) {
                Some((place, depth)) => {
                    for tile in self.tiles.within(place) {
                        nearest[tile] = nearest[tile].min(depth);
                    }
                }
                None => nearest.fill(f64::NEG_INFINITY),
            }
        }
        nearest
    }
}

/// A frame in squares.
#[derive(Clone, Copy, Debug)]
struct Tiles {
    edge_px: f64,
    counts: [usize; 2],
}

impl Tiles {
    /// As wide as a cell in the middle of the lattice.
    fn new(spec: &FrameSpec) -> Self {
        let lattice = &spec.target.lattice;
        let middle = affine::point(&eye_from_lattice(lattice, spec.camera), lattice.bounds().center());
        let pixels_per_mm = spec.camera.pixels_per_mm(middle.z.max(spec.camera.near_mm()));
        let cell_px = CELL as f64 * lattice.spacing_mm().min_element() * pixels_per_mm;
        let edge_px = cell_px.clamp(4.0, 64.0).floor();
        let counts = spec.camera.size.map(|n| (f64::from(n) / edge_px).ceil() as usize);
        Self { edge_px, counts }
    }

    fn count(&self) -> usize {
        self.counts[0] * self.counts[1]
    }

    /// The pixels of a tile: the least and the greatest column and row.
    fn place(&self, tile: usize) -> [DVec2; 2] {
        let [x, y] = [tile % self.counts[0], tile / self.counts[0]];
        let least = self.edge_px * DVec2::new(x as f64, y as f64);
        [least - UNSURE, least + self.edge_px + UNSURE]
    }

    /// The tiles that a part of the frame touches.
    fn within(&self, [least, greatest]: [DVec2; 2]) -> impl Iterator<Item = usize> + use<> {
        let range = |a: usize| {
            let first = ((least[a] - UNSURE) / self.edge_px).floor().max(0.0) as usize;
            let end = ((greatest[a] + UNSURE) / self.edge_px).floor() + 1.0;
            first..(end.max(0.0) as usize).min(self.counts[a])
        };
        let (columns, across) = (range(0), self.counts[0]);
        range(1).flat_map(move |y| columns.clone().map(move |x| y * across + x))
    }
}

/// The least opacity of a slab in each cell of the lattice.
struct Opacities {
    dims: [usize; 3],
    /// Where the first cell begins, in lattice coordinates.
    begin: DVec3,
    /// The ends of the lattice.
    bounds: [Vec3A; 2],
    least: Vec<f32>,
}

impl Opacities {
    fn new(spec: &FrameSpec, cells: &[CellRanges]) -> Self {
        let Target { lattice, blocks, .. } = spec.target;
        let whole = VoxelBox {
            origin: [0; 3],
            extent: lattice.dims,
        };
        let all = CellRanges::empty(lattice, &whole);
        let mut least = vec![0.0; all.dims.iter().product()];
        let (opacity, bounds) = (LeastOpacity::new(spec), lattice.bounds());
        // Of smaller blocks several may lie in one cell; nothing is said of it then.
        for (_, cells) in blocks.iter().zip(cells).filter(|(block, _)| block.size >= CELL) {
            let known = cells.ranges.par_iter().zip(&cells.covered);
            let of_block: Vec<f32> = known
                .with_min_len(1 << 12)
                .map(|(range, covered)| if *covered { opacity.of(*range) } else { 0.0 })
                .collect();
            let first: [usize; 3] = std::array::from_fn(|a| (cells.first[a] - all.first[a]) as usize);
            for (n, row) in of_block.chunks_exact(cells.dims[0]).enumerate() {
                let (y, z) = (first[1] + n % cells.dims[1], first[2] + n / cells.dims[1]);
                let to = first[0] + all.dims[0] * (y + all.dims[1] * z);
                least[to..to + row.len()].copy_from_slice(row);
            }
        }
        Self {
            dims: all.dims,
            begin: all.begin(lattice),
            bounds: [bounds.min, bounds.max].map(|end| end.as_vec3a()),
            least,
        }
    }

    /// The box of a cell, in lattice coordinates.
    fn cell(&self, n: usize) -> Aabb {
        let [x, y, _] = self.dims;
        let cell = [n % x, n / x % y, n / (x * y)].map(|c| (c * CELL) as f64);
        let least = self.begin + DVec3::from_array(cell);
        Aabb::new(least, least + CELL as f64)
    }

    /// The cells that are at all opaque throughout and have none such before them along the axis that is nearest to `direction`.
    fn first_along(&self, direction: DVec3) -> impl Iterator<Item = usize> {
        let axis = (0..3).fold(0, |a, b| if direction[b].abs() > direction[a].abs() { b } else { a });
        let step: usize = self.dims[..axis].iter().product();
        let last = self.dims[axis] - 1;
        let is_first = move |n: &usize| match (n / step % self.dims[axis], direction[axis] >= 0.0) {
            (0, true) => true,
            (at, false) if at == last => true,
            (_, rising) => self.least[if rising { n - step } else { n + step }] == 0.0,
        };
        let opaque = |n: &usize| self.least[*n] > 0.0;
        (0..self.least.len()).filter(opaque).filter(is_first)
    }

    /// The least of all cells that a box touches; 0 where it leaves the lattice.
    fn within(&self, [least, greatest]: [Vec3A; 2]) -> f32 {
        let (least, greatest) = (least - UNSURE as f32, greatest + UNSURE as f32);
        if least.cmplt(self.bounds[0]).any() || greatest.cmpgt(self.bounds[1]).any() {
            return 0.0;
        }
        let begin = self.begin.as_vec3a();
        let cell = |p: Vec3A| ((p - begin) / CELL as f32).to_array().map(|n| n as usize);
        let (first, last) = (cell(least), cell(greatest));
        // A point on the lattice's last face lies in its last cell.
        let last: [usize; 3] = std::array::from_fn(|a| last[a].min(self.dims[a] - 1));
        let mut opacity = f32::INFINITY;
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                let row = self.dims[0] * (y + self.dims[1] * z);
                for least in &self.least[row + first[0]..=row + last[0]] {
                    opacity = opacity.min(*least);
                }
                if opacity == 0.0 {
                    return 0.0;
                }
            }
        }
        opacity
    }
}

/// The least opacity of a slab of which the values are known to lie in a range.
enum LeastOpacity {
    /// Entry `i` of run `n` is the least of the `2ⁿ` table entries from `i` on.
    Table { taken: TakenEntries, runs: Vec<Vec<f32>> },
    /// Of opacities, which hold for paths of a length: so many of them are a slab.
    Colors { slab_units: f32 },
}

impl LeastOpacity {
    fn new(spec: &FrameSpec) -> Self {
        if let Some(units) = spec.slab_units() {
            return Self::Colors {
                slab_units: units as f32,
            };
        }
        let table = spec.table();
        let mut runs: Vec<Vec<f32>> = vec![table.entries().iter().map(|entry| entry[3]).collect()];
        for n in 0..TransferTable::LEN.ilog2() {
            let half = 1 << n;
            let shorter = &runs[n as usize];
            let pairs = shorter.iter().zip(&shorter[half..]);
            runs.push(pairs.map(|(a, b)| a.min(*b)).collect());
        }
        Self::Table {
            taken: TakenEntries::new(spec.target.value_range),
            runs,
        }
    }

    fn of(&self, values: Interval) -> f32 {
        match self {
            Self::Table { taken, runs } => {
                let first = taken.first(values);
                if runs[0][first] == 0.0 {
                    return 0.0;
                }
                let end = taken.end(values);
                let n = (end - first).ilog2() as usize;
                runs[n][first].min(runs[n][end - (1 << n)])
            }
            Self::Colors { slab_units } => 1.0 - (1.0 - values.lo.clamp(0.0, 1.0)).powf(*slab_units),
        }
    }
}

/// A search along the rays of a tile.
struct Search<'a> {
    opacities: &'a Opacities,
    camera: &'a Camera,
    planes: Planes,
    lattice_from_eye: DAffine3,
    /// The depths of the lattice.
    depths_mm: [f64; 2],
    /// Planes that are taken together.
    stride: i64,
}

impl<'a> Search<'a> {
    fn new(spec: &'a FrameSpec, opacities: &'a Opacities, eye_from_lattice: &DAffine3) -> Self {
        let planes = spec.planes();
        let lattice = &spec.target.lattice;
        let depths = lattice.bounds().transformed(eye_from_lattice);
        let together_mm = 0.5 * CELL as f64 * lattice.spacing_mm().min_element();
        Self {
            opacities,
            camera: spec.camera,
            planes,
            lattice_from_eye: eye_from_lattice.inverse(),
            depths_mm: [depths.min.z.max(spec.camera.near_mm()), depths.max.z],
            stride: (together_mm / planes.step_mm).floor().max(1.0) as i64,
        }
    }

    /// The depth behind which nothing shows in a part of the frame, where nothing nearer than `from_mm` is opaque throughout.
    fn behind_mm(&self, place: &[DVec2; 2], from_mm: f64) -> f64 {
        let [near, far] = self.depths_mm;
        let planes = self.planes.between(near.max(from_mm), far);
        let bundle = self.bundle(place);
        let mut passes = 1.0;
        let mut near_end = bundle.across(self.planes.depth(planes.start));
        for first in planes.clone().step_by(self.stride as usize) {
            let end = (first + self.stride).min(planes.end);
            let far_end = bundle.across(self.planes.depth(end));
            let part = [near_end[0].min(far_end[0]), near_end[1].max(far_end[1])];
            let opacity = f64::from(self.opacities.within(part));
            passes *= (1.0 - opacity).powi((end - first) as i32);
            if passes * f64::from(HIDES_ALL_BUT) < 1.0 {
                return self.planes.depth(end - 1);
            }
            near_end = far_end;
        }
        f64::INFINITY
    }

    /// The rays through the corners of a part of the frame.
    fn bundle(&self, place: &[DVec2; 2]) -> Bundle {
        let [near, far] = self.depths_mm;
        let rays = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| {
            let px = DVec2::new(place[x].x, place[y].y);
            let at = |z: f64| affine::point(&self.lattice_from_eye, self.camera.unproject(px, z));
            [at(near), at(far) - at(near)].map(|v| v.as_vec3a())
        });
        Bundle {
            rays,
            near_mm: near,
            depth_mm: (far - near).max(f64::MIN_POSITIVE),
        }
    }
}

/// Four rays in lattice coordinates: where they are at a depth, and where they go until another. (In single precision: of the
/// largest lattice a voxel is 2⁻⁸ off at most, which [`UNSURE`] allows.)
struct Bundle {
    rays: [[Vec3A; 2]; 4],
    near_mm: f64,
    depth_mm: f64,
}

impl Bundle {
    /// The least and the greatest coordinates between them at a depth, millimetres.
    fn across(&self, z: f64) -> [Vec3A; 2] {
        let part = ((z - self.near_mm) / self.depth_mm) as f32;
        let places = self.rays.map(|[from, way]| from + part * way);
        let hull = |end: fn(Vec3A, Vec3A) -> Vec3A| end(end(places[0], places[1]), end(places[2], places[3]));
        [hull(Vec3A::min), hull(Vec3A::max)]
    }
}
