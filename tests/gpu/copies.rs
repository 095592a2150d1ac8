//! Texels and bytes go in and come back unchanged.

use std::sync::Arc;

use vcsg::gpu::{
    Buffer, BufferCopy, BufferRole, Command, Device, Extent, Format, Image, ImageCopy, ImageRole, Recording, Region,
    texel_bytes,
};

use crate::support::{on_device, texels_after};

/// Bytes that differ from their neighbours in every direction.
fn pattern(count: u64) -> Vec<u8> {
    (0..count)
        .map(|place| (place.wrapping_mul(2_654_435_761) >> 13) as u8)
        .collect()
}

fn image(device: &Arc<Device>, format: Format, extent: Extent) -> Arc<Image> {
    Image::new(device, "an image", ImageRole::Sampled, format, extent).expect("an image")
}

#[test]
fn images_come_back_as_they_went() {
    let formats = [
        Format::R8_UNORM,
        Format::R8G8_UNORM,
        Format::R16_UNORM,
        Format::R16_SFLOAT,
        Format::R32_SFLOAT,
        Format::R8G8B8A8_UNORM,
        Format::R16G16B16A16_SFLOAT,
        Format::R32G32B32A32_SFLOAT,
    ];
    on_device(|device| {
        for (format, extent) in formats
            .into_iter()
            .flat_map(|format| [Extent::D1(37), Extent::D2(13, 7), Extent::D3(13, 7, 5)].map(|extent| (format, extent)))
        {
            let texture = image(device, format, extent);
            let data = pattern(extent.texels() * texel_bytes(format).expect("a known format"));
            let staging = Buffer::with_data(device, "staging", &data).expect("a buffer");
            let mut recording = Recording::new();
            recording.upload(&staging, &texture);
            assert_eq!(
                texels_after::<u8>(device, &recording, &texture),
                data,
                "{format:?} {extent:?}"
            );
        }
    });
}

#[test]
fn a_region_is_written_and_nothing_else() {
    on_device(|device| {
        let texture = image(device, Format::R8_UNORM, Extent::D3(6, 5, 4));
        let zeros = Buffer::with_data(device, "zeros", &[0u8; 120]).expect("a buffer");
        let values = Buffer::with_data(device, "values", &pattern(4 + 24)).expect("a buffer");
        let mut recording = Recording::new();
        recording.upload(&zeros, &texture);
        let region = Region {
            offset: [1, 2, 1],
            extent: [4, 2, 3],
        };
        let copy = ImageCopy {
            buffer: values,
            offset: 4,
            image: Arc::clone(&texture),
            region,
        };
        recording.commands.push(Command::Upload(copy));
        let mut expected = vec![0u8; 120];
        for (place, value) in pattern(28)[4..].iter().enumerate() {
            let (x, y, z) = (1 + place % 4, 2 + place / 4 % 2, 1 + place / 8);
            expected[x + 6 * (y + 5 * z)] = *value;
        }
        assert_eq!(texels_after::<u8>(device, &recording, &texture), expected);
    });
}

#[test]
fn buffers_copy_through_the_device_s_own() {
    on_device(|device| {
        let data = pattern(1000);
        let source = Buffer::with_data(device, "source", &data).expect("a buffer");
        let middle = Buffer::new(device, "middle", BufferRole::Device, 1000).expect("a buffer");
        let seen = Buffer::new(device, "seen", BufferRole::Readback, 600).expect("a buffer");
        let copy = |source: &Arc<Buffer>, source_offset, destination: &Arc<Buffer>, bytes| {
            let (source, destination) = (Arc::clone(source), Arc::clone(destination));
            Command::CopyBuffer(BufferCopy {
                source,
                source_offset,
                destination,
                destination_offset: 0,
                bytes,
            })
        };
        let commands = vec![copy(&source, 0, &middle, 1000), copy(&middle, 300, &seen, 600)];
        device.submit(&Recording { commands }).expect("a submission");
        assert_eq!(seen.read_vec::<u8>().expect("bytes"), &data[300..900]);
    });
}

#[test]
fn the_host_waits_before_it_writes_again() {
    on_device(|device| {
        let texture = image(device, Format::R8_UNORM, Extent::D3(256, 256, 16));
        let staging = Buffer::new(device, "staging", BufferRole::Upload, texture.bytes()).expect("a buffer");
        let seen: Vec<_> = (0..4u8)
            .map(|round| {
                staging.fill(|bytes| bytes.fill(round)).expect("to write");
                let seen = Buffer::new(device, "seen", BufferRole::Readback, texture.bytes()).expect("a buffer");
                let mut recording = Recording::new();
                recording.upload(&staging, &texture);
                recording.read_back(&texture, &seen);
                (round, seen, device.submit(&recording).expect("a submission"))
            })
            .collect();
        for (round, buffer, _submission) in &seen {
            assert!(
                buffer
                    .read(|bytes| bytes.iter().all(|byte| byte == round))
                    .expect("bytes"),
                "round {round}"
            );
        }
    });
}

#[test]
fn a_readback_buffer_serves_again_and_again() {
    on_device(|device| {
        let texture = image(device, Format::R8_UNORM, Extent::D2(64, 64));
        let seen = Buffer::new(device, "seen", BufferRole::Readback, texture.bytes());
        let seen = seen.expect("a buffer");
        for round in 0..3u8 {
            let values = Buffer::with_data(device, "values", &[round; 64 * 64]);
            let mut recording = Recording::new();
            recording.upload(&values.expect("a buffer"), &texture);
            recording.read_back(&texture, &seen);
            recording.read_back(&texture, &seen);
            device.submit(&recording).expect("a submission");
            assert_eq!(seen.read_vec::<u8>().expect("bytes"), [round; 64 * 64]);
        }
    });
}
