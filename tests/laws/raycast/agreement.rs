//! Law 3: the ray caster's frames lie between the bounds of single precision, and so does the reference.

use vcsg::conformance::FrameBounds;
use vcsg::image::Frame;
use vcsg::projection::{Camera, FrameSpec, Projector, Reference, raycast::RayCaster};

use super::drawing::drawing;
use super::picture::{nearer, picture};
use crate::scene::Recipe;
use crate::support::scenes::{scene, subdivision};
use crate::support::seeded;
use vcsg::model::Boundary;

/// How far the ray caster's frame is from the middle of its bounds, the worst channel, in half widths; and from the reference.
fn deviations(spec: &FrameSpec) -> [f64; 2] {
    let bounds = FrameBounds::new(spec, &drawing(spec));
    let cast = RayCaster.project(spec).expect("a frame");
    let reference = Reference.project(spec).expect("a frame");
    assert_eq!(
        bounds.pixels_outside(&reference),
        0,
        "the reference itself: {}",
        worst(&bounds, &reference, &cast)
    );
    assert_eq!(bounds.pixels_outside(&cast), 0, "{}", worst(&bounds, &cast, &reference));
    let worst = bounds.deviations(&cast).into_iter().fold(0.0, f64::max);
    let channels = |frame: &Frame| frame.pixels().as_flattened().to_vec();
    let differences = channels(&cast)
        .into_iter()
        .zip(channels(&reference))
        .map(|(a, b)| f64::from(a - b).abs());
    [worst, differences.fold(0.0, f64::max)]
}

fn worst(bounds: &FrameBounds, cast: &Frame, reference: &Frame) -> String {
    let all = bounds.deviations(cast);
    let worst = (0..all.len()).max_by(|a, b| all[*a].total_cmp(&all[*b])).unwrap_or(0);
    let at = |frame: &Frame| frame.pixels()[worst / 4];
    let [cast, reference, low, high] = [at(cast), at(reference), at(&bounds.low), at(&bounds.high)];
    format!(
        "pixel {}: {cast:?} where the reference has {reference:?}, within {low:?} and {high:?}",
        worst / 4
    )
}

#[test]
fn scenes_agree_with_the_reference() {
    let mut worst = [0.0f64; 2];
    for seed in 0..120 {
        let scene = Recipe::random(seed).scene();
        let found = deviations(&scene.spec());
        worst = [0, 1].map(|n| worst[n].max(found[n]));
    }
    println!(
        "at most {:.3} of the bounds' half width, and {:.2e} from the reference",
        worst[0], worst[1]
    );
}

/// From so near that cells of blocks are looked into for what shows.
#[test]
fn scenes_from_near_agree_with_the_reference() {
    for seed in 0..120 {
        let scene = Recipe::random(seed).scene();
        let camera = &nearer(&scene.spec(), 6.0);
        deviations(&FrameSpec { camera, ..scene.spec() });
    }
}

/// Frames of which threads share parts, some at their ends.
#[test]
fn wide_frames_agree_with_the_reference() {
    let mut shown_at_the_right = 0;
    for seed in 0..12 {
        let scene = Recipe::random(seed).scene();
        let camera = &Camera {
            size: [150, 37],
            ..nearer(&scene.spec(), 3.0)
        };
        let spec = FrameSpec { camera, ..scene.spec() };
        deviations(&spec);
        let frame = RayCaster.project(&spec).expect("a frame");
        let rows = frame.pixels().chunks_exact(150);
        shown_at_the_right += rows.flat_map(|row| &row[128..]).filter(|pixel| pixel[3] > 0.0).count();
    }
    assert!(shown_at_the_right > 100, "{shown_at_the_right} pixels");
}

/// Scenes of all that a model can hold, of values all the same, from eyes within: bounds are numbers, and hold both.
#[test]
fn any_model_agrees_with_the_reference() {
    let mut asked = [0, 0];
    for seed in 0..400 {
        let target = seeded(&scene(), seed).target(&seeded(&subdivision(Boundary::Exact), seed));
        if target.blocks.is_empty() {
            continue;
        }
        seeded(&picture(), seed).of(&target, |spec| {
            let bounds = FrameBounds::new(spec, &drawing(spec));
            assert!(bounds.widths().iter().all(|width| !width.is_nan()), "{seed}");
            deviations(spec);
        });
        asked[usize::from(target.tree.has_colors())] += 1;
    }
    assert!(
        asked.iter().all(|models| *models > 50),
        "of values, of colours: {asked:?}"
    );
}
