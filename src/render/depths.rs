//! The depths that are tested: what is nearer has the smaller number.
//!
//! *Practice.* With parallel rays the number is linear in depth, else in the depth's inverse, which is what a rasteriser
//! interpolates exactly. The nearest thing is at 0 or a little above and the farthest at 1/2; 1 is free, and a pixel is closed
//! at 0. Under perspective a step of single precision at depth z is about 2⁻²³ z² (1/near − 1/far): 10⁻⁴ mm for a patient seen
//! from a metre's distance, a tenth of a millimetre for an eye within the body.

use glam::DVec3;

use crate::math::Aabb;
use crate::projection::{Camera, Lens};

/// From depth to the number that is tested.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthScale {
    /// What is multiplied by depth, or under perspective by 1.
    pub factor: f64,
    /// What is added to that, under perspective divided by depth.
    pub summand: f64,
    /// Whether it is so.
    pub perspective: bool,
}

/// What the farthest is held as.
const FARTHEST: f64 = 0.5;

/// Room before the nearest and behind the farthest, in parts of the span between: nothing is cut off by rounding.
const ROOM: f64 = 1.0 / 64.0;

/// The same in parts of the depth, for thin things far away: 2⁶ steps of single precision.
const ROUNDING: f64 = 1.0 / (1u32 << 17) as f64;

impl DepthScale {
    /// For what fills `bounds` in the eye frame; any if they are empty or endless.
    pub fn new(camera: &Camera, bounds: &Aabb) -> Self {
        let [nearest, farthest] = [bounds.min.z, bounds.max.z];
        if !bounds.is_finite() {
            return Self::new(camera, &Aabb::new(DVec3::ONE, DVec3::ONE));
        }
        let sideways = bounds.min.abs().max(bounds.max.abs()).max_element();
        let room = ROOM * (farthest - nearest) + ROUNDING * sideways + f64::from(f32::MIN_POSITIVE);
        match camera.lens {
            Lens::Orthographic { .. } => {
                let (near, far) = (nearest - room, farthest + room);
                let factor = FARTHEST / (far - near);
                Self {
                    factor,
                    summand: -factor * near,
                    perspective: false,
                }
            }
            Lens::Perspective { near_mm, .. } => {
                let near = (nearest - room).max(near_mm);
                let far = (farthest + room).max(2.0 * near);
                let summand = -FARTHEST / (near.recip() - far.recip());
                Self {
                    factor: -summand / near,
                    summand,
                    perspective: true,
                }
            }
        }
    }

    /// The number at a depth.
    pub fn at(&self, depth_mm: f64) -> f64 {
        let [product, summand] = self.terms(depth_mm);
        product + summand
    }

    /// The two terms of the number at a depth.
    pub fn terms(&self, depth_mm: f64) -> [f64; 2] {
        if self.perspective {
            [self.factor, self.summand / depth_mm]
        } else {
            [self.factor * depth_mm, self.summand]
        }
    }

    /// How fast the number rises at a depth, for each millimetre.
    pub fn slope(&self, depth_mm: f64) -> f64 {
        if self.perspective {
            -self.summand / (depth_mm * depth_mm)
        } else {
            self.factor
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::{Projection, View};

    #[test]
    fn what_is_there_is_before_what_is_cleared() {
        for projection in [Projection::Orthographic, Projection::Perspective { fov_y_deg: 40.0 }] {
            let view = View {
                projection,
                ..View::default()
            };
            let world = Aabb::new(DVec3::splat(-100.0), DVec3::splat(100.0));
            let camera = view.camera(&world, [64, 64]);
            let eye = world.transformed(&camera.eye_from_world);
            let scale = DepthScale::new(&camera, &eye);
            let [near, far] = [scale.at(eye.min.z), scale.at(eye.max.z)];
            assert!(0.0 < near && near < far && far <= FARTHEST, "{near} {far}");
        }
    }
}
