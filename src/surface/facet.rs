//! One triangle as it is seen: its corners in the eye frame, and what any point of it looks like, in double precision.

use glam::DVec3;

use super::view::unit_normal;
use super::{Mesh, MeshColor, MeshLook, MeshShading, SurfaceView};
use crate::interface::FLAT_ABOVE;

/// Of the weights of corners with and without a normal, and of the length of a mean normal: what is as good as none.
const NONE_BELOW: f64 = 1.0 / FLAT_ABOVE as f64;

/// A corner in the eye frame.
#[derive(Clone, Copy)]
struct Corner {
    place: DVec3,
    normal: DVec3,
    rgb: DVec3,
}

/// A triangle and how it is lit.
pub(super) struct Facet {
    corners: [Corner; 3],
    shading: MeshShading,
}

impl Facet {
    /// Triangle `n` of `mesh`, whose vertices exist.
    pub fn new(view: &SurfaceView, mesh: &Mesh, look: &MeshLook, n: usize) -> Self {
        let eye = view.camera.eye_from_world;
        let rgb = |v: usize| match look.color {
            MeshColor::Uniform(rgb) => vector(rgb),
            MeshColor::OfVertices => mesh.colors.get(v).map_or(DVec3::ONE, |&[r, g, b, _]| {
                DVec3::from_array([r, g, b].map(|c| f64::from(c) / 255.0))
            }),
        };
        let places = places(view, mesh, n);
        let corner = |c: usize| {
            let v = mesh.triangles[n][c] as usize;
            Corner {
                place: places[c],
                normal: eye.matrix3 * mesh.normals.get(v).map_or(DVec3::ZERO, |n| unit_normal(*n)),
                rgb: rgb(v),
            }
        };
        Self {
            corners: [0, 1, 2].map(corner),
            shading: look.shading,
        }
    }

    /// Where the corners are.
    pub fn places(&self) -> [DVec3; 3] {
        self.corners.map(|corner| corner.place)
    }

    /// What the point sends to the eye that is at `depth_mm`, of whose place the corners have these parts.
    pub fn color(&self, view: &SurfaceView, weights: [f64; 3], depth_mm: f64) -> DVec3 {
        let mean =
            |of: &dyn Fn(&Corner) -> DVec3| -> DVec3 { self.corners.iter().zip(weights).map(|(c, w)| w * of(c)).sum() };
        let is_flat = |c: &Corner| c.normal == DVec3::ZERO;
        let corners = self.corners.iter().zip(weights);
        let without: f64 = corners.filter(|(c, _)| is_flat(c)).map(|(_, w)| w).sum();
        let normal = mean(&|c| c.normal);
        let rgb = mean(&|c| c.rgb);
        if without >= NONE_BELOW {
            return view.color(rgb, self.plane(), depth_mm);
        }
        match self.shading {
            MeshShading::Gouraud => mean(&|c| view.color(c.rgb, c.normal, c.place.z)),
            MeshShading::Phong if normal.length() > NONE_BELOW => view.color(rgb, normal.normalize(), depth_mm),
            MeshShading::Phong => view.color(rgb, self.plane(), depth_mm),
        }
    }

    fn plane(&self) -> DVec3 {
        let [a, b, c] = self.places();
        (b - a).cross(c - a).normalize_or_zero()
    }
}

/// The corners of triangle `n` of `mesh` in the eye frame.
pub(super) fn places(view: &SurfaceView, mesh: &Mesh, n: usize) -> [DVec3; 3] {
    let place = |v: u32| {
        view.camera
            .eye_from_world
            .transform_point3(vector(mesh.positions[v as usize]))
    };
    mesh.triangles[n].map(place)
}

fn vector(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}
