//! Rays, and how wide the pixel is that each stands for.

use glam::{DAffine3, DVec2, DVec3};

use crate::math::affine;
use crate::projection::{Camera, Lens};

/// A ray in the world; places on it are millimetres from its origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it begins.
    pub origin: DVec3,
    /// Where it goes, of length 1.
    pub direction: DVec3,
    /// The width of the pixel at its origin, millimetres.
    pub width_mm: f64,
    /// How much wider the pixel gets a millimetre.
    pub spread: f64,
}

/// A mirror or a lens bends neighbouring rays apart, and how much a ray does not know: it is taken to stand for twice the width.
const WIDENED: f64 = 2.0;

impl Ray {
    /// The ray of `camera` through the point `(x, y)` of the frame, in pixels. Parallel rays begin at depth `nearest_mm`.
    pub fn of_pixel(camera: &Camera, [x, y]: [f64; 2], nearest_mm: f64) -> Self {
        let world_from_eye = camera.eye_from_world.inverse();
        let off_axis = DVec2::new(x, y) - camera.center_px();
        let (start, towards, focal_px) = match camera.lens {
            Lens::Orthographic { pixels_per_mm } => ((off_axis / pixels_per_mm).extend(nearest_mm), DVec3::Z, None),
            Lens::Perspective { focal_px, near_mm } => {
                let through = (off_axis / focal_px).extend(1.0);
                (through * near_mm, through, Some(focal_px))
            }
        };
        Self {
            origin: affine::point(&world_from_eye, start),
            direction: (world_from_eye.matrix3 * towards).normalize(),
            width_mm: 1.0 / camera.pixels_per_mm(start.z),
            spread: focal_px.map_or(0.0, |focal_px| 1.0 / focal_px),
        }
    }

    /// The place `mm` along it.
    pub fn at(&self, mm: f64) -> DVec3 {
        self.origin + self.direction * mm
    }

    /// The width of its pixel `mm` along it, millimetres.
    pub fn width_at(&self, mm: f64) -> f64 {
        self.width_mm + self.spread * mm
    }

    /// A ray that goes on from the place `mm` along this one in another `direction`.
    pub fn turned(&self, mm: f64, direction: DVec3) -> Self {
        Self {
            origin: self.at(mm),
            direction,
            width_mm: WIDENED * self.width_at(mm),
            spread: WIDENED * self.spread,
        }
    }

    /// The ray in another frame; places on it stay millimetres of the world.
    pub fn line_in(&self, frame_from_world: &DAffine3) -> Line {
        Line {
            origin: affine::point(frame_from_world, self.origin),
            step: frame_from_world.matrix3 * self.direction,
        }
    }
}

/// A line in a lattice's coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// The place of 0 mm.
    pub origin: DVec3,
    /// Voxels a millimetre.
    pub step: DVec3,
}

impl Line {
    /// The place `mm` along it.
    pub fn at(&self, mm: f64) -> DVec3 {
        self.origin + self.step * mm
    }

    /// Where it leaves a box that it goes through: [`Self::stretch`]'s end, for half of the work.
    pub fn leave(&self, low: DVec3, high: DVec3) -> f64 {
        let mut leave = f64::INFINITY;
        for axis in 0..3 {
            let (o, d) = (self.origin[axis], self.step[axis]);
            if d != 0.0 {
                let face = if d > 0.0 { high[axis] } else { low[axis] };
                leave = leave.min((face - o) / d);
            }
        }
        leave
    }

    /// The stretch inside a box, as the places where it enters and leaves, and the axis of the face that it enters by; leaves before
    /// it enters where it misses the box.
    pub fn stretch(&self, low: DVec3, high: DVec3) -> Stretch {
        let mut stretch = Stretch {
            enter: f64::NEG_INFINITY,
            leave: f64::INFINITY,
            axes: [0; 2],
        };
        for axis in 0..3 {
            let (o, d) = (self.origin[axis], self.step[axis]);
            if d == 0.0 {
                if o < low[axis] || o > high[axis] {
                    stretch.leave = f64::NEG_INFINITY;
                }
                continue;
            }
            let [a, b] = [(low[axis] - o) / d, (high[axis] - o) / d];
            let (near, far) = if a < b { (a, b) } else { (b, a) };
            if near > stretch.enter {
                stretch.enter = near;
                stretch.axes[0] = axis;
            }
            if far < stretch.leave {
                stretch.leave = far;
                stretch.axes[1] = axis;
            }
        }
        stretch
    }
}

/// A stretch of a line inside a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Where it begins.
    pub enter: f64,
    /// Where it ends.
    pub leave: f64,
    /// The axes of the faces that it enters and leaves by.
    pub axes: [usize; 2],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_leaves_where_its_stretch_ends() {
        let [low, high] = [DVec3::new(-1.0, 2.0, 0.0), DVec3::new(3.0, 5.0, 0.5)];
        for n in 0..343u32 {
            let step = DVec3::from_array([n % 7, n / 7 % 7, n / 49].map(|k| f64::from(k) / 3.0 - 1.0));
            let line = Line {
                origin: DVec3::new(0.3, 4.1, 0.2) - 2.0 * step,
                step,
            };
            assert_eq!(line.leave(low, high), line.stretch(low, high).leave, "{step}");
        }
    }
}
