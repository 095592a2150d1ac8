//! Meshes whose inside can be said in another way.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DVec2, DVec3};
use vcsg::math::Aabb;
use vcsg::voxelize::{Solid, TriangleMesh, TriangleSolid};

use crate::cases::{Case, Kind, Random};

/// The solid within a mesh that has one.
pub fn solid(mesh: &TriangleMesh) -> TriangleSolid {
    TriangleSolid::new(mesh).expect("a closed mesh")
}

fn case(mesh: &TriangleMesh, inside: impl Fn(DVec3) -> bool + Send + Sync + 'static) -> Case {
    Case {
        solid: Solid::Mesh(Arc::new(solid(mesh))),
        inside: Box::new(inside),
    }
}

/// The polygon `outline`, counter-clockwise and cut into `triangles`, from `-half_height` to `half_height` along z.
pub fn extruded(outline: &[DVec2], triangles: &[[u32; 3]], half_height: f64) -> TriangleMesh {
    let count = outline.len() as u32;
    let ring = |z: f64| outline.iter().map(move |p| p.extend(z));
    let mut mesh = TriangleMesh {
        positions: ring(-half_height).chain(ring(half_height)).collect(),
        triangles: Vec::new(),
    };
    for [a, b, c] in triangles {
        mesh.triangles.extend([[*a, *c, *b], [a + count, b + count, c + count]]);
    }
    for n in 0..count {
        let next = (n + 1) % count;
        mesh.triangles
            .extend([[n, next, next + count], [n, next + count, n + count]]);
    }
    mesh
}

/// The triangles of a convex polygon.
pub fn fan(corners: usize) -> Vec<[u32; 3]> {
    (2..corners as u32).map(|n| [0, n - 1, n]).collect()
}

/// A box.
pub fn cuboid(bounds: &Aabb) -> TriangleMesh {
    let half = 0.5 * bounds.size();
    let outline = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|p| DVec2::from(p) * half.truncate());
    let mut mesh = extruded(&outline, &fan(4), half.z);
    mesh.positions.iter_mut().for_each(|p| *p += bounds.center());
    mesh
}

/// A block of the size `size` without the quarter beyond `notch`, about the origin; not convex.
pub fn angle_iron(size: DVec2, notch: DVec2, half_height: f64) -> TriangleMesh {
    let corner = |x: f64, y: f64| DVec2::new(x, y) - 0.5 * size;
    let outline = [
        corner(0.0, 0.0),
        corner(size.x, 0.0),
        corner(size.x, notch.y),
        corner(notch.x, notch.y),
        corner(notch.x, size.y),
        corner(0.0, size.y),
    ];
    extruded(&outline, &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]], half_height)
}

/// A torus of quadrilaterals cut in two, `ring` times round the axis and `tube` times round the tube.
pub fn torus(ring: u32, tube: u32, [large, small]: [f64; 2]) -> TriangleMesh {
    let angle = |n: u32, of: u32| f64::from(n) * TAU / f64::from(of);
    let position = |i: u32, j: u32| {
        let section = DVec2::from_angle(angle(j, tube)) * small;
        (DVec2::from_angle(angle(i, ring)) * (large + section.x)).extend(section.y)
    };
    let places = || (0..ring).flat_map(move |i| (0..tube).map(move |j| (i, j)));
    let number = |i: u32, j: u32| i % ring * tube + j % tube;
    let quad = |(i, j): (u32, u32)| {
        let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    TriangleMesh {
        positions: places().map(|(i, j)| position(i, j)).collect(),
        triangles: places().flat_map(quad).collect(),
    }
}

/// Whether `p` is in [`torus`]: each sector of the ring is the section drawn out along a straight line.
pub fn in_torus(ring: u32, tube: u32, [large, small]: [f64; 2], p: DVec3) -> bool {
    let step = TAU / f64::from(ring);
    let sector = (p.truncate().to_angle().rem_euclid(TAU) / step).floor();
    let along = DVec2::from_angle((sector + 0.5) * step).dot(p.truncate());
    let section = DVec2::new(along / (0.5 * step).cos() - large, p.z);
    let apothem = small * (PI / f64::from(tube)).cos();
    (0..tube).all(|j| DVec2::from_angle((f64::from(j) + 0.5) * TAU / f64::from(tube)).dot(section) < apothem)
}

/// A ball of 20 · 4ⁿ triangles.
pub fn ball(radius: f64, halvings: u32) -> TriangleMesh {
    let g = 0.5 * (1.0 + 5f64.sqrt());
    let around = |a: f64, b: f64| [DVec3::new(0.0, a, b), DVec3::new(b, 0.0, a), DVec3::new(a, b, 0.0)];
    let ico = [around(1.0, g), around(1.0, -g), around(-1.0, g), around(-1.0, -g)].concat();
    let near = |a: usize, b: usize| ico[a].distance_squared(ico[b]) < 4.1;
    let mut corners = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in (b + 1..12).filter(|c| near(a, b) && near(b, *c) && near(a, *c)) {
                let is_out = (ico[b] - ico[a]).cross(ico[c] - ico[a]).dot(ico[a]) > 0.0;
                corners.push(if is_out {
                    [ico[a], ico[b], ico[c]]
                } else {
                    [ico[a], ico[c], ico[b]]
                });
            }
        }
    }
    for _ in 0..halvings {
        let parts = |[a, b, c]: [DVec3; 3]| {
            let [d, e, f] = [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5];
            [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
        };
        corners = corners.into_iter().flat_map(parts).collect();
    }
    soup(corners.into_iter().map(|t| t.map(|p| p.normalize() * radius)))
}

/// Triangles that share no vertices.
pub fn soup(corners: impl Iterator<Item = [DVec3; 3]>) -> TriangleMesh {
    let positions: Vec<DVec3> = corners.flatten().collect();
    let first = |n: u32| [3 * n, 3 * n + 1, 3 * n + 2];
    TriangleMesh {
        triangles: (0..positions.len() as u32 / 3).map(first).collect(),
        positions,
    }
}

/// Both in one mesh.
pub fn both(mut one: TriangleMesh, other: &TriangleMesh) -> TriangleMesh {
    let first = one.positions.len() as u32;
    one.positions.extend(&other.positions);
    one.triangles
        .extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
    one
}

/// With every triangle facing the other side.
pub fn inside_out(mut mesh: TriangleMesh) -> TriangleMesh {
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    mesh
}

/// Moved.
pub fn shifted(mut mesh: TriangleMesh, by: DVec3) -> TriangleMesh {
    mesh.positions.iter_mut().for_each(|p| *p += by);
    mesh
}

fn prism_case(r: &mut Random) -> Case {
    let sides = 3 + r.within(0.0, 9.0) as usize;
    let (radius, half) = (r.within(1.0, 14.0), r.within(0.3, 10.0));
    let corner = |n: usize| DVec2::from_angle(n as f64 * TAU / sides as f64) * radius;
    let outline: Vec<DVec2> = (0..sides).map(corner).collect();
    let apothem = radius * (PI / sides as f64).cos();
    case(&extruded(&outline, &fan(sides), half), move |p| {
        let normal = |n: usize| DVec2::from_angle((n as f64 + 0.5) * TAU / sides as f64);
        p.z.abs() < half && (0..sides).all(|n| normal(n).dot(p.truncate()) < apothem)
    })
}

fn angle_case(r: &mut Random) -> Case {
    let size = DVec2::new(r.within(2.0, 16.0), r.within(2.0, 16.0));
    let notch = size * DVec2::new(r.within(0.1, 0.9), r.within(0.1, 0.9));
    let half = r.within(0.3, 8.0);
    case(&angle_iron(size, notch, half), move |p| {
        let q = p.truncate() + 0.5 * size;
        let in_block = q.min_element() > 0.0 && q.cmplt(size).all() && p.z.abs() < half;
        in_block && q.cmplt(notch).any()
    })
}

fn torus_case(r: &mut Random) -> Case {
    let [ring, tube] = [3 + r.within(0.0, 14.0) as u32, 3 + r.within(0.0, 10.0) as u32];
    let large = r.within(2.0, 14.0);
    let sizes = [large, large * r.within(0.1, 0.9)];
    case(&torus(ring, tube, sizes), move |p| in_torus(ring, tube, sizes, p))
}

/// A box with a box-shaped hollow.
fn hollow_case(r: &mut Random) -> Case {
    let half = DVec3::new(r.within(1.0, 10.0), r.within(1.0, 10.0), r.within(1.0, 10.0));
    let inner = half * r.within(0.2, 0.95);
    let boxed = |half: DVec3| cuboid(&Aabb::new(-half, half));
    case(&both(boxed(half), &inside_out(boxed(inner))), move |p| {
        p.abs().cmplt(half).all() && !p.abs().cmplt(inner).all()
    })
}

/// Meshes for design law 7.
pub const KINDS: [Kind; 4] = [
    ("mesh of a prism", prism_case),
    ("mesh of an angle iron", angle_case),
    ("mesh of a torus", torus_case),
    ("mesh of a hollow box", hollow_case),
];
