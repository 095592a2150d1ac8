//! What triangles connect by shared vertices.
//!
//! *Practice.* Union–find on all threads at once: a root is only ever put below a lower one, and only if it still is a root
//! (Jayanti and Tarjan 2016, *A randomized concurrent algorithm for disjoint set union*, with the vertices' own order in the
//! place of a random one). In the end every component's root is its lowest vertex, whatever the threads did.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};

use rayon::prelude::*;

/// The connected components of triangles.
pub(super) struct Components {
    /// For each vertex the lowest of its component.
    pub root: Vec<u32>,
    /// For each vertex whether a triangle has it.
    pub is_used: Vec<bool>,
}

impl Components {
    /// Those of `triangles` of so many `vertices`.
    pub fn of(triangles: &[[u32; 3]], vertices: usize) -> Self {
        let forest = Forest::new(vertices);
        triangles.par_iter().for_each(|t| forest.join(*t));
        let root = |v: usize| forest.root(v as u32);
        Self {
            root: (0..vertices).into_par_iter().map(root).collect(),
            is_used: forest.is_used.into_par_iter().map(AtomicBool::into_inner).collect(),
        }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        let is_root = |v: &usize| self.is_used[*v] && self.root[*v] as usize == *v;
        (0..self.root.len()).into_par_iter().filter(is_root).count()
    }
}

struct Forest {
    /// A lower vertex of the same component, or the vertex itself.
    parent: Vec<AtomicU32>,
    is_used: Vec<AtomicBool>,
}

impl Forest {
    fn new(vertices: usize) -> Self {
        Self {
            parent: (0..vertices)
                .into_par_iter()
                .map(|v| AtomicU32::new(v as u32))
                .collect(),
            is_used: (0..vertices).into_par_iter().map(|_| AtomicBool::new(false)).collect(),
        }
    }

    fn join(&self, triangle: [u32; 3]) {
        let [a, b, c] = triangle;
        for v in triangle {
            self.is_used[v as usize].store(true, Relaxed);
        }
        self.unite(a, b);
        self.unite(b, c);
    }

    fn unite(&self, a: u32, b: u32) {
        loop {
            let (a, b) = (self.root(a), self.root(b));
            let (low, high) = (a.min(b), a.max(b));
            let link = || self.parent[high as usize].compare_exchange(high, low, Relaxed, Relaxed);
            if low == high || link().is_ok() {
                return;
            }
        }
    }

    /// Halves the path on the way. What it stores is an ancestor even if another thread has stored a closer one meanwhile.
    fn root(&self, mut v: u32) -> u32 {
        loop {
            let parent = self.parent[v as usize].load(Relaxed);
            if parent == v {
                return v;
            }
            let next = self.parent[parent as usize].load(Relaxed);
            self.parent[v as usize].store(next, Relaxed);
            v = next;
        }
    }
}
