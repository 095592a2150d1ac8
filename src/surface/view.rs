//! How meshes are seen: colour, lights and depth cue, the same as those of slices (LC87 §6 shades with the data's gradient).
//!
//! *Theory.* Gouraud (1971) lights vertices and interpolates colours, Phong (1975) interpolates normals and lights pixels.
//! *Changes from the papers.* Both sides of a surface are lit, as in [`Shading`](crate::projection::Shading), whose soft normal
//! is of length 1 here. Where a vertex has no normal, the triangle is lit as the plane it is.

use glam::DVec3;

use crate::math::Aabb;
use crate::projection::{Camera, FrameSpec, Settings, eye_from_lattice};

/// Where the colour of a mesh comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MeshColor {
    /// Display-referred red, green and blue in [0, 1] for all of it.
    Uniform([f32; 3]),
    /// [`Mesh::colors`](super::Mesh::colors) without their alpha; white if there are none.
    OfVertices,
}

/// Where a mesh is lit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MeshShading {
    /// At its vertices; colours are interpolated.
    Gouraud,
    /// At each pixel; normals are interpolated.
    #[default]
    Phong,
}

/// How an opaque mesh looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshLook {
    /// Its colour.
    pub color: MeshColor,
    /// Where it is lit.
    pub shading: MeshShading,
}

impl Default for MeshLook {
    fn default() -> Self {
        Self {
            color: MeshColor::Uniform([0.9, 0.85, 0.75]),
            shading: MeshShading::default(),
        }
    }
}

/// What meshes are seen with.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceView<'a> {
    /// The eye and the frame's size.
    pub camera: &'a Camera,
    /// Lights, material and depth cue; meshes are lit in every mode.
    pub settings: &'a Settings,
    /// The depths between which the depth cue darkens, millimetres.
    pub cue_mm: [f64; 2],
}

impl<'a> SurfaceView<'a> {
    /// For meshes in the volume of `spec`. The depth cue spans the volume, so that no mesh changes what that looks like.
    pub fn beside(spec: &FrameSpec<'a>) -> Self {
        let lattice = &spec.target.lattice;
        let depth = lattice.bounds().transformed(&eye_from_lattice(lattice, spec.camera));
        Self {
            camera: spec.camera,
            settings: spec.settings,
            cue_mm: [depth.min.z, depth.max.z],
        }
    }

    /// For meshes alone that fill `bounds` (world), which the depth cue spans.
    pub fn alone(camera: &'a Camera, settings: &'a Settings, bounds: &Aabb) -> Self {
        let depth = bounds.transformed(&camera.eye_from_world);
        Self {
            camera,
            settings,
            cue_mm: [depth.min.z, depth.max.z],
        }
    }

    /// What a surface of colour `rgb` sends to the eye, with `normal` (eye frame) of length 1, or 0 for no light at all.
    pub fn color(&self, rgb: DVec3, normal: DVec3, depth_mm: f64) -> DVec3 {
        let shading = self.settings.shading.as_ref();
        let (factor, highlight) = shading.map_or((1.0, 0.0), |shading| shading.response(normal));
        let [near, far] = self.cue_mm;
        self.settings.depth_cue.factor(depth_mm, near, far) * (factor * rgb + highlight)
    }
}

/// `normal` at length 1; zero if it has no direction or is not finite.
pub fn unit_normal(normal: [f32; 3]) -> DVec3 {
    DVec3::from_array(normal.map(f64::from)).normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_normal_without_direction_is_none() {
        assert_eq!(unit_normal([0.0; 3]), DVec3::ZERO);
        assert_eq!(unit_normal([f32::NAN, 0.0, 1.0]), DVec3::ZERO);
        assert_eq!(unit_normal([f32::INFINITY, 0.0, 1.0]), DVec3::ZERO);
        assert_eq!(unit_normal([0.0, -3.0, 0.0]), -DVec3::Y);
    }
}
