//! The slice template: every Z-plane polygon of a box size, computed once (VCSG §3.3.2, figure 3).
//!
//! *Theory.* All blocks of one size cut the Z-planes in the same polygons up to a translation, so the polygons of a sample
//! block serve them all.
//! *Changes from the paper.* VCSG's template is a list of polygons at whole displacements of the sample block. Between two
//! successive corner depths of a box the polygon's vertices run along fixed edges, linearly in depth; so a template here is at
//! most seven segments of at most six vertices `base + t·slope`, exact for any plane at any phase. Planes across the view axis
//! meet a box in the same polygons whatever the lens, so perspective, which the paper leaves as future work, needs nothing
//! more: cut in eye space, project after.
//! *Practice.* Coordinates are of the unit box; a box of the lattice is its scale and translation. All cubes, whatever their
//! size, have templates that differ only by scale.

use glam::{DMat3, DVec2, DVec3};

/// Most vertices of the polygon in which a plane meets a box.
pub const MAX_VERTICES: usize = 6;
/// Most depth intervals between successive corners of a box.
pub const MAX_SEGMENTS: usize = 7;

/// A polygon vertex that moves along an edge of the unit box: at `base + t·slope`, `t` millimetres behind the box's nearest
/// corner.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MovingVertex {
    /// Position for `t = 0` (outside the box unless the segment begins there).
    pub base: DVec3,
    /// Movement a millimetre of depth.
    pub slope: DVec3,
}

impl MovingVertex {
    /// Its place in the unit box at depth `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.base + t * self.slope
    }
}

/// The polygons between two successive corner depths.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Where the segment ends, millimetres behind the nearest corner.
    pub end_mm: f64,
    /// Three to six vertices, in order round the polygon, the first in the middle of the best fan.
    pub vertices: Vec<MovingVertex>,
}

/// All polygons of a box of one size in one view.
#[derive(Clone, Debug, PartialEq)]
pub struct Template {
    /// By rising depth, one to seven.
    pub segments: Vec<Segment>,
}

impl Template {
    /// The template of a box whose unit axes `x, y, z` map to the eye-space vectors of `eye_from_unit`, millimetres.
    pub fn new(eye_from_unit: &DMat3) -> Self {
        let depth_of = |corner: usize| unit_corner(corner).dot(eye_from_unit.row(2));
        let nearest = (0..8).map(depth_of).fold(f64::INFINITY, f64::min);
        let corner_depths: [f64; 8] = std::array::from_fn(|c| depth_of(c) - nearest);
        let mut stops = corner_depths;
        stops.sort_by(f64::total_cmp);
        // Corners that differ by rounding only would make slivers of segments.
        let thinnest = stops[7] * 1e-12;
        let segments = stops
            .windows(2)
            .filter(|s| s[1] - s[0] > thinnest)
            .map(|s| Segment {
                end_mm: s[1],
                vertices: polygon(&corner_depths, 0.5 * (s[0] + s[1]), eye_from_unit),
            })
            .collect();
        Self { segments }
    }

    /// Depth of the farthest corner behind the nearest, millimetres.
    pub fn depth_mm(&self) -> f64 {
        self.segments.last().map_or(0.0, |s| s.end_mm)
    }

    /// The segment that a plane `t` millimetres behind the nearest corner cuts.
    pub fn segment(&self, t: f64) -> Option<&Segment> {
        self.segments.get(self.segment_index(t))
    }

    /// Its index; that of the last one for a plane behind all.
    pub fn segment_index(&self, t: f64) -> usize {
        let ended = self.segments.iter().take_while(|s| t >= s.end_mm).count();
        ended.min(self.segments.len().saturating_sub(1))
    }
}

fn unit_corner(index: usize) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|a| (index >> a & 1) as f64))
}

/// The vertices on the edges that cross depth `t`, ordered round their middle as the eye sees them. The first is the one from which
/// a fan has the shortest diagonals.
fn polygon(corner_depths: &[f64; 8], t: f64, eye_from_unit: &DMat3) -> Vec<MovingVertex> {
    let mut vertices: Vec<MovingVertex> = (0..8usize)
        .flat_map(|a| [1, 2, 4].map(|bit| (a, a | bit)))
        .filter(|&(a, b)| a != b && (corner_depths[a] < t) != (corner_depths[b] < t))
        .map(|(a, b)| on_edge(a, b, corner_depths))
        .collect();
    let middle = vertices.iter().map(|v| v.at(t)).sum::<DVec3>() / vertices.len() as f64;
    let angle = |v: &MovingVertex| {
        let seen = *eye_from_unit * (v.at(t) - middle);
        seen.y.atan2(seen.x)
    };
    vertices.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    let seen: Vec<DVec2> = vertices.iter().map(|v| (*eye_from_unit * v.at(t)).truncate()).collect();
    let shortest = (0..seen.len()).min_by(|a, b| diagonals(&seen, *a).total_cmp(&diagonals(&seen, *b)));
    vertices.rotate_left(shortest.unwrap_or(0));
    vertices
}

/// The length of all diagonals from a vertex, across and down: so many squares of pixels are drawn on twice where two triangles of
/// the fan meet.
fn diagonals(polygon: &[DVec2], from: usize) -> f64 {
    let n = polygon.len();
    let to = (2..n.saturating_sub(1)).map(|step| (polygon[(from + step) % n] - polygon[from]).abs());
    to.map(|way| way.x + way.y).sum()
}

fn on_edge(a: usize, b: usize, corner_depths: &[f64; 8]) -> MovingVertex {
    let (from, to) = (unit_corner(a), unit_corner(b));
    let slope = (to - from) / (corner_depths[b] - corner_depths[a]);
    MovingVertex {
        base: from - slope * corner_depths[a],
        slope,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn area(vertices: &[DVec3]) -> f64 {
        let origin = vertices[0];
        let doubled = vertices
            .windows(2)
            .map(|v| (v[0] - origin).cross(v[1] - origin))
            .sum::<DVec3>();
        0.5 * doubled.length()
    }

    fn edges(seed: [f64; 9]) -> DMat3 {
        DMat3::from_cols_array(&seed)
    }

    proptest! {
        #[test]
        fn polygons_stacked_up_are_the_box(seed in prop::array::uniform9(-1.0f64..1.0)) {
            let eye_from_unit = edges(seed);
            prop_assume!(eye_from_unit.determinant().abs() > 1e-3);
            let template = Template::new(&eye_from_unit);
            // Within a segment the area is quadratic in depth: Simpson's rule is exact.
            let mut volume = 0.0;
            let mut begin = 0.0;
            for segment in &template.segments {
                let slice = |t: f64| area(&segment.vertices.iter().map(|v| eye_from_unit * v.at(t)).collect::<Vec<_>>());
                let thickness = segment.end_mm - begin;
                volume += thickness / 6.0
                    * (slice(begin) + 4.0 * slice(begin + 0.5 * thickness) + slice(segment.end_mm));
                begin = segment.end_mm;
            }
            let exact = eye_from_unit.determinant().abs();
            prop_assert!((volume - exact).abs() < 1e-9, "{volume} is not {exact}");
        }

        #[test]
        fn every_vertex_lies_on_its_plane_and_on_an_edge(seed in prop::array::uniform9(-1.0f64..1.0), f in 0.0f64..1.0) {
            let eye_from_unit = edges(seed);
            prop_assume!(eye_from_unit.determinant().abs() > 1e-3);
            let template = Template::new(&eye_from_unit);
            let t = f * template.depth_mm();
            let nearest = (0..8).map(|c| (eye_from_unit * unit_corner(c)).z).fold(f64::INFINITY, f64::min);
            for v in &template.segment(t).unwrap().vertices {
                let p = v.at(t);
                prop_assert!(((eye_from_unit * p).z - nearest - t).abs() < 1e-9);
                let on_face = (0..3).filter(|&a| p[a].abs() < 1e-9 || (p[a] - 1.0).abs() < 1e-9).count();
                prop_assert!(on_face >= 2 && p.min_element() > -1e-9 && p.max_element() < 1.0 + 1e-9, "{p}");
            }
        }
    }

    #[test]
    fn an_axis_aligned_cube_has_one_segment_of_four_vertices() {
        let template = Template::new(&DMat3::IDENTITY);
        assert_eq!(template.segments.len(), 1);
        assert_eq!(template.segments[0].vertices.len(), 4);
    }

    #[test]
    fn a_cube_seen_along_its_diagonal_shows_a_hexagon() {
        let turned = DMat3::from_quat(glam::DQuat::from_rotation_arc(DVec3::ONE.normalize(), DVec3::Z));
        let template = Template::new(&turned);
        let middle = template.segment(0.5 * template.depth_mm()).unwrap();
        assert_eq!(middle.vertices.len(), 6);
    }
}
