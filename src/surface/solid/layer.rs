//! A layer of cells: what each contributes, by the truth table.

use glam::{DVec3, Vec3};

use super::cap;
use super::cell::{Cell, Corners, Node, SurfaceVertex, Vertex};
use super::clip::{Clipped, clip};
use super::table::{Relations, Side, Work};
use super::{Border, CAP, FIRST_FACE, Group, Pieces, Point, SURFACE, Task};
use crate::math::affine;
use crate::surface::cases::CASES;
use crate::surface::cells::{CellWord, SetBits};
use crate::surface::crossings::Crossings;
use crate::surface::inside::{Classifier, InsideRows, Ties};
use crate::surface::numbering::{Numbering, OwnVertices};
use crate::surface::slices::Slices;
use crate::surface::ties::{is_whole, triangles_through};

/// What the cells between slices `k` and `k + 1` make.
pub(super) fn march(task: &Task<'_>, k: usize) -> Pieces {
    let [nx, ny, _] = task.grid.dims();
    let mut samples = Vec::with_capacity(2 * nx * ny);
    task.cutter.add_slice(task.grid.dims(), k, &mut samples);
    task.cutter.add_slice(task.grid.dims(), k + 1, &mut samples);
    let dims = [nx, ny, 2];
    let slices = Slices {
        voxels: &samples,
        first_slice: 0,
        dims,
    };
    let cutter = InsideRows::of(&Classifier::new(slices, 0.0, Ties::Apart), 0..2);
    let rows = task.rows_round(k);
    let crossings = [k, k + 1].map(|k| task.surface.crossings(&rows, k));
    let mut layer = Layer {
        task,
        k,
        samples: &samples,
        pieces: Pieces::default(),
    };
    for j in 0..ny - 1 {
        layer.march_row([&rows, &cutter], crossings.each_ref(), j);
    }
    layer.pieces.points.sort_by_key(|(vertex, _)| *vertex);
    layer.pieces.points.dedup_by_key(|(vertex, _)| *vertex);
    layer.pieces
}

/// A layer that is being worked on.
struct Layer<'a> {
    task: &'a Task<'a>,
    k: usize,
    /// The cutter at the voxels below and above.
    samples: &'a [f64],
    pieces: Pieces,
}

/// 64 cells of a row, and the scan's vertices round them.
struct Block<'a> {
    word: &'a CellWord,
    own: &'a OwnVertices,
    numbering: &'a Numbering,
    /// The index of the first cell.
    at: [usize; 3],
}

impl Layer<'_> {
    /// Row `j` of the layer, of which there are the scan's and the cutter's bits, and the scan's vertices.
    fn march_row(&mut self, [rows, cutter]: [&InsideRows; 2], crossings: [&Crossings; 2], j: usize) {
        let operation = self.task.operation;
        let mut numbering = Numbering::new(crossings, j);
        for w in 0..rows.words_a_row() {
            let word = CellWord::new(rows, [w, j, self.k]);
            let cutter = CellWord::new(cutter, [w, j, 0]);
            let own = OwnVertices::of(crossings, j, w);
            let block = Block {
                word: &word,
                own: &own,
                numbering: &numbering,
                at: [64 * w, j, self.k],
            };
            let relations = |word: &CellWord| Relations::new(word.inside.any(), word.inside.all(), word.cells);
            let work = Work::new(operation, relations(&word), relations(&cutter));
            SetBits(work.surface).for_each(|i| self.add_surface(&block, i));
            SetBits(work.cutter).for_each(|i| self.add_cutter(&block, i));
            SetBits(work.both).for_each(|i| self.add_both(&block, i));
            SetBits(self.at_border(j, w) & word.cells).for_each(|i| self.add_border(&block, i));
            numbering.step_over(&own);
        }
    }

    /// Whole triangles of the scan's surface.
    fn add_surface(&mut self, block: &Block<'_>, i: u32) {
        let case = &CASES[block.word.inside.of_cell(i)];
        let vertices = block.numbering.in_places(block.own, i);
        let triangles = triangles_through(case, block.word.on.of_cell(i));
        let triangles = triangles.map(|places| places.map(|place| vertices[usize::from(place)]));
        self.pieces.surface.extend(triangles);
    }

    /// Whole triangles of the cutter's surface.
    fn add_cutter(&mut self, block: &Block<'_>, i: u32) {
        let cell = self.cell(block, i);
        for triangle in cell.cutter_surface() {
            self.add_cap(&cell, triangle);
        }
    }

    /// The scan's surface, clipped, and the cap that fills the loops of the cuts.
    fn add_both(&mut self, block: &Block<'_>, i: u32) {
        let operation = self.task.operation;
        let cell = self.cell(block, i);
        let caps_inside = operation.cutter_stays() == Side::Inside;
        let mut cuts = Vec::new();
        for triangle in cell.surface() {
            let clipped = clip(&cell, &triangle);
            // Outside the scan's solid the surface is seen from behind.
            cuts.extend(
                clipped
                    .cuts
                    .iter()
                    .map(|&[from, to]| if caps_inside { [from, to] } else { [to, from] }),
            );
            self.add_pieces(&cell, SURFACE, clipped, |side| side == operation.surface_stays());
        }
        for face in 0..6 {
            cell.face_polygons(face, caps_inside, |polygon| cuts.extend(clip(&cell, polygon).cuts));
        }
        for polygon in cap::loops(cuts) {
            cap::fill(polygon, |triangle| self.add_cap(&cell, triangle));
        }
    }

    /// What of the solid lies in the lattice's border.
    fn add_border(&mut self, block: &Block<'_>, i: u32) {
        let cell = self.cell(block, i);
        let dims = self.task.grid.dims();
        let at = [block.at[0] + i as usize, block.at[1], block.at[2]];
        let is_border = |face: &usize| at[face / 2] == face % 2 * (dims[face / 2] - 2);
        for face in (0..6).filter(is_border) {
            for scan in [Side::Inside, Side::Outside] {
                cell.face_polygons(face, scan == Side::Inside, |polygon| {
                    let stays = |cutter| self.task.operation.has(scan, cutter);
                    self.add_pieces(&cell, FIRST_FACE + face as Group, clip(&cell, polygon), stays);
                });
            }
        }
    }

    /// The cells at the border, of word `w` of row `j`, if the border is to be closed.
    fn at_border(&self, j: usize, w: usize) -> u64 {
        let [nx, ny, nz] = self.task.grid.dims();
        if self.task.border == Border::Open {
            return 0;
        }
        if j == 0 || j == ny - 2 || self.k == 0 || self.k == nz - 2 {
            return u64::MAX;
        }
        let bit = |i: usize| if i / 64 == w { 1 << (i % 64) } else { 0 };
        bit(0) | bit(nx - 2)
    }

    fn add_cap(&mut self, cell: &Cell, [a, b, c]: [Node; 3]) {
        let triangle = if self.task.operation.turns_cutter() {
            [a, c, b]
        } else {
            [a, b, c]
        };
        self.add(cell, CAP, triangle);
    }

    fn add_pieces(&mut self, cell: &Cell, group: Group, clipped: Clipped, stays: impl Fn(Side) -> bool) {
        for (side, pieces) in [(Side::Inside, clipped.inside), (Side::Outside, clipped.outside)] {
            for piece in pieces.into_iter().filter(|_| stays(side)) {
                cap::fill(piece, |triangle| self.add(cell, group, triangle));
            }
        }
    }

    fn add(&mut self, cell: &Cell, group: Group, triangle: [Node; 3]) {
        let vertices = triangle.map(|node| node.vertex);
        if !is_whole(vertices) {
            return;
        }
        self.pieces.triangles.push((group, vertices));
        for node in triangle
            .iter()
            .filter(|node| !matches!(node.vertex, Vertex::Surface(_)))
        {
            let point = Point {
                position: node.position.as_vec3(),
                value: (cell.value(node.at) + self.task.iso) as f32,
                normal: node.normal,
            };
            self.pieces.points.push((node.vertex, point));
        }
    }

    fn cell(&self, block: &Block<'_>, i: u32) -> Cell {
        let Task { grid, iso, surface, .. } = self.task;
        let [nx, ny, _] = grid.dims();
        let at = [block.at[0] + i as usize, block.at[1], block.at[2]];
        let corner = |c: usize| [0, 1, 2].map(|axis| at[axis] + (c >> axis & 1));
        let each = [0, 1, 2, 3, 4, 5, 6, 7].map(corner);
        let place = |[i, j, k]: [usize; 3]| i + nx * (j + ny * k);
        let below = nx * ny * self.k;
        let world = |index: [usize; 3]| affine::point(grid.world_from_index(), DVec3::from(index.map(|i| i as f64)));
        let corners = Corners {
            values: each.map(|index| grid.value_at(index) - iso),
            voxels: each.map(|index| place(index) as u64),
            positions: each.map(world),
            cutter: each.map(|index| self.samples[place(index) - below]),
            inside: block.word.inside.of_cell(i),
            on: block.word.on.of_cell(i),
        };
        let vertices = block.numbering.in_places(block.own, i);
        Cell::new(&corners, |place| {
            let number = vertices[place];
            let as_double = |v: [f32; 3]| Vec3::from(v).as_dvec3();
            SurfaceVertex {
                number,
                position: as_double(surface.mesh.positions[number as usize]),
                normal: as_double(surface.mesh.normals[number as usize]),
            }
        })
    }
}
