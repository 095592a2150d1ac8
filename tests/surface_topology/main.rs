//! The topologically correct marching cubes is a manifold, and has the topology of the trilinear interpolant.

mod fields;
mod truth;
mod weld;

use fields::{Random, hard, orient};
use truth::Truth;
use vcsg::surface::trilinear::triangulate;
use weld::{Field, Groups, Shape, Welded, lower_corner};

fn floats<const N: usize>(cell: &[i64; N]) -> [f64; N] {
    cell.map(|v| v as f64)
}

fn one_cell(cell: &[f64; 8]) -> Field {
    Field { n: 2, values: cell.to_vec() }
}

/// The components of a cell's triangles, by the edges that they cross.
fn components(cell: &[f64; 8]) -> [Option<usize>; 12] {
    let found = triangulate(cell);
    let mut groups = Groups::new(12 + found.interior().len());
    for &[a, b, c] in found.triangles() {
        groups.join(a as usize, b as usize);
        groups.join(b as usize, c as usize);
    }
    let used = |edge: usize| found.triangles().iter().flatten().any(|&v| v as usize == edge);
    std::array::from_fn(|edge| used(edge).then(|| groups.root(edge)))
}

/// Names in the order of first appearance, to compare partitions.
fn renamed(names: [Option<usize>; 12]) -> [Option<usize>; 12] {
    names.map(|name| name.map(|_| names.iter().position(|&other| other == name).unwrap_or(12)))
}

/// Compares a cell with the truth of the same cell in whole numbers; `None` if that is not resolved.
fn compare(values: &[f64; 8], exact: &[i64; 8]) -> Option<Shape> {
    let truth = Truth::of(exact)?;
    let welded = Welded::extract(&one_cell(values));
    assert_eq!(welded.fault(), None, "{values:?}");
    let shape = Shape { euler: truth.euler, components: truth.components };
    assert_eq!(welded.shape(), shape, "{values:?}: {:?}", triangulate(values).triangles());
    assert_eq!(renamed(components(values)), renamed(truth.component_of_edge), "{values:?}");
    Some(shape)
}

/// Compares cells from a source; returns how many are not resolved and how many have a tunnel.
fn compare_all(n: usize, mut cell: impl FnMut() -> ([f64; 8], [i64; 8])) -> [usize; 2] {
    let mut counts = [0; 2];
    for _ in 0..n {
        let (values, exact) = cell();
        match compare(&values, &exact) {
            Some(shape) => counts[1] += usize::from(shape.euler < shape.components as i64),
            None => counts[0] += 1,
        }
    }
    counts
}

fn exactly(cell: [i64; 8]) -> ([f64; 8], [i64; 8]) {
    (floats(&cell), cell)
}

#[test]
fn random_cells_have_the_interpolants_topology() {
    let mut random = Random(1);
    let counts = compare_all(10_000, || {
        let logarithmic = random.below(2) == 1;
        exactly(std::array::from_fn(|_| random.generic(logarithmic)))
    });
    println!("{counts:?}");
    assert_eq!(counts, [0, 0]);
}

#[test]
fn hard_cells_have_the_interpolants_topology() {
    let mut random = Random(2);
    let counts = compare_all(10_000, || exactly(hard(&mut random)));
    println!("{counts:?}");
    assert_eq!(counts, [0, 0]);
}

#[test]
fn tied_cells_have_the_topology_of_a_slightly_larger_field() {
    let mut random = Random(3);
    let counts = compare_all(10_000, || {
        let cell: [i64; 8] = std::array::from_fn(|_| random.small());
        (floats(&cell), cell.map(|v| (v << 16) + 1))
    });
    println!("{counts:?}");
    assert_eq!(counts, [0, 0]);
}
