//! A cell that needs special processing: its corners and the surface's vertices on its edges as nodes, and the polygons that
//! bound the scan's solid, or what it leaves free, within the cell.

use glam::DVec3;

use crate::surface::cases::CASES;
use crate::surface::cell::{FACE_EDGES, FACES, edge_between, edge_corners};
use crate::surface::trilinear::interpolant::sample;

/// Which vertex of the combined mesh a node is. Cells that share a node name it alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Vertex {
    /// One of the scan's surface.
    Surface(u32),
    /// Where the cutter's surface crosses an edge between two of those, the lower one first.
    Crease(u32, u32),
    /// Where the cutter's surface crosses a lattice edge: three times the voxel at its lower end, and its axis.
    Lattice(u64),
    /// A voxel, by its place in the lattice, x fastest.
    Voxel(u64),
}

/// Where a node lies in its cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Corner(u8),
    Edge(u8),
    Cut,
}

/// A corner of a polygon in a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub vertex: Vertex,
    /// The cutter's function: at least 0 inside.
    pub cutter: f64,
    /// The position in the unit cell, and in the world.
    pub at: DVec3,
    pub position: DVec3,
    /// The normal of the scan's surface; zero where the node is not on it.
    pub normal: DVec3,
    place: Place,
}

impl Node {
    /// A node that lies nowhere in particular in its cell.
    #[cfg(test)]
    pub fn of_test(name: u32, position: DVec3, cutter: f64) -> Self {
        Self {
            vertex: Vertex::Surface(name),
            cutter,
            at: position,
            position,
            normal: DVec3::ZERO,
            place: Place::Cut,
        }
    }

    /// Whether the node is inside the cutter.
    pub fn is_inside(&self) -> bool {
        self.cutter >= 0.0
    }
}

/// What is known of a vertex of the scan's surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceVertex {
    pub number: u32,
    pub position: DVec3,
    pub normal: DVec3,
}

/// The cell at which both surfaces meet, or at the lattice's border.
pub(super) struct Cell {
    /// The scan's values less the isovalue.
    values: [f64; 8],
    /// The numbers of the voxels at the corners.
    voxels: [u64; 8],
    /// The corners that are inside the scan's solid.
    inside: usize,
    corners: [Node; 8],
    /// For each edge that the scan's surface crosses, its vertex there.
    edges: [Option<Node>; 12],
}

/// What a [`Cell`] is made of; corners are those of the cell.
pub(super) struct Corners {
    pub values: [f64; 8],
    pub voxels: [u64; 8],
    pub positions: [DVec3; 8],
    pub cutter: [f64; 8],
    /// One bit for each corner inside the scan's solid, and for each that is a vertex of its surface.
    pub inside: usize,
    pub on: usize,
}

impl Cell {
    /// The cell of `corners`; `vertex` finds the scan's vertex on an edge (0 to 11) or on a corner (12 and more).
    pub fn new(corners: &Corners, vertex: impl Fn(usize) -> SurfaceVertex) -> Self {
        let nodes = [0, 1, 2, 3, 4, 5, 6, 7].map(|c: usize| corner(corners, c, &vertex));
        let edges = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11].map(|e: usize| {
            let [lower, upper] = edge_corners(e as u8).map(usize::from);
            let is_inside = |c: usize| corners.inside >> c & 1 == 1;
            if is_inside(lower) == is_inside(upper) {
                return None;
            }
            let end = if is_inside(lower) { lower } else { upper };
            if corners.on >> end & 1 == 1 {
                return Some(nodes[end]);
            }
            Some(on_edge(corners, e, [&nodes[lower], &nodes[upper]], vertex(e)))
        });
        Self {
            values: corners.values,
            voxels: corners.voxels,
            inside: corners.inside,
            corners: nodes,
            edges,
        }
    }

    /// The triangles of the scan's surface.
    pub fn surface(&self) -> impl Iterator<Item = [Node; 3]> {
        let case = &CASES[self.inside];
        let triangles = &case.triangles[..usize::from(case.count)];
        triangles.iter().filter_map(|t| {
            let [a, b, c] = t.map(|e| self.edges[usize::from(e)]);
            Some([a?, b?, c?])
        })
    }

    /// The triangles of the cutter's surface, as marching cubes makes them.
    pub fn cutter_surface(&self) -> impl Iterator<Item = [Node; 3]> {
        let signs = (0..8).fold(0, |signs, c| signs | usize::from(self.corners[c].is_inside()) << c);
        let case = &CASES[signs];
        let vertex = |e: u8| {
            let [a, b] = edge_corners(e).map(|c| self.corners[usize::from(c)]);
            self.crossing(&a, &b)
        };
        case.triangles[..usize::from(case.count)]
            .iter()
            .map(move |t| t.map(vertex))
    }

    /// Calls `each` with the polygons of a face that lie in the scan's solid, or outside it, counterclockwise seen from outside the
    /// cell. Where inside corners are opposite each other they are apart, as in the cases of the surface.
    pub fn face_polygons(&self, face: usize, of_inside: bool, mut each: impl FnMut(&[Node])) {
        let (corners, edges) = (FACES[face], FACE_EDGES[face]);
        let is_part = corners.map(|c| (self.inside >> c & 1 == 1) == of_inside);
        let node = |n: usize| self.corners[usize::from(corners[n % 4])];
        let edge = |n: usize| self.edges[usize::from(edges[n % 4])];
        let alternates = is_part[0] == is_part[2] && is_part[1] == is_part[3] && is_part[0] != is_part[1];
        if alternates && of_inside {
            for n in (0..4).filter(|n| is_part[*n]) {
                if let (Some(before), Some(after)) = (edge(n + 3), edge(n)) {
                    each(&[before, node(n), after]);
                }
            }
            return;
        }
        let mut polygon = Vec::with_capacity(8);
        for (n, is_part) in is_part.into_iter().enumerate() {
            polygon.extend(is_part.then(|| node(n)));
            polygon.extend(edge(n));
        }
        each(&polygon);
    }

    /// Where the cutter's surface crosses the line between two nodes on either side of it. It is the inside one of them where
    /// that lies on the surface.
    pub fn crossing(&self, a: &Node, b: &Node) -> Node {
        // In one order always, so that all polygons with this line get the same bits.
        let (a, b) = if a.vertex < b.vertex { (a, b) } else { (b, a) };
        let inside = if a.is_inside() { a } else { b };
        if inside.cutter == 0.0 {
            return *inside;
        }
        let t = a.cutter / (a.cutter - b.cutter);
        Node {
            vertex: self.name_between(a, b),
            cutter: 0.0,
            at: a.at.lerp(b.at, t),
            position: a.position.lerp(b.position, t),
            normal: a.normal.lerp(b.normal, t).normalize_or_zero(),
            place: Place::Cut,
        }
    }

    fn name_between(&self, a: &Node, b: &Node) -> Vertex {
        let edge = match (a.vertex, b.vertex, a.place, b.place) {
            (Vertex::Surface(a), Vertex::Surface(b), ..) => return Vertex::Crease(a, b),
            (_, _, Place::Edge(e), _) | (_, _, _, Place::Edge(e)) => e,
            (_, _, Place::Corner(a), Place::Corner(b)) => edge_between(a, b),
            // A cut is never cut again.
            (_, _, Place::Cut, _) | (_, _, _, Place::Cut) => return a.vertex,
        };
        let [lower, _] = edge_corners(edge);
        Vertex::Lattice(3 * self.voxels[usize::from(lower)] + u64::from(edge / 4))
    }

    /// The scan's trilinear interpolant, less the isovalue.
    pub fn value(&self, at: DVec3) -> f64 {
        sample(&self.values, at.to_array()).0
    }
}

fn corner(corners: &Corners, c: usize, vertex: &impl Fn(usize) -> SurfaceVertex) -> Node {
    let at = DVec3::from([0, 1, 2].map(|axis| (c >> axis & 1) as f64));
    let node = Node {
        vertex: Vertex::Voxel(corners.voxels[c]),
        cutter: corners.cutter[c],
        at,
        position: corners.positions[c],
        normal: DVec3::ZERO,
        place: Place::Corner(c as u8),
    };
    if corners.on >> c & 1 == 0 {
        return node;
    }
    let found = vertex(12 + c);
    Node {
        vertex: Vertex::Surface(found.number),
        position: found.position,
        normal: found.normal,
        ..node
    }
}

fn on_edge(corners: &Corners, e: usize, [lower, upper]: [&Node; 2], vertex: SurfaceVertex) -> Node {
    let [from, to] = edge_corners(e as u8).map(|c| corners.values[usize::from(c)]);
    let t = from / (from - to);
    // Next to a voxel that is not finite.
    let t = if t.is_finite() { t } else { 0.5 };
    Node {
        vertex: Vertex::Surface(vertex.number),
        cutter: lower.cutter + t * (upper.cutter - lower.cutter),
        at: lower.at.lerp(upper.at, t),
        position: vertex.position,
        normal: vertex.normal,
        place: Place::Edge(e as u8),
    }
}
