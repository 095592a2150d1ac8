//! The 256 ways a surface can pass through a cell (LC87 §4, figures 3 and 4).
//!
//! *Theory.* A cell's corners are inside or not, which makes 256 cases. Turning the cell, and exchanging inside and outside,
//! carry a few patterns into all of them.
//! *Changes from the paper.* Its 14 patterns and their complements do not fit together: two cells may part a face with two
//! inside corners on a diagonal in different ways, and leave a hole. Here such corners are always parted from each other, as
//! VTK does; so a pattern with such a face is turned but not complemented, and there are 17.
//! *Practice.* Corners and edges are numbered as in [`cell`](super::cell). A corner is inside where its value is not below the
//! isovalue.

use super::cell::{edge_between, edge_corners};

/// The triangles of one case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Case {
    /// How many there are, at most [`MAX_TRIANGLES`].
    pub count: u8,
    /// The cell edges that the vertices lie on, counterclockwise seen from outside; zeros beyond `count`.
    pub triangles: [[u8; 3]; MAX_TRIANGLES],
}

/// The most triangles of a case.
pub(super) const MAX_TRIANGLES: usize = 5;

/// The triangles of each case; bit `c` of the index says that corner `c` is inside.
pub(super) static CASES: [Case; 256] = all_cases();

/// Triangles of one case, from which turning, and complementing where no face is ambiguous, makes those of others.
struct Pattern {
    inside: u8,
    complemented: bool,
    triangles: &'static [[u8; 3]],
}

const PATTERNS: [Pattern; 17] = {
    const fn both(inside: u8, triangles: &'static [[u8; 3]]) -> Pattern {
        Pattern {
            inside,
            complemented: true,
            triangles,
        }
    }
    const fn turned(inside: u8, triangles: &'static [[u8; 3]]) -> Pattern {
        Pattern {
            inside,
            complemented: false,
            triangles,
        }
    }
    [
        both(1, &[[0, 4, 8]]),
        both(3, &[[4, 8, 5], [5, 8, 9]]),
        turned(6, &[[0, 9, 5], [1, 10, 4]]),
        both(7, &[[1, 10, 5], [5, 10, 9], [8, 9, 10]]),
        both(15, &[[8, 9, 11], [8, 11, 10]]),
        turned(22, &[[0, 9, 5], [1, 10, 4], [2, 8, 6]]),
        both(23, &[[1, 9, 5], [1, 10, 9], [2, 9, 10], [2, 10, 6]]),
        both(24, &[[1, 5, 11], [2, 8, 6]]),
        turned(25, &[[0, 4, 2], [1, 5, 11], [2, 4, 6]]),
        both(92, &[[2, 8, 3], [3, 5, 11], [3, 8, 5], [4, 5, 8]]),
        both(58, &[[0, 8, 1], [1, 7, 11], [1, 8, 7], [6, 7, 8]]),
        turned(30, &[[0, 9, 10], [0, 10, 4], [2, 8, 6], [9, 11, 10]]),
        turned(153, &[[0, 4, 2], [1, 5, 7], [1, 7, 3], [2, 4, 6]]),
        turned(61, &[[0, 5, 11], [0, 6, 7], [0, 7, 9], [0, 10, 6], [0, 11, 10]]),
        turned(105, &[[0, 4, 8], [1, 5, 11], [2, 7, 9], [3, 6, 10]]),
        turned(107, &[[1, 4, 7], [1, 7, 11], [2, 4, 8], [2, 7, 4], [3, 6, 10]]),
        turned(123, &[[1, 4, 11], [3, 4, 10], [3, 7, 4], [4, 7, 11]]),
    ]
};

/// A symmetric pattern comes into a case by several turns, which may cut its polygons along other diagonals. The first is
/// taken, in the order of [`all_cases`], except in these cases, where VTK has the one after so many.
const PASSED_OVER: [(usize, u8); 16] = [
    (46, 2),
    (77, 4),
    (85, 2),
    (109, 1),
    (111, 1),
    (113, 2),
    (116, 2),
    (139, 2),
    (142, 2),
    (165, 2),
    (170, 2),
    (178, 4),
    (209, 2),
    (222, 1),
    (233, 1),
    (235, 1),
];

const fn all_cases() -> [Case; 256] {
    let none = Case {
        count: 0,
        triangles: [[0; 3]; MAX_TRIANGLES],
    };
    let mut cases = [none; 256];
    let mut left = passed_over();
    let mut p = 0;
    while p < PATTERNS.len() {
        let mut flips = 0;
        while flips < 8 {
            let mut order = 0;
            while order < 6 {
                let turn = Turn {
                    axes: AXIS_ORDERS[order],
                    flips,
                };
                if turn.is_rotation() {
                    turn.carry(&PATTERNS[p], &mut cases, &mut left);
                }
                order += 1;
            }
            flips += 1;
        }
        p += 1;
    }
    cases
}

const fn passed_over() -> [u8; 256] {
    let mut left = [0; 256];
    let mut n = 0;
    while n < PASSED_OVER.len() {
        left[PASSED_OVER[n].0] = PASSED_OVER[n].1;
        n += 1;
    }
    left
}

const AXIS_ORDERS: [[u8; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];

/// A symmetry of the cell: axis `a` of the image is axis `axes[a]`, reversed where bit `a` of `flips` is set.
#[derive(Clone, Copy)]
struct Turn {
    axes: [u8; 3],
    flips: u8,
}

impl Turn {
    /// Whether it is no reflection: exchanges of axes and reversals together are even.
    const fn is_rotation(self) -> bool {
        let [x, y, z] = self.axes;
        let exchanges = (x > y) as u32 + (x > z) as u32 + (y > z) as u32;
        (exchanges + self.flips.count_ones()).is_multiple_of(2)
    }

    const fn corner(self, c: u8) -> u8 {
        let [x, y, z] = self.axes;
        ((c >> x & 1) | (c >> y & 1) << 1 | (c >> z & 1) << 2) ^ self.flips
    }

    const fn case(self, inside: u8) -> u8 {
        let (mut image, mut c) = (0, 0);
        while c < 8 {
            image |= (inside >> c & 1) << self.corner(c);
            c += 1;
        }
        image
    }

    const fn edge(self, e: u8) -> u8 {
        let [a, b] = edge_corners(e);
        edge_between(self.corner(a), self.corner(b))
    }

    /// Writes the image of `pattern`, and its complement's, to cases that have none yet.
    const fn carry(self, pattern: &Pattern, cases: &mut [Case; 256], left: &mut [u8; 256]) {
        let case = self.case(pattern.inside) as usize;
        self.place(pattern, [0, 1, 2], &mut cases[case], &mut left[case]);
        if pattern.complemented {
            self.place(pattern, [0, 2, 1], &mut cases[255 - case], &mut left[255 - case]);
        }
    }

    const fn place(self, pattern: &Pattern, winding: [usize; 3], case: &mut Case, left: &mut u8) {
        if case.count > 0 {
            return;
        }
        if *left > 0 {
            *left -= 1;
            return;
        }
        while (case.count as usize) < pattern.triangles.len() {
            let n = case.count as usize;
            let from = pattern.triangles[n];
            let mut v = 0;
            while v < 3 {
                case.triangles[n][v] = self.edge(from[winding[v]]);
                v += 1;
            }
            case.count += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// The border of the cell's surface, found on the faces alone: from edge to edge, the surface on the left seen from
    /// lower values. Each face is walked round, counterclockwise seen from outside; where the walk leaves the inside a
    /// segment ends, which starts where it came in last, so that every inside corner, or row of them, is cut off by itself.
    fn contour(case: usize) -> BTreeMap<u8, u8> {
        let inside = |c: u8| case >> c & 1 == 1;
        let mut segments = BTreeMap::new();
        for (axis, upper) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)] {
            let face = face_corners(axis, upper);
            let sides: Vec<[u8; 2]> = (0..4).map(|n| [face[n], face[(n + 1) % 4]]).collect();
            let leaves = |[a, b]: [u8; 2]| inside(a) && !inside(b);
            let enters = |[a, b]: [u8; 2]| !inside(a) && inside(b);
            for n in (0..4).filter(|&n| leaves(sides[n])) {
                let back = (1..4).map(|d| (n + 4 - d) % 4).find(|&m| enters(sides[m]));
                let [from, to] =
                    [sides[back.expect("the walk came in somewhere")], sides[n]].map(|[a, b]| edge_between(a, b));
                assert_eq!(
                    segments.insert(from, to),
                    None,
                    "case {case}: two segments leave edge {from}"
                );
            }
        }
        segments
    }

    /// The corners of a face in their order, counterclockwise seen from outside the cell.
    fn face_corners(axis: u8, upper: u8) -> [u8; 4] {
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        let base = upper << axis;
        let round = [base, base | u, base | u | v, base | v];
        if upper == 1 {
            round
        } else {
            [round[0], round[3], round[2], round[1]]
        }
    }

    #[test]
    fn each_case_fills_the_contour_that_the_faces_have() {
        for (n, case) in CASES.iter().enumerate() {
            let triangles = &case.triangles[..usize::from(case.count)];
            let mut open: Vec<(u8, u8)> = Vec::new();
            for side in triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]) {
                match open.iter().position(|&other| other == (side.1, side.0)) {
                    Some(twin) => drop(open.swap_remove(twin)),
                    None => open.push(side),
                }
            }
            let border: BTreeMap<u8, u8> = open.iter().copied().collect();
            assert_eq!(border.len(), open.len(), "case {n}: {open:?}");
            assert_eq!(border, contour(n), "case {n}: {triangles:?}");
            // Triangles that fill a polygon of n sides without inner vertices are n - 2.
            assert_eq!(
                triangles.len(),
                border.len() - 2 * loops(&border),
                "case {n}: {triangles:?}"
            );
        }
    }

    fn loops(border: &BTreeMap<u8, u8>) -> usize {
        let mut left = border.clone();
        let mut count = 0;
        while let Some((start, mut at)) = left.pop_first() {
            while at != start {
                at = left.remove(&at).expect("a closed polygon");
            }
            count += 1;
        }
        count
    }

    #[test]
    fn vertices_lie_on_edges_that_cross() {
        for (n, case) in CASES.iter().enumerate() {
            let used = case.triangles[..usize::from(case.count)].iter().flatten();
            let used = used.fold(0_u16, |set, e| set | 1 << e);
            let crosses = |e: u8| {
                let [a, b] = edge_corners(e);
                (n >> a ^ n >> b) & 1 == 1
            };
            let expected = (0..12).filter(|&e| crosses(e)).fold(0_u16, |set, e| set | 1 << e);
            assert_eq!(used, expected, "case {n}");
        }
    }
}
