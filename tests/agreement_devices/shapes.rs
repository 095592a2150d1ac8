//! Meshes that follow from a seed, in the cube from −20 to 20 mm.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec3};
use vcsg::math::Aabb;
use vcsg::projection::{Camera, DepthCue, Light, Material, Projection, Settings, Shading, View};
use vcsg::surface::{Mesh, MeshColor, MeshLook, MeshShading};

use crate::random::Random;

pub const FRAME_PX: [u32; 2] = [72, 60];

/// Meshes and how they are seen.
pub struct Shapes {
    pub meshes: Vec<(Mesh, MeshLook)>,
    pub camera: Camera,
    pub settings: Settings,
}

impl Shapes {
    pub fn random(seed: u64) -> Self {
        let random = &mut Random(seed);
        let count = 1 + random.below(3);
        let meshes: Vec<_> = (0..count).map(|_| (mesh(random), look(random))).collect();
        let cube = Aabb::new(DVec3::splat(-20.0), DVec3::splat(20.0));
        Self {
            meshes,
            camera: view(random).camera(&cube, FRAME_PX),
            settings: settings(random),
        }
    }

    pub fn borrowed(&self) -> Vec<(&Mesh, MeshLook)> {
        self.meshes.iter().map(|(mesh, look)| (mesh, *look)).collect()
    }
}

fn mesh(random: &mut Random) -> Mesh {
    let center = direction(random) * random.between(0.0, 8.0);
    let turn = DQuat::from_rotation_arc(DVec3::Z, direction(random));
    let mut mesh = match random.below(4) {
        0 => triangles(random),
        1 => grid([3 + random.below(12), 3 + random.below(6)], |u, v| {
            torus(center, turn, 11.0, 4.0, u, v)
        }),
        _ => {
            let radius = random.between(4.0, 13.0);
            grid([3 + random.below(14), 2 + random.below(9)], |u, v| {
                let normal = ball(u, v);
                (center + radius * normal, normal)
            })
        }
    };
    match random.below(6) {
        0 => mesh.normals.truncate(0),
        1 => mesh.normals.iter_mut().for_each(|n| *n = [f32::NAN; 3]),
        _ => {}
    }
    mesh.colors = (0..mesh.positions.len())
        .map(|_| [0; 4].map(|_: u8| random.below(256) as u8))
        .collect();
    mesh
}

/// A few anywhere, with normals of any direction.
fn triangles(random: &mut Random) -> Mesh {
    let count = 1 + random.below(6) as u32;
    let vertices = 3 * count;
    Mesh {
        positions: (0..vertices)
            .map(|_| single(direction(random) * random.between(2.0, 20.0)))
            .collect(),
        normals: (0..vertices).map(|_| single(direction(random))).collect(),
        triangles: (0..count).map(|n| [3 * n, 3 * n + 1, 3 * n + 2]).collect(),
        ..Mesh::default()
    }
}

fn torus(center: DVec3, turn: DQuat, large: f64, small: f64, u: f64, v: f64) -> (DVec3, DVec3) {
    let outwards = DVec3::new((TAU * u).cos(), (TAU * u).sin(), 0.0);
    let normal = outwards * (TAU * v).cos() + DVec3::Z * (TAU * v).sin();
    (center + turn * (large * outwards + small * normal), turn * normal)
}

fn ball(u: f64, v: f64) -> DVec3 {
    let (sin, cos) = (PI * v).sin_cos();
    DVec3::new(sin * (TAU * u).cos(), sin * (TAU * u).sin(), cos)
}

/// Two triangles for each cell of a grid over [0, 1]², of which `at` gives place and normal.
fn grid(cells: [usize; 2], at: impl Fn(f64, f64) -> (DVec3, DVec3)) -> Mesh {
    let [columns, rows] = cells;
    let mut mesh = Mesh::default();
    for (column, row) in (0..=columns).flat_map(|c| (0..=rows).map(move |r| (c, r))) {
        let (place, normal) = at(column as f64 / columns as f64, row as f64 / rows as f64);
        mesh.positions.to_mut().push(single(place));
        mesh.normals.to_mut().push(single(normal));
        if column < columns && row < rows {
            let vertex = |c: usize, r: usize| (c * (rows + 1) + r) as u32;
            let [a, b] = [vertex(column, row), vertex(column + 1, row)];
            mesh.triangles.to_mut().extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    mesh
}

/// A sheet across `center`, twelve millimetres each way along `across`.
pub fn sheet(center: DVec3, across: [DVec3; 2]) -> Mesh {
    let normal = across[0].cross(across[1]).normalize();
    grid([3, 2], |u, v| {
        let place = center + (2.0 * u - 1.0) * across[0] + (2.0 * v - 1.0) * across[1];
        (place, normal)
    })
}

/// A ball of `radius`.
pub fn sphere(center: DVec3, radius: f64) -> Mesh {
    grid([12, 8], |u, v| (center + radius * ball(u, v), ball(u, v)))
}

fn single(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

fn direction(random: &mut Random) -> DVec3 {
    ball(random.between(0.0, 1.0), random.between(0.0, 1.0))
}

pub fn look(random: &mut Random) -> MeshLook {
    let rgb = [0.0; 3].map(|_: f64| random.between(0.0, 1.0) as f32);
    MeshLook {
        color: random.of(&[MeshColor::Uniform(rgb), MeshColor::OfVertices]),
        shading: random.of(&[MeshShading::Gouraud, MeshShading::Phong]),
    }
}

/// From all sides, with both lenses, some of them within.
fn view(random: &mut Random) -> View {
    let perspective = Projection::Perspective {
        fov_y_deg: random.between(20.0, 100.0),
    };
    View {
        azimuth_deg: random.between(-180.0, 180.0),
        elevation_deg: random.between(-80.0, 80.0),
        roll_deg: random.between(-180.0, 180.0),
        zoom: random.between(0.8, 4.0),
        projection: random.of(&[Projection::Orthographic, perspective]),
        ..View::default()
    }
}

fn settings(random: &mut Random) -> Settings {
    let lights = 1 + random.below(Shading::MAX_LIGHTS);
    let lights = (0..lights).map(|_| Light {
        towards: direction(random),
        intensity: random.between(0.1, 0.6) as f32,
    });
    let shading = Shading {
        lights: lights.collect(),
        material: Material {
            shininess_log2: random.below(7) as u32,
            ..Material::default()
        },
        ..Shading::default()
    };
    let lit = random.below(8) > 0;
    Settings {
        shading: lit.then_some(shading),
        depth_cue: DepthCue {
            strength: random.of(&[0.0, 0.7]),
        },
        ..Settings::default()
    }
}
