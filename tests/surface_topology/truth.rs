//! The topology of a trilinear level set by subdivision in whole numbers, without its saddles.
//!
//! A cell is cut by planes until in every part that the level set meets the interpolant rises or falls strictly along one axis and
//! no face has alternating signs. Then, along that axis, the inside of the part shrinks onto its part in the face at one end and
//! the outside onto the other face's, both bounded by at most one arc; on each of the part's faces and edges, too, inside and
//! outside are in one piece without holes. So the level set's two sides have the Euler characteristics and the components of the
//! cubes, squares, edges and points of the subdivision that are wholly inside or wholly outside. For two sides A and B of a
//! surface in a cube, χ(A) + χ(B) − χ(surface) = χ(cube) = 1; and since the cube has no holes, each component of the surface
//! divides one component of A from one of B, and no other component does.
//!
//! The planes halve intervals at most [`DEPTH`] times. Values below 2²⁰ in size, weighted with three factors of at most 2^DEPTH,
//! stay below 2⁵⁶, so that all arithmetic is exact in `i64`. A level set that is not resolved then has a saddle of the interpolant
//! or of a face within about 2^−DEPTH of it; it is discarded, and counted.

use crate::weld::{Groups, lower_corner};

/// How often an interval may be halved.
const DEPTH: u32 = 12;

/// The level set in one cell.
pub struct Truth {
    pub euler: i64,
    pub components: usize,
    /// For each edge that the level set crosses, which component does; unspecified names.
    pub component_of_edge: [Option<usize>; 12],
}

/// The subdivision of a cell: planes across each axis, in units of 2^−DEPTH.
struct Grid {
    planes: [Vec<i64>; 3],
    /// The interpolant at the planes' intersections, x fastest, times 2^(3·DEPTH).
    values: Vec<i64>,
}

impl Truth {
    /// The truth for corner values below 2²⁰ in size, none zero; `None` if it is not resolved.
    pub fn of(corners: &[i64; 8]) -> Option<Self> {
        let whole = || vec![0, 1 << DEPTH];
        let mut planes = [whole(), whole(), whole()];
        loop {
            let grid = Grid::new(corners, planes);
            let cuts = grid.cuts()?;
            if cuts.iter().all(Vec::is_empty) {
                return Some(grid.truth());
            }
            planes = grid.planes;
            for (planes, cuts) in planes.iter_mut().zip(cuts) {
                planes.extend(cuts);
                planes.sort_unstable();
                planes.dedup();
            }
        }
    }
}

impl Grid {
    fn new(corners: &[i64; 8], planes: [Vec<i64>; 3]) -> Self {
        let one = 1i64 << DEPTH;
        let mix = |a: i64, b: i64, t: i64| a * (one - t) + b * t;
        let mut values = Vec::with_capacity(planes.iter().map(Vec::len).product());
        for &z in &planes[2] {
            let face: [i64; 4] = std::array::from_fn(|c| mix(corners[c], corners[c + 4], z));
            for &y in &planes[1] {
                let ends = [mix(face[0], face[2], y), mix(face[1], face[3], y)];
                values.extend(planes[0].iter().map(|&x| mix(ends[0], ends[1], x)));
            }
        }
        Self { planes, values }
    }

    fn dims(&self) -> [usize; 3] {
        [0, 1, 2].map(|axis| self.planes[axis].len())
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.planes[0].len() * (y + self.planes[1].len() * z)
    }

    /// All points of the subdivision that have a successor along the axes in the bit set `along`.
    fn points(&self, along: usize) -> impl Iterator<Item = [usize; 3]> + use<> {
        let dims = self.dims();
        let [nx, ny, nz] = [0, 1, 2].map(|axis| dims[axis] - (along >> axis & 1));
        (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
    }

    fn part(&self, at: [usize; 3]) -> [i64; 8] {
        std::array::from_fn(|c| self.values[self.index(crate::weld::moved(at, c))])
    }

    /// New planes through the middle of the longest side of every part that is not simple; `None` if one is too small.
    fn cuts(&self) -> Option<[Vec<i64>; 3]> {
        let mut cuts = [vec![], vec![], vec![]];
        for at in self.points(7).filter(|&at| !is_simple(&self.part(at))) {
            let ends = [0, 1, 2].map(|axis| [self.planes[axis][at[axis]], self.planes[axis][at[axis] + 1]]);
            let longest = (0..3).max_by_key(|&axis| ends[axis][1] - ends[axis][0])?;
            let [lower, upper] = ends[longest];
            (upper - lower > 1).then_some(())?;
            cuts[longest].push((lower + upper) / 2);
        }
        Some(cuts)
    }

    fn truth(&self) -> Truth {
        let sides = [self.euler_of(true), self.euler_of(false)];
        let mut groups = self.sides();
        let mut roots: Vec<_> = (0..self.values.len()).map(|k| groups.root(k)).collect();
        let component_of_edge = std::array::from_fn(|edge| self.component(&roots, edge));
        roots.sort_unstable();
        roots.dedup();
        Truth {
            euler: sides[0] + sides[1] - 1,
            components: roots.len() - 1,
            component_of_edge,
        }
    }

    /// The Euler characteristic of the subcomplex on one side.
    fn euler_of(&self, inside: bool) -> i64 {
        let is_whole = |at, along: usize| {
            let mut corners = (0..8).filter(|c| c & !along == 0);
            corners.all(|c| (self.values[self.index(crate::weld::moved(at, c))] >= 0) == inside)
        };
        let count = |along| self.points(along).filter(|&at| is_whole(at, along)).count() as i64;
        let sign = |along: usize| if along.count_ones() % 2 == 0 { 1 } else { -1 };
        (0..8).map(|along| sign(along) * count(along)).sum()
    }

    /// The components of both sides.
    fn sides(&self) -> Groups {
        let mut groups = Groups::new(self.values.len());
        for along in [1, 2, 4] {
            for at in self.points(along) {
                let [a, b] = [at, crate::weld::moved(at, along)].map(|at| self.index(at));
                if (self.values[a] >= 0) == (self.values[b] >= 0) {
                    groups.join(a, b);
                }
            }
        }
        groups
    }

    /// The component of the level set that crosses an edge of the cell, named by the components on its two sides.
    fn component(&self, roots: &[usize], edge: usize) -> Option<usize> {
        let dims = self.dims();
        let point = |c: usize| self.index([0, 1, 2].map(|axis| (c >> axis & 1) * (dims[axis] - 1)));
        let lower = lower_corner(edge);
        let [a, b] = [point(lower), point(lower | 1 << (edge / 4))];
        let crossed = (self.values[a] >= 0) != (self.values[b] >= 0);
        let [a, b] = [roots[a], roots[b]];
        crossed.then(|| a.min(b) * self.values.len() + a.max(b))
    }
}

/// Whether the level set does not meet a part, or divides it as a graph over one of its faces.
fn is_simple(part: &[i64; 8]) -> bool {
    let inside = part.map(|v| v >= 0);
    if inside == [inside[0]; 8] {
        return true;
    }
    let alternates = |axis: usize, side: usize| {
        let [u, v] = [1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3)];
        let [a, b, c, d] = [0, u, v, u | v].map(|c| inside[c | side << axis]);
        a == d && b == c && a != b
    };
    let is_monotone = |axis: usize| {
        let steps = (0..8).filter(|c| c >> axis & 1 == 0).map(|c| part[c | 1 << axis] - part[c]);
        let signs = steps.fold(0, |sum, step| sum + step.signum());
        signs.abs() == 4
    };
    !(0..3).any(|axis| alternates(axis, 0) || alternates(axis, 1)) && (0..3).any(is_monotone)
}
