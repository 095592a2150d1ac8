//! CT presets against the landmarks of tissues, and modes of histograms against data.

use vcsg::projection::presets::{self, DataStatistics, Kind};
use vcsg::scene::{Scene, VolumeFiles};
use vcsg::target::{BlockVoxels, Target};
use vcsg::volume::io::ReadOptions;

/// Tissues, each with a value in Hounsfield units in the middle of its range.
const TISSUES: [(&str, f32); 8] = [
    ("air", -1000.0),
    ("lung", -750.0),
    ("fat", -90.0),
    ("soft", 48.0),
    ("blood", 300.0),
    ("cancellous", 450.0),
    ("cortical", 1100.0),
    ("metal", 2800.0),
];

/// What CT presets show, and what they hide; of what is in neither nothing is promised.
const PROMISES: &[(&str, &str, &str)] = &[
    ("ct-bone", "cancellous cortical", "air lung fat soft"),
    ("ct-bone-skin", "cancellous cortical", "air lung fat soft"),
    ("ct-skin", "soft cortical", "air lung"),
    ("ct-soft-tissue", "fat soft cortical", "air lung"),
    ("ct-muscle-bone", "soft cancellous cortical", "air lung fat"),
    ("ct-muscle", "soft", "air lung fat blood cancellous cortical metal"),
    ("ct-fat", "fat", "air lung soft blood cancellous cortical metal"),
    ("ct-lung", "lung", "air"),
    ("ct-airways", "lung", "air fat soft blood cancellous cortical metal"),
    ("ct-chest", "lung blood cortical", "air fat soft"),
    ("ct-vessels", "blood", "air lung fat soft"),
    ("ct-aorta", "blood", "air lung fat soft"),
    ("ct-cardiac", "blood", "air lung fat soft"),
    ("ct-coronary", "blood", "air lung fat soft"),
    ("ct-pulmonary", "blood", "air lung fat soft cortical metal"),
    ("ct-liver-vessels", "blood", "air lung fat soft"),
    ("ct-metal", "metal", "air lung fat soft"),
    ("ct-mip", "soft blood cancellous cortical metal", "air lung fat"),
    ("ct-x-ray", "lung fat soft blood cancellous cortical metal", "air"),
];

#[test]
fn each_ct_preset_shows_its_tissues_and_hides_the_others() {
    let value = |name: &str| TISSUES.iter().find(|tissue| tissue.0 == name).expect("a tissue").1;
    let named = presets::all().iter().filter(|preset| preset.kind() == Kind::Ct);
    assert_eq!(named.count(), PROMISES.len());
    for (name, shown, hidden) in PROMISES {
        let function = presets::named(name).expect("a preset").own_function();
        let opacity = |tissue: &str| function.evaluate(value(tissue)).1;
        for tissue in shown.split_whitespace() {
            assert!(opacity(tissue) > 0.0, "{name} hides {tissue}");
        }
        for tissue in hidden.split_whitespace() {
            assert_eq!(opacity(tissue), 0.0, "{name} shows {tissue}");
        }
    }
}

/// A volume that setup brings, sampled at `spacing_mm`.
pub fn volume(name: &str, spacing_mm: f64) -> (Scene, Target) {
    let path = format!("target/deps/data/{name}");
    let scene = Scene::open(path.as_ref(), &ReadOptions::default(), &mut VolumeFiles);
    let mut scene = scene.unwrap_or_else(|error| panic!("{error}: run `make setup`"));
    scene.target.spacing_mm = Some(spacing_mm);
    let target = scene.target.build(&scene.model).expect("a target");
    (scene, target)
}

/// In Colin27's brain, by any of its published segmentations, grey matter is darker than white, and there is little between them.
#[test]
fn the_modes_of_an_mr_head_are_those_of_its_grey_and_white_matter() {
    let (_, target) = volume("ch2.nii.gz", 1.0);
    let data = DataStatistics::of_target(&target).expect("values");
    let modes = data.found_modes.expect("modes");
    let [grey, white] = modes.tissues;
    let values = values(&target);
    let count = |value: f32| values.iter().filter(|v| (**v - value).abs() <= 2.0).count();
    let valley = 0.5 * (grey + white);
    assert!(modes.background < 0.25 * grey, "{modes:?}");
    assert!(count(valley) < count(grey) && count(valley) < count(white), "{modes:?}");
    // A mode is no lower than what is half the valley's distance beside it.
    for mode in [grey, white] {
        let beside = 0.25 * (white - grey);
        assert!(
            count(mode) > count(mode - beside) && count(mode) > count(mode + beside),
            "{mode} of {modes:?}"
        );
    }
}

/// The values of all voxels that are there.
fn values(target: &Target) -> Vec<f32> {
    let of_block = |block| {
        let voxels = BlockVoxels::reconstruct(target, block, 0);
        let values = voxels.premultiplied.to_vec();
        match voxels.coverage.as_ref() {
            Some(coverage) => values
                .into_iter()
                .zip(coverage.iter())
                .filter(|(_, c)| **c > 0.5)
                .map(|(v, c)| v / c)
                .collect(),
            None => values,
        }
    };
    target.blocks.iter().flat_map(of_block).collect()
}
