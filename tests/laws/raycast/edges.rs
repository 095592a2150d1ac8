//! Frames that cannot be, and eyes where eyes seldom are.

use glam::DVec3;
use vcsg::projection::{FrameSpec, Lens, Light, Mode, ProjectError, Projector, Shading, raycast, raycast::RayCaster};

use crate::random::Random;
use crate::scene::{Content, Recipe, Scene};

fn scene(content: Content, mode: Mode) -> Scene {
    Recipe {
        content,
        mode,
        ..Recipe::random(7)
    }
    .scene()
}

#[test]
fn frames_without_pixels_and_endless_ones_are_refused() {
    let mut scene = scene(Content::Volume, Mode::Composite);
    for size in [[0, 5], [5, 0], [0, 0], [40_000, 1], [1, u32::MAX]] {
        scene.camera.size = size;
        let refused = RayCaster.project(&scene.spec());
        assert!(matches!(refused, Err(ProjectError::FrameSize { .. })), "{size:?}");
    }
}

#[test]
fn values_of_colours_are_refused() {
    let mut scene = scene(Content::Blended, Mode::Composite);
    scene.settings.mode = Mode::Mip;
    assert!(matches!(
        RayCaster.project(&scene.spec()),
        Err(ProjectError::NoValues { .. })
    ));
}

/// Eyes anywhere in the volume, on its corners too, looking anywhere: every pixel is a finite colour.
#[test]
fn an_eye_in_the_volume_sees_something_defined() {
    let random = &mut Random(5);
    for n in 0..60 {
        let mut scene = scene(Content::Carved, Mode::ALL[n % Mode::ALL.len()]);
        let bounds = scene.target.lattice.world_bounds();
        let eye = match n % 3 {
            0 => bounds.corners()[n % 8],
            _ => bounds.min + bounds.size() * DVec3::from_array(std::array::from_fn(|_| random.between(0.0, 1.0))),
        };
        scene.camera.eye_from_world.translation = -(scene.camera.eye_from_world.matrix3 * eye);
        scene.camera.lens = Lens::Perspective {
            focal_px: 30.0,
            near_mm: 1e-6,
        };
        let frame = RayCaster.project(&scene.spec()).expect("a frame");
        assert!(frame.pixels().as_flattened().iter().all(|c| c.is_finite()), "{n}");
    }
}

/// Rays end at the depths of surfaces: nothing is left at the nearest point, and all of it behind the farthest.
#[test]
fn rays_end_at_surfaces() {
    let scene = scene(Content::Volume, Mode::Composite);
    let spec: FrameSpec = scene.spec();
    let target = raycast::CastTarget::of(&spec);
    let pixels = (scene.camera.size[0] * scene.camera.size[1]) as usize;
    let until = |mm: f32| raycast::draw(&spec, &target, Some(&vec![mm; pixels])).expect("a frame");
    let whole = raycast::draw(&spec, &target, None).expect("a frame");
    assert!(
        until(f32::NEG_INFINITY)
            .pixels()
            .as_flattened()
            .iter()
            .all(|c| *c == 0.0)
    );
    assert_eq!(until(f32::INFINITY).pixels(), whole.pixels());
    let planes = spec.planes();
    let half = until(planes.depth(planes.between(0.0, 1e9).start + 12) as f32);
    assert!(
        half.pixels()
            .iter()
            .zip(whole.pixels())
            .all(|(half, whole)| half[3] <= whole[3])
    );
}

/// No lights, lights from behind, from nowhere, of no strength: lit by them every pixel is a finite colour, and where no light comes
/// from it is as without.
#[test]
fn degenerate_lights_give_something_defined() {
    let lit_by = |lights: &[(DVec3, f32)]| {
        let mut scene = scene(Content::Carved, Mode::Composite);
        let light = |(towards, intensity): &(DVec3, f32)| Light {
            towards: *towards,
            intensity: *intensity,
        };
        scene.settings.shading = Some(Shading {
            lights: lights.iter().map(light).collect(),
            ..Shading::default()
        });
        let frame = RayCaster.project(&scene.spec()).expect("a frame");
        assert!(
            frame.pixels().as_flattened().iter().all(|c| c.is_finite()),
            "{lights:?}"
        );
        frame
    };
    let dark = lit_by(&[]);
    assert!(dark.pixels() == lit_by(&[(-DVec3::Z, 0.0)]).pixels());
    // Half-way between the eye and a light behind everything there is no direction.
    assert!(dark.pixels() != lit_by(&[(DVec3::Z, 1.0)]).pixels());
    lit_by(&[(DVec3::ZERO, 1.0)]);
}
