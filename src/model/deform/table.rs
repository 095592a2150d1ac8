//! φ⁻¹ tabulated: an octree of cells, in each of which it is interpolated between its corners.
//!
//! *Theory.* A cell is split until trilinear interpolation of φ⁻¹ is within the stated error in it (VCSG §3.1, criterion 3).
//! *Practice.* Cells lie on a grid of the whole frame, so that what a point comes from depends on neither the box of what is
//! deformed nor the block that asks. Where cells of two sizes meet, their interpolants differ by no more than their errors.
//! A cell of one voxel has its corners at voxels, which it reproduces exactly.

use std::fmt;

use glam::DVec3;

use super::warp::WarpReport;
use crate::math::Aabb;

/// Where a table's cells lie. Lengths are in steps, the edge of the smallest cells, from the anchor.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Layout {
    /// The edge of a smallest cell in the frame's units.
    pub step: f64,
    /// A point of the frame, in steps, where cells of all sizes have a corner.
    pub anchor: DVec3,
    /// log₂ of the edge of a root cell.
    pub root_log2: u32,
    /// The first root cell, counted in root cells.
    pub first: [i64; 3],
    /// Root cells along each axis.
    pub dims: [i64; 3],
}

/// φ⁻¹ by cells.
#[derive(Clone)]
pub struct Table {
    pub(super) layout: Layout,
    /// Beyond it nothing is, whatever interpolation says: what is deformed keeps to its box.
    pub(super) domain: Aabb,
    /// The nodes of the root cells, x fastest.
    pub(super) roots: Vec<Node>,
    pub(super) branches: Vec<Branch>,
    pub(super) cells: Vec<Cell>,
    pub(super) report: WarpReport,
}

/// A node of the octree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Node {
    /// Nothing comes to be there.
    Empty,
    /// The cell of this index.
    Cell(u32),
    /// The branch of this index.
    Branch(u32),
}

/// A split node.
#[derive(Clone, Debug)]
pub(super) struct Branch {
    /// Where all of it comes from.
    pub region: Region,
    /// Its octants; bit a of the index is the upper half along axis a.
    pub octants: [Node; 8],
}

/// The corners of a cell before the deformation, in the frame; bit a of the index is the upper one along axis a.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell(pub [DVec3; 8]);

/// Where a box comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// A box of all its points before the deformation.
    pub hull: Aabb,
    /// Whether nothing comes to some of its points.
    pub beyond: bool,
}

/// Points, coordinate by coordinate.
#[derive(Clone, Debug, Default)]
pub struct Points([Vec<f64>; 3]);

/// A node that holds a point: its place and edge in steps.
struct Found {
    node: Node,
    origin: [i64; 3],
    edge: i64,
}

/// No point.
const NOWHERE: DVec3 = DVec3::NAN;

impl Points {
    /// Makes room for `len` points.
    pub fn resize(&mut self, len: usize) {
        self.0.iter_mut().for_each(|axis| axis.resize(len, 0.0));
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.0[0].len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Their coordinates, axis by axis.
    pub fn columns(&self) -> [&[f64]; 3] {
        [&self.0[0], &self.0[1], &self.0[2]]
    }

    /// The `n`th.
    #[inline]
    pub fn get(&self, n: usize) -> DVec3 {
        DVec3::new(self.0[0][n], self.0[1][n], self.0[2][n])
    }

    /// Changes the `n`th.
    pub fn set(&mut self, n: usize, p: DVec3) {
        (0..3).for_each(|axis| self.0[axis][n] = p[axis]);
    }
}

impl Layout {
    /// log₂ of the edge of root cells, in most frames.
    const ROOT_LOG2: u32 = 6;

    /// The most root cells along an axis.
    const MOST_ROOTS: f64 = 128.0;

    /// Root cells over `domain`, a box of the frame.
    pub fn over(domain: &Aabb, step: f64, anchor: DVec3) -> Self {
        if domain.is_empty() {
            return Self::default();
        }
        let (min, max) = (domain.min / step - anchor, domain.max / step - anchor);
        let longest = (max - min).max_element() / Self::MOST_ROOTS;
        let root_log2 = (Self::ROOT_LOG2..40).find(|&log2| f64::from(log2).exp2() >= longest);
        let root_log2 = root_log2.unwrap_or(40);
        let root = |p: DVec3| p.to_array().map(|x| x.floor() as i64 >> root_log2);
        let (first, last) = (root(min), root(max));
        Self {
            step,
            anchor,
            root_log2,
            first,
            dims: [0, 1, 2].map(|a| last[a] - first[a] + 1),
        }
    }

    /// The place and edge of a root cell.
    pub fn root(&self, n: usize) -> ([i64; 3], i64) {
        let [nx, ny, _] = self.dims;
        let n = n as i64;
        let at = [n % nx, n / nx % ny, n / (nx * ny)];
        let origin = [0, 1, 2].map(|a| (self.first[a] + at[a]) << self.root_log2);
        (origin, 1 << self.root_log2)
    }

    /// How many root cells there are.
    pub fn roots(&self) -> usize {
        self.dims.iter().product::<i64>() as usize
    }

    /// The point of the frame `p` in steps.
    #[inline(always)]
    fn steps(&self, p: DVec3) -> DVec3 {
        p / self.step - self.anchor
    }

    /// The point of the frame that is at `q`, in steps.
    pub fn place(&self, q: DVec3) -> DVec3 {
        (q + self.anchor) * self.step
    }
}

/// The octant of a node at `origin`, and half its edge.
pub(super) fn octant(origin: [i64; 3], edge: i64, n: usize) -> ([i64; 3], i64) {
    let half = edge / 2;
    let origin = [0, 1, 2].map(|a| origin[a] + if n >> a & 1 == 1 { half } else { 0 });
    (origin, half)
}

/// Linear interpolation; exact at 0 and for equal ends.
#[inline(always)]
fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + t * (b - a)
}

#[inline(always)]
fn lerp3(a: DVec3, b: DVec3, t: f64) -> DVec3 {
    DVec3::new(lerp(a.x, b.x, t), lerp(a.y, b.y, t), lerp(a.z, b.z, t))
}

impl Cell {
    /// Both ends of the row at the fractions `ty` and `tz` of the cell.
    #[inline(always)]
    fn row(&self, ty: f64, tz: f64) -> [DVec3; 2] {
        let c = &self.0;
        [0, 1].map(|x| {
            let [low, high] = [x, x + 4].map(|e| lerp3(c[e], c[e + 2], ty));
            lerp3(low, high, tz)
        })
    }

    fn at(&self, t: DVec3) -> DVec3 {
        let [a, b] = self.row(t.y, t.z);
        lerp3(a, b, t.x)
    }
}

impl Default for Table {
    /// Of nothing.
    fn default() -> Self {
        Self {
            layout: Layout::default(),
            domain: Aabb::EMPTY,
            roots: Vec::new(),
            branches: Vec::new(),
            cells: Vec::new(),
            report: WarpReport::default(),
        }
    }
}

impl Table {
    /// The most cells that a table may have.
    pub const MAX_CELLS: usize = 1 << 22;

    /// What it came to.
    pub fn report(&self) -> &WarpReport {
        &self.report
    }

    /// Where the frame's point `p` was before the deformation; NaN where nothing is.
    pub fn point(&self, p: DVec3) -> DVec3 {
        let q = self.layout.steps(p);
        let Some(found) = self.find(q).filter(|_| self.domain.contains(p)) else {
            return NOWHERE;
        };
        match found.node {
            Node::Cell(cell) => self.cells[cell as usize].at(found.fraction(q)),
            _ => NOWHERE,
        }
    }

    /// [`Self::point`] of each of the points (x + n, y, z), bit for bit.
    pub fn row(&self, first: DVec3, out: &mut Points) {
        let [xs, ys, zs] = &mut out.0;
        let mut start = 0;
        while start < xs.len() {
            let x = first.x + start as f64;
            let q = self.layout.steps(DVec3::new(x, first.y, first.z));
            let Some(found) = self.find(q) else {
                xs[start] = f64::NAN;
                start += 1;
                continue;
            };
            let end = (start + self.columns(&found, x)).min(xs.len());
            let parts = [&mut xs[start..end], &mut ys[start..end], &mut zs[start..end]];
            match found.node {
                Node::Cell(cell) => self.fill(&self.cells[cell as usize], &found, q, x, parts),
                _ => parts[0].fill(f64::NAN),
            }
            start = end;
        }
        // Within the rest of the row nothing is beyond the domain, as its ends are not.
        let is_beyond = |n: &usize| !self.domain.contains(first + DVec3::X * *n as f64);
        let ahead = (0..xs.len()).take_while(is_beyond).count();
        let behind = (ahead..xs.len()).rev().take_while(is_beyond).count();
        let end = xs.len() - behind;
        xs[..ahead].fill(f64::NAN);
        xs[end..].fill(f64::NAN);
    }

    /// How many of the columns x, x + 1, … lie in a node that holds the first: at least that one.
    fn columns(&self, found: &Found, x: f64) -> usize {
        let end = (found.origin[0] + found.edge) as f64;
        let layout = &self.layout;
        let inside = |n: usize| (x + n as f64) / layout.step - layout.anchor.x < end;
        let mut count = ((end + layout.anchor.x) * layout.step - x).ceil().max(1.0) as usize;
        while count > 1 && !inside(count - 1) {
            count -= 1;
        }
        while inside(count) {
            count += 1;
        }
        count
    }

    #[inline(always)]
    fn fill(&self, cell: &Cell, found: &Found, q: DVec3, x: f64, parts: [&mut [f64]; 3]) {
        let t = found.fraction(q);
        let [a, b] = cell.row(t.y, t.z);
        let (origin, per_edge) = (found.origin[0] as f64, 1.0 / found.edge as f64);
        let (step, anchor) = (self.layout.step, self.layout.anchor.x);
        for (axis, part) in parts.into_iter().enumerate() {
            let (a, b) = (a[axis], b[axis]);
            for (n, out) in part.iter_mut().enumerate() {
                let t = ((x + n as f64) / step - anchor - origin) * per_edge;
                *out = lerp(a, b, t);
            }
        }
    }

    /// The node without octants that holds the point `q` (in steps).
    #[inline]
    fn find(&self, q: DVec3) -> Option<Found> {
        if !q.is_finite() {
            return None;
        }
        let at = [q.x.floor() as i64, q.y.floor() as i64, q.z.floor() as i64];
        let layout = &self.layout;
        let root = [0, 1, 2].map(|a| (at[a] >> layout.root_log2) - layout.first[a]);
        if (0..3).any(|a| root[a] < 0 || root[a] >= layout.dims[a]) {
            return None;
        }
        let mut node = self.roots[(root[0] + layout.dims[0] * (root[1] + layout.dims[1] * root[2])) as usize];
        let mut log2 = layout.root_log2;
        while let Node::Branch(branch) = node {
            log2 -= 1;
            let bit = |a: usize| ((at[a] >> log2 & 1) as usize) << a;
            node = self.branches[branch as usize].octants[bit(0) | bit(1) | bit(2)];
        }
        Some(Found {
            node,
            origin: at.map(|x| x >> log2 << log2),
            edge: 1 << log2,
        })
    }

    /// Where the points of `block`, a box of the frame, come from.
    pub fn region(&self, block: &Aabb) -> Region {
        let inside = block.intersect(&self.domain);
        if inside.is_empty() {
            return Region::NOWHERE;
        }
        let mut region = Region {
            beyond: inside != *block,
            ..Region::NOTHING
        };
        let wanted = Aabb::new(self.layout.steps(inside.min), self.layout.steps(inside.max));
        let layout = &self.layout;
        let root = |x: f64| x.floor() as i64 >> layout.root_log2;
        let ranges = [0, 1, 2].map(|a| {
            let (first, last) = (root(wanted.min[a]), root(wanted.max[a]));
            let end = layout.first[a] + layout.dims[a];
            region.beyond |= first < layout.first[a] || last >= end;
            first.max(layout.first[a]) - layout.first[a]..last.saturating_add(1).min(end) - layout.first[a]
        });
        let [xs, ys, zs] = ranges;
        for z in zs {
            for y in ys.clone() {
                for x in xs.clone() {
                    let n = (x + layout.dims[0] * (y + layout.dims[1] * z)) as usize;
                    let (origin, edge) = layout.root(n);
                    region = region.with(&self.region_of(self.roots[n], origin, edge, &wanted));
                }
            }
        }
        let rounding = 8.0 * f64::EPSILON * region.hull.min.abs().max(region.hull.max.abs());
        Region {
            hull: region.hull.expand(rounding.max(DVec3::ZERO)),
            ..region
        }
    }

    /// Where the part of a node that lies in `wanted` (in steps) comes from.
    fn region_of(&self, node: Node, origin: [i64; 3], edge: i64, wanted: &Aabb) -> Region {
        let min = DVec3::from(origin.map(|x| x as f64));
        // A node holds its lower faces, and not its upper ones.
        let max = min + edge as f64;
        if wanted.max.cmplt(min).any() || wanted.min.cmpge(max).any() {
            return Region::NOTHING;
        }
        match node {
            Node::Empty => Region::NOWHERE,
            Node::Cell(cell) => {
                let part = wanted.intersect(&Aabb::new(min, max));
                let per_edge = 1.0 / edge as f64;
                let corners = part
                    .corners()
                    .map(|q| self.cells[cell as usize].at((q - min) * per_edge));
                Region::of(corners)
            }
            Node::Branch(branch) => {
                let branch = &self.branches[branch as usize];
                if wanted.min.cmple(min).all() && wanted.max.cmpge(max).all() {
                    return branch.region;
                }
                (0..8).fold(Region::NOTHING, |region, n| {
                    let (origin, edge) = octant(origin, edge, n);
                    region.with(&self.region_of(branch.octants[n], origin, edge, wanted))
                })
            }
        }
    }
}

impl Found {
    /// Where in it the point `q` (in steps) lies, in parts of its edge.
    #[inline(always)]
    fn fraction(&self, q: DVec3) -> DVec3 {
        let per_edge = 1.0 / self.edge as f64;
        DVec3::new(
            (q.x - self.origin[0] as f64) * per_edge,
            (q.y - self.origin[1] as f64) * per_edge,
            (q.z - self.origin[2] as f64) * per_edge,
        )
    }
}

impl Region {
    /// Of no point.
    pub const NOTHING: Self = Self {
        hull: Aabb::EMPTY,
        beyond: false,
    };

    /// Of points that nothing comes to.
    pub const NOWHERE: Self = Self {
        hull: Aabb::EMPTY,
        beyond: true,
    };

    /// Of the points of a cell or of a part of it, whose corners come from `corners`.
    pub(super) fn of(corners: [DVec3; 8]) -> Self {
        match corners.iter().all(|c| c.is_finite()) {
            true => Self {
                hull: Aabb::of_points(corners),
                beyond: false,
            },
            false => Self::NOWHERE,
        }
    }

    /// Both.
    pub fn with(&self, other: &Self) -> Self {
        Self {
            hull: self.hull.hull(&other.hull),
            beyond: self.beyond || other.beyond,
        }
    }
}

impl fmt::Debug for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Table")
            .field("report", &self.report)
            .finish_non_exhaustive()
    }
}
