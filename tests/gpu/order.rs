//! Several passes and several submissions: what comes later sees what came before.

use std::sync::Arc;

use vcsg::gpu::{
    Binding, BindingKind, Bindings, Blend, Extent, Filter, Format, Image, ImageRole, Load, Recording, Sampler,
};

use crate::support::{float_target, on_device, pass, quad, quad_pipeline, shader, texels_after};

#[test]
fn a_pass_split_in_many_is_the_same_picture() {
    on_device(|device| {
        let over = &[(Format::R32G32B32A32_SFLOAT, Some(Blend::Over))];
        let pipeline = quad_pipeline(device, shader("color.frag"), |desc| desc.color_targets = over);
        let layers: Vec<_> = (0..12u8)
            .map(|layer| quad(&pipeline, None, [f32::from(layer % 3) / 4.0, 0.5, 0.0, 0.5]))
            .collect();
        let target = float_target(device, 16);
        let mut at_once = Recording::new();
        at_once.render(pass(&target, Load::Clear([0.0; 4]), layers.clone()));
        let expected = texels_after::<[f32; 4]>(device, &at_once, &target);

        let mut split = Recording::new();
        split.render(pass(&target, Load::Clear([0.0; 4]), Vec::new()));
        layers
            .iter()
            .for_each(|layer| split.render(pass(&target, Load::Keep, vec![layer.clone()])));
        assert_eq!(
            texels_after::<[f32; 4]>(device, &split, &target),
            expected,
            "in many passes"
        );

        let mut clear = Recording::new();
        clear.render(pass(&target, Load::Clear([0.0; 4]), Vec::new()));
        let mut submissions = vec![device.submit(&clear).expect("a submission")];
        for layer in &layers {
            let mut one = Recording::new();
            one.render(pass(&target, Load::Keep, vec![layer.clone()]));
            submissions.push(device.submit(&one).expect("a submission"));
        }
        let seen = texels_after::<[f32; 4]>(device, &Recording::new(), &target);
        assert_eq!(seen, expected, "in many submissions");
    });
}

#[test]
fn a_target_is_sampled_by_the_next_pass() {
    on_device(|device| {
        let images: Vec<_> = (0..2).map(|_| float_target(device, 8)).collect();
        let sampler = Sampler::new(device, Filter::Nearest).expect("a sampler");
        let bindings: Vec<_> = images
            .iter()
            .map(|image| Binding::SampledImage(Arc::clone(image), Arc::clone(&sampler)))
            .map(|binding| Bindings::new(device, "an image", &[binding]).expect("bindings"))
            .collect();
        let pipeline = quad_pipeline(device, shader("add.frag"), |desc| {
            desc.bindings = &[BindingKind::SampledImage]
        });
        let mut recording = Recording::new();
        recording.render(pass(&images[0], Load::Clear([1.0, 2.0, 3.0, 4.0]), Vec::new()));
        for round in 0..6 {
            let draw = quad(&pipeline, Some(&bindings[round % 2]), [1.0, 0.0, 0.5, 0.0]);
            recording.render(pass(&images[(round + 1) % 2], Load::Clear([0.0; 4]), vec![draw]));
        }
        let submission = device.submit(&recording).expect("a submission");
        assert_eq!(submission.pass_times().expect("times").len() % 7, 0);
        let seen = texels_after::<[f32; 4]>(device, &Recording::new(), &images[0]);
        assert_eq!(seen, [[7.0, 2.0, 6.0, 4.0]; 64]);
    });
}

#[test]
fn what_a_submission_uses_may_be_dropped_at_once() {
    on_device(|device| {
        let target = float_target(device, 256);
        let submission = {
            let image = Image::new(
                device,
                "short-lived",
                ImageRole::ColorTarget,
                Format::R8_UNORM,
                Extent::D2(256, 256),
            );
            let image = image.expect("an image");
            let pipeline = quad_pipeline(device, shader("color.frag"), |_| ());
            let mut recording = Recording::new();
            recording.render(pass(&image, Load::Clear([0.0; 4]), Vec::new()));
            recording.render(pass(
                &target,
                Load::Clear([0.0; 4]),
                vec![quad(&pipeline, None, [1.0; 4]); 50],
            ));
            device.submit(&recording).expect("a submission")
        };
        drop(submission);
    });
}
