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
