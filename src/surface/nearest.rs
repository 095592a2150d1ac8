//! How far a point is from a triangle.

use glam::DVec3;

use super::sound;

/// The square of the distance from `p` to the triangle, which may be a line or a point.
pub(super) fn distance_squared(p: DVec3, corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners;
    let normal = sound::double_area(corners);
    let is_above = |from: DVec3, to: DVec3| (to - from).cross(p - from).dot(normal) >= 0.0;
    if normal.length_squared() > 0.0 && is_above(a, b) && is_above(b, c) && is_above(c, a) {
        return (p - a).dot(normal).powi(2) / normal.length_squared();
    }
    let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| to_segment(p, from, to));
    sides.into_iter().fold(f64::INFINITY, f64::min)
}

fn to_segment(p: DVec3, from: DVec3, to: DVec3) -> f64 {
    let along = to - from;
    let t = (p - from).dot(along) / along.length_squared();
    // A side without length is a point: 0/0 is not above 0.
    let t = if t > 0.0 { t.min(1.0) } else { 0.0 };
    (from + along * t).distance_squared(p)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [DVec3; 3] = [DVec3::ZERO, DVec3::new(4.0, 0.0, 0.0), DVec3::new(0.0, 3.0, 0.0)];

    #[test]
    fn the_nearest_point_may_be_a_face_a_side_or_a_corner() {
        let squared = |x, y, z| distance_squared(DVec3::new(x, y, z), CORNERS);
        assert_eq!(squared(1.0, 1.0, -2.0), 4.0);
        assert_eq!(squared(2.0, -3.0, 4.0), 25.0);
        assert_eq!(squared(7.0, -4.0, 0.0), 25.0);
        // The long side's line is 3x + 4y = 12; (5, 5.5) is 5 from it.
        assert!((squared(5.0, 5.5, 0.0) - 25.0).abs() < 1e-13);
    }

    #[test]
    fn a_triangle_without_area_is_a_line_or_a_point() {
        let p = DVec3::new(1.0, 2.0, 0.0);
        let x = DVec3::X;
        assert_eq!(distance_squared(p, [DVec3::ZERO, x * 2.0, x * 4.0]), 4.0);
        assert_eq!(distance_squared(p, [x; 3]), 4.0);
    }
}
