//! Energy: nothing gives more light than it gets, and what loses none gives all of it back.

use glam::DVec3;
use vcsg::image::Frame;
use vcsg::projection::Material;
use vcsg::projection::trace::{Bounds, Look, Optics, Sampling, Source, World, draw};

use crate::world::{along_z, glass, medium, mirror, picture, solid, world};

fn channels(frame: &Frame) -> impl Iterator<Item = f32> {
    frame.pixels().iter().flat_map(|[r, g, b, _]| [*r, *g, *b])
}

/// In a white furnace a body that loses no light cannot be seen: each pixel is the furnace, as far as rays are followed.
#[test]
fn bodies_without_loss_vanish_in_a_white_furnace() {
    let ball = "sphere radius=12";
    for optics in [
        mirror(1.0),
        glass(1.0),
        glass(1.5),
        glass(0.7),
        Optics::new(0.4, 1.0, 1.3).expect("optics"),
    ] {
        let world = world(vec![solid(ball, optics)], Vec::new(), Some([1.0; 3]));
        // Rays that are not followed see the furnace too.
        let frame = picture(&world, &along_z(40, 30.0), 1);
        for [r, g, b, a] in frame.pixels() {
            let behind = 1.0 - a;
            for c in [r, g, b] {
                // Channels are sums of a few hundred products in double precision, rounded once to single.
                assert!((c + behind - 1.0).abs() < 1e-6, "{optics:?}: {c} and {behind} behind");
            }
        }
    }
}

/// Where light is lost, by a tint, a depth bound with darkness behind, or scattering without lights, there is less.
#[test]
fn nothing_is_brighter_than_the_furnace() {
    let ball = "sphere radius=12";
    let tinted = glass(1.5).tinted([0.9, 0.5, 1.0], 5.0).expect("a tint");
    for optics in [
        tinted,
        mirror(0.6),
        Optics::new(0.2, 0.5, 1.4).expect("optics"),
        Optics::default(),
    ] {
        let objects = vec![
            solid(ball, optics),
            medium("sphere radius=5 center=\"6 0 -14\"", [0.7, 0.8, 0.9], 0.3),
        ];
        let world = world(objects, Vec::new(), Some([1.0; 3]));
        let frame = picture(&world, &along_z(40, 30.0), 1);
        assert!(channels(&frame).all(|c| (0.0..=1.0 + 1e-6).contains(&c)), "{optics:?}");
    }
}

/// Lit surfaces and media are never above the sum of the lights, whatever the factors of the material are.
#[test]
fn nothing_lit_is_brighter_than_its_lights() {
    let material = Material {
        ambient: 0.5,
        diffuse: 2.0,
        specular: 3.0,
        shininess_log2: 3,
    };
    let look = Look {
        material: Some(material),
        soft_gradient: 0.02,
        samples_per_voxel: 1.0,
        environment: Some([0.0; 3]),
    };
    let lights = vec![
        Source::far(DVec3::new(0.2, 0.1, -1.0), 0.7).expect("a light"),
        Source::point(DVec3::new(10.0, 5.0, -40.0), 0.8).expect("a light"),
        Source::area(DVec3::new(-20.0, 0.0, -30.0), 9.0 * DVec3::X, 9.0 * DVec3::Y, 0.5).expect("a light"),
    ];
    let objects = vec![
        solid("sphere radius=9 center=\"-5 0 0\"", mirror(0.3)),
        solid("box min=\"2 -9 -9\" max=\"9 9 9\"", Optics::default()),
        medium("sphere radius=6 center=\"0 8 -9\"", [1.0; 3], 0.4),
    ];
    let world = World::new(objects, lights, look).expect("a world");
    let frame = picture(&world, &along_z(60, 34.0), 2);
    let brightest = channels(&frame).fold(0.0, f32::max);
    println!("at most {brightest}, of lights of 2 in all");
    assert!(brightest <= 2.0 && brightest > 0.5);
}

/// Two mirrors face each other: the bound is hit, and the result is what is said: the environment for what is not followed.
#[test]
fn the_recursion_bound_gives_a_defined_result() {
    let between = "box min=\"-20 -20 8\" max=\"20 20 14\"; box min=\"-20 -20 -14\" max=\"20 20 -8\"";
    for (depth, expected) in [(0, 1.0), (3, 1.0), (Bounds::MAX_DEPTH, 1.0)] {
        let world = world(vec![solid(between, mirror(1.0))], Vec::new(), Some([1.0; 3]));
        let mut camera = along_z(8, 10.0);
        // Between the mirrors.
        camera.eye_from_world.translation = DVec3::new(0.0, 0.0, 0.5);
        camera.lens = vcsg::projection::Lens::Perspective {
            focal_px: 20.0,
            near_mm: 1e-3,
        };
        let sampling = Sampling {
            bounds: Bounds {
                depth,
                ..Bounds::default()
            },
            ..Sampling::default()
        };
        let frame = draw(&world, &camera, sampling, &|_| {}).expect("a frame");
        assert!(channels(&frame).all(|c| (c - expected).abs() < 1e-6));
    }
}
