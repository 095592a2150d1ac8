//! Lattices of several cells: across their faces, too, the surface is a manifold of the interpolant's topology.

use crate::fields::{Random, orient};
use crate::geometry::enclosed_volume;
use crate::truth::Truth;
use crate::weld::{Field, Groups, Shape, Welded, lower_corner, moved};

/// The truth of all cells put together; `None` if one is not resolved.
///
/// In the sum over cells, the level set in a face between two cells is counted twice: arcs, half as many as there are crossed
/// edges around it. A crossing on an edge of two cells is on one such face and so counted half too often; one on an edge of four
/// cells is on four, which takes two away, and must itself be counted once: it is counted once too often.
fn truth(n: usize, values: &[i64]) -> Option<Shape> {
    let field = Field {
        n,
        values: values.to_vec(),
    };
    let mut groups = Groups::new(3 * n * n * n);
    let mut cells_at_edge = vec![0_u32; 3 * n * n * n];
    let mut euler = 0;
    for cell in field.cells() {
        let truth = Truth::of(&field.corners(cell))?;
        euler += truth.shape.euler;
        let names = truth.component_of_edge;
        let id = |edge: usize| edge / 4 + 3 * field.index(moved(cell, lower_corner(edge)));
        for edge in (0..12).filter(|&edge| names[edge].is_some()) {
            cells_at_edge[id(edge)] += 1;
            let same = (0..edge).find(|&other| names[other] == names[edge]);
            same.into_iter().for_each(|other| groups.join(id(edge), id(other)));
        }
    }
    let crossed: Vec<_> = (0..cells_at_edge.len()).filter(|&id| cells_at_edge[id] > 0).collect();
    let halves: u32 = crossed.iter().map(|&id| cells_at_edge[id].trailing_zeros()).sum();
    let components = crossed.iter().filter(|&&id| groups.root(id) == id).count();
    Some(Shape {
        euler: euler - i64::from(halves / 2),
        components,
    })
}

/// Welds 10,000 lattices of 4 × 4 × 4 samples and compares the first of them with the truth of the samples that `exact` makes of
/// them; returns how many of these are not resolved.
fn compare(mut sample: impl FnMut() -> i64, exact: fn(i64) -> i64, compared: usize) -> usize {
    let mut discarded = 0;
    for k in 0..10_000 {
        let values: Vec<_> = (0..64).map(|_| sample()).collect();
        let field = Field {
            n: 4,
            values: values.iter().map(|&v| v as f64).collect(),
        };
        let welded = Welded::extract(&field);
        assert_eq!(welded.fault(), None, "{values:?}");
        if k < compared {
            let exact: Vec<_> = values.iter().map(|&v| exact(v)).collect();
            match truth(4, &exact) {
                Some(shape) => assert_eq!(welded.shape(), shape, "{values:?}"),
                None => discarded += 1,
            }
        }
    }
    discarded
}

#[test]
fn random_lattices_have_the_interpolants_topology() {
    let mut random = Random(11);
    let discarded = compare(|| random.generic(false), |v| v, 10_000);
    assert_eq!(discarded, 0);
}

/// As with single cells, 2⁻¹⁶ stands for zero.
#[test]
fn tied_lattices_have_the_topology_of_a_slightly_larger_field() {
    let mut random = Random(12);
    let discarded = compare(|| random.small(), |v| (v << 16) + 1, 2_000);
    assert_eq!(discarded, 0);
}

/// Around the inner cell all samples are outside.
#[test]
fn all_cases_within_a_lattice_are_closed() {
    let mut random = Random(13);
    for (signs, orientation) in (0..256).flat_map(|signs| (0..48).map(move |k| (signs, k))) {
        let cell: [f64; 8] = std::array::from_fn(|c| {
            let magnitude = random.magnitude(orientation % 2 == 0) as f64;
            if signs >> c & 1 == 1 { magnitude } else { -magnitude }
        });
        let cell = orient(&cell, orientation);
        let mut field = Field {
            n: 4,
            values: vec![-1e3; 64],
        };
        for (c, &value) in cell.iter().enumerate() {
            let at = field.index(moved([1; 3], c));
            field.values[at] = value;
        }
        let welded = Welded::extract(&field);
        assert_eq!(welded.fault(), None, "{cell:?}");
        assert!(welded.is_closed(), "{cell:?}");
        let volume = enclosed_volume(&field);
        assert!(volume > 0.0 || signs == 0, "{cell:?}: {volume}");
    }
}
