//! A triangle in the frame: where its edges may be, and the part of it that a pixel may show.
//!
//! *Theory.* A rasteriser puts vertices on a grid, each at most some way off in x and y, so it covers only centres that are no farther
//! off the exact triangle. Whether it interpolates between the vertices on the grid or between exact ones (lavapipe), what it
//! computes at a centre is what the exact plane has in a box of that size round it. What is interpolated is a quotient of linear
//! functions, and takes its extremes at the box's corners.

use glam::{DVec2, DVec3};

use super::precision::{Precision, ULP};
use crate::math::Aabb;
use crate::projection::{Camera, Lens};

/// A point of a triangle, as linear functions in the frame.
#[derive(Clone, Copy, Debug)]
struct Point {
    /// Where it is in the frame, pixels.
    px: DVec2,
    /// The weights of the triangle's corners over w.
    over_w: DVec3,
    /// One over w, which is depth in millimetres under perspective, else 1.
    inverse_w: f64,
}

impl Point {
    fn weights(&self) -> DVec3 {
        self.over_w / self.inverse_w
    }

    fn lerp(&self, other: &Self, t: f64) -> Self {
        Self {
            px: self.px.lerp(other.px, t),
            over_w: self.over_w.lerp(other.over_w, t),
            inverse_w: self.inverse_w + t * (other.inverse_w - self.inverse_w),
        }
    }
}

/// A triangle in the frame, cut off at the nearest depth that is drawn.
pub(super) struct Outline {
    /// Its corners in order.
    points: Vec<Point>,
    /// How far each is off at most in x and in y, pixels.
    pub off_px: f64,
}

/// The part of a triangle's plane that a pixel may show.
pub(super) struct Part {
    /// The weights of the triangle's corners, at corners of the part.
    pub weights: Vec<DVec3>,
    /// The largest w of the part over the smallest of the triangle: by how much more than 1 the triangle's nearest corner counts in what
    /// is interpolated.
    pub w_ratio: f64,
}

/// What a pixel may show of a triangle.
pub(super) enum Seen {
    /// Nothing.
    Nothing,
    /// This part of it.
    Part(Part),
    /// Anything: it is seen so much from the side that a step of the grid goes beyond its horizon.
    Anything,
}

impl Outline {
    /// The outline of the triangle with these corners in the eye frame, each off by `off_mm` at most along each axis; `None` if it
    /// is all too near.
    pub fn new(camera: &Camera, corners: &[DVec3; 3], off_mm: f64, precision: &Precision) -> Option<Self> {
        let weights = [DVec3::X, DVec3::Y, DVec3::Z];
        let whole: Vec<(DVec3, DVec3)> = corners.iter().copied().zip(weights).collect();
        let near = camera.near_mm();
        let mix = |a: &(DVec3, DVec3), b: &(DVec3, DVec3), t| (a.0.lerp(b.0, t), a.1.lerp(b.1, t));
        let before = if near.is_finite() {
            clip(&whole, |(place, _)| place.z - near, mix)
        } else {
            whole
        };
        let points: Vec<Point> = before.iter().map(|(place, w)| point(camera, *place, *w)).collect();
        let off_px = before.iter().map(|(place, _)| off_px(camera, *place, off_mm));
        let off_px = precision.vertex_px + off_px.fold(0.0, f64::max);
        (!points.is_empty()).then_some(Self { off_px, points })
    }

    /// The frame's pixels that it may cover: the first and the one after the last, in x and in y.
    pub fn reach(&self, size: [u32; 2]) -> [[u32; 2]; 2] {
        let all = Aabb::of_points(self.points.iter().map(|p| p.px.extend(0.0)));
        [0, 1].map(|axis| {
            let limit = f64::from(size[axis]);
            let first = (all.min[axis] - self.off_px - 0.5).ceil().clamp(0.0, limit);
            let last = (all.max[axis] + self.off_px - 0.5).floor().clamp(-1.0, limit - 1.0);
            [first as u32, (last + 1.0) as u32]
        })
    }

    /// What a pixel with this centre may show. A triangle thinner than the grid has no area there, and then it may be any of it.
    pub fn seen(&self, center: DVec2) -> Seen {
        let sides = [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)];
        let common = sides.into_iter().fold(self.points.clone(), |part, (axis, side)| {
            let inside = |p: &Point| side * (p.px[axis] - center[axis]) + self.off_px;
            clip(&part, inside, Point::lerp)
        });
        if common.is_empty() {
            return Seen::Nothing;
        }
        let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
        let mut part: Vec<Point> = corners
            .into_iter()
            .map(|(x, y)| self.at(center + self.off_px * DVec2::new(x, y)))
            .collect();
        if self.is_thin() {
            part.extend(&self.points);
        }
        let least = part.iter().map(|p| p.inverse_w).fold(f64::INFINITY, f64::min);
        // (A comparison with what is no number is false.)
        if !part.iter().all(|p| p.inverse_w > 0.0) {
            return Seen::Anything;
        }
        let most = self.points.iter().map(|p| p.inverse_w).fold(0.0, f64::max);
        Seen::Part(Part {
            weights: part.iter().map(Point::weights).collect(),
            w_ratio: most / least,
        })
    }

    /// The point of the triangle's plane that is seen at `px`.
    fn at(&self, px: DVec2) -> Point {
        let fan = (2..self.points.len()).map(|n| [self.points[0], self.points[n - 1], self.points[n]]);
        let area = |[a, b, c]: &[Point; 3]| (b.px - a.px).perp_dot(c.px - a.px).abs();
        let largest = fan.max_by(|one, other| area(one).total_cmp(&area(other)));
        let Some([a, b, c]) = largest else {
            return self.points[0];
        };
        let (ab, ac, to) = (b.px - a.px, c.px - a.px, px - a.px);
        let whole = ab.perp_dot(ac);
        let (second, third) = (to.perp_dot(ac) / whole, ab.perp_dot(to) / whole);
        let first = 1.0 - second - third;
        Point {
            px,
            over_w: first * a.over_w + second * b.over_w + third * c.over_w,
            inverse_w: first * a.inverse_w + second * b.inverse_w + third * c.inverse_w,
        }
    }

    /// Whether a pixel with this centre is covered, wherever the corners are put.
    pub fn covers(&self, center: DVec2) -> bool {
        let turn = self.turn();
        turn != 0.0
            && self.edges().all(|(a, b)| {
                let along = b.px - a.px;
                let inside = turn.signum() * along.perp_dot(center - a.px);
                inside > self.off_px * (along.x.abs() + along.y.abs())
            })
    }

    /// Whether the grid may take half its area or more.
    pub fn is_thin(&self) -> bool {
        self.height_px() <= 8.0 * self.off_px
    }

    /// How far what is interpolated goes up and down on its way: over so many heights of the triangle lies a pixel from where a device
    /// begins (the frame's corner, or a vertex), and each of them may be a rise by all that there is.
    pub fn heights(&self, size: [u32; 2]) -> f64 {
        (f64::from(size[0].max(size[1])) + self.longest_px()) / self.height_px()
    }

    fn height_px(&self) -> f64 {
        self.turn().abs() / self.longest_px()
    }

    fn longest_px(&self) -> f64 {
        self.edges().map(|(a, b)| a.px.distance(b.px)).fold(0.0, f64::max)
    }

    /// Twice the area, signed.
    fn turn(&self) -> f64 {
        let first = self.points[0].px;
        self.edges().map(|(a, b)| (a.px - first).perp_dot(b.px - first)).sum()
    }

    fn edges(&self) -> impl Iterator<Item = (&Point, &Point)> {
        self.points.iter().zip(self.points.iter().cycle().skip(1))
    }
}

fn point(camera: &Camera, place: DVec3, weights: DVec3) -> Point {
    let w = match camera.lens {
        Lens::Orthographic { .. } => 1.0,
        Lens::Perspective { .. } => place.z,
    };
    Point {
        px: camera.project(place),
        over_w: weights / w,
        inverse_w: w.recip(),
    }
}

/// What rounding moves a vertex by in the frame: its place, a division, the lens and the viewport. The last are as many operations as
/// for slices, and clipping at the frame and at the nearest depth does as many again, all on numbers as large as it is off the axis.
fn off_px(camera: &Camera, place: DVec3, off_mm: f64) -> f64 {
    let scale = camera.pixels_per_mm(place.z);
    let slope = match camera.lens {
        Lens::Orthographic { .. } => 0.0,
        Lens::Perspective { .. } => (place.truncate() / place.z).abs().max_element(),
    };
    let frame = f64::from(camera.size[0].max(camera.size[1]));
    scale * off_mm * (1.0 + slope) + 16.0 * ULP * (scale * place.truncate().abs().max_element() + frame)
}

/// The part of a polygon where `inside` is not negative (Sutherland and Hodgman).
fn clip<T: Copy>(polygon: &[T], inside: impl Fn(&T) -> f64, mix: impl Fn(&T, &T, f64) -> T) -> Vec<T> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (n, a) in polygon.iter().enumerate() {
        let b = &polygon[(n + 1) % polygon.len()];
        let (at_a, at_b) = (inside(a), inside(b));
        if at_a >= 0.0 {
            kept.push(*a);
        }
        if (at_a >= 0.0) != (at_b >= 0.0) {
            kept.push(mix(a, b, at_a / (at_a - at_b)));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::{Projection, View};

    fn camera(projection: Projection) -> Camera {
        let bounds = Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0));
        let view = View {
            projection,
            ..View::default()
        };
        view.camera(&bounds, [64, 64])
    }

    #[test]
    fn a_part_is_round_the_centre_and_has_its_weights() {
        for projection in [Projection::Orthographic, Projection::Perspective { fov_y_deg: 50.0 }] {
            let camera = camera(projection);
            let corners =
                [[4, 4, 2], [60, 9, 3], [20, 58, 5]].map(|[x, y, z]| camera.point_at_depth(x, y, f64::from(z)));
            let outline = Outline::new(&camera, &corners, 0.0, &Precision::EXACT).expect("an outline");
            let center = DVec2::new(25.5, 20.5);
            assert!(outline.covers(center) && !outline.covers(DVec2::new(3.5, 40.5)));
            let Seen::Part(part) = outline.seen(center) else {
                panic!("it is seen");
            };
            for w in part.weights {
                let place = w.x * corners[0] + w.y * corners[1] + w.z * corners[2];
                let off_px = (camera.project(place) - center).abs().max_element();
                assert!((off_px - outline.off_px).abs() < 1e-9, "{off_px}");
            }
            assert!(matches!(outline.seen(DVec2::new(3.5, 40.5)), Seen::Nothing));
        }
    }
}
