//! How triangles meet along edges.
//!
//! *Practice.* An edge is found at the lower of its vertices: the sides of all triangles are put in bins by that vertex, and each
//! bin, of six sides or so, is sorted by the other. Threads fill bins in any order; sorting makes that harmless.

use std::ops::AddAssign;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use rayon::prelude::*;

/// The edges of triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct EdgeCounts {
    pub edges: usize,
    /// Edges of one triangle.
    pub boundary: usize,
    /// Edges of more than two triangles, or of two that run along it in the same direction.
    pub non_manifold: usize,
    /// Edges along which not as many triangles run in one direction as in the other. Without any, the mesh encloses a volume.
    pub unbalanced: usize,
}

impl AddAssign for EdgeCounts {
    fn add_assign(&mut self, other: Self) {
        self.edges += other.edges;
        self.boundary += other.boundary;
        self.non_manifold += other.non_manifold;
        self.unbalanced += other.unbalanced;
    }
}

impl EdgeCounts {
    /// Those of `triangles` of so many `vertices`.
    pub fn of(triangles: &[[u32; 3]], vertices: usize) -> Self {
        let bins = Bins::of(triangles, vertices);
        let count = |(mut counts, mut sides): (Self, Vec<u64>), v: usize| {
            bins.sorted(v, &mut sides);
            counts.add(&sides);
            (counts, sides)
        };
        let join = |mut a: Self, b: Self| {
            a += b;
            a
        };
        let vertices = (0..vertices).into_par_iter();
        let counts = vertices.fold(Default::default, count).map(|(counts, _)| counts);
        counts.reduce(Self::default, join)
    }

    /// Adds the edges of the sorted `sides` of one vertex.
    fn add(&mut self, sides: &[u64]) {
        for edge in sides.chunk_by(|a, b| a / 2 == b / 2) {
            let backward = edge.iter().filter(|side| *side % 2 == 1).count();
            let is_balanced = 2 * backward == edge.len();
            *self += Self {
                edges: 1,
                boundary: usize::from(edge.len() == 1),
                non_manifold: usize::from(edge.len() > 2 || edge.len() == 2 && !is_balanced),
                unbalanced: usize::from(!is_balanced),
            };
        }
    }
}

/// The sides of triangles by their lower vertex: twice the upper vertex, and one more where the side runs downwards.
struct Bins {
    /// Where each vertex's bin starts, and where the last one ends.
    starts: Vec<usize>,
    sides: Vec<AtomicU64>,
}

impl Bins {
    fn of(triangles: &[[u32; 3]], vertices: usize) -> Self {
        let sizes = zeros(vertices);
        each_side(triangles, |low, _| {
            sizes[low as usize].fetch_add(1, Relaxed);
        });
        let mut starts = Vec::with_capacity(sizes.len() + 1);
        let mut end = 0;
        starts.push(0);
        for size in &sizes {
            end += size.load(Relaxed) as usize;
            starts.push(end);
        }
        let sides: Vec<AtomicU64> = (0..end).into_par_iter().map(|_| AtomicU64::new(0)).collect();
        // What is left to fill of each bin counts down to its start.
        each_side(triangles, |low, side| {
            let left = sizes[low as usize].fetch_sub(1, Relaxed) as usize;
            sides[starts[low as usize] + left - 1].store(side, Relaxed);
        });
        Self { starts, sides }
    }

    /// Puts the bin of `vertex` in the place of what is in `sides`.
    fn sorted(&self, vertex: usize, sides: &mut Vec<u64>) {
        let bin = &self.sides[self.starts[vertex]..self.starts[vertex + 1]];
        sides.clear();
        sides.extend(bin.iter().map(|side| side.load(Relaxed)));
        sides.sort_unstable();
    }
}

fn zeros(count: usize) -> Vec<AtomicU32> {
    (0..count).into_par_iter().map(|_| AtomicU32::new(0)).collect()
}

/// Calls `visit` with the lower vertex of each side, and the side as [`Bins`] keep it.
fn each_side(triangles: &[[u32; 3]], visit: impl Fn(u32, u64) + Sync) {
    triangles.par_iter().for_each(|[a, b, c]| {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            visit(*from.min(to), 2 * u64::from(*from.max(to)) + u64::from(to < from));
        }
    });
}
