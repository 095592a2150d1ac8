//! Cameras: where the eye is, and how millimetres become pixels.
//!
//! The eye frame has x to the right, y down and z into the scene, so that depth is z, image rows run along y, and the frame
//! is right-handed. In the default view of a patient (LPS) the eye looks at the face: right is the patient's left, up is
//! superior.

use glam::{DAffine3, DMat3, DVec2, DVec3};

use crate::math::{Aabb, Viewpoint};

/// How rays leave the eye.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Projection {
    /// Parallel rays.
    #[default]
    Orthographic,
    /// Rays from one point.
    Perspective {
        /// Vertical field of view, degrees, in (0, 180).
        fov_y_deg: f64,
    },
}

/// A view in the words a user has for it; [`View::camera`] makes it a [`Camera`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Degrees round the superior axis; positive moves the eye to the patient's left.
    pub azimuth_deg: f64,
    /// Degrees above the axial plane; positive moves the eye up.
    pub elevation_deg: f64,
    /// Degrees about the line of sight; positive turns the picture clockwise.
    pub roll_deg: f64,
    /// Magnification: at 1 the bounding sphere of what is looked at fits the frame.
    pub zoom: f64,
    /// World point in the middle of the frame; the middle of the bounds when `None`.
    pub focus: Option<DVec3>,
    /// Parallel or perspective.
    pub projection: Projection,
}

impl Default for View {
    fn default() -> Self {
        Self {
            azimuth_deg: 0.0,
            elevation_deg: 0.0,
            roll_deg: 0.0,
            zoom: 1.0,
            focus: None,
            projection: Projection::default(),
        }
    }
}

/// The scale from eye space to pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// Pixels a millimetre.
    Orthographic {
        /// The scale at every depth.
        pixels_per_mm: f64,
    },
    /// The scale at depth z is `focal_px / z`.
    Perspective {
        /// Focal length in pixels.
        focal_px: f64,
        /// The nearest depth that is drawn, millimetres, above 0.
        near_mm: f64,
    },
}

/// A placed camera with its frame size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Rigid map from world millimetres to the eye frame.
    pub eye_from_world: DAffine3,
    /// Scale to pixels.
    pub lens: Lens,
    /// Width and height of the frame in pixels.
    pub size: [u32; 2],
}

/// A perspective eye sees nothing closer than this fraction of its distance from the focus.
const NEAR_FRACTION: f64 = 1e-3;

impl View {
    /// The camera that shows `bounds` (world) in a frame of `size` pixels.
    pub fn camera(&self, bounds: &Aabb, size: [u32; 2]) -> Camera {
        let radius = (bounds.size().length() * 0.5).max(f64::MIN_POSITIVE);
        let fitted_px = f64::from(size[0].min(size[1]));
        let pixels_per_mm = self.zoom * fitted_px / (2.0 * radius);
        let (lens, distance) = match self.projection {
            Projection::Orthographic => (Lens::Orthographic { pixels_per_mm }, 2.0 * radius),
            Projection::Perspective { fov_y_deg } => {
                let focal_px = 0.5 * f64::from(size[1]) / (0.5 * fov_y_deg.to_radians()).tan();
                let distance = focal_px / pixels_per_mm;
                let near_mm = distance * NEAR_FRACTION;
                (Lens::Perspective { focal_px, near_mm }, distance)
            }
        };
        let focus = self.focus.unwrap_or_else(|| bounds.center());
        let rotation = self.eye_from_world_rotation();
        let translation = DVec3::new(0.0, 0.0, distance) - rotation * focus;
        Camera {
            eye_from_world: DAffine3 {
                matrix3: rotation,
                translation,
            },
            lens,
            size,
        }
    }

    fn eye_from_world_rotation(&self) -> DMat3 {
        let (sin_a, cos_a) = self.azimuth_deg.to_radians().sin_cos();
        let (sin_e, cos_e) = self.elevation_deg.to_radians().sin_cos();
        let forward = DVec3::new(-sin_a * cos_e, cos_a * cos_e, -sin_e);
        let right = DVec3::new(cos_a, sin_a, 0.0);
        let down = forward.cross(right);
        let upright = DMat3::from_cols(right, down, forward).transpose();
        DMat3::from_rotation_z(self.roll_deg.to_radians()) * upright
    }
}

impl Camera {
    /// The nearest depth that is drawn, millimetres; parallel rays reach back without end.
    pub fn near_mm(&self) -> f64 {
        match self.lens {
            Lens::Orthographic { .. } => f64::NEG_INFINITY,
            Lens::Perspective { near_mm, .. } => near_mm,
        }
    }

    /// The ray through the centre of pixel `(x, y)`, as the eye-space point at depth `z` (millimetres).
    pub fn point_at_depth(&self, x: u32, y: u32, z: f64) -> DVec3 {
        self.unproject(DVec2::new(f64::from(x), f64::from(y)) + 0.5, z)
    }

    /// The eye-space point at depth `z` (millimetres) that falls on a place in the frame, in pixels.
    pub fn unproject(&self, px: DVec2, z: f64) -> DVec3 {
        let off_axis = px - self.center_px();
        match self.lens {
            Lens::Orthographic { pixels_per_mm } => (off_axis / pixels_per_mm).extend(z),
            Lens::Perspective { focal_px, .. } => (off_axis * (z / focal_px)).extend(z),
        }
    }

    /// Millimetres of ray through pixel `(x, y)` for each millimetre of depth; 1 for parallel rays.
    pub fn path_per_depth(&self, x: u32, y: u32) -> f64 {
        match self.lens {
            Lens::Orthographic { .. } => 1.0,
            Lens::Perspective { .. } => self.point_at_depth(x, y, 1.0).length(),
        }
    }

    /// Where an eye-space point falls in the frame, in pixels; pixel centres are at half-integers.
    pub fn project(&self, eye: DVec3) -> DVec2 {
        self.center_px() + eye.truncate() * self.pixels_per_mm(eye.z)
    }

    /// The scale of the picture of what is at depth `z`, millimetres.
    pub fn pixels_per_mm(&self, z: f64) -> f64 {
        match self.lens {
            Lens::Orthographic { pixels_per_mm } => pixels_per_mm,
            Lens::Perspective { focal_px, .. } => focal_px / z,
        }
    }

    /// Where the eye is, in the world: a point for perspective, else the direction towards the viewer.
    pub fn viewpoint(&self) -> Viewpoint {
        let world_from_eye = self.eye_from_world.inverse();
        match self.lens {
            Lens::Orthographic { .. } => Viewpoint::Direction(-world_from_eye.matrix3.z_axis),
            Lens::Perspective { .. } => Viewpoint::Point(world_from_eye.translation),
        }
    }

    /// The middle of the frame, pixels.
    pub(super) fn center_px(&self) -> DVec2 {
        DVec2::new(f64::from(self.size[0]), f64::from(self.size[1])) * 0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patient() -> Aabb {
        Aabb::new(DVec3::new(-80.0, -100.0, -90.0), DVec3::new(80.0, 100.0, 90.0))
    }

    #[test]
    fn the_default_view_faces_the_patient() {
        let camera = View::default().camera(&patient(), [100, 100]);
        let place = |p| camera.project(camera.eye_from_world.transform_point3(p));
        let middle = place(DVec3::ZERO);
        assert!(place(DVec3::X * 50.0).x > middle.x, "patient's left is on the right");
        assert!(place(DVec3::Z * 50.0).y < middle.y, "superior is up");
        let depth = |p| camera.eye_from_world.transform_point3(p).z;
        assert!(depth(-DVec3::Y) < depth(DVec3::Y), "the face is nearer");
    }

    #[test]
    fn a_pixel_and_its_ray_agree() {
        for projection in [Projection::Orthographic, Projection::Perspective { fov_y_deg: 40.0 }] {
            let view = View {
                azimuth_deg: 33.0,
                elevation_deg: -20.0,
                roll_deg: 10.0,
                projection,
                ..View::default()
            };
            let camera = view.camera(&patient(), [120, 80]);
            let px = camera.project(camera.point_at_depth(17, 61, 300.0));
            assert!((px - DVec2::new(17.5, 61.5)).length() < 1e-9, "{px}");
        }
    }

    #[test]
    fn the_bounding_sphere_fits_the_shorter_side() {
        let camera = View::default().camera(&patient(), [200, 100]);
        let radius = patient().size().length() * 0.5;
        let top = camera.eye_from_world.transform_point3(DVec3::Z * radius);
        assert!(camera.project(top).y.abs() < 1e-9);
    }
}
