//! Law 3: slices and reference agree, in every mode.

use vcsg::image::Frame;
use vcsg::interface::HIDES_ALL_BUT;
use vcsg::projection::composite::Blending;
use vcsg::projection::{Mode, Projector, Reference, TransferFunction, bands};
use vcsg::volume::VoxelType::{F32, I16, U8};

use crate::device::{Bench, on_device};
use crate::scene::{Content, Recipe};

/// Each data type, content, lens and light meets each kind of mode, and blocks are one, many, or of several sizes.
#[rustfmt::skip]
fn recipes() -> Vec<Recipe> {
    use Content::{Blended, Carved, Deformed, Turned, United, Volume};
    use Mode::{Additive, Average, Composite, MinIp, Mip, XRay};
    let table = [
        (U8,  Volume, Composite, false, false, [16, 16]),
        (I16, Volume, Composite, true,  false, [64, 64]),
        (F32, Volume, Composite, true,  true,  [16, 16]),
        (U8,  Carved, Composite, true,  false, [8, 64]),
        (I16, Carved, Composite, false, true,  [16, 32]),
        (F32, Carved, Composite, true,  true,  [8, 16]),
        (U8,  United, Composite, true,  true,  [16, 64]),
        (F32, Turned, Composite, false, false, [8, 64]),
        (I16, Turned, Composite, true,  false, [32, 32]),
        (I16, United, Mip,       false, true,  [8, 32]),
        (U8,  Carved, Mip,       false, false, [16, 16]),
        (F32, Carved, MinIp,     false, false, [8, 64]),
        (U8,  Volume, MinIp,     false, true,  [32, 32]),
        (I16, Carved, Average,   false, true,  [16, 16]),
        (F32, United, Average,   false, false, [8, 8]),
        (U8,  United, Additive,  false, false, [16, 64]),
        (F32, Turned, Additive,  false, true,  [16, 16]),
        (I16, Volume, XRay,      false, true,  [16, 16]),
        (F32, Carved, XRay,      false, false, [8, 16]),
        (F32, Blended, Composite, true,  false, [16, 16]),
        (U8,  Blended, Composite, false, true,  [8, 32]),
        (F32, Blended, Additive,  false, false, [8, 16]),
        (I16, Blended, XRay,      false, true,  [64, 64]),
        (U8,  Blended, Composite, true,  true,  [16, 64]),
        (U8,  Deformed, Composite, true, false, [8, 32]),
        (F32, Deformed, Mip,     false, true,  [16, 16]),
    ];
    (101..).zip(table)
        .map(|(seed, (voxels, content, mode, lit, perspective, blocks))| {
            Recipe { seed, voxels, content, mode, lit, perspective, blocks }
        })
        .collect()
}

fn require_agreement(bench: &mut Bench, recipe: &Recipe) -> Frame {
    let scene = recipe.scene();
    let spec = scene.spec();
    let prepared = bench.prepare(&spec);
    let frame = bench.draw(&spec, &prepared);
    let bounds = bench.bounds(&spec, &prepared);
    let reference = Reference.project(&spec).expect("a frame");
    let deviations = bounds.deviations(&frame);
    let near_ends = deviations.iter().filter(|&&d| d > 0.9).count();
    println!(
        "{recipe:?}: {} boxes, mean width {:.2e}, {:.2} % of channels in the outer tenth, the worst at {:.3}",
        prepared.plan.boxes.len(),
        bounds.mean_width(),
        100.0 * near_ends as f64 / deviations.len() as f64,
        deviations.iter().copied().fold(0.0, f64::max),
    );
    bench.require_within(&format!("reference of {recipe:?}"), &reference, &bounds);
    bench.require_within(&format!("{recipe:?}"), &frame, &bounds);
    frame
}

/// Drawn in bands, and so opaque that many rays end in the first of them.
pub fn what_is_hidden_may_be_left_out() {
    on_device(|bench| {
        let mut ended = 0;
        for recipe in recipes().iter().filter(|r| r.mode.blending() == Blending::Over) {
            let mut scene = recipe.scene();
            let points = scene.transfer.points().to_vec();
            scene.transfer = TransferFunction::new(points, 0.2).expect("the same points");
            let spec = scene.spec();
            let mut prepared = bench.prepare(&spec);
            prepared.plan = bands::cut_into(prepared.plan, 4);
            let frame = bench.draw(&spec, &prepared);
            let bounds = bench.bounds(&spec, &prepared);
            bench.require_within(&format!("{recipe:?} in bands"), &frame, &bounds);
            let opaque = 1.0 - 1.0 / HIDES_ALL_BUT as f32;
            ended += frame.pixels().iter().filter(|p| p[3] >= opaque).count();
        }
        assert!(ended > 2000, "{ended} rays end");
    });
}

/// Law 6: made anew from the recipe, brought to the device anew and drawn anew, a frame has the same bits.
pub fn the_same_scene_gives_the_same_bytes() {
    on_device(|bench| {
        let mut bits = |recipe: &Recipe| -> Vec<u32> {
            let scene = recipe.scene();
            let spec = scene.spec();
            let prepared = bench.prepare(&spec);
            let frame = bench.draw(&spec, &prepared);
            let channels = frame.pixels().as_flattened().iter();
            channels.map(|channel| channel.to_bits()).collect()
        };
        for recipe in recipes() {
            assert!(bits(&recipe) == bits(&recipe), "{recipe:?} differs from itself");
        }
        let [one, other] = [101, 1000].map(|seed| Recipe { seed, ..recipes()[0] });
        assert!(bits(&one) != bits(&other), "frames that differ are told apart");
    });
}

pub fn slices_agree_with_the_reference() {
    on_device(|bench| {
        for recipe in recipes() {
            let frame = require_agreement(bench, &recipe);
            let shown = frame.pixels().iter().filter(|p| p[3] > 0.0).count();
            assert!(5 * shown > frame.pixels().len(), "{recipe:?} shows little");
        }
    });
}

/// Names the variable with the number of random scenes, for longer runs.
const SCENES: &str = "VCSG_TEST_SCENES";

pub fn random_scenes_agree_with_the_reference() {
    let scenes = std::env::var(SCENES).map_or(12, |n| n.parse().expect("a number of scenes"));
    on_device(|bench| {
        for seed in 1000..1000 + scenes {
            require_agreement(bench, &Recipe::random(seed));
        }
    });
}
