//! Where the triangles are: they enclose the inside, and do not cross each other.

use std::collections::BTreeSet;

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

/// The interpolant at a point of the unit cell.
fn interpolant(values: &[f64; 8], at: Point) -> f64 {
    let weight = |c: usize, k: usize| if c >> k & 1 == 1 { at[k] } else { 1.0 - at[k] };
    let term = |c: usize| (0..3).map(|k| weight(c, k)).product::<f64>() * values[c];
    (0..8).map(term).sum()
}

/// The mean of the vertices around each vertex inside a cell.
fn centroids(values: &[f64; 8]) -> Vec<Point> {
    let found = triangulate(values);
    let around = |k: u8| {
        let fan = found
            .triangles()
            .iter()
            .filter(move |triangle| triangle.contains(&(12 + k)));
        let rim: BTreeSet<u8> = fan.flatten().copied().filter(|&v| v < 12).collect();
        let sum = rim.iter().map(|&v| crossing(values, v as usize));
        let sum = sum.fold([0.0; 3], |sum, p| [0, 1, 2].map(|axis| sum[axis] + p[axis]));
        sum.map(|x| x / rim.len() as f64)
    };
    (0..found.interior().len() as u8).map(around).collect()
}

/// The centre of a disc is no farther from the level set than the middle of its rim, where Newton's steps begin.
///
/// The rim's vertices are summed in another order here, which moves the middle by rounding: 12 additions of numbers below 1 by
/// less than 2⁻⁴⁶, and the interpolant, whose slope is below twice the largest value, by less than 2⁻⁴⁵ of that.
#[test]
fn centers_of_discs_are_near_the_level_set() {
    let mut random = Random(22);
    for _ in 0..10_000 {
        let cell = hard(&mut random).map(|v| v as f64);
        let size = cell.iter().fold(0.0, |size: f64, v| size.max(v.abs()));
        let found = triangulate(&cell);
        if let &[center] = found.interior() {
            let [at_center, at_middle] = [center, centroids(&cell)[0]].map(|p| interpolant(&cell, p).abs());
            assert!(
                at_center <= at_middle + size * 2.0_f64.powi(-45),
                "{cell:?}: {center:?}"
            );
        }
    }
}

/// The sides that join a tube's two halves lie on lines of the level set along the axes.
///
/// On the section across z through such a line's end the interpolant's saddle is the decider over the sum of the corners' sizes.
/// The decider is a difference of products of values, zero up to a few dozen roundings of 2⁻⁵³; 2⁻⁴⁴ allows for 500.
#[test]
fn the_waist_of_a_tube_lies_on_the_level_set() {
    let mut random = Random(23);
    let mut tubes = 0;
    for _ in 0..10_000 {
        let cell = hard(&mut random).map(|v| v as f64);
        let size = cell.iter().fold(0.0, |size: f64, v| size.max(v.abs()));
        let found = triangulate(&cell);
        let sides = found.triangles().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let waist = sides.filter(|&[a, b]| (12..15).contains(&a) && b >= 15);
        let waist: BTreeSet<_> = waist.map(|side| side.map(|v| v as usize - 12)).collect();
        for [p, q] in waist.iter().map(|side| side.map(|k| found.interior()[k])) {
            assert!(
                (0..3).filter(|&axis| p[axis] == q[axis]).count() >= 2,
                "{cell:?}: {p:?} {q:?}"
            );
            for at in [p, q] {
                let column = |k: usize| cell[k] + (cell[k + 4] - cell[k]) * at[2];
                let sum: f64 = (0..4).map(|k| column(k).abs()).sum();
                let off = interpolant(&cell, at).abs() * sum / (size * size);
                assert!(off <= 2.0_f64.powi(-44), "{cell:?}: {off} at {at:?}");
            }
        }
        tubes += usize::from(waist.len() == 6);
        assert!([0, 6].contains(&waist.len()), "{cell:?}");
    }
    assert!(tubes > 200, "{tubes} tubes");
}
