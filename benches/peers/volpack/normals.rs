//! VolPack's table of normals: points of an octahedron, 44 steps from its middle to a corner (13 bits).

use glam::DVec3;

const STEPS: f64 = 44.0;

/// The direction of the table for a gradient; zero for none.
pub fn nearest(gradient: DVec3) -> DVec3 {
    let sum = gradient.abs().element_sum();
    if sum == 0.0 {
        return DVec3::ZERO;
    }
    let y = (gradient.y / sum * STEPS).round_ties_even();
    let x_most = STEPS - y.abs();
    let x = (gradient.x / sum * STEPS).round_ties_even().clamp(-x_most, x_most);
    // What is left of the steps is z: all points are on the octahedron's faces.
    let z = (STEPS - x.abs() - y.abs()).copysign(gradient.z);
    DVec3::new(x, y, z).normalize()
}
