//! Pictures of meshes by casting a ray through each pixel at each triangle: slow, in double precision, and obviously right.

use glam::DVec3;
use rayon::prelude::*;

use super::view::unit_normal;
use super::{Mesh, MeshColor, MeshLook, MeshShading, SurfaceView};
use crate::interface::FLAT_ABOVE;

/// Of the weights of corners with and without a normal, and of the length of a mean normal: what is as good as none.
const NONE_BELOW: f64 = 1.0 / FLAT_ABOVE as f64;

/// Where a ray first meets a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Depth, millimetres.
    pub depth_mm: f64,
    /// Display-referred red, green and blue.
    pub color: [f64; 3],
}

/// What each pixel's ray first meets, top row first.
pub fn hits(view: &SurfaceView, meshes: &[(&Mesh, MeshLook)]) -> Vec<Option<Hit>> {
    let triangles: Vec<Triangle> = meshes
        .iter()
        .flat_map(|(mesh, look)| (0..mesh.triangles.len()).map(|n| Triangle::new(view, mesh, look, n)))
        .collect();
    let [width, height] = view.camera.size;
    let pixel = |n: usize| {
        let (x, y) = ((n % width as usize) as u32, (n / width as usize) as u32);
        let base = view.camera.point_at_depth(x, y, 0.0);
        let slope = view.camera.point_at_depth(x, y, 1.0) - base;
        let hits = triangles.iter().filter_map(|t| Some((t, t.meets(base, slope)?)));
        let seen = hits.filter(|(_, met)| met.depth_mm >= view.camera.near_mm());
        let first = seen.min_by(|a, b| a.1.depth_mm.total_cmp(&b.1.depth_mm));
        first.map(|(triangle, met)| triangle.hit(view, &met))
    };
    (0..width as usize * height as usize)
        .into_par_iter()
        .map(pixel)
        .collect()
}

/// A corner of a triangle in the eye frame.
#[derive(Clone, Copy)]
struct Corner {
    place: DVec3,
    normal: DVec3,
    rgb: DVec3,
}

struct Triangle {
    corners: [Corner; 3],
    shading: MeshShading,
}

/// Where a ray meets a triangle's plane within the triangle.
struct Met {
    depth_mm: f64,
    weights: [f64; 3],
}

impl Triangle {
    fn new(view: &SurfaceView, mesh: &Mesh, look: &MeshLook, n: usize) -> Self {
        let eye = view.camera.eye_from_world;
        let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let rgb = |v: usize| match look.color {
            MeshColor::Uniform(rgb) => vector(rgb),
            MeshColor::OfVertices => mesh.colors.get(v).map_or(DVec3::ONE, |&[r, g, b, _]| {
                DVec3::from_array([r, g, b].map(|c| f64::from(c) / 255.0))
            }),
        };
        let corner = |v: u32| Corner {
            place: eye.transform_point3(vector(mesh.positions[v as usize])),
            normal: eye.matrix3 * mesh.normals.get(v as usize).map_or(DVec3::ZERO, |n| unit_normal(*n)),
            rgb: rgb(v as usize),
        };
        Self {
            corners: mesh.triangles[n].map(corner),
            shading: look.shading,
        }
    }

    /// Where the ray `base + depth · slope` meets the triangle: Cramer's rule for depth and the weights of two corners.
    fn meets(&self, base: DVec3, slope: DVec3) -> Option<Met> {
        let [a, b, c] = self.corners.map(|corner| corner.place);
        let (ab, ac, to_a) = (b - a, c - a, a - base);
        let normal = ab.cross(ac);
        let facing = slope.dot(normal);
        if facing == 0.0 {
            return None;
        }
        let across = to_a.cross(slope);
        let (second, third) = (ac.dot(across) / facing, -ab.dot(across) / facing);
        let weights = [1.0 - second - third, second, third];
        let inside = weights.iter().all(|w| *w >= 0.0);
        inside.then(|| Met {
            depth_mm: to_a.dot(normal) / facing,
            weights,
        })
    }

    fn hit(&self, view: &SurfaceView, met: &Met) -> Hit {
        let mean = |of: &dyn Fn(&Corner) -> DVec3| -> DVec3 {
            self.corners.iter().zip(met.weights).map(|(c, w)| w * of(c)).sum()
        };
        let is_flat = |c: &Corner| c.normal == DVec3::ZERO;
        let corners = self.corners.iter().zip(met.weights);
        let without: f64 = corners.filter(|(c, _)| is_flat(c)).map(|(_, w)| w).sum();
        let normal = mean(&|c| c.normal);
        let rgb = mean(&|c| c.rgb);
        let color = if without >= NONE_BELOW {
            view.color(rgb, self.plane(), met.depth_mm)
        } else {
            match self.shading {
                MeshShading::Gouraud => mean(&|c| view.color(c.rgb, c.normal, c.place.z)),
                MeshShading::Phong if normal.length() > NONE_BELOW => view.color(rgb, normal.normalize(), met.depth_mm),
                MeshShading::Phong => view.color(rgb, self.plane(), met.depth_mm),
            }
        };
        Hit {
            depth_mm: met.depth_mm,
            color: color.to_array(),
        }
    }

    fn plane(&self) -> DVec3 {
        let [a, b, c] = self.corners.map(|corner| corner.place);
        (b - a).cross(c - a).normalize_or_zero()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Aabb;
    use crate::projection::{Settings, View};

    fn triangle(z: f32) -> Mesh {
        Mesh {
            positions: vec![[-10.0, z, -10.0], [10.0, z, -10.0], [0.0, z, 10.0]].into(),
            triangles: vec![[0, 1, 2]].into(),
            ..Mesh::default()
        }
    }

    #[test]
    fn the_nearest_triangle_is_met_where_it_is() {
        let bounds = Aabb::new(DVec3::splat(-10.0), DVec3::splat(10.0));
        let camera = View::default().camera(&bounds, [9, 9]);
        let settings = Settings {
            shading: None,
            ..Settings::default()
        };
        let view = SurfaceView::alone(&camera, &settings, &bounds);
        let (near, far) = (triangle(-5.0), triangle(5.0));
        let look = |rgb| MeshLook {
            color: MeshColor::Uniform(rgb),
            ..MeshLook::default()
        };
        let seen = hits(&view, &[(&far, look([0.0; 3])), (&near, look([1.0, 0.5, 0.0]))]);
        let middle = seen[9 * 4 + 4].expect("a hit in the middle");
        let expected = camera.eye_from_world.transform_point3(DVec3::new(0.0, -5.0, 0.0)).z;
        assert!((middle.depth_mm - expected).abs() < 1e-12 * expected);
        assert_eq!(middle.color, [1.0, 0.5, 0.0]);
        assert!(seen[0].is_none(), "nothing is in the corner");
    }
}
