//! The same picture however it is computed, and defined pictures at the edges.

use glam::DVec3;
use vcsg::image::Frame;
use vcsg::projection::trace::{Bounds, Object, Optics, Progressive, Sampling, Source, World, draw};
use vcsg::projection::{Lens, Light, ProjectError, Settings, Shading};
use vcsg::target::Subdivision;

use crate::world::{along_z, even, glass, medium, mirror, picture, solid, target_of, world};

/// A bit of everything.
fn mixed(subdivision: &Subdivision) -> World {
    let made = |shapes: &str, color, optics| Object::new(&target_of(shapes, subdivision), &even(color, 0.9), optics);
    let objects = vec![
        made(
            "box min=\"-30 -30 16\" max=\"30 30 22\"",
            [0.8, 0.9, 1.0],
            Some(mirror(0.5)),
        ),
        made("sphere radius=9 center=\"-8 2 0\"", [1.0; 3], Some(glass(1.5))),
        made(
            "torus radius=8 tube=3 center=\"9 -3 2\" axis=\"1 2 3\"",
            [0.9, 0.5, 0.2],
            None,
        ),
        made(
            "cone radius=7 from=\"2 12 10\" to=\"2 12 -8\"",
            [0.3, 0.8, 0.4],
            Some(Optics::default()),
        ),
    ];
    let lights = vec![
        Source::area(DVec3::new(-30.0, -30.0, -60.0), 20.0 * DVec3::X, 20.0 * DVec3::Y, 0.8).expect("a light"),
        Source::point(DVec3::new(40.0, -20.0, -30.0), 0.3).expect("a light"),
    ];
    world(objects, lights, Some([0.1, 0.2, 0.3]))
}

fn bits(frame: &Frame) -> Vec<u32> {
    frame.pixels().as_flattened().iter().map(|c| c.to_bits()).collect()
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let world = mixed(&Subdivision::default());
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        bits(&pool.install(|| picture(&world, &along_z(50, 50.0), 2)))
    };
    let one = on(1);
    assert!(one == on(2) && one == on(3));
}

#[test]
fn blocks_do_not_show() {
    let blocks = |edge| Subdivision {
        min_block: edge,
        max_block: edge,
        ..Subdivision::default()
    };
    let frame = |subdivision| picture(&mixed(&subdivision), &along_z(60, 50.0), 1);
    let (one, many) = (frame(blocks(128)), frame(blocks(8)));
    // Where cells begin and end decides where samples are, so that places of surfaces differ by what secants leave: 1e-4 of
    // density. A pixel that sees an edge in a mirror can differ by more.
    let off = |a: &[f32; 4], b: &[f32; 4]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    let differences: Vec<f32> = one.pixels().iter().zip(many.pixels()).map(|(a, b)| off(a, b)).collect();
    let mean = differences.iter().sum::<f32>() / differences.len() as f32;
    let worst = differences.iter().fold(0.0f32, |worst, d| worst.max(*d));
    println!("on average {mean:.2e}, at most {worst:.3}");
    assert!(mean < 2e-3);
}

#[test]
fn seeds_differ_and_passes_add_up() {
    let world = mixed(&Subdivision::default());
    let camera = along_z(30, 50.0);
    let sampling = |seed| Sampling {
        samples: 3,
        seed,
        ..Sampling::default()
    };
    let frame = |seed| bits(&draw(&world, &camera, sampling(seed), &|_| {}).expect("a frame"));
    assert!(frame(1) == frame(1) && frame(1) != frame(2));
    // What is there after each pass is the frame of as many samples.
    let mut progressive = Progressive::new(&world, &camera, sampling(0)).expect("a frame");
    for samples in 1..=3 {
        progressive.pass(&|_| {});
        assert_eq!(bits(&progressive.frame()), bits(&picture(&world, &camera, samples)));
    }
}

#[test]
fn progress_counts_every_sample() {
    let counted = std::sync::atomic::AtomicU64::new(0);
    let world = mixed(&Subdivision::default());
    let sampling = Sampling {
        samples: 2,
        ..Sampling::default()
    };
    let count = |n| {
        counted.fetch_add(n, std::sync::atomic::Ordering::Relaxed);
    };
    draw(&world, &along_z(37, 50.0), sampling, &count).expect("a frame");
    assert_eq!(counted.into_inner(), 2 * 37 * 37);
}

#[test]
fn frames_without_pixels_and_endless_ones_are_refused() {
    let world = world(Vec::new(), Vec::new(), None);
    for size in [[0, 5], [5, 0], [0, 0], [40_000, 1], [1, u32::MAX]] {
        let mut camera = along_z(8, 8.0);
        camera.size = size;
        let refused = draw(&world, &camera, Sampling::default(), &|_| {});
        assert!(matches!(refused, Err(ProjectError::FrameSize { .. })), "{size:?}");
    }
}

#[test]
fn too_many_objects_are_refused() {
    let objects = |count| (0..count).map(|_| medium("sphere radius=2", [1.0; 3], 0.5)).collect();
    let look = *world(Vec::new(), Vec::new(), None).look();
    assert!(World::new(objects(World::MAX_OBJECTS), Vec::new(), look).is_ok());
    assert!(World::new(objects(World::MAX_OBJECTS + 1), Vec::new(), look).is_err());
}

#[test]
fn a_world_of_nothing_is_transparent() {
    for objects in [Vec::new(), vec![medium("sphere radius=4", [1.0; 3], 0.0)], vec![]] {
        let frame = picture(&world(objects, Vec::new(), Some([1.0; 3])), &along_z(8, 10.0), 2);
        assert!(frame.pixels().iter().all(|pixel| *pixel == [0.0; 4]));
    }
    let nothing = Object::new(
        &target_of("sphere radius=4", &Subdivision::default()),
        &even([1.0; 3], 0.0),
        Some(mirror(1.0)),
    );
    let frame = picture(&world(vec![nothing], Vec::new(), Some([1.0; 3])), &along_z(8, 10.0), 1);
    assert!(frame.pixels().iter().all(|pixel| *pixel == [0.0; 4]));
}

/// Eyes in media, in glass, in opaque solids, in soft surfaces: every pixel is a finite colour.
#[test]
fn an_eye_in_a_volume_sees_something_defined() {
    let world = mixed(&Subdivision::default());
    let eyes = [
        [0.0, 0.0, 19.0],
        [-8.0, 2.0, 0.0],
        [9.0, -3.0, 2.0],
        [2.0, 12.0, 5.0],
        [-8.0, 2.0, -9.0],
        [1.0, -7.0, 5.0],
    ];
    for eye in eyes.map(DVec3::from_array) {
        let mut camera = along_z(24, 10.0);
        camera.eye_from_world.translation = -eye;
        camera.lens = Lens::Perspective {
            focal_px: 10.0,
            near_mm: 1e-6,
        };
        let frame = picture(&world, &camera, 1);
        let fine = |c: &f32| c.is_finite() && (0.0..=2.0).contains(c);
        assert!(frame.pixels().as_flattened().iter().all(fine), "{eye}");
    }
}

/// Within a glass ball at its middle rays leave straight.
#[test]
fn from_the_middle_of_a_glass_ball_nothing_is_bent() {
    let wall = solid("box min=\"-40 -40 20\" max=\"0 40 26\"", Optics::default());
    let ball = solid("sphere radius=8", glass(1.5));
    let light = Source::point(DVec3::new(0.0, 0.0, 12.0), 1.0).expect("a light");
    let world = world(vec![wall, ball], vec![light], None);
    let mut camera = along_z(64, 10.0);
    camera.eye_from_world.translation = DVec3::ZERO;
    camera.lens = Lens::Perspective {
        focal_px: 64.0,
        near_mm: 1e-6,
    };
    let frame = picture(&world, &camera, 1);
    let middle_row = &frame.pixels()[32 * 64..33 * 64];
    let lit = middle_row.iter().filter(|pixel| pixel[0] > 0.1).count();
    // The wall's edge at x = 0 is in the middle; a pixel is a third of a voxel there.
    assert!((30..=34).contains(&lit), "{lit} of 64");
}

/// What is not followed is cut off softly: one generation more changes a picture by no more than what that generation weighs.
#[test]
fn deeper_rays_matter_less() {
    let world = mixed(&Subdivision::default());
    let frame = |depth| {
        let bounds = Bounds {
            depth,
            ..Bounds::default()
        };
        let sampling = Sampling {
            bounds,
            ..Sampling::default()
        };
        draw(&world, &along_z(40, 50.0), sampling, &|_| {}).expect("a frame")
    };
    let difference = |a: &Frame, b: &Frame| {
        let (a, b) = (a.pixels().as_flattened(), b.pixels().as_flattened());
        a.iter().zip(b).map(|(a, b)| f64::from(a - b).abs()).sum::<f64>() / a.len() as f64
    };
    let frames = [0, 1, 2, 4, 8, 16].map(frame);
    let steps: Vec<f64> = frames.windows(2).map(|pair| difference(&pair[0], &pair[1])).collect();
    assert!(
        steps[1] > 0.01 && steps[3] < 0.02 * steps[1] && steps[4] <= steps[3],
        "{steps:?}"
    );
}

/// Points in glass, on a surface, where the eye's rays meet it, areas small and vast, lights of no strength: every pixel is a finite colour.
#[test]
fn lights_in_odd_places_give_something_defined() {
    let objects = || {
        vec![
            solid("box min=\"-30 -30 16\" max=\"30 30 22\"", Optics::default()),
            solid("sphere radius=9", glass(1.5)),
            medium("sphere radius=5 center=\"14 0 0\"", [1.0; 3], 0.3),
        ]
    };
    let point = |x, y, z| Source::point(DVec3::new(x, y, z), 1.0);
    let area = |mm: f64| Source::area(DVec3::new(0.0, 0.0, -40.0), mm * DVec3::X, mm * DVec3::Y, 1.0);
    let lights = [
        point(0.0, 0.0, 0.0),
        point(9.0, 0.0, 0.0),
        point(0.0, 0.0, 16.0),
        point(5.0, 5.0, 19.0),
        point(14.0, 0.0, 0.0),
        point(1e12, 0.0, 0.0),
        area(1e-9),
        area(1e9),
        Source::far(DVec3::Z, 1.0),
    ];
    for light in lights {
        let light = light.expect("a light");
        let frame = picture(&world(objects(), vec![light], None), &along_z(24, 50.0), 1);
        let fine = |c: &f32| c.is_finite() && (0.0..=1.0 + 1e-6).contains(c);
        assert!(frame.pixels().as_flattened().iter().all(fine), "{light:?}");
    }
    let lit_by = |lights| bits(&picture(&world(objects(), lights, None), &along_z(24, 50.0), 1));
    let none = Source::far(-DVec3::Z, 0.0).expect("a light");
    assert!(lit_by(vec![]) == lit_by(vec![none]));
}

/// A light of a frame's settings that comes from nowhere is told as such.
#[test]
fn a_light_from_nowhere_is_refused() {
    for (towards, intensity) in [
        (DVec3::ZERO, 1.0),
        (DVec3::NAN, 1.0),
        (DVec3::Z, -1.0),
        (DVec3::Z, f32::NAN),
    ] {
        let shading = Shading {
            lights: vec![Light { towards, intensity }],
            ..Shading::default()
        };
        let settings = Settings {
            shading: Some(shading),
            ..Settings::default()
        };
        let refused = World::of(Vec::new(), &[], &along_z(8, 8.0), &settings);
        assert!(matches!(refused, Err(ProjectError::Light(_))), "{towards}, {intensity}");
    }
}
