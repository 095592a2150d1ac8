//! Pictures of meshes by casting a ray through each pixel at each triangle: slow, in double precision, and obviously right.

use glam::DVec3;
use rayon::prelude::*;

use super::facet::Facet;
use super::{Mesh, MeshLook, SurfaceView};

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
    let facets: Vec<Facet> = meshes
        .iter()
        .flat_map(|(mesh, look)| (0..mesh.triangles.len()).map(|n| Facet::new(view, mesh, look, n)))
        .collect();
    let [width, height] = view.camera.size;
    let pixel = |n: usize| {
        let (x, y) = ((n % width as usize) as u32, (n / width as usize) as u32);
        let base = view.camera.point_at_depth(x, y, 0.0);
        let slope = view.camera.point_at_depth(x, y, 1.0) - base;
        let hits = facets.iter().filter_map(|f| Some((f, meets(f.places(), base, slope)?)));
        let seen = hits.filter(|(_, met)| met.depth_mm >= view.camera.near_mm());
        let first = seen.min_by(|a, b| a.1.depth_mm.total_cmp(&b.1.depth_mm));
        first.map(|(facet, met)| Hit {
            depth_mm: met.depth_mm,
            color: facet.color(view, met.weights, met.depth_mm).to_array(),
        })
    };
    (0..width as usize * height as usize)
        .into_par_iter()
        .map(pixel)
        .collect()
}

/// Where a ray meets a triangle's plane within the triangle.
struct Met {
    depth_mm: f64,
    weights: [f64; 3],
}

/// Where the ray `base + depth · slope` meets the triangle: Cramer's rule for depth and the weights of two corners.
fn meets([a, b, c]: [DVec3; 3], base: DVec3, slope: DVec3) -> Option<Met> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Aabb;
    use crate::projection::{Settings, View};
    use crate::surface::MeshColor;

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
