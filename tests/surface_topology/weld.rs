//! The surface of a small lattice, welded from its cells, and what is wrong with it.

use std::collections::HashSet;

use vcsg::surface::trilinear::triangulate;

/// Samples less the isovalue, `n` an axis, x fastest.
pub struct Field<T> {
    pub n: usize,
    pub values: Vec<T>,
}

/// Triangles with vertices that cells share.
#[derive(Default)]
pub struct Welded {
    pub triangles: Vec<[u32; 3]>,
    /// For each vertex, one bit for each of the lattice's six faces on which it lies.
    border: Vec<u8>,
}

/// A surface's Euler characteristic and its number of components.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    pub euler: i64,
    pub components: usize,
}

impl<T: Copy> Field<T> {
    pub fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.n * (y + self.n * z)
    }

    /// The lower corners of all cells.
    pub fn cells(&self) -> impl Iterator<Item = [usize; 3]> + use<T> {
        let m = self.n - 1;
        (0..m * m * m).map(move |k| [k % m, k / m % m, k / (m * m)])
    }

    pub fn corners(&self, cell: [usize; 3]) -> [T; 8] {
        std::array::from_fn(|c| self.values[self.index(moved(cell, c))])
    }
}

/// The lattice point at corner `c` of a cell.
pub fn moved(cell: [usize; 3], c: usize) -> [usize; 3] {
    [0, 1, 2].map(|axis| cell[axis] + (c >> axis & 1))
}

/// The lower corner of a cell's edge, written out anew so as not to trust the code under test.
pub fn lower_corner(edge: usize) -> usize {
    let (u, v) = (edge & 1, edge >> 1 & 1);
    match edge / 4 {
        0 => u << 1 | v << 2,
        1 => u | v << 2,
        _ => u | v << 1,
    }
}

/// One bit for each of the cell's faces in which an edge lies.
pub fn faces_of(edge: u8) -> u8 {
    let lower = lower_corner(edge as usize);
    let across = (0..3).filter(|&axis| axis != edge / 4);
    across.fold(0, |faces, axis| faces | 1 << (2 * axis + (lower >> axis & 1) as u8))
}

impl Welded {
    pub fn extract(field: &Field<f64>) -> Self {
        let mut ids = vec![u32::MAX; 3 * field.values.len()];
        let mut welded = Self::default();
        for cell in field.cells() {
            let found = triangulate(&field.corners(cell));
            let first_interior = welded.border.len() as u32;
            welded.border.extend(found.interior().iter().map(|_| 0));
            for triangle in found.triangles() {
                let triangle = triangle.map(|v| match (v as usize).checked_sub(12) {
                    Some(k) => first_interior + k as u32,
                    None => welded.shared(&mut ids, field, cell, v as usize),
                });
                welded.triangles.push(triangle);
            }
        }
        welded
    }

    /// The vertex on an edge of a cell.
    fn shared(&mut self, ids: &mut [u32], field: &Field<f64>, cell: [usize; 3], edge: usize) -> u32 {
        let at = moved(cell, lower_corner(edge));
        let id = &mut ids[edge / 4 + 3 * field.index(at)];
        if *id == u32::MAX {
            *id = self.border.len() as u32;
            let on_face = |face: usize| at[face / 2] == (face % 2) * (field.n - 1) && face / 2 != edge / 4;
            self.border
                .push((0..6).fold(0, |faces, face| faces | u8::from(on_face(face)) << face));
        }
        *id
    }

    /// What keeps the triangles from being an oriented manifold whose edges of one triangle lie on the lattice's border.
    pub fn fault(&self) -> Option<String> {
        self.edge_fault().or_else(|| self.link_fault())
    }

    /// Whether the surface has no border at all.
    pub fn is_closed(&self) -> bool {
        let edges: HashSet<_> = self.directed_edges().collect();
        edges.iter().all(|&[a, b]| edges.contains(&[b, a]))
    }

    fn directed_edges(&self) -> impl Iterator<Item = [u32; 2]> {
        self.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
    }

    fn edge_fault(&self) -> Option<String> {
        let mut edges: Vec<_> = self.directed_edges().collect();
        edges.sort_unstable();
        if let Some(pair) = edges.windows(2).find(|pair| pair[0] == pair[1]) {
            return Some(format!("the directed edge {:?} is of two triangles", pair[0]));
        }
        let loose = |&&[a, b]: &&[u32; 2]| {
            let inner = self.border[a as usize] & self.border[b as usize] == 0;
            inner && edges.binary_search(&[b, a]).is_err()
        };
        let loose = edges.iter().find(loose);
        loose.map(|edge| format!("the edge {edge:?} away from the border is of one triangle"))
    }

    /// With every directed edge used once, the link of a vertex is arcs and circles; there must be one.
    fn link_fault(&self) -> Option<String> {
        let mut links = vec![vec![]; self.border.len()];
        for &[a, b, c] in &self.triangles {
            links[a as usize].push((b, c));
            links[b as usize].push((c, a));
            links[c as usize].push((a, b));
        }
        let split = links.iter().position(|link| !is_one_piece(link));
        split.map(|vertex| format!("the link of vertex {vertex} is {:?}", links[vertex]))
    }

    pub fn shape(&self) -> Shape {
        let used: HashSet<u32> = self.triangles.iter().flatten().copied().collect();
        let edges: HashSet<_> = self.directed_edges().map(|[a, b]| [a.min(b), a.max(b)]).collect();
        let mut groups = Groups::new(self.border.len());
        edges.iter().for_each(|&[a, b]| groups.join(a as usize, b as usize));
        let roots: HashSet<_> = used.iter().map(|&v| groups.root(v as usize)).collect();
        Shape {
            euler: used.len() as i64 - edges.len() as i64 + self.triangles.len() as i64,
            components: roots.len(),
        }
    }
}

fn is_one_piece(link: &[(u32, u32)]) -> bool {
    let begins = |&&(b, _): &&(u32, u32)| link.iter().all(|&(_, c)| c != b);
    let Some(&start) = link.iter().find(begins).or(link.first()) else {
        return true;
    };
    let mut at = start.1;
    let mut passed = 1;
    while let Some(&(_, next)) = link.iter().find(|&&(b, _)| b == at && at != start.0) {
        at = next;
        passed += 1;
    }
    passed == link.len()
}

/// Disjoint sets.
pub struct Groups(Vec<usize>);

impl Groups {
    pub fn new(n: usize) -> Self {
        Self((0..n).collect())
    }

    pub fn root(&mut self, mut k: usize) -> usize {
        while self.0[k] != k {
            self.0[k] = self.0[self.0[k]];
            k = self.0[k];
        }
        k
    }

    pub fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a] = b;
    }
}
