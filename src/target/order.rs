//! The order in which blocks hide one another (VCSG §3.2).
//!
//! *Theory.* The signs of the viewing vector decide the order in which a node's eight octants are visited; a depth-first
//! traversal then meets the blocks from back to front.
//! *Changes from the paper.* Under perspective the signs are taken at each node, from the side of the node's centre that the
//! eye is on. The three planes through the centre separate the octants, so what is on the eye's side of one can hide what is
//! not, and never the other way.

use super::Cube;
use crate::math::Viewpoint;

/// The octants of `cube` in an order in which none is hidden by an earlier one. `viewpoint` is in lattice coordinates.
pub fn octants_back_to_front(cube: &Cube, viewpoint: Viewpoint) -> [usize; 8] {
    let towards = match viewpoint {
        Viewpoint::Direction(d) => d,
        Viewpoint::Point(eye) => eye - cube.center(),
    };
    let far = (0..3).filter(|&a| towards[a] <= 0.0).fold(0, |far, a| far | 1 << a);
    std::array::from_fn(|i| far ^ i)
}
