//! What ImageJ and OME say of a stack.

use std::fs;

use glam::DVec3;
use serde_json::{Value, json};
use vcsg::volume::io::{self, ReadOptions};

use crate::oracle::Oracle;
use crate::{f64s, folder, grid};

/// Times, slices, channels, rows, columns.
const SHAPE: [usize; 5] = [2, 3, 4, 5, 6];

fn options(frame: usize, channel: usize) -> ReadOptions {
    ReadOptions {
        frame: Some(frame),
        component: Some(channel),
        ..ReadOptions::default()
    }
}

/// Holds all volumes of the file that tifffile writes of these options against what it reads, whose axes have these strides.
fn check(writer: &Value, shape: [usize; 5], strides: [usize; 3]) {
    let (mut oracle, folder) = (Oracle::start(), folder());
    let path = folder.path().join("a.tif");
    let all = oracle.write(&path, "u16", &shape, writer);
    for frame in 0..2 {
        for channel in 0..4 {
            let volume = io::read_with(&path, &options(frame, channel)).unwrap();
            assert_eq!((volume.frames, volume.components), (2, 4));
            assert_eq!(volume.grid.dims(), [6, 5, 3]);
            let slices = (0..3).flat_map(|slice| {
                let [t, z, c] = strides;
                let start = 30 * (frame * t + slice * z + channel * c);
                all[start..start + 30].to_vec()
            });
            assert_eq!(f64s(volume.grid.voxels()), slices.collect::<Vec<_>>(), "{writer}");
            let scale = DVec3::new(0.25, 0.5, 3.0) * 1e-3;
            let place = volume.grid.world_from_index();
            let found = DVec3::new(place.x_axis.x, place.y_axis.y, place.z_axis.z);
            // Resolutions are quotients of two numbers of 32 bits.
            assert!((found - scale).abs().max_element() < 1e-12, "{found}");
        }
    }
    for (frame, channel) in [(2, 0), (0, 4)] {
        assert!(io::read_with(&path, &options(frame, channel)).is_err());
    }
}

#[test]
fn imagej_hyperstacks_are_read() {
    for (order, unit) in [("<", "um"), (">", "\\u00B5m"), ("<", "micron")] {
        let writer = json!({
            "imagej": true, "byteorder": order, "resolution": [4.0, 2.0],
            "metadata": {"spacing": 3.0, "unit": unit, "axes": "TZCYX"},
        });
        check(&writer, SHAPE, [12, 4, 1]);
    }
}

/// Without axes tifffile calls the slices of a stack channels.
#[test]
fn more_channels_than_imagej_has_are_slices() {
    let (mut oracle, folder) = (Oracle::start(), folder());
    let path = folder.path().join("a.tif");
    for (planes, slices, channels) in [(7, 1, 7), (8, 8, 1)] {
        let all = oracle.write(&path, "u16", &[planes, 5, 6], &json!({"imagej": true}));
        let volume = io::read(&path).unwrap();
        assert_eq!((volume.grid.dims(), volume.components), ([6, 5, slices], channels));
        assert_eq!(f64s(volume.grid.voxels()), all[..slices * 30]);
    }
}

#[test]
fn ome_stacks_are_read_in_any_order() {
    let size = json!({
        "PhysicalSizeX": 250.0, "PhysicalSizeXUnit": "nm", "PhysicalSizeY": 0.5, "PhysicalSizeZ": 0.003, "PhysicalSizeZUnit": "mm",
    });
    for (axes, shape, strides) in [
        ("TZCYX", SHAPE, [12, 4, 1]),
        ("TCZYX", [2, 4, 3, 5, 6], [12, 1, 3]),
        ("CTZYX", [4, 2, 3, 5, 6], [3, 1, 6]),
    ] {
        let mut metadata = size.clone();
        metadata["axes"] = json!(axes);
        check(
            &json!({"ome": true, "photometric": "minisblack", "metadata": metadata}),
            shape,
            strides,
        );
    }
}

/// ImageJ writes stacks above 4 GiB with one page, and the others behind it.
#[test]
fn planes_without_pages_follow_the_first() {
    let (mut oracle, folder) = (Oracle::start(), folder());
    let path = folder.path().join("a.tif");
    let writer =
        json!({"photometric": "minisblack", "description": "ImageJ=1.54\nimages=3\nslices=3\n", "metadata": null});
    let all = oracle.write(&path, "u16", &[1, 5, 6], &writer);
    let mut bytes = fs::read(&path).unwrap();
    let first: Vec<u8> = all.iter().flat_map(|v| (*v as u16).to_le_bytes()).collect();
    let start = bytes.windows(first.len()).position(|part| part == first).unwrap();
    assert_eq!(start + first.len(), bytes.len(), "the page's pixels end the file");
    bytes.extend(first.iter().rev());
    assert!(io::read(&path).is_err(), "two planes are missing");
    bytes.extend(&first);
    fs::write(&path, &bytes).unwrap();
    let read = f64s(grid(&path, &ReadOptions::default()).voxels());
    assert_eq!(read[..30], all[..]);
    assert_eq!(read[60..], all[..]);
}

#[test]
fn resolution_is_spacing_unless_it_is_a_screens() {
    let (mut oracle, folder) = (Oracle::start(), folder());
    let path = folder.path().join("a.tif");
    for (resolution, unit, expected) in [(100.0, 3, 0.1), (254.0, 2, 25.4 / 254.0), (72.0, 2, 1.0), (7.0, 1, 1.0)] {
        let writer = json!({
            "photometric": "minisblack", "resolution": [resolution, resolution], "resolutionunit": unit, "metadata": null,
        });
        oracle.write(&path, "u8", &[2, 5, 6], &writer);
        let info = io::open(&path, &ReadOptions::default()).unwrap().info().unwrap();
        let place = *grid(&path, &ReadOptions::default()).world_from_index();
        assert_eq!([place.x_axis.x, place.y_axis.y, place.z_axis.z], [expected; 3]);
        assert!(!info.notes.is_empty(), "the distance between slices is a guess");
    }
}
