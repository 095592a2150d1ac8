//! Caps: loops of cuts, and triangles that fill them (LC87 §5.2).
//!
//! *Practice.* A loop is filled by cutting off ears, the best shaped first. A cap of a plane is cut by the scan's surface along
//! lines that end at the cell's faces, so its loops have no holes. Other loops are nearly flat, and are looked at along their
//! mean normal. Where no ear is free, as rounding or folds can have it, the best of the others is taken: whatever the
//! positions, the triangles fill the loop's sides exactly.

use glam::DVec3;

use super::cell::Node;
use crate::surface::ties::is_whole;

/// The closed loops, without repeated vertices, that cuts of one cell make: each goes on where another ends.
pub(super) fn loops(mut cuts: Vec<[Node; 2]>) -> Vec<Vec<Node>> {
    let mut loops = Vec::new();
    let mut path: Vec<Node> = Vec::new();
    while let Some(next) = next_cut(&mut cuts, path.last()) {
        if path.is_empty() {
            path.push(next[0]);
        }
        match path.iter().position(|node| node.vertex == next[1].vertex) {
            Some(start) => {
                let closed = path.split_off(start);
                path.extend((start > 0).then(|| closed[0]));
                loops.push(closed);
            }
            None => path.push(next[1]),
        }
    }
    loops
}

/// Takes a cut that starts where the path ends, or any where there is none.
fn next_cut(cuts: &mut Vec<[Node; 2]>, end: Option<&Node>) -> Option<[Node; 2]> {
    let n = match end {
        Some(end) => cuts.iter().position(|cut| cut[0].vertex == end.vertex)?,
        None => cuts.len().checked_sub(1)?,
    };
    Some(cuts.swap_remove(n))
}

/// Triangles that fill a polygon, wound as it is; none of them has a corner twice.
pub(super) fn fill(mut polygon: Vec<Node>, mut each: impl FnMut([Node; 3])) {
    polygon.dedup_by_key(|node| node.vertex);
    while polygon.len() > 1 && polygon[0].vertex == polygon[polygon.len() - 1].vertex {
        polygon.pop();
    }
    let normal = mean_normal(&polygon);
    while polygon.len() > 3 {
        let ear = best_ear(&polygon, normal);
        let n = polygon.len();
        emit(
            [polygon[(ear + n - 1) % n], polygon[ear], polygon[(ear + 1) % n]],
            &mut each,
        );
        polygon.remove(ear);
    }
    if let [a, b, c] = polygon[..] {
        emit([a, b, c], &mut each);
    }
}

fn emit(triangle: [Node; 3], each: &mut impl FnMut([Node; 3])) {
    if is_whole(triangle.map(|node| node.vertex)) {
        each(triangle);
    }
}

/// Newell's normal: the sum of the triangles of a fan.
fn mean_normal(polygon: &[Node]) -> DVec3 {
    let side = |n: usize| polygon[n].position - polygon[0].position;
    let fan = (2..polygon.len()).map(|n| side(n - 1).cross(side(n)));
    fan.sum::<DVec3>().normalize_or_zero()
}

/// Where to cut off a triangle: free ears are better than others, and large ones for their longest side better than slivers.
fn best_ear(polygon: &[Node], normal: DVec3) -> usize {
    let n = polygon.len();
    let score = |i: usize| {
        let corners = [(i + n - 1) % n, i, (i + 1) % n];
        let [a, b, c] = corners.map(|i| polygon[i].position);
        let shape = turn(a, b, c, normal) / longest_squared(a, b, c);
        let is_free =
            shape > 0.0 && (0..n).all(|i| corners.contains(&i) || !covers([a, b, c], polygon[i].position, normal));
        (is_free, shape)
    };
    let better = |a: (bool, f64), b: (bool, f64)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1));
    (0..n).max_by(|&a, &b| better(score(a), score(b))).unwrap_or(0)
}

/// Twice the area of a triangle seen along `normal`; positive if it turns left.
fn turn(a: DVec3, b: DVec3, c: DVec3, normal: DVec3) -> f64 {
    (b - a).cross(c - a).dot(normal)
}

fn longest_squared(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let sides = [b - a, c - b, a - c].map(DVec3::length_squared);
    sides.into_iter().fold(f64::MIN_POSITIVE, f64::max)
}

/// Whether a point lies in a triangle or on its border.
fn covers([a, b, c]: [DVec3; 3], p: DVec3, normal: DVec3) -> bool {
    [(a, b), (b, c), (c, a)]
        .into_iter()
        .all(|(from, to)| turn(from, to, p, normal) >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::solid::cell::Vertex;

    fn node(name: u32, x: f64, y: f64) -> Node {
        Node::of_test(name, DVec3::new(x, y, 7.0), 0.0)
    }

    fn areas(polygon: &[[f64; 2]]) -> Vec<f64> {
        let nodes = polygon.iter().zip(0..).map(|(&[x, y], name)| node(name, x, y));
        let mut areas = Vec::new();
        fill(nodes.collect(), |t| {
            let [a, b, c] = t.map(|node| node.position);
            areas.push(turn(a, b, c, DVec3::Z) / 2.0);
        });
        areas
    }

    #[test]
    fn a_comb_is_filled_without_folds() {
        let comb = [
            [0.0, 0.0],
            [5.0, 0.0],
            [5.0, 3.0],
            [4.0, 0.5],
            [3.0, 3.0],
            [2.0, 0.5],
            [1.0, 3.0],
            [0.0, 0.5],
        ];
        let areas = areas(&comb);
        assert_eq!(areas.len(), comb.len() - 2);
        assert!(areas.iter().all(|area| *area > 0.0), "{areas:?}");
        // By the shoelace formula.
        let twice: f64 = (0..8)
            .map(|n| (comb[n], comb[(n + 1) % 8]))
            .map(|([a, b], [c, d])| a * d - b * c)
            .sum();
        assert!((2.0 * areas.iter().sum::<f64>() - twice).abs() < 1e-12);
    }

    #[test]
    fn what_cannot_be_filled_well_is_filled_all_the_same() {
        assert_eq!(areas(&[[0.0, 0.0]; 5]).len(), 3);
        assert_eq!(areas(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]]).len(), 2);
        assert_eq!(areas(&[[0.0, 0.0], [1.0, 0.0]]).len(), 0);
    }

    #[test]
    fn cuts_that_meet_twice_make_two_loops() {
        let [a, b, c, d, e] = [0, 1, 2, 3, 4].map(|name| node(name, 0.0, 0.0));
        let found = loops(vec![[a, b], [b, c], [c, a], [c, d], [d, e], [e, c]]);
        let mut names: Vec<Vec<Vertex>> = found
            .iter()
            .map(|nodes| nodes.iter().map(|node| node.vertex).collect())
            .collect();
        names.iter_mut().for_each(|names| names.sort());
        names.sort();
        assert_eq!(
            names,
            [[a, b, c], [c, d, e]].map(|nodes| nodes.map(|node| node.vertex).to_vec())
        );
    }
}
