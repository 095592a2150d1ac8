//! Clipping a polygon by the cutter (LC87 §5.2; Sutherland and Hodgman).
//!
//! *Theory.* Walk round the polygon, keep the corners on one side, and add a vertex wherever the walk changes sides.
//! *Practice.* Each run of inside corners is closed by a line of its own, so that a polygon that the cutter enters twice falls
//! apart as a face of marching cubes does; what is outside stays in one piece. The closing lines, turned round, bound the cap.

use super::cell::{Cell, Node};

/// What a cutter makes of a polygon.
#[derive(Default)]
pub(super) struct Clipped {
    /// What is inside the cutter.
    pub inside: Vec<Vec<Node>>,
    /// What is outside it, at most one polygon.
    pub outside: Vec<Vec<Node>>,
    /// The cut: from where the walk comes in to where it goes out.
    pub cuts: Vec<[Node; 2]>,
}

/// Clips a polygon of a cell, whose sides the cutter's surface crosses once each at most.
pub(super) fn clip(cell: &Cell, polygon: &[Node]) -> Clipped {
    let n = polygon.len();
    let enters = |i: usize| !polygon[i].is_inside() && polygon[(i + 1) % n].is_inside();
    let mut clipped = Clipped::default();
    if polygon.iter().all(Node::is_inside) {
        clipped.inside.push(polygon.to_vec());
        return clipped;
    }
    let mut outside = Vec::with_capacity(n + 2);
    for i in (0..n).filter(|&i| !polygon[i].is_inside()) {
        outside.push(polygon[i]);
        if enters(i) {
            let run = run_from(cell, polygon, i);
            let cut = [run[0], run[run.len() - 1]];
            outside.extend(cut);
            clipped.cuts.push(cut);
            clipped.inside.push(run);
        }
    }
    clipped.outside.push(outside);
    clipped
}

/// The run of inside corners after corner `before`, with the crossings at both ends.
fn run_from(cell: &Cell, polygon: &[Node], before: usize) -> Vec<Node> {
    let n = polygon.len();
    let corner = |i: usize| &polygon[(before + i) % n];
    let inside = (1..n).take_while(|&i| corner(i).is_inside()).count();
    let mut run = vec![cell.crossing(corner(0), corner(1))];
    run.extend((1..=inside).map(corner));
    run.push(cell.crossing(corner(inside), corner(inside + 1)));
    run
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::surface::solid::cell::{Corners, Vertex};

    /// A cell in the scan's solid.
    fn cell() -> Cell {
        let corners = Corners {
            values: [1.0; 8],
            voxels: [0; 8],
            positions: [DVec3::ZERO; 8],
            cutter: [1.0; 8],
            inside: 255,
            on: 0,
        };
        Cell::new(&corners, |_| unreachable!("no vertex of the surface is here"))
    }

    fn square(cutter: [f64; 4]) -> Vec<Node> {
        let at = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let nodes = at.iter().zip(cutter).zip(0..);
        nodes
            .map(|((&(x, y), cutter), name)| Node::of_test(name, DVec3::new(x, y, 0.0), cutter))
            .collect()
    }

    #[test]
    fn opposite_corners_come_apart() {
        let clipped = clip(&cell(), &square([1.0, -1.0, 3.0, -1.0]));
        let sizes = |polygons: &[Vec<Node>]| polygons.iter().map(Vec::len).collect::<Vec<_>>();
        assert_eq!((sizes(&clipped.inside), sizes(&clipped.outside)), (vec![3, 3], vec![6]));
        let [from, to] = clipped.cuts[0].map(|node| node.position.truncate().to_array());
        assert_eq!((from, to), ([1.0, 0.25], [0.25, 1.0]));
    }

    #[test]
    fn a_corner_on_the_cutter_is_its_own_cut() {
        let clipped = clip(&cell(), &square([0.0, -1.0, -1.0, -1.0]));
        assert_eq!(clipped.cuts[0].map(|node| node.vertex), [Vertex::Surface(0); 2]);
        let clipped = clip(&cell(), &square([0.0, 0.0, 0.0, 0.0]));
        assert_eq!(
            (clipped.inside.len(), clipped.outside.len(), clipped.cuts.len()),
            (1, 0, 0)
        );
    }
}
