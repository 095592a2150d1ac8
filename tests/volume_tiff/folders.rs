//! Folders of slices, and single images.

use std::fs;
use std::path::Path;

use image::{DynamicImage, GrayImage, ImageBuffer, Luma, Rgb, RgbImage};
use serde_json::json;
use vcsg::volume::Voxels;
use vcsg::volume::io::{self, ReadOptions};

use crate::oracle::Oracle;
use crate::{component, folder, grid};

fn save(folder: &Path, name: &str, image: impl Into<DynamicImage>) {
    image.into().save(folder.join(name)).unwrap();
}

fn grey(value: u8) -> GrayImage {
    GrayImage::from_pixel(3, 2, Luma([value]))
}

#[test]
fn slices_are_in_the_order_of_their_numbers() {
    let folder = folder();
    for (name, value) in [("s10.png", 10), ("s2.png", 2), ("s1.png", 1)] {
        save(folder.path(), name, grey(value));
    }
    fs::write(folder.path().join("notes.txt"), "no slice").unwrap();
    fs::write(folder.path().join(".s3.png"), "hidden").unwrap();
    let volume = grid(folder.path(), &ReadOptions::default());
    assert_eq!(volume.dims(), [3, 2, 3]);
    let expected = [1, 2, 10].map(|value| [value; 6]).concat();
    assert_eq!(*volume.voxels(), Voxels::U8(expected));
    save(folder.path(), "s11.png", GrayImage::from_pixel(2, 2, Luma([0])));
    let error = io::read(folder.path()).unwrap_err().to_string();
    assert!(
        error.contains("s11.png") && error.contains("2 x 2") && error.contains("3 x 2"),
        "{error}"
    );
}

#[test]
fn images_keep_their_bits_and_colours_are_luminance() {
    let folder = folder();
    save(
        folder.path(),
        "a.png",
        ImageBuffer::from_pixel(2, 1, Luma([40_000_u16])),
    );
    assert_eq!(
        *grid(&folder.path().join("a.png"), &ReadOptions::default()).voxels(),
        Voxels::U16(vec![40_000; 2])
    );
    save(folder.path(), "b.png", RgbImage::from_pixel(1, 1, Rgb([255, 0, 0])));
    let path = folder.path().join("b.png");
    assert_eq!(*grid(&path, &ReadOptions::default()).voxels(), Voxels::U8(vec![54]));
    assert_eq!(*grid(&path, &component(1)).voxels(), Voxels::U8(vec![0]));
}

#[test]
fn folders_of_tiff_are_read() {
    let (mut oracle, folder) = (Oracle::start(), folder());
    let mut expected = Vec::new();
    for slice in 0..3 {
        let writer = json!({"photometric": "minisblack", "compression": "zlib", "resolution": [100.0, 100.0], "resolutionunit": 3});
        expected.extend(oracle.write(&folder.path().join(format!("a{slice}.tif")), "f32", &[5, 6], &writer));
    }
    let volume = grid(folder.path(), &ReadOptions::default());
    assert_eq!(crate::f64s(volume.voxels()), expected);
    assert_eq!(volume.world_from_index().x_axis.x, 0.1);
    oracle.write(
        &folder.path().join("a3.tif"),
        "f32",
        &[2, 5, 6],
        &json!({"photometric": "minisblack"}),
    );
    let error = io::read(folder.path()).unwrap_err().to_string();
    assert!(error.contains("2 pages"), "{error}");
}

#[test]
fn jpeg_slices_are_read() {
    let folder = folder();
    for (name, value) in [("a1.jpg", 100), ("a2.JPEG", 200)] {
        save(folder.path(), name, GrayImage::from_pixel(16, 16, Luma([value])));
    }
    let expected = [[100; 256], [200; 256]].concat();
    assert_eq!(
        *grid(folder.path(), &ReadOptions::default()).voxels(),
        Voxels::U8(expected)
    );
}

#[test]
fn a_folder_without_slices_is_refused() {
    assert!(io::read(folder().path()).is_err());
}

/// The start of a JPEG image, whose header declares 60,000 x 60,000 pixels, and one with as many as there are.
#[test]
fn declared_sizes_of_slices_are_held_against_their_bytes_and_the_budget() {
    let folder = folder();
    let path = folder.path().join("s.jpg");
    let noise = GrayImage::from_fn(300, 200, |x, y| Luma([(x * x * 7 + y * 31 * x) as u8]));
    save(folder.path(), "s.jpg", noise);
    let sound = fs::read(&path).unwrap();
    let little = ReadOptions {
        budget: io::Budget::of_bytes(50_000),
        ..ReadOptions::default()
    };
    let error = io::open(&path, &little).unwrap_err();
    assert!(
        matches!(error.problem, io::Problem::Budget { bytes: 60_000, .. }),
        "{error}"
    );
    let mut bytes = sound.clone();
    let frame = bytes.windows(2).position(|start| start == [0xff, 0xc0]).unwrap();
    bytes[frame + 5..frame + 9].copy_from_slice(&[0xea, 0x60, 0xea, 0x60]);
    fs::write(&path, &bytes).unwrap();
    let error = io::read(&path).unwrap_err();
    assert!(matches!(error.problem, io::Problem::Implausible { .. }), "{error}");
}

#[test]
fn what_is_no_image_of_its_name_is_refused() {
    let folder = folder();
    fs::write(folder.path().join("a.png"), [0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0]).unwrap();
    let error = io::read(&folder.path().join("a.png")).unwrap_err().to_string();
    assert!(error.contains("neither PNG nor JPEG"), "{error}");
}
