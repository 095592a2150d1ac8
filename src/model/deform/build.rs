//! Makes the table of φ⁻¹.
//!
//! *Practice.* Root cells are made in parallel, each for itself: what is in one depends on nothing but its place and the
//! spline. Each cell's search for its preimage starts from its parent's; corners that cells of one root share are sought once.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::table::{Branch, Cell, Layout, Node, Region, Table, octant};
use super::warp::{Frame, Start, WarpError, WarpReport};
use crate::math::{Aabb, affine};

/// A cell before its corners are known.
struct Pending {
    origin: [i64; 3],
    edge: i64,
    /// The inverse in its middle.
    middle: Start,
}

/// One root cell's part of the table.
struct Grower<'a> {
    frame: &'a Frame,
    source: &'a Aabb,
    step: f64,
    /// Cells of all roots so far.
    count: &'a AtomicUsize,
    branches: Vec<Branch>,
    pending: Vec<Pending>,
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
    /// The table over `layout` of the inverse of `frame`'s morph, for what lay within `source`.
    pub(super) fn build(frame: &Frame, source: &Aabb, layout: Layout) -> Result<Self, WarpError> {
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
        r.bound_voxels = r.bound_voxels.max(s.bound_voxels);
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
            let whole = octants.into_iter().fold(Region::NOTHING, |r, node| r.with(&region(node)));
            self.branches[n].region = whole;
        }
    }
}

fn grow_root(
    frame: &Frame,
    source: &Aabb,
    layout: &Layout,
    n: usize,
    count: &AtomicUsize,
) -> Result<Grown, WarpError> {
    let mut grower = Grower {
        frame,
        source,
        step: layout.step,
        count,
        branches: Vec::new(),
        pending: Vec::new(),
        report: WarpReport::default(),
    };
    let (origin, edge) = layout.root(n);
    let root = grower.grow(origin, edge, None)?;
    let cells = grower.cells()?;
    Ok(Grown {
        root,
        branches: grower.branches,
        cells,
        report: grower.report,
    })
}

impl Grower<'_> {
    /// The node at `origin`, from the inverse in its parent's middle. As deep as the octree.
    fn grow(&mut self, origin: [i64; 3], edge: i64, parent: Option<&Start>) -> Result<Node, WarpError> {
        if self.count.load(Ordering::Relaxed) > Table::MAX_CELLS {
            return Ok(Node::Empty);
        }
        let middle = (DVec3::from(origin.map(|x| x as f64)) + 0.5 * edge as f64) * self.step;
        let found = match self.seek(middle, parent) {
            Ok(found) => found,
            Err(stop) if edge == 1 => return self.unreachable(stop),
            Err(_) => return self.split(origin, edge, None),
        };
        let bound = match edge {
            1 => 0.0,
            _ => self.frame.error_bound(&found, edge as f64 * self.step),
        };
        if bound > self.frame.error_voxels {
            return self.split(origin, edge, Some(&found));
        }
        self.report.bound_voxels = self.report.bound_voxels.max(bound);
        self.count.fetch_add(1, Ordering::Relaxed);
        self.pending.push(Pending {
            origin,
            edge,
            middle: found,
        });
        Ok(Node::Cell(self.pending.len() as u32 - 1))
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

    /// Where no preimage is found, there is none of what is deformed, unless the search stopped within that.
    fn unreachable(&self, stop: DVec3) -> Result<Node, WarpError> {
        let place = affine::point(&self.frame.frame_from_node, stop);
        if !self.source.expand(DVec3::splat(self.step)).contains(place) {
            return Ok(Node::Empty);
        }
        Err(WarpError::NoInverse {
            place_mm: stop,
            nearest: self.frame.morph.spline().nearest(stop).to_owned(),
        })
    }

    /// The cells with their corners.
    fn cells(&mut self) -> Result<Vec<Cell>, WarpError> {
        let pending = std::mem::take(&mut self.pending);
        let mut corners: Vec<([i64; 3], u32)> = Vec::with_capacity(8 * pending.len());
        for (n, cell) in pending.iter().enumerate() {
            for corner in 0..8 {
                let at = [0, 1, 2].map(|a| cell.origin[a] + if corner >> a & 1 == 1 { cell.edge } else { 0 });
                corners.push((at, (8 * n + corner) as u32));
            }
        }
        corners.sort_unstable();
        let mut cells = vec![Cell([DVec3::NAN; 8]); pending.len()];
        for same in corners.chunk_by(|a, b| a.0 == b.0) {
            let at = DVec3::from(same[0].0.map(|x| x as f64)) * self.step;
            let start = &pending[same[0].1 as usize / 8].middle;
            let place = match self.seek(at, Some(start)) {
                Ok(found) => self.frame.place(&found),
                Err(stop) => {
                    self.unreachable(stop)?;
                    DVec3::NAN
                }
            };
            for &(_, n) in same {
                cells[n as usize / 8].0[n as usize % 8] = place;
            }
        }
        self.measure(&pending, &cells);
        Ok(cells)
    }

    /// Interpolation errs the most in a cell's middle where φ⁻¹ bends one way.
    fn measure(&mut self, pending: &[Pending], cells: &[Cell]) {
        self.report.cells = cells.len();
        for (cell, pending) in cells.iter().zip(pending).filter(|(_, p)| p.edge > 1) {
            let middle = cell.0.iter().sum::<DVec3>() / 8.0;
            let off = middle.distance(self.frame.place(&pending.middle)) / self.frame.voxel;
            self.report.measured_voxels = self.report.measured_voxels.max(off);
        }
    }
}
