//! Depths that are tested against and held.

use std::sync::Arc;

use vcsg::gpu::{
    Buffer, BufferRole, Command, DEPTH_FORMAT, Depth, DepthTarget, Device, Draw, Extent, GraphicsPipeline, Image,
    ImageCopy, ImageRole, Load, Recording, RenderPass,
};

use crate::support::{float_target, on_device, pass, quad, quad_pipeline, shader, texels_after};

const EDGE: u32 = 4;

fn depths(device: &Arc<Device>) -> Arc<Image> {
    let extent = Extent::D2(EDGE, EDGE);
    Image::new(device, "depths", ImageRole::DepthTarget, DEPTH_FORMAT, extent).expect("depths")
}

fn pipeline(device: &Arc<Device>, depth: Option<Depth>) -> Arc<GraphicsPipeline> {
    quad_pipeline(device, shader("color.frag"), |desc| {
        (desc.vertex_spirv, desc.depth) = (shader("deep.vert"), depth);
    })
}

fn deep(image: &Arc<Image>, depth: Load<f32>, target: &Arc<Image>, load: Load, draws: Vec<Draw>) -> RenderPass {
    RenderPass {
        depth: Some(DepthTarget {
            image: Arc::clone(image),
            load: depth,
        }),
        ..pass(target, load, draws)
    }
}

#[test]
fn what_is_held_hides_what_is_behind_it_from_pass_to_pass() {
    on_device(|device| {
        let (target, depth) = (float_target(device, EDGE), depths(device));
        let test = pipeline(device, Some(Depth::Test));
        let hold = pipeline(device, Some(Depth::TestAndHold));
        // Alpha is the depth, too.
        let color = |red: f32, depth: f32| [red, 0.0, 0.0, depth];
        let mut recording = Recording::new();
        let first = [
            (&test, color(1.0, 0.25)),
            (&hold, color(2.0, 0.5)),
            (&test, color(3.0, 0.75)),
        ];
        let draws = first
            .iter()
            .map(|(pipeline, push)| quad(pipeline, None, *push))
            .collect();
        recording.render(deep(&depth, Load::Clear(1.0), &target, Load::Clear([0.0; 4]), draws));
        // A test holds nothing: what came first at 0.25 did not hide 0.5, which hides 0.75.
        assert_eq!(
            texels_after::<[f32; 4]>(device, &recording, &target),
            vec![color(2.0, 0.5); 16]
        );
        let draws = vec![quad(&test, None, color(4.0, 0.625))];
        recording.render(deep(&depth, Load::Keep, &target, Load::Keep, draws));
        assert_eq!(
            texels_after::<[f32; 4]>(device, &recording, &target),
            vec![color(2.0, 0.5); 16]
        );
        let draws = vec![quad(&test, None, color(5.0, 0.375))];
        recording.render(deep(&depth, Load::Keep, &target, Load::Keep, draws));
        assert_eq!(
            texels_after::<[f32; 4]>(device, &recording, &target),
            vec![color(5.0, 0.375); 16]
        );
    });
}

#[test]
fn depths_that_do_not_fit_are_refused() {
    on_device(|device| {
        let (target, depth) = (float_target(device, EDGE), depths(device));
        let refused = |pass: RenderPass| {
            let mut recording = Recording::new();
            recording.render(pass);
            device.submit(&recording).err().map(|error| error.to_string())
        };
        let (with, without) = (pipeline(device, Some(Depth::Test)), pipeline(device, None));
        let draw = |pipeline| vec![quad(pipeline, None, [0.5; 4])];
        let clear = Load::Clear([0.0; 4]);
        assert!(
            refused(pass(&target, clear, draw(&with))).is_some(),
            "no depths to test"
        );
        assert!(
            refused(deep(&depth, Load::Clear(1.0), &target, clear, draw(&without))).is_some(),
            "depths that nobody tests"
        );
        let large = float_target(device, 2 * EDGE);
        assert!(
            refused(deep(&depth, Load::Clear(1.0), &large, clear, draw(&with))).is_some(),
            "another size"
        );
        assert!(
            refused(deep(&large, Load::Clear(1.0), &large, clear, draw(&with))).is_some(),
            "colours as depths"
        );
        assert!(
            refused(deep(&depth, Load::Keep, &target, clear, draw(&with))).is_some(),
            "nothing to keep"
        );
        let buffer = Buffer::new(device, "seen", BufferRole::Readback, depth.bytes()).expect("a buffer");
        let mut recording = Recording::new();
        recording.commands.push(Command::ReadBack(ImageCopy {
            buffer,
            offset: 0,
            image: Arc::clone(&depth),
            region: depth.region(),
        }));
        assert!(device.submit(&recording).is_err(), "depths are not copied");
    });
}
