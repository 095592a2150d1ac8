//! One device for all tests, and short ways to draw and look.

use std::sync::{Arc, OnceLock};

use vcsg::gpu::{
    Bindings, Buffer, BufferRole, Device, DeviceSelector, Draw, Elements, Extent, Feature, Format, GraphicsPipeline,
    Image, ImageRole, Instance, Load, PipelineDesc, Push, Recording, RenderPass, Requirements, Target, Topology,
    Validation,
};

mod shaders {
    include!(concat!(env!("OUT_DIR"), "/test_shaders.rs"));
}

/// The SPIR-V of a file of `tests/shaders`.
pub fn shader(file: &str) -> &'static [u32] {
    shaders::ALL
        .iter()
        .find(|shader| shader.0 == file)
        .unwrap_or_else(|| panic!("no shader {file}"))
        .1
}

pub const REQUIREMENTS: Requirements = Requirements {
    sampled_linear: &[
        Format::R8_UNORM,
        Format::R16_SFLOAT,
        Format::R32_SFLOAT,
        Format::R8G8B8A8_UNORM,
    ],
    blended: &[Format::R32G32B32A32_SFLOAT, Format::R16G16B16A16_SFLOAT],
    features: &[Feature::IndependentBlend, Feature::FragmentStores],
    image_dimension_3d: 2048,
};

/// Runs `test` on the shared device, and fails if the validation layer has said anything.
pub fn on_device(test: impl FnOnce(&Arc<Device>)) {
    static DEVICE: OnceLock<Arc<Device>> = OnceLock::new();
    let device = DEVICE.get_or_init(|| {
        let instance = Instance::new(Validation::On).unwrap_or_else(|error| panic!("{error}: run `make setup`"));
        let device = Device::open(&instance, &DeviceSelector::Default, &REQUIREMENTS);
        device.unwrap_or_else(|error| panic!("{error}: run `make setup`"))
    });
    test(device);
    assert_eq!(device.instance().messages(), Vec::<String>::new());
}

pub fn float_target(device: &Arc<Device>, edge: u32) -> Arc<Image> {
    let format = Format::R32G32B32A32_SFLOAT;
    Image::new(
        device,
        "a target",
        ImageRole::ColorTarget,
        format,
        Extent::D2(edge, edge),
    )
    .expect("a target")
}

/// A pipeline that fills the target, with `fragment` and what `change` changes.
pub fn quad_pipeline<'a>(
    device: &Arc<Device>,
    fragment: &'a [u32],
    change: impl FnOnce(&mut PipelineDesc<'a>),
) -> Arc<GraphicsPipeline> {
    let mut desc = PipelineDesc {
        label: "a quad",
        vertex_spirv: shader("quad.vert"),
        fragment_spirv: fragment,
        color_targets: &[(Format::R32G32B32A32_SFLOAT, None)],
        push_bytes: 16,
        topology: Topology::TriangleStrip,
        ..PipelineDesc::default()
    };
    change(&mut desc);
    GraphicsPipeline::new(device, &desc).expect("a pipeline")
}

pub fn quad(pipeline: &Arc<GraphicsPipeline>, bindings: Option<&Arc<Bindings>>, push: [f32; 4]) -> Draw {
    Draw {
        pipeline: Arc::clone(pipeline),
        bindings: bindings.cloned(),
        push: Push::of(&push),
        stream: None,
        elements: Elements::Vertices(0..4),
        instances: 0..1,
    }
}

pub fn pass(image: &Arc<Image>, load: Load, draws: Vec<Draw>) -> RenderPass {
    RenderPass {
        targets: vec![Target {
            image: Arc::clone(image),
            load,
        }],
        depth: None,
        draws,
    }
}

/// Does `recording`, and returns the texels that `image` then has.
pub fn texels_after<T: bytemuck::Pod>(device: &Arc<Device>, recording: &Recording, image: &Arc<Image>) -> Vec<T> {
    let seen = Buffer::new(device, "seen", BufferRole::Readback, image.bytes()).expect("a buffer");
    let mut recording = recording.clone();
    recording.read_back(image, &seen);
    device.submit(&recording).expect("a submission").wait().expect("an end");
    seen.read_vec().expect("the texels")
}
