//! Buffers that fragments write.

use std::sync::Arc;

use vcsg::gpu::{
    Binding, BindingKind, Bindings, Buffer, BufferRole, DEPTH_FORMAT, Depth, DepthTarget, Device, Extent, Image,
    ImageRole, Load, Recording, RenderPass,
};

use crate::support::{float_target, on_device, pass, quad, quad_pipeline, shader, texels_after};

const EDGE: u32 = 4;

const BYTES: u64 = size_of::<u32>() as u64 * (EDGE * EDGE) as u64;

fn told_in(device: &Arc<Device>, role: BufferRole) -> Arc<Buffer> {
    Buffer::new(device, "told", role, BYTES).expect("a buffer")
}

#[test]
fn fragments_tell_the_host_whatever_depths_are_held() {
    on_device(|device| {
        let target = float_target(device, EDGE);
        let extent = Extent::D2(EDGE, EDGE);
        let depths = Image::new(device, "depths", ImageRole::DepthTarget, DEPTH_FORMAT, extent).expect("depths");
        let pipeline = quad_pipeline(device, shader("tell.frag"), |desc| {
            (desc.depth, desc.bindings) = (Some(Depth::Ignore), &[BindingKind::WrittenStorage]);
        });
        let told = told_in(device, BufferRole::Readback);
        let bindings = Bindings::new(device, "told", &[Binding::WrittenStorage(Arc::clone(&told))]).expect("bindings");
        let held = |load| {
            let depth = DepthTarget {
                image: Arc::clone(&depths),
                load,
            };
            RenderPass {
                depth: Some(depth),
                ..pass(
                    &target,
                    Load::Clear([0.0; 4]),
                    vec![quad(&pipeline, Some(&bindings), [1.0; 4])],
                )
            }
        };
        // Nothing is nearer than what is held. Two passes write the same buffer, of which the second waits for the first.
        let mut recording = Recording::new();
        recording.render(held(Load::Clear(0.0)));
        recording.render(held(Load::Keep));
        assert_eq!(
            texels_after::<[f32; 4]>(device, &recording, &target),
            vec![[1.0; 4]; 16]
        );
        let places: Vec<u32> = (0..EDGE * EDGE).map(|n| n % EDGE + 10 * (n / EDGE)).collect();
        assert_eq!(told.read_vec::<u32>().expect("what was told"), places);
    });
}

#[test]
fn what_the_host_writes_is_not_written_by_fragments() {
    on_device(|device| {
        let told = told_in(device, BufferRole::Upload);
        let bound = Bindings::new(device, "told", &[Binding::WrittenStorage(told)]);
        assert!(bound.is_err_and(|error| error.to_string().contains("told")));
    });
}
