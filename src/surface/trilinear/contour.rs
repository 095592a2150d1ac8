//! The closed contours in which the level set meets the faces of a cell.

use super::interpolant::is_inside;
use crate::surface::cell::{FACE_EDGES, FACES};

/// In the place of an edge that the surface does not cross.
pub(super) const NONE: u8 = u8::MAX;

/// The contours of a cell as successors: from the vertex on each edge, where the contour goes and through which face.
///
/// They run so that the inside is on their right, seen from outside the cell; the surface is then on their left, seen from the
/// side of lower values.
pub(super) struct Contours {
    /// The edge after each edge, or [`NONE`].
    pub next: [u8; 12],
    /// The face in which the contour leaves each edge's vertex.
    pub face: [u8; 12],
    /// The contour on which each edge's vertex lies, or [`NONE`].
    pub label: [u8; 12],
    /// Any edge of each contour; the first `count` count. Each contour takes at least three of the twelve edges.
    first: [u8; 4],
    count: usize,
}

impl Contours {
    /// The contours of the interpolant of eight values.
    pub fn trace(values: &[f64; 8]) -> Self {
        let mut contours = Self {
            next: [NONE; 12],
            face: [NONE; 12],
            label: [NONE; 12],
            first: [NONE; 4],
            count: 0,
        };
        (0..6).for_each(|face| contours.add_face(values, face));
        (0..12).for_each(|edge| contours.name_from(edge));
        contours
    }

    /// One edge of each contour.
    pub fn firsts(&self) -> &[u8] {
        &self.first[..self.count]
    }

    /// The edges of a contour in order, from `first` on.
    pub fn walk(&self, first: u8) -> impl Iterator<Item = u8> {
        let mut at = Some(first);
        std::iter::from_fn(move || {
            let edge = at?;
            at = Some(self.next[edge as usize]).filter(|&next| next != first);
            Some(edge)
        })
    }

    /// Adds the segments on a face: each goes from where the walk around the face enters the inside to where it leaves it, either
    /// after the same run of inside corners or, where the inside is joined across the face, before it.
    fn add_face(&mut self, values: &[f64; 8], face: u8) {
        let around = FACES[face as usize].map(|c| values[c as usize]);
        let edges = FACE_EDGES[face as usize];
        let inside = around.map(is_inside);
        let step = if alternate(inside) && joins(around) { 3 } else { 1 };
        let leaves = |k: &usize| inside[*k] && !inside[(*k + 1) % 4];
        for entry in (0..4).filter(|&k| !inside[k] && inside[(k + 1) % 4]) {
            let exit = (1..4).map(|n| (entry + n * step) % 4).find(leaves);
            let exit = exit.expect("a closed walk that enters the inside leaves it");
            self.next[edges[entry] as usize] = edges[exit];
            self.face[edges[entry] as usize] = face;
        }
    }

    fn name_from(&mut self, edge: u8) {
        if self.next[edge as usize] == NONE || self.label[edge as usize] != NONE {
            return;
        }
        let mut at = edge;
        while self.label[at as usize] == NONE {
            self.label[at as usize] = self.count as u8;
            at = self.next[at as usize];
        }
        self.first[self.count] = edge;
        self.count += 1;
    }
}

/// Whether signs alternate around a quadrilateral, so that they do not tell how its contour runs.
pub(super) fn alternate([a, b, c, d]: [bool; 4]) -> bool {
    a == c && b == d && a != b
}

/// The asymptotic decider: whether the two inside corners are joined across a quadrilateral with alternating signs.
///
/// The bilinear interpolant's saddle has the sign of the product of the inside corners less that of the outside corners. Products
/// commute bit for bit, so that the two cells at a face decide alike; equal products join the inside, as they would if all values
/// were a little larger.
pub(super) fn joins(around: [f64; 4]) -> bool {
    let (even, odd) = (around[0] * around[2], around[1] * around[3]);
    if is_inside(around[0]) { even >= odd } else { odd >= even }
}
