//! Each preset draws something of data of its kind, on a device under validation.

use vcsg::gpu::{Device, DeviceSelector, Instance, Validation};
use vcsg::projection::presets::{self, DataStatistics, Kind, Preset};
use vcsg::projection::{FrameSpec, Settings};
use vcsg::render::{PagedTarget, SliceRenderer, soft_normals};

use crate::landmarks::volume;

const SIZE: [u32; 2] = [96, 72];

/// A head fills about a quarter of its frame; what shows only a part of it a fiftieth of that at least.
const LEAST_PIXELS: usize = (SIZE[0] * SIZE[1]) as usize / 200;

#[test]
fn every_preset_draws_something_of_its_kind() {
    let instance = Instance::new(Validation::On).unwrap_or_else(|error| panic!("{error}: run `make setup`"));
    let device = Device::open(&instance, &DeviceSelector::Default, &SliceRenderer::REQUIREMENTS);
    let device = device.unwrap_or_else(|error| panic!("{error}: run `make setup`"));
    let mut renderer = SliceRenderer::new(&device).expect("a renderer");
    let subjects = [
        (volume("cranium.nhdr", 3.0), &[Kind::Ct][..]),
        (volume("ch2.nii.gz", 2.5), &[Kind::Mr, Kind::Any]),
    ];
    for ((scene, target), kinds) in &subjects {
        let data = DataStatistics::of_target(target).expect("values");
        let bounds = scene.model.bounds()[scene.model.root().expect("a root").index()];
        let camera = scene.view.camera(&bounds, SIZE);
        let drawn_with = |preset: &&Preset| kinds.contains(&preset.kind());
        for preset in presets::all().iter().filter(drawn_with) {
            let mut settings = Settings::default();
            preset.look().apply(&mut settings);
            let spec = FrameSpec {
                target,
                transfer: &preset.fitted(&data, preset.unit_for(bounds.size().length())),
                camera: &camera,
                settings: &settings,
            };
            let normals = soft_normals(&spec);
            let paged = PagedTarget::new(&device, target, normals.as_ref(), &mut |_| {}).expect("pages");
            let (frame, _) = renderer.draw(&spec, &paged, &[]).expect("a frame");
            let seen = frame
                .pixels()
                .iter()
                .filter(|p| p[3] > 1.0 / 255.0 && p[0].max(p[1]).max(p[2]) > 1.0 / 255.0);
            let seen = seen.count();
            assert!(seen >= LEAST_PIXELS, "{} shows {seen} pixels", preset.name());
        }
    }
    assert_eq!(
        instance.take_messages(),
        Vec::<String>::new(),
        "of the validation layer"
    );
}
