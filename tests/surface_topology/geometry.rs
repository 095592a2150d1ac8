//! Where the triangles are: they enclose the inside, and do not cross each other.

use vcsg::surface::trilinear::triangulate;

use crate::fields::{Random, hard};
use crate::weld::{Field, lower_corner};

type Point = [f64; 3];

fn minus(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| a[k] - b[k])
}

/// Six times the signed volume of a tetrahedron.
fn volume(a: Point, b: Point, c: Point, d: Point) -> f64 {
    let [u, v, w] = [b, c, d].map(|p| minus(p, a));
    let cross = [
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    ];
    (0..3).map(|k| cross[k] * w[k]).sum()
}

/// The triangles' corners, in the unit cell.
fn placed(values: &[f64; 8]) -> Vec<[Point; 3]> {
    let found = triangulate(values);
    let place = |v: u8| match (v as usize).checked_sub(12) {
        Some(k) => found.interior()[k],
        None => crossing(values, v as usize),
    };
    found.triangles().iter().map(|triangle| triangle.map(place)).collect()
}

fn crossing(values: &[f64; 8], edge: usize) -> Point {
    let (axis, lower) = (edge / 4, lower_corner(edge));
    let [a, b] = [lower, lower | 1 << axis].map(|c| values[c]);
    let mut at = [0, 1, 2].map(|k| (lower >> k & 1) as f64);
    at[axis] = a / (a - b);
    at
}

/// The volume within a closed surface whose triangles are counterclockwise from outside.
pub fn enclosed_volume(field: &Field<f64>) -> f64 {
    let of_cell = |cell: [usize; 3]| -> f64 {
        let triangles = placed(&field.corners(cell)).into_iter();
        let moved = triangles.map(|triangle| triangle.map(|p| [0, 1, 2].map(|k| p[k] + cell[k] as f64)));
        moved.map(|[a, b, c]| volume([0.0; 3], a, b, c) / 6.0).sum()
    };
    field.cells().map(of_cell).sum()
}

/// Whether a segment certainly passes through a triangle.
///
/// The products and sums behind a volume of points in the unit cell are below 6 in size and fewer than 32, so that rounding
/// changes it by less than 6 · 32 · 2⁻⁵³ < 3e-14.
fn pierces([p, q]: [Point; 2], [a, b, c]: [Point; 3]) -> bool {
    const ROUNDING: f64 = 3e-14;
    let apart = |x: f64, y: f64| x.min(y) < -ROUNDING && x.max(y) > ROUNDING;
    let around = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)];
    let on_one_side = around.iter().all(|&v| v > ROUNDING) || around.iter().all(|&v| v < -ROUNDING);
    on_one_side && apart(volume(a, b, c, p), volume(a, b, c, q))
}

#[test]
fn triangles_of_a_cell_do_not_cross() {
    let mut random = Random(21);
    for _ in 0..10_000 {
        let cell = hard(&mut random).map(|v| v as f64);
        let triangles = placed(&cell);
        for [a, b, c] in &triangles {
            for side in [[a, b], [b, c], [c, a]] {
                let mut others = triangles.iter().filter(|other| !side.iter().any(|p| other.contains(p)));
                assert!(!others.any(|&other| pierces(side.map(|&p| p), other)), "{cell:?}");
            }
        }
    }
}
