//! VolPack's table of normals: points of an octahedron, 44 steps from its middle to a corner (13 bits).

use glam::DVec3;

const STEPS: f64 = 44.0;

/// The direction of the table for a gradient; zero for none.
pub fn nearest(gradient: DVec3) -> DVec3 {
    let length = gradient.length();
    if length == 0.0 {
        return DVec3::ZERO;
    }
    // In VolPack's order: many gradients are half-way between two directions, and rounding decides.
    let unit = gradient / length;
    let scale = STEPS / unit.abs().element_sum();
    let y = (unit.y * scale).round_ties_even();
    let x_most = STEPS - y.abs();
    let x = (unit.x * scale).round_ties_even().clamp(-x_most, x_most);
    // What is left of the steps is z: all points are on the octahedron's faces.
    let z = (STEPS - x.abs() - y.abs()).copysign(gradient.z);
    DVec3::new(x, y, z).normalize()
}
