//! Meshes of which something is known.

use glam::{DAffine3, DVec3};
use vcsg::surface::{Mesh, Part, marching_cubes};
use vcsg::volume::{Grid, Voxels, io};

/// `f` at the points of an `n`³ lattice in the middle of which is the origin, `spacing` apart.
pub fn lattice(n: usize, spacing: f64, f: impl Fn(DVec3) -> f64) -> Grid {
    let middle = (n - 1) as f64 / 2.0;
    let at = |i: usize| (i as f64 - middle) * spacing;
    let values = (0..n * n * n).map(|v| f(DVec3::new(at(v % n), at(v / n % n), at(v / (n * n)))));
    let world_from_index = DAffine3 {
        translation: DVec3::splat(-middle * spacing),
        ..DAffine3::from_scale(DVec3::splat(spacing))
    };
    Grid::new([n; 3], world_from_index, Voxels::F64(values.collect())).expect("a grid")
}

/// The surface where `f` is 0 on such a lattice.
pub fn surface(n: usize, spacing: f64, f: impl Fn(DVec3) -> f64) -> Mesh {
    marching_cubes(&lattice(n, spacing, f), 0.0).expect("a mesh")
}

pub fn torus(p: DVec3) -> f64 {
    3.0 - DVec3::new(p.x.hypot(p.y) - 8.0, p.z, 0.0).length()
}

/// A large ball and, apart from it, a small one.
pub fn two_balls(p: DVec3) -> f64 {
    let ball = |center: DVec3, radius: f64| radius - p.distance(center);
    ball(DVec3::splat(-2.0), 5.0).max(ball(DVec3::splat(6.0), 2.5))
}

/// A box of `size`, one corner at `corner`, its sides facing outwards.
pub fn cuboid(corner: [f32; 3], size: [f32; 3]) -> Mesh {
    let position = |v: usize| std::array::from_fn(|a| corner[a] + if v >> a & 1 == 1 { size[a] } else { 0.0 });
    let sides = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    mesh(
        (0..8).map(position).collect(),
        sides
            .iter()
            .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
            .collect(),
    )
}

/// A mesh of one part.
pub fn mesh(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh {
        normals: vec![[0.0, 0.0, 1.0]; positions.len()].into(),
        parts: vec![Part {
            label: 1,
            iso: Some(0.0),
            triangles: 0..triangles.len(),
        }],
        positions: positions.into(),
        triangles: triangles.into(),
        ..Mesh::default()
    }
}

/// `a` and then `b`, with the parts of both.
pub fn joined(mut a: Mesh, b: Mesh) -> Mesh {
    let (vertices, triangles) = (a.positions.len() as u32, a.triangles.len());
    a.positions.to_mut().extend(&b.positions);
    a.normals.to_mut().extend(&b.normals);
    a.triangles
        .to_mut()
        .extend(b.triangles.iter().map(|t| t.map(|v| v + vertices)));
    a.parts.extend(b.parts.into_iter().map(|part| Part {
        triangles: part.triangles.start + triangles..part.triangles.end + triangles,
        ..part
    }));
    a
}

/// `mesh` with a value and a colour that tell each vertex.
pub fn marked(mut mesh: Mesh) -> Mesh {
    mesh.values = (0..mesh.positions.len()).map(|v| v as f32).collect();
    mesh.colors = (0..mesh.positions.len() as u32).map(u32::to_le_bytes).collect();
    mesh
}

/// The MR head.
pub fn head() -> Grid {
    let volume = io::read("target/deps/data/ch2.nii.gz".as_ref());
    volume.unwrap_or_else(|error| panic!("{error}; run make setup")).grid
}
