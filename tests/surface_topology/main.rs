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

fn one_cell(cell: [f64; 8]) -> Field {
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

/// Compares a cell with the truth; `None` if that is not resolved.
fn compare(cell: &[i64; 8]) -> Option<Shape> {
    let truth = Truth::of(cell)?;
    let values = floats(cell);
    let welded = Welded::extract(&one_cell(values));
    assert_eq!(welded.fault(), None, "{cell:?}");
    let shape = Shape { euler: truth.euler, components: truth.components };
    assert_eq!(welded.shape(), shape, "{cell:?}: {:?}", triangulate(&values).triangles());
    assert_eq!(renamed(components(&values)), renamed(truth.component_of_edge), "{cell:?}");
    Some(shape)
}

#[test]
fn random_cells() {
    let mut random = Random(1);
    let mut discarded = 0;
    for k in 0..10_000 {
        let cell = std::array::from_fn(|_| random.generic(k % 2 == 0));
        discarded += usize::from(compare(&cell).is_none());
    }
    println!("{discarded} of 10000 random cells discarded");
}

#[test]
fn hard_cells() {
    let mut random = Random(2);
    let mut discarded = 0;
    let mut tubes = 0;
    for _ in 0..10_000 {
        let cell = hard(&mut random);
        match compare(&cell) {
            Some(shape) => tubes += usize::from(shape.euler < shape.components as i64),
            None => discarded += 1,
        }
    }
    println!("{discarded} of 10000 hard cells discarded, {tubes} tubes");
}
