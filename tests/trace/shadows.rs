//! Shadows: their edges where they belong, as dark and as coloured as what casts them.

use glam::DVec3;
use vcsg::projection::trace::{Optics, Source, World};

use crate::world::{along_z, glass, medium, picture, solid, world};

/// A floor seen from above, its upper face at z = 6 (rays go along +z), and `light`.
fn floor_and(casting: vcsg::projection::trace::Object, light: Source) -> World {
    let floor = solid("box min=\"-60 -60 6\" max=\"60 60 12\"", Optics::default());
    world(vec![floor, casting], vec![light], None)
}

/// The brightness of pixels along the middle row of a frame of `pixels` over `width_mm`.
fn row(world: &World, pixels: u32, width_mm: f64, samples: u32) -> Vec<[f32; 4]> {
    let mut camera = along_z(pixels, width_mm);
    camera.size = [pixels, 1];
    camera.eye_from_world.translation.y = 0.0;
    picture(world, &camera, samples).pixels().to_vec()
}

/// Where brightness passes `level` going right from the middle, millimetres from it.
fn edge_mm(row: &[[f32; 4]], width_mm: f64, level: f32) -> f64 {
    let pixel = width_mm / row.len() as f64;
    let half = row.len() / 2;
    let n = (half..row.len() - 1)
        .find(|&n| row[n][0] < level && row[n + 1][0] >= level)
        .expect("an edge");
    let part = f64::from((level - row[n][0]) / (row[n + 1][0] - row[n][0]));
    (n as f64 + part + 0.5) * pixel - 0.5 * width_mm
}

/// A ball off the view's path casts its shadow aslant: the edge on the floor is where the tangents to the ball meet it.
#[test]
fn a_balls_shadow_ends_within_a_voxel_of_its_place() {
    // The light comes from the left, 45 degrees; the ball is far to the left of where its shadow is.
    let ball = solid("sphere radius=10 center=\"-40 0 -40\"", Optics::default());
    let towards = DVec3::new(-1.0, 0.0, -1.0);
    let light = Source::far(towards, 1.0).expect("a light");
    let world = floor_and(ball, light);
    let lit = 0.5f32.sqrt();
    let row = row(&world, 400, 80.0, 1);
    // The shadow's middle: from (−40, −40) down to z = 6, 46 mm to the right; its half width along x is r √2.
    let expected = -40.0 + 46.0 + 10.0 * 2f64.sqrt();
    let found = edge_mm(&row, 80.0, 0.5 * lit);
    println!("the edge is at {found:.3} mm, where {expected:.3} is right");
    assert!((found - expected).abs() < 1.0);
    // In the light and in the dark.
    assert!(
        (row[390][0] - lit).abs() < 0.01 && row[220][0] < 0.01,
        "{:?} {:?}",
        row[390],
        row[220]
    );
}

#[test]
fn a_point_lights_shadow_is_wider() {
    let ball = solid("sphere radius=5 center=\"0 0 -20\"", Optics::default());
    // From the side of the eye, but beside its rays: the ball is seen too, so the edge is beyond it.
    let light = Source::point(DVec3::new(0.0, 0.0, -60.0), 1.0).expect("a light");
    let row = row(&floor_and(ball, light), 400, 60.0, 1);
    // The tangent from the light, 40 mm above the ball's middle and 66 above the floor.
    let expected = 66.0 * 5.0 / (40f64.powi(2) - 25.0).sqrt();
    let at = |mm: f64| row[(200.0 + mm / 60.0 * 400.0) as usize][0];
    let cos = 66.0 / 66f64.hypot(expected);
    assert!(at(expected - 1.0) < 0.1 && f64::from(at(expected + 1.0)) > cos - 0.1);
    let found = edge_mm(&row, 60.0, 0.5 * cos as f32);
    println!("the edge is at {found:.3} mm, where {expected:.3} is right");
    assert!((found - expected).abs() < 1.0);
}

/// Across a penumbra the light is the part of the area that is seen over a straight edge.
#[test]
fn an_area_lights_penumbra_is_linear() {
    let screen = solid("box min=\"-50 -50 -14\" max=\"0 50 -10\"", Optics::default());
    // The light is 36 mm above the edge of the screen that hides it, and that 20 mm above the floor.
    let light = Source::area(DVec3::new(0.0, 0.0, -50.0), 20.0 * DVec3::X, 20.0 * DVec3::Y, 1.0).expect("a light");
    let row = row(&floor_and(screen, light), 200, 40.0, 64);
    for (n, [brightness, ..]) in row.iter().enumerate() {
        let x = (n as f64 + 0.5) / 5.0 - 20.0;
        if x < 0.5 {
            continue;
        }
        let seen = (0.5 + x * 36.0 / 20.0 / 20.0).clamp(0.0, 1.0);
        // Light from the middle of the area arrives with about this cosine.
        let cos = 56.0 / 56f64.hypot(x);
        assert!(
            (f64::from(*brightness) - seen * cos).abs() < 0.06,
            "{brightness} at {x}, where {seen} is seen"
        );
    }
}

/// A red veil lets through what its opacity leaves, and more of red.
#[test]
fn media_cast_coloured_shadows() {
    let thickness = 8.0;
    let veil = medium("box min=\"-60 -60 -30\" max=\"-20 60 -22\"", [0.9, 0.2, 0.2], 0.1);
    let light = Source::far(DVec3::new(-1.0, 0.0, -1.0), 1.0).expect("a light");
    let row = row(&floor_and(veil, light), 80, 20.0, 1);
    let lit = 0.5f64.sqrt();
    // Through the veil aslant; half of what it scatters goes on.
    let left = |color: f64| lit * 0.9f64.powf(thickness * 2f64.sqrt() * (1.0 - 0.5 * color));
    let [r, g, b, _] = row[20];
    assert!((f64::from(r) - left(0.9)).abs() < 0.02, "{r} for {}", left(0.9));
    assert!(
        (f64::from(g) - left(0.2)).abs() < 0.02 && g == b,
        "{g} for {}",
        left(0.2)
    );
}

/// Glass dims by what its two faces mirror and by its tint, and no more.
#[test]
fn glass_casts_a_tinted_shadow() {
    let tint = [1.0, 0.8, 0.5];
    let pane = solid(
        "box min=\"-60 -60 -30\" max=\"60 60 -20\"",
        glass(1.5).tinted(tint, 10.0).expect("a tint"),
    );
    let light = Source::far(-DVec3::Z, 1.0).expect("a light");
    // Seen along the light, through the pane once more.
    let row = row(&floor_and(pane, light), 8, 4.0, 1);
    let faces = 0.96f64.powi(2);
    for (c, tint) in tint.into_iter().enumerate() {
        let expected = (faces * tint).powi(2);
        assert!(
            (f64::from(row[4][c]) - expected).abs() < 0.01,
            "{} for {expected}",
            row[4][c]
        );
    }
}
