//! The 6561 ways a surface can pass through a cell some of whose corners have the isovalue.
//!
//! *Theory.* A corner is outside, or inside, or the surface goes through it. So a way is a number of eight digits to the base
//! of three. Its triangles are those of the case of the corners inside, but where an edge ends on a corner that the surface
//! goes through the vertex is that corner's. A triangle of which two corners became one is left out, as vtkMarchingCubes does.
//! *Practice.* A table has the triangles of all ways, so that such cells cost little more than others.

use super::cases::{CASES, Case, MAX_TRIANGLES};
use super::cell::edge_corners;
use super::numbering::SLOTS;

/// How many ways there are.
const WAYS: usize = 3_usize.pow(8);

/// The number whose digits to the base of three are the index's to the base of two.
static TO_BASE_3: [u16; 256] = {
    let mut numbers = [0; 256];
    let mut n = 1;
    while n < 256 {
        numbers[n] = 3 * numbers[n / 2] + n as u16 % 2;
        n += 1;
    }
    numbers
};

/// The way with the corners `inside`, of which the surface goes through those `on`.
#[inline(always)]
pub(super) fn way(inside: usize, on: usize) -> usize {
    usize::from(TO_BASE_3[inside % 256] + TO_BASE_3[on % 256])
}

/// The triangles of each way, with the slots of their vertices in place of edges.
pub(super) static TIED_CASES: [Case; WAYS] = {
    let none = Case {
        count: 0,
        triangles: [[0; 3]; MAX_TRIANGLES],
    };
    let mut cases = [none; WAYS];
    let mut way = 0;
    while way < WAYS {
        cases[way] = tied_case(way);
        way += 1;
    }
    cases
};

/// How many triangles each way has.
pub(super) static COUNTS: [u8; WAYS] = {
    let mut counts = [0; WAYS];
    let mut way = 0;
    while way < WAYS {
        counts[way] = TIED_CASES[way].count;
        way += 1;
    }
    counts
};

const fn tied_case(way: usize) -> Case {
    let [inside, on] = corners(way);
    let case = &CASES[inside];
    let mut tied = Case {
        count: 0,
        triangles: [[0; 3]; MAX_TRIANGLES],
    };
    let mut n = 0;
    while n < case.count as usize {
        let [a, b, c] = case.triangles[n];
        let [a, b, c] = [place(a, on), place(b, on), place(c, on)];
        if a != b && b != c && c != a {
            tied.triangles[tied.count as usize] = [SLOTS[a as usize], SLOTS[b as usize], SLOTS[c as usize]];
            tied.count += 1;
        }
        n += 1;
    }
    tied
}

/// The corners of a way that are inside, and those that the surface goes through.
const fn corners(way: usize) -> [usize; 2] {
    let [mut inside, mut on] = [0; 2];
    let (mut corner, mut rest) = (0, way);
    while corner < 8 {
        inside |= (rest % 3).div_ceil(2) << corner;
        on |= (rest % 3 / 2) << corner;
        rest /= 3;
        corner += 1;
    }
    [inside, on]
}

/// The place of the vertex on an edge, where the surface goes through the corners `on`.
const fn place(edge: u8, on: usize) -> u8 {
    let [a, b] = edge_corners(edge);
    if on >> a & 1 == 1 {
        12 + a
    } else if on >> b & 1 == 1 {
        12 + b
    } else {
        edge
    }
}

/// The triangles of a case, by place, where the surface goes through the corners `on`.
pub(super) fn triangles_through(case: &Case, on: usize) -> impl Iterator<Item = [u8; 3]> {
    let triangles = case.triangles[..usize::from(case.count)].iter();
    triangles
        .map(move |edges| edges.map(|edge| place(edge, on)))
        .filter(|places| is_whole(*places))
}

/// Whether no two corners are one.
#[inline(always)]
pub(super) fn is_whole<V: PartialEq>([a, b, c]: [V; 3]) -> bool {
    a != b && b != c && c != a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_the_triangles_of_every_way() {
        let mut ways = 0;
        for inside in 0..256 {
            for on in (0..256).filter(|on| on & !inside == 0) {
                let tied = &TIED_CASES[way(inside, on)];
                let triangles = triangles_through(&CASES[inside], on);
                let expected: Vec<[u8; 3]> = triangles.map(|t| t.map(|place| SLOTS[usize::from(place)])).collect();
                assert_eq!(
                    tied.triangles[..usize::from(tied.count)],
                    expected,
                    "{inside:b}, {on:b}"
                );
                assert_eq!(
                    usize::from(COUNTS[way(inside, on)]),
                    expected.len(),
                    "{inside:b}, {on:b}"
                );
                ways += 1;
            }
        }
        assert_eq!(ways, WAYS);
    }
}
