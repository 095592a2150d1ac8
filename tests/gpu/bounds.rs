//! What contradicts itself is refused with a message, and nothing is done.

use std::sync::Arc;

use vcsg::gpu::{
    Binding, Bindings, Buffer, BufferRole, Command, DEPTH_FORMAT, Elements, Extent, Format, GpuError, Image, ImageCopy,
    ImageRole, Load, Recording, Region,
};

use crate::support::{float_target, on_device, pass, quad, quad_pipeline, shader};

#[test]
fn impossible_objects_are_refused() {
    on_device(|device| {
        let new = |format, extent| {
            Image::new(device, "odd", ImageRole::Sampled, format, extent)
                .err()
                .map(|e| e.to_string())
        };
        let limit = device.info().limits.image_dimension_3d;
        let large = new(Format::R8_UNORM, Extent::D3(4, limit + 1, 4)).expect("too large");
        assert_eq!(
            large,
            format!(
                "odd is too large: height {}, and the device's limit is {limit}",
                limit + 1
            )
        );
        assert!(new(Format::R8_UNORM, Extent::D3(4, 0, 4)).is_some(), "no texels");
        assert!(
            new(Format::A8B8G8R8_UINT_PACK32, Extent::D2(4, 4)).is_some(),
            "an unknown format"
        );
        assert!(new(DEPTH_FORMAT, Extent::D2(4, 4)).is_some(), "depths are not sampled");
        let solid = Image::new(
            device,
            "odd",
            ImageRole::ColorTarget,
            Format::R8_UNORM,
            Extent::D3(4, 4, 4),
        );
        assert!(matches!(solid.err(), Some(GpuError::Usage { .. })));
        assert!(matches!(
            Buffer::new(device, "none", BufferRole::Upload, 0).err(),
            Some(GpuError::Usage { .. })
        ));
    });
}

#[test]
fn too_much_memory_is_an_error_with_its_size() {
    on_device(|device| {
        for role in [BufferRole::Upload, BufferRole::Readback, BufferRole::Device] {
            let error = Buffer::new(device, "the whole sky", role, 1 << 46)
                .err()
                .expect("more than any device has");
            assert!(error.to_string().contains("the whole sky"), "{error}");
            assert!(error.to_string().contains("70368744177664"), "{error}");
        }
    });
}

#[test]
fn uniform_data_beyond_the_limit_are_refused() {
    on_device(|device| {
        let bytes = u64::from(device.info().limits.uniform_bytes) + 1;
        let buffer = Buffer::new(device, "long", BufferRole::Upload, bytes).expect("a buffer");
        let error = Bindings::new(device, "too much", &[Binding::Uniform(buffer)]).err();
        assert!(matches!(error, Some(GpuError::TooLarge { .. })), "{error:?}");
        assert!(Bindings::new(device, "nothing", &[]).is_err());
    });
}

#[test]
fn copies_stay_within_their_objects() {
    on_device(|device| {
        let image = Image::new(
            device,
            "image",
            ImageRole::Sampled,
            Format::R8_UNORM,
            Extent::D3(4, 4, 4),
        )
        .expect("an image");
        let buffer = Buffer::new(device, "bytes", BufferRole::Upload, 64).expect("a buffer");
        let readback = Buffer::new(device, "readback", BufferRole::Readback, 64).expect("a buffer");
        let refused = |buffer: &Arc<Buffer>, offset, from, extent| {
            let region = Region { offset: from, extent };
            let copy = ImageCopy {
                buffer: Arc::clone(buffer),
                offset,
                image: Arc::clone(&image),
                region,
            };
            device
                .submit(&Recording {
                    commands: vec![Command::Upload(copy)],
                })
                .is_err()
        };
        assert!(!refused(&buffer, 0, [0; 3], [4; 3]), "the whole image fits");
        assert!(refused(&buffer, 4, [0; 3], [4; 3]), "beyond the buffer");
        assert!(refused(&buffer, 1, [0; 3], [1; 3]), "an odd offset");
        assert!(refused(&buffer, 0, [3, 0, 0], [2, 1, 1]), "beyond the image");
        assert!(refused(&buffer, 0, [u32::MAX, 0, 0], [2, 1, 1]), "far beyond the image");
        assert!(refused(&buffer, 0, [0; 3], [1, 0, 1]), "nothing");
        assert!(refused(&readback, 0, [0; 3], [4; 3]), "a role that does not allow it");
        assert!(
            buffer.write(60, &[0; 5]).is_err() && buffer.write(u64::MAX, &[0]).is_err(),
            "writes beyond the buffer"
        );
        assert!(buffer.read_vec::<u8>().is_err(), "reads of an upload buffer");
    });
}

#[test]
fn draws_match_their_pipeline() {
    on_device(|device| {
        let target = float_target(device, 4);
        let pipeline = quad_pipeline(device, shader("color.frag"), |_| ());
        let good = quad(&pipeline, None, [1.0; 4]);
        let refused = |image: &Arc<Image>, load, draws| {
            let mut recording = Recording::new();
            recording.render(pass(image, load, draws));
            device.submit(&recording).is_err()
        };
        assert!(refused(&target, Load::Keep, vec![]), "nothing to keep yet");
        assert!(!refused(&target, Load::Clear([0.0; 4]), vec![good.clone()]));
        let mut few = good.clone();
        few.push = vcsg::gpu::Push::of(&1.0f32);
        assert!(refused(&target, Load::Keep, vec![few]), "too few push constants");
        let mut beyond = good.clone();
        let buffer = Buffer::with_data(device, "indices", &[0u32; 3]).expect("a buffer");
        beyond.elements = Elements::Indices {
            buffer,
            range: 0..4,
            base_vertex: 0,
        };
        assert!(
            refused(&target, Load::Keep, vec![good.clone(), beyond]),
            "too few indices"
        );
        let extent = Extent::D2(4, 4);
        let other = Image::new(device, "other", ImageRole::ColorTarget, Format::R8_UNORM, extent).expect("an image");
        assert!(refused(&other, Load::Clear([0.0; 4]), vec![good]), "another format");
        let plain = Image::new(device, "plain", ImageRole::Sampled, Format::R8_UNORM, extent).expect("an image");
        assert!(refused(&plain, Load::Clear([0.0; 4]), vec![]), "no target");
    });
}
