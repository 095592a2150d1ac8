//! Drawn pixels where Vulkan leaves one answer only.

use std::sync::Arc;

use vcsg::gpu::{
    Attribute, Binding, BindingKind, Bindings, Blend, Buffer, Draw, Elements, Extent, Filter, Format, GraphicsPipeline,
    Image, ImageRole, Load, PipelineDesc, Push, Recording, Sampler, StepRate, Stream, Topology, VertexInput,
};

use crate::support::{float_target, on_device, pass, quad, quad_pipeline, shader, texels_after};

#[test]
fn a_pass_clears() {
    on_device(|device| {
        let target = float_target(device, 5);
        let mut recording = Recording::new();
        recording.render(pass(&target, Load::Clear([0.25, -1.0, 3.0, 1e30]), Vec::new()));
        assert_eq!(
            texels_after::<[f32; 4]>(device, &recording, &target),
            [[0.25, -1.0, 3.0, 1e30]; 25]
        );
    });
}

#[test]
fn texels_are_seen_at_their_centres() {
    on_device(|device| {
        // At a centre every weight but one is 0, so nearest and linear agree and are exact (R32_SFLOAT, power-of-two edges).
        for filter in [Filter::Nearest, Filter::Linear] {
            let values: Vec<f32> = (0..8 * 8 * 4u16).map(|place| f32::from(place) / 8.0).collect();
            let staging = Buffer::with_data(device, "staging", &values).expect("a buffer");
            let extent = Extent::D3(8, 8, 4);
            let texture =
                Image::new(device, "a texture", ImageRole::Sampled, Format::R32_SFLOAT, extent).expect("an image");
            let sampler = Sampler::new(device, filter).expect("a sampler");
            let binding = Binding::SampledImage(Arc::clone(&texture), sampler);
            let bindings = Bindings::new(device, "the texture", &[binding]).expect("bindings");
            let pipeline = quad_pipeline(device, shader("texture3d.frag"), |desc| {
                desc.bindings = &[BindingKind::SampledImage]
            });
            for z in 0..4u8 {
                let target = float_target(device, 8);
                let mut recording = Recording::new();
                recording.upload(&staging, &texture);
                let draw = quad(&pipeline, Some(&bindings), [0.0, 0.0, f32::from(z), 0.0]);
                recording.render(pass(&target, Load::Clear([0.0; 4]), vec![draw]));
                let seen = texels_after::<[f32; 4]>(device, &recording, &target);
                let seen: Vec<f32> = seen.iter().map(|color| color[0]).collect();
                assert_eq!(seen, values[64 * usize::from(z)..][..64], "{filter:?}, z = {z}");
            }
        }
    });
}

#[test]
fn instances_take_their_element_and_their_number() {
    on_device(|device| {
        let attributes = [Attribute {
            location: 0,
            format: Format::R32G32_SFLOAT,
            offset: 8,
        }];
        let desc = PipelineDesc {
            label: "instances",
            vertex_spirv: shader("instances.vert"),
            fragment_spirv: shader("instances.frag"),
            specialization: &[(7, 8f32.to_bits())],
            color_targets: &[(Format::R32G32B32A32_SFLOAT, None)],
            topology: Topology::Triangles,
            vertex_input: Some(VertexInput {
                stride: 16,
                rate: StepRate::Instance,
                attributes: &attributes,
            }),
            ..PipelineDesc::default()
        };
        let pipeline = GraphicsPipeline::new(device, &desc).expect("a pipeline");
        let pixel = |element: u8| (element % 8, element / 2);
        let element = |number| [0.0, 0.0, f32::from(pixel(number).0), f32::from(pixel(number).1)];
        let pixels: Vec<[f32; 4]> = (0..9).map(element).collect();
        let buffer = Buffer::with_data(device, "pixels", &pixels).expect("a buffer");
        let indices = Buffer::with_data(device, "indices", &[9u32, 9, 0, 1, 2, 2, 1, 3]).expect("a buffer");
        let target = float_target(device, 8);
        let draw = Draw {
            pipeline,
            bindings: None,
            push: Push::NONE,
            stream: Some(Stream { buffer, offset: 16 }),
            elements: Elements::Indices {
                buffer: indices,
                range: 2..8,
                base_vertex: 0,
            },
            instances: 2..8,
        };
        let mut recording = Recording::new();
        recording.render(pass(&target, Load::Clear([0.0; 4]), vec![draw]));
        let mut expected = vec![0.0f32; 64];
        // The stream starts one element late, and instance numbers start at 2.
        for number in 2..8 {
            let (x, y) = pixel(number + 1);
            expected[usize::from(x + 8 * y)] = f32::from(number);
        }
        let seen = texels_after::<[f32; 4]>(device, &recording, &target);
        assert_eq!(seen.iter().map(|color| color[0]).collect::<Vec<_>>(), expected);
    });
}

#[test]
fn ten_thousand_draws_each_count_once() {
    on_device(|device| {
        let add = &[(Format::R32G32B32A32_SFLOAT, Some(Blend::Add))];
        let pipelines: Vec<_> = (0..2)
            .map(|_| quad_pipeline(device, shader("color.frag"), |desc| desc.color_targets = add))
            .collect();
        let draws: Vec<_> = (0..10_000u16)
            .map(|number| {
                let which = usize::from(number / 100 % 2);
                let push = [1.0, f32::from(number % 2), f32::from(number % 4), 0.0];
                quad(&pipelines[which], None, push)
            })
            .collect();
        let target = float_target(device, 2);
        let mut recording = Recording::new();
        recording.render(pass(&target, Load::Clear([0.0; 4]), draws));
        let seen = texels_after::<[f32; 4]>(device, &recording, &target);
        assert_eq!(seen, [[10_000.0, 5_000.0, 15_000.0, 0.0]; 4]);
    });
}
