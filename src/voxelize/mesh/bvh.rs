//! A hierarchy of boxes, split at the median, so that it is balanced and the same on every run.

use glam::DVec3;

use crate::math::Aabb;

/// How many items a leaf holds at most.
const LEAF: usize = 4;

/// The most nodes that wait while others are looked at: one a level, and a balanced tree of 2³² items has 33.
const WAITING: usize = 64;

/// A binary tree of boxes over items that are put in the tree's order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bvh {
    /// Parents before children, and a first child right behind its parent.
    nodes: Vec<Node>,
}

#[derive(Clone, Debug, PartialEq)]
struct Node {
    bounds: Aabb,
    /// A leaf's first item; otherwise the second child.
    first: u32,
    /// How many items a leaf has; otherwise 0.
    count: u32,
}

impl Bvh {
    /// The tree over less than 2³² boxes, and their order in it.
    pub fn new(boxes: &[Aabb]) -> (Self, Vec<u32>) {
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        let mut tree = Self::default();
        if !order.is_empty() {
            tree.grow(boxes, &mut order, 0);
        }
        (tree, order)
    }

    fn grow(&mut self, boxes: &[Aabb], items: &mut [u32], first: u32) {
        let bounds = items.iter().fold(Aabb::EMPTY, |b, n| b.hull(&boxes[*n as usize]));
        let at = self.nodes.len();
        self.nodes.push(Node {
            bounds,
            first,
            count: items.len() as u32,
        });
        if items.len() <= LEAF {
            return;
        }
        let axis = bounds.size().max_position();
        let middle = |n: u32| boxes[n as usize].min[axis] + boxes[n as usize].max[axis];
        let half = items.len() / 2;
        items.select_nth_unstable_by(half, |m, n| middle(*m).total_cmp(&middle(*n)).then(m.cmp(n)));
        let (before, after) = items.split_at_mut(half);
        self.grow(boxes, before, first);
        self.nodes[at].count = 0;
        self.nodes[at].first = self.nodes.len() as u32;
        self.grow(boxes, after, first + half as u32);
    }

    /// Calls `item` with each item of each leaf whose box, and those of all nodes above it, `enters`.
    pub fn visit(&self, enters: impl Fn(&Aabb) -> bool, mut item: impl FnMut(usize)) {
        let mut waiting = [0; WAITING];
        let mut count = usize::from(!self.nodes.is_empty());
        while count > 0 {
            count -= 1;
            let at = waiting[count];
            let node = &self.nodes[at as usize];
            if !enters(&node.bounds) {
                continue;
            }
            if node.count > 0 {
                (node.first..node.first + node.count).for_each(|n| item(n as usize));
            } else {
                waiting[count] = node.first;
                waiting[count + 1] = at + 1;
                count += 2;
            }
        }
    }

    /// The least squared distance from `p` to an item, or `limit_squared` if that is less. `to_item` is never below the distance
    /// to the item's box.
    pub fn nearest_squared(&self, p: DVec3, limit_squared: f64, to_item: impl Fn(usize) -> f64) -> f64 {
        let mut best = limit_squared;
        let to_node = |at: u32| (distance_squared(&self.nodes[at as usize].bounds, p), at);
        let mut waiting = [(0.0, 0); WAITING];
        let mut count = usize::from(!self.nodes.is_empty());
        while count > 0 {
            count -= 1;
            let (distance, at) = waiting[count];
            if distance >= best {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.count > 0 {
                let items = node.first..node.first + node.count;
                best = items.fold(best, |best, n| best.min(to_item(n as usize)));
                continue;
            }
            let (first, second) = (to_node(at + 1), to_node(node.first));
            let (near, far) = if second.0 < first.0 {
                (second, first)
            } else {
                (first, second)
            };
            waiting[count] = far;
            waiting[count + 1] = near;
            count += 2;
        }
        best
    }
}

/// The square of the distance from `p` to a box; 0 within it.
#[inline]
pub fn distance_squared(bounds: &Aabb, p: DVec3) -> f64 {
    (bounds.min - p).max(p - bounds.max).max(DVec3::ZERO).length_squared()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a lattice, as boxes without a size.
    fn points() -> Vec<DVec3> {
        let at = |n: u32| DVec3::new(f64::from(n % 7), f64::from(n * 5 % 11), f64::from(n * 3 % 13));
        (0..500).map(at).collect()
    }

    #[test]
    fn the_nearest_and_the_visited_are_those_of_a_loop() {
        let points = points();
        let boxes: Vec<_> = points.iter().map(|p| Aabb::new(*p, *p)).collect();
        let (tree, order) = Bvh::new(&boxes);
        let item = |n: usize| points[order[n] as usize];
        for n in 0..200 {
            let p = DVec3::new(f64::from(n) * 0.05, 3.3, f64::from(n % 17));
            let slow = points
                .iter()
                .map(|q| q.distance_squared(p))
                .fold(f64::INFINITY, f64::min);
            let nearest = |limit| tree.nearest_squared(p, limit, |n| item(n).distance_squared(p));
            assert_eq!([nearest(f64::INFINITY), nearest(0.25)], [slow, slow.min(0.25)]);
            let mut met = 0;
            let near = |bounds: &Aabb| distance_squared(bounds, p) <= 4.0;
            tree.visit(near, |n| met += usize::from(item(n).distance_squared(p) <= 4.0));
            assert_eq!(met, points.iter().filter(|q| q.distance_squared(p) <= 4.0).count());
        }
    }

    #[test]
    fn nothing_is_never_met() {
        let (tree, order) = Bvh::new(&[]);
        assert!(order.is_empty());
        tree.visit(|_| true, |_| unreachable!());
        assert_eq!(tree.nearest_squared(DVec3::ZERO, 9.0, |_| 0.0), 9.0);
    }
}
