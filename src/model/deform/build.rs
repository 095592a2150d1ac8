//! Makes the table of φ⁻¹.
//!
//! *Theory.* Linear interpolation along an axis errs by h²/8 times the second derivative at most, and trilinear by the sum over the
//! axes (each for its longest). While the derivative changes linearly in a cell its length is largest at a corner. It changes
//! the least so beside a thin plate's landmark, as 1/r: one as near as it may be, 1.5 · 1.3 · √¾ = 1.7 edges from the
//! middle and so 1.2 from a face, is 1.39 edges from that face's corners, and a [`MARGIN`] of 1.25 holds what is between.
//! What error is left is measured.
//! *Practice.* Root cells are made in parallel, each for itself: what is in one depends on nothing but its place and the
//! spline. Each cell's search for its preimage starts from its parent's; corners that cells of one root share are sought once.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::table::{Branch, Cell, Layout, Node, Region, Table, octant};
use super::warp::{Frame, Start, WarpError, WarpReport};
use crate::math::{Aabb, affine};

/// How much more than at its corners a derivative may be in a cell.
const MARGIN: f64 = 1.25;

/// A corner of cells.
#[derive(Clone, Copy)]
struct Vertex {
    /// Where it is, in the frame.
    at: DVec3,
    /// The inverse there, if it is found.
    start: Option<Start>,
    /// How the inverse bends there, in voxels, once that is asked for; infinite if it is not found.
    bends: Option<DVec3>,
}

impl Vertex {
    fn bends(&mut self, frame: &Frame) -> DVec3 {
        let bends = || self.start.as_ref().map_or(DVec3::INFINITY, |start| frame.bends(start));
        *self.bends.get_or_insert_with(bends)
    }
}

/// Hashes places. Nobody chooses them to collide, so they need no more than a product a coordinate; the standard hash of eight corners
/// takes as long as a cell's sums over thirty landmarks.
#[derive(Default)]
struct Mixer(u64);

impl Hasher for Mixer {
    fn write(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks();
        words.iter().for_each(|word| self.write_u64(u64::from_ne_bytes(*word)));
        rest.iter().for_each(|byte| self.write_u64((*byte).into()));
    }

    fn write_u64(&mut self, n: u64) {
        self.0 = (self.0.rotate_left(23) ^ n).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }

    /// A product's high bits depend on all of its factor, its low ones on few.
    fn finish(&self) -> u64 {
        self.0.rotate_left(32)
    }
}

/// A corner of a cell; bit a of its number is the upper one along axis a.
fn corner_at(origin: [i64; 3], edge: i64, corner: usize) -> [i64; 3] {
    [0, 1, 2].map(|a| origin[a] + if corner >> a & 1 == 1 { edge } else { 0 })
}

/// One root cell's part of the table.
struct Grower<'a> {
    frame: &'a Frame,
    source: &'a Aabb,
    layout: &'a Layout,
    /// Cells of all roots so far.
    count: &'a AtomicUsize,
    vertices: HashMap<[i64; 3], Vertex, BuildHasherDefault<Mixer>>,
    branches: Vec<Branch>,
    cells: Vec<Cell>,
    report: WarpReport,
}

/// A root cell's part, finished.
struct Grown {
    root: Node,
    branches: Vec<Branch>,
    cells: Vec<Cell>,
    report: WarpReport,
}

impl Table {
    /// The table of the inverse of `frame`'s morph, for what lay within `source` and is within `domain`.
    pub(super) fn build(frame: &Frame, source: &Aabb, domain: &Aabb) -> Result<Self, WarpError> {
        let layout = Layout::over(domain, frame.step, frame.anchor);
        let count = AtomicUsize::new(0);
        let grown: Vec<Result<Grown, WarpError>> = (0..layout.roots())
            .into_par_iter()
            .map(|n| grow_root(frame, source, &layout, n, &count))
            .collect();
        if count.load(Ordering::Relaxed) > Self::MAX_CELLS {
            return Err(WarpError::TooManyCells);
        }
        let mut table = Self {
            layout,
            domain: *domain,
            ..Self::default()
        };
        for root in grown {
            table.append(root?);
        }
        table.bound_branches();
        Ok(table)
    }

    fn append(&mut self, grown: Grown) {
        let (cells, branches) = (self.cells.len() as u32, self.branches.len() as u32);
        let moved = |node: Node| match node {
            Node::Empty => Node::Empty,
            Node::Cell(n) => Node::Cell(n + cells),
            Node::Branch(n) => Node::Branch(n + branches),
        };
        self.roots.push(moved(grown.root));
        self.cells.extend(grown.cells);
        self.branches.extend(grown.branches.into_iter().map(|branch| Branch {
            octants: branch.octants.map(moved),
            ..branch
        }));
        let (r, s) = (&mut self.report, &grown.report);
        r.cells += s.cells;
        r.measured_voxels = r.measured_voxels.max(s.measured_voxels);
    }

    /// Finds where each branch comes from; octants stand behind their branch.
    fn bound_branches(&mut self) {
        for n in (0..self.branches.len()).rev() {
            let octants = self.branches[n].octants;
            let region = |node: Node| match node {
                Node::Empty => Region::NOWHERE,
                Node::Cell(cell) => Region::of(self.cells[cell as usize].0),
                Node::Branch(branch) => self.branches[branch as usize].region,
            };
            let whole = octants
                .into_iter()
                .fold(Region::NOTHING, |r, node| r.with(&region(node)));
            self.branches[n].region = whole;
        }
    }
}

fn grow_root(frame: &Frame, source: &Aabb, layout: &Layout, n: usize, count: &AtomicUsize) -> Result<Grown, WarpError> {
    let mut grower = Grower {
        frame,
        source,
        layout,
        count,
        vertices: HashMap::default(),
        branches: Vec::new(),
        cells: Vec::new(),
        report: WarpReport::default(),
    };
    let (origin, edge) = layout.root(n);
    let root = grower.grow(origin, edge, None)?;
    Ok(Grown {
        root,
        branches: grower.branches,
        cells: grower.cells,
        report: grower.report,
    })
}

impl Grower<'_> {
    /// The node at `origin`, from the inverse in its parent's middle. As deep as the octree.
    fn grow(&mut self, origin: [i64; 3], edge: i64, parent: Option<&Start>) -> Result<Node, WarpError> {
        if self.count.load(Ordering::Relaxed) > Table::MAX_CELLS {
            return Ok(Node::Empty);
        }
        if edge == 1 {
            return self.smallest(origin, parent);
        }
        let Ok(found) = self.seek(self.middle(origin, edge), parent) else {
            return self.split(origin, edge, None);
        };
        let size = edge as f64 * self.layout.step;
        let allowed = self.frame.error_voxels;
        let local = self.frame.about(&found, size);
        let at_landmarks = self.frame.error_at_landmarks(&local, size);
        if at_landmarks > allowed || self.frame.is_coarse(&found, size) {
            return self.split(origin, edge, Some(&found));
        }
        let vertices = self.corners(origin, edge, Some(&found));
        // Where no landmark is near, the second derivatives about the middle are known already.
        let in_middle = match local.kinks == 0.0 {
            true => self.frame.bends_as(&found, &local),
            false => self.frame.bends(&found),
        };
        let bends = self.bends(origin, edge, in_middle);
        let bent = MARGIN / 8.0 * size * size * bends.element_sum();
        let is_bent = bent.is_nan() || bent > allowed;
        if bends == DVec3::INFINITY || is_bent && at_landmarks == 0.0 {
            return self.split(origin, edge, Some(&found));
        }
        let off = self.off(&vertices, &found);
        if off > allowed {
            return self.split(origin, edge, Some(&found));
        }
        self.report.measured_voxels = self.report.measured_voxels.max(off);
        Ok(self.push(&vertices, &found))
    }

    /// The middle of a cell.
    fn middle(&self, origin: [i64; 3], edge: i64) -> DVec3 {
        let origin = DVec3::from(origin.map(|x| x as f64));
        self.layout.place(origin + 0.5 * edge as f64)
    }

    /// A cell of one voxel, of which only the corners matter. Those that nothing is found to come to are beyond what is deformed, and go
    /// on as the cell does in its middle.
    fn smallest(&mut self, origin: [i64; 3], parent: Option<&Start>) -> Result<Node, WarpError> {
        if parent.is_some() {
            let vertices = self.corners(origin, 1, parent);
            if let [Some(known), ..] = vertices.map(|v| v.start)
                && vertices.iter().all(|v| v.start.is_some())
            {
                return Ok(self.push(&vertices, &known));
            }
        }
        let middle = self.seek(self.middle(origin, 1), parent);
        let vertices = self.corners(origin, 1, middle.as_ref().ok().or(parent));
        let known = middle.ok().or(vertices.iter().find_map(|v| v.start));
        match (known, middle) {
            (Some(known), _) => Ok(self.push(&vertices, &known)),
            (None, Err(stop)) => self.unreachable(stop),
            (None, Ok(_)) => Ok(Node::Empty),
        }
    }

    /// Keeps a cell.
    fn push(&mut self, vertices: &[Vertex; 8], known: &Start) -> Node {
        let place = |v: &Vertex| match &v.start {
            Some(start) => self.frame.place(start),
            None => self.frame.extrapolated(v.at, known),
        };
        self.cells.push(Cell(vertices.each_ref().map(place)));
        self.count.fetch_add(1, Ordering::Relaxed);
        self.report.cells += 1;
        Node::Cell(self.cells.len() as u32 - 1)
    }

    /// By how many voxels interpolation errs in a cell's middle, where it errs the most if φ⁻¹ bends one way.
    fn off(&self, vertices: &[Vertex; 8], middle: &Start) -> f64 {
        let corners = vertices.iter().filter_map(|v| v.start.as_ref());
        let mean = corners.map(|start| self.frame.place(start)).sum::<DVec3>() / 8.0;
        mean.distance(self.frame.place(middle)) / self.frame.voxel
    }

    /// The corners of a cell, each sought once.
    fn corners(&mut self, origin: [i64; 3], edge: i64, near: Option<&Start>) -> [Vertex; 8] {
        std::array::from_fn(|corner| {
            let at = corner_at(origin, edge, corner);
            match self.vertices.get(&at) {
                Some(known) => *known,
                None => {
                    let vertex = self.vertex(at, near);
                    self.vertices.insert(at, vertex);
                    vertex
                }
            }
        })
    }

    fn vertex(&self, at: [i64; 3], near: Option<&Start>) -> Vertex {
        let at = self.layout.place(DVec3::from(at.map(|x| x as f64)));
        Vertex {
            at,
            start: self.seek(at, near).ok(),
            bends: None,
        }
    }

    /// The most that the inverse bends at a cell's corners, which have been sought, and `in_middle`.
    fn bends(&mut self, origin: [i64; 3], edge: i64, in_middle: DVec3) -> DVec3 {
        (0..8).fold(in_middle, |most, corner| {
            let vertex = self.vertices.get_mut(&corner_at(origin, edge, corner));
            vertex.map_or(most, |vertex| most.max(vertex.bends(self.frame)))
        })
    }

    fn split(&mut self, origin: [i64; 3], edge: i64, middle: Option<&Start>) -> Result<Node, WarpError> {
        let branch = self.branches.len();
        self.branches.push(Branch {
            region: Region::NOTHING,
            octants: [Node::Empty; 8],
        });
        for n in 0..8 {
            let (origin, edge) = octant(origin, edge, n);
            self.branches[branch].octants[n] = self.grow(origin, edge, middle)?;
        }
        Ok(Node::Branch(branch as u32))
    }

    fn seek(&self, at: DVec3, near: Option<&Start>) -> Result<Start, DVec3> {
        match near {
            Some(near) => self.frame.seek(at, near).or_else(|_| self.frame.seek_afresh(at)),
            None => self.frame.seek_afresh(at),
        }
    }

    /// Where no preimage is found, there is none of what is deformed, unless the search stopped within that. Its box in the frame may be
    /// larger than the one that is proven free of folds, which holds all of it too.
    fn unreachable(&self, stop: DVec3) -> Result<Node, WarpError> {
        let place = affine::point(&self.frame.frame_from_node, stop);
        if !self.source.contains(place) || !self.frame.morph.within().contains(stop) {
            return Ok(Node::Empty);
        }
        Err(WarpError::NoInverse {
            place_mm: stop,
            nearest: self.frame.morph.spline().nearest(stop).to_owned(),
        })
    }
}
