//! VTK's piecewise functions, made piecewise linear.
//!
//! *Theory.* Between two nodes VTK puts the middle of the change where the left node's *midpoint* says, and bends the change by
//! its *sharpness* k. With s running from 0 to ½ before the middle and to 1 after it: below k = 0.01 the change is s; above 0.99 that of
//! a colour, not that of an opacity, is a step in the middle; else it is `3w² − 2w³ + (1−k)(2w³ − 3w² + w)` with `w = ½(2s)^(1+10k)` before the middle, and the same turned
//! about the middle after it. Before the middle both the power and the cubic are convex and rise, so their composition does too.
//! *Practice.* Lines and steps are taken as they are. A bend is halved until it is near its chord: a convex curve lies in the triangle
//! of its chord and the tangents at its ends, and that triangle is at most [`BEND_ERROR`] of the change high.

/// How far a bend may be from the lines that are taken for it, as a part of the change between its nodes: a quarter of an 8-bit step.
pub const BEND_ERROR: f64 = 1.0 / 1024.0;

/// The sharpest bends of VTK's colours, and of its opacities.
pub(super) const COLOR_BEND: f64 = 0.99;
pub(super) const OPACITY_BEND: f64 = 1.0;

/// A node of VTK's functions: a value, what the function is there, and how it goes on to the next node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node<const N: usize> {
    /// The value.
    pub x: f64,
    /// What the function is there.
    pub y: [f64; N],
    /// Where the middle of the change to the next node is, as a part of the way there.
    pub midpoint: f64,
    /// How sharp the change is: from 0, lines, to 1, a step.
    pub sharpness: f64,
}

/// A function that is linear between its knots, and constant beyond them; two knots of one place make a step.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Polyline<const N: usize>(Vec<(f32, [f64; N])>);

impl<const N: usize> Polyline<N> {
    /// Through `nodes`, in any order; of several in one place the last counts. Sharper changes than `sharpest_bend` are steps.
    pub fn through(mut nodes: Vec<Node<N>>, sharpest_bend: f64) -> Self {
        // Stable, so the last of a place is the one that came last.
        nodes.sort_by(|a, b| a.x.total_cmp(&b.x));
        let mut unique: Vec<Node<N>> = Vec::new();
        for node in nodes {
            match unique.last_mut() {
                Some(last) if last.x == node.x => *last = node,
                _ => unique.push(node),
            }
        }
        let mut knots = Vec::new();
        for (i, node) in unique.iter().enumerate() {
            knots.push((node.x as f32, node.y));
            if let Some(next) = unique.get(i + 1) {
                knots.extend(between(node, next, sharpest_bend));
            }
        }
        Self(knots)
    }

    /// The places of the knots, rising.
    pub fn places(&self) -> impl Iterator<Item = f32> {
        self.0.iter().map(|knot| knot.0)
    }

    /// What the function is just before `x` and just after it.
    pub fn around(&self, x: f32) -> [[f64; N]; 2] {
        let before = self.0.partition_point(|knot| knot.0 < x);
        let after = self.0.partition_point(|knot| knot.0 <= x);
        match before < after {
            true => [self.0[before].1, self.0[after - 1].1],
            false => [self.across(before, x); 2],
        }
    }

    /// At `x`, on the line to the knot `next` from the one before it.
    fn across(&self, next: usize, x: f32) -> [f64; N] {
        let (from, to) = match (next.checked_sub(1).map(|i| self.0[i]), self.0.get(next)) {
            (Some(from), Some(to)) => (from, to),
            (Some(end), None) => return end.1,
            (None, Some(end)) => return end.1,
            (None, None) => return [0.0; N],
        };
        let t = f64::from(x - from.0) / f64::from(to.0 - from.0);
        mix(&from.1, &to.1, t)
    }
}

fn mix<const N: usize>(from: &[f64; N], to: &[f64; N], t: f64) -> [f64; N] {
    std::array::from_fn(|i| from[i] + t * (to[i] - from[i]))
}

/// The knots between two nodes.
fn between<const N: usize>(from: &Node<N>, to: &Node<N>, sharpest_bend: f64) -> Vec<(f32, [f64; N])> {
    // As VTK does: in an end of the way the middle would be nowhere.
    let middle = from.midpoint.clamp(1e-5, 1.0 - 1e-5);
    let place = |s: f64| {
        let way = match s < 0.5 {
            true => middle * 2.0 * s,
            false => middle + (1.0 - middle) * (2.0 * s - 1.0),
        };
        (from.x + (to.x - from.x) * way) as f32
    };
    let knot = |(s, change): (f64, f64)| (place(s), mix(&from.y, &to.y, change));
    let straight = from.midpoint == 0.5 && from.sharpness < 0.01;
    if straight || from.y == to.y {
        Vec::new()
    } else if from.sharpness < 0.01 {
        vec![knot((0.5, 0.5))]
    } else if from.sharpness > sharpest_bend {
        vec![knot((0.5, 0.0)), knot((0.5, 1.0))]
    } else {
        Bend::of(from.sharpness).knots().into_iter().map(knot).collect()
    }
}

/// A bent change.
struct Bend {
    sharpness: f64,
    power: f64,
}

impl Bend {
    fn of(sharpness: f64) -> Self {
        Self {
            sharpness,
            power: 1.0 + 10.0 * sharpness,
        }
    }

    /// The change at `s` before the middle, and its slope.
    fn at(&self, s: f64) -> (f64, f64) {
        let w = 0.5 * (2.0 * s).powf(self.power);
        let rise = self.power * (2.0 * s).powf(self.power - 1.0);
        let k = self.sharpness;
        let change = w * w * (3.0 - 2.0 * w) + (1.0 - k) * w * (1.0 - w) * (1.0 - 2.0 * w);
        (change, ((1.0 - k) + 6.0 * k * w * (1.0 - w)) * rise)
    }

    /// How high the triangle between chord and tangents is from `a` to `b`, at most the middle.
    fn bow(&self, a: f64, b: f64) -> f64 {
        let ((at_a, slope_a), (at_b, slope_b)) = (self.at(a), self.at(b));
        let chord = (at_b - at_a) / (b - a);
        match slope_b > slope_a {
            true => (chord - slope_a) * (slope_b - chord) / (slope_b - slope_a) * (b - a),
            false => 0.0,
        }
    }

    /// Places s between 0 and 1, and the change there.
    fn knots(&self) -> Vec<(f64, f64)> {
        let (mut knots, mut from, mut ends) = (Vec::new(), 0.0, vec![0.5]);
        while let Some(&to) = ends.last() {
            if self.bow(from, to) <= BEND_ERROR {
                knots.push((to, self.at(to).0));
                from = to;
                ends.pop();
            } else {
                ends.push(0.5 * (from + to));
            }
        }
        let before_middle = knots.len() - 1;
        let turned = |&(s, change): &(f64, f64)| (1.0 - s, 1.0 - change);
        let after: Vec<_> = knots[..before_middle].iter().rev().map(turned).collect();
        knots.extend(after);
        knots
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bend_is_as_near_its_lines_as_it_is_said_to_be() {
        for sharpness in [0.01, 0.02, 0.1, 0.37, 0.8, 0.99, 1.0] {
            let bend = Bend::of(sharpness);
            let ends = [vec![(0.0, 0.0)], bend.knots(), vec![(1.0, 1.0)]].concat();
            // So the 4096 nodes that a file may have make no more than 2^19 points.
            assert!(ends.len() < 128, "{sharpness} takes {} knots", ends.len());
            for pair in ends.windows(2) {
                let [(a, at_a), (b, at_b)] = [pair[0], pair[1]];
                for i in 0..=20 {
                    let t = f64::from(i) / 20.0;
                    let s = a + t * (b - a);
                    let true_change = match s < 0.5 {
                        true => bend.at(s).0,
                        false => 1.0 - bend.at(1.0 - s).0,
                    };
                    let apart = (at_a + t * (at_b - at_a) - true_change).abs();
                    // Roundings of numbers up to 1.
                    assert!(apart <= BEND_ERROR + 8.0 * f64::EPSILON, "{sharpness} at {s}: {apart}");
                }
            }
        }
    }

    #[test]
    fn the_last_node_of_a_place_counts_and_a_step_has_two_sides() {
        let node = |x, y, sharpness| Node {
            x,
            y: [y],
            midpoint: 0.5,
            sharpness,
        };
        let nodes = vec![node(2.0, 1.0, 0.0), node(0.0, 0.3, 1.0), node(0.0, 0.0, 1.0)];
        let line = Polyline::through(nodes, COLOR_BEND);
        assert_eq!(line.around(0.0), [[0.0]; 2]);
        assert_eq!(line.around(1.0), [[0.0], [1.0]]);
        assert_eq!(line.around(9.0), [[1.0]; 2]);
        assert_eq!(line.around(-9.0), [[0.0]; 2]);
    }
}
