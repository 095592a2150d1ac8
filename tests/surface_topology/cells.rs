//! Single cells against the truth.

use vcsg::surface::trilinear::triangulate;

use crate::fields::{Random, hard, orient};
use crate::truth::Truth;
use crate::weld::{Field, Groups, Shape, Welded, faces_of};

/// The value of a tied cell's exact counterpart: the small number that stands for zero is 2⁻¹⁶.
fn raised(cell: [i64; 8]) -> [i64; 8] {
    cell.map(|v| (v << 16) + 1)
}

fn floats(cell: [i64; 8]) -> [f64; 8] {
    cell.map(|v| v as f64)
}

/// The components of a cell's triangles, by the edges that they cross.
fn components(cell: &[f64; 8]) -> [Option<usize>; 12] {
    let found = triangulate(cell);
    let mut groups = Groups::new(12 + found.interior().len());
    for &[a, b, c] in found.triangles() {
        groups.join(a as usize, b as usize);
        groups.join(b as usize, c as usize);
    }
    let is_used = |edge: usize| found.triangles().iter().flatten().any(|&v| v as usize == edge);
    std::array::from_fn(|edge| is_used(edge).then(|| groups.root(edge)))
}

/// Names in the order of first appearance, to compare partitions.
fn renamed(names: [Option<usize>; 12]) -> [Option<usize>; 12] {
    names.map(|name| name.and_then(|_| names.iter().position(|&other| other == name)))
}

/// A cell's surface as a lattice of one cell, found to be without fault.
fn welded(values: &[f64; 8]) -> Welded {
    let field = Field {
        n: 2,
        values: values.to_vec(),
    };
    let welded = Welded::extract(&field);
    assert_eq!(welded.fault(), None, "{values:?}");
    assert_eq!(chord_in_a_face(values), None, "{values:?}");
    welded
}

/// A triangle's side that connects two vertices of one face although it is used twice, so that it is no contour segment; every
/// triangle that lies in a face has one, for no contour of a face is closed.
fn chord_in_a_face(values: &[f64; 8]) -> Option<[u8; 2]> {
    let found = triangulate(values);
    let sides: Vec<_> = found
        .triangles()
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .collect();
    let is_chord = |&[a, b]: &[u8; 2]| a.max(b) < 12 && sides.contains(&[b, a]) && faces_of(a) & faces_of(b) != 0;
    sides.iter().copied().find(is_chord)
}

/// Compares a cell with the truth of the same cell in whole numbers; `None` if that is not resolved.
fn compare(values: &[f64; 8], exact: &[i64; 8]) -> Option<Shape> {
    let welded = welded(values);
    let truth = Truth::of(exact)?;
    assert_eq!(welded.shape(), truth.shape, "{values:?}: {:?}", triangulate(values));
    assert_eq!(
        renamed(components(values)),
        renamed(truth.component_of_edge),
        "{values:?}"
    );
    Some(truth.shape)
}

/// Compares cells and their exact counterparts; returns how many are not resolved and how many have a tunnel.
fn compare_all(cells: impl Iterator<Item = ([f64; 8], [i64; 8])>) -> [usize; 2] {
    let mut counts = [0; 2];
    for (values, exact) in cells {
        match compare(&values, &exact) {
            Some(shape) => counts[1] += usize::from(shape.euler < shape.components as i64),
            None => counts[0] += 1,
        }
    }
    counts
}

/// Discarded are 2 in 10,000: only those that the subdivision does not resolve.
#[test]
fn random_cells_have_the_interpolants_topology() {
    let mut random = Random(1);
    let cells = (0..10_000).map(|_| random.cell());
    let [discarded, tunnels] = compare_all(cells.map(|cell| (floats(cell), cell)));
    assert!(
        discarded <= 5 && tunnels > 50,
        "{discarded} discarded, {tunnels} tunnels"
    );
}

/// Discarded are 5 in 10,000.
#[test]
fn hard_cells_have_the_interpolants_topology() {
    let mut random = Random(2);
    let cells = (0..10_000).map(|_| hard(&mut random));
    let [discarded, tunnels] = compare_all(cells.map(|cell| (floats(cell), cell)));
    assert!(
        discarded <= 10 && tunnels > 200,
        "{discarded} discarded, {tunnels} tunnels"
    );
}

/// In whole numbers from -3 to 3 all that is not a tie is far from one for 2⁻¹⁶: adding that changes a face's decider, a whole
/// number, by at most 12 · 2⁻¹⁶, and the decisive section's, which is whole times 4 · 72, the most of its quadratic's leading
/// coefficient, by as much. The tunnels that open at ties are wider than the subdivision's smallest parts: none is discarded.
#[test]
fn tied_cells_have_the_topology_of_a_slightly_larger_field() {
    let mut random = Random(3);
    let signs_and_zero = (0..3i64.pow(8)).map(|k| std::array::from_fn(|c| k / 3i64.pow(c as u32) % 3 - 1));
    let small = (0..10_000).map(|_| std::array::from_fn(|_| random.small()));
    let cells = signs_and_zero.chain(small);
    let [discarded, tunnels] = compare_all(cells.map(|cell| (floats(cell), raised(cell))));
    assert!(
        discarded == 0 && tunnels > 100,
        "{discarded} discarded, {tunnels} tunnels"
    );
}

/// With ties, and with magnitudes of one and of many sizes.
#[test]
fn all_cases_in_all_orientations_are_alike() {
    let mut random = Random(4);
    for (signs, kind) in (0..256).flat_map(|signs| (0..4).map(move |kind| (signs, kind))) {
        let cell: [i64; 8] = std::array::from_fn(|c| {
            let magnitude = if kind == 0 { 1 } else { random.magnitude(kind > 1) };
            if signs >> c & 1 == 1 { magnitude } else { -magnitude }
        });
        let shape = welded(&floats(cell)).shape();
        for orientation in 1..48 {
            let turned = floats(orient(&cell, orientation));
            assert_eq!(welded(&turned).shape(), shape, "orientation {orientation} of {cell:?}");
        }
    }
}

#[test]
fn values_out_of_range_are_manifold() {
    const EXTREMES: [f64; 12] = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::MAX,
        f64::MIN,
        f64::MIN_POSITIVE,
        -f64::MIN_POSITIVE,
        5e-324,
        -5e-324,
        -0.0,
        1e-200,
        -1e200,
    ];
    let mut random = Random(5);
    for _ in 0..10_000 {
        welded(&std::array::from_fn(|_| EXTREMES[random.below(12) as usize]));
    }
}

/// Sevenths, tenths and the like, some moved by one unit in the last place: rounding decides.
#[test]
fn blurred_ties_are_manifold() {
    let mut random = Random(6);
    for k in 0..20_000 {
        let unit = [0.1, 1.0 / 3.0, 1.0 / 7.0][k % 3];
        welded(&std::array::from_fn(|_| {
            let tied = random.small() as f64 * unit;
            [tied, tied.next_up(), tied.next_down()][random.below(3) as usize]
        }));
    }
}
