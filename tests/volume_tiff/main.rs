//! TIFF: what tifffile writes is read as tifffile reads it; ImageJ's and OME's descriptions; folders of slices; damage.

mod damage;
mod descriptions;
mod folders;
mod oracle;

use std::path::Path;

use serde_json::{Value, json};
use tempfile::TempDir;
use vcsg::volume::io::{self, ReadOptions};
use vcsg::volume::{Grid, Voxels};

use crate::oracle::Oracle;

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

fn f64s(voxels: &Voxels) -> Vec<f64> {
    (0..voxels.len()).map(|i| voxels.get(i)).collect()
}

fn component(component: usize) -> ReadOptions {
    ReadOptions {
        component: Some(component),
        ..ReadOptions::default()
    }
}

fn grid(path: &Path, options: &ReadOptions) -> Grid {
    io::read_with(path, options).unwrap_or_else(|e| panic!("{e}")).grid
}

const TYPES: [&str; 11] = [
    "u8", "i8", "u16", "i16", "u32", "i32", "f16", "f32", "f64", "i64", "u64",
];

/// A stack of 3 slices of 40 x 33, which the tiles do not divide.
const SHAPE: [usize; 3] = [3, 33, 40];

#[test]
fn every_type_and_compression_is_read() {
    let (mut oracle, folder) = (Oracle::start(), folder());
    let path = folder.path().join("a.tif");
    for kind in TYPES {
        for compression in [
            Value::Null,
            json!("zlib"),
            json!("lzw"),
            json!("packbits"),
            json!("zstd"),
        ] {
            for order in ["<", ">"] {
                for more in [
                    json!({}),
                    json!({"tile": [16, 16]}),
                    json!({"bigtiff": true, "rowsperstrip": 7}),
                ] {
                    let mut options =
                        json!({"compression": compression, "byteorder": order, "photometric": "minisblack"});
                    options
                        .as_object_mut()
                        .unwrap()
                        .extend(more.as_object().unwrap().clone());
                    let expected = oracle.write(&path, kind, &SHAPE, &options);
                    let read = grid(&path, &ReadOptions::default());
                    assert_eq!(read.dims(), [40, 33, 3]);
                    assert_eq!(f64s(read.voxels()), expected, "{kind} {options}");
                }
            }
        }
    }
}

#[test]
fn predictors_are_undone() {
    let (mut oracle, folder) = (Oracle::start(), folder());
    let path = folder.path().join("a.tif");
    for kind in ["u8", "u16", "i16", "u32", "f32", "f64"] {
        for (compression, order) in [("zlib", "<"), ("lzw", "<"), ("lzw", ">")] {
            for tile in [json!({}), json!({"tile": [16, 16]})] {
                let mut options = json!({
                    "compression": compression, "predictor": true, "photometric": "minisblack", "byteorder": order,
                });
                let more = tile.as_object().unwrap().clone();
                options.as_object_mut().unwrap().extend(more);
                let expected = oracle.write(&path, kind, &SHAPE, &options);
                let read = f64s(grid(&path, &ReadOptions::default()).voxels());
                assert_eq!(read, expected, "{kind} {options}");
            }
        }
    }
}

/// Both decoders' transforms keep within one of the exact values (ITU-T T.83), so they are two apart at most.
#[test]
fn jpeg_pages_are_read() {
    let (mut oracle, folder) = (Oracle::start(), folder());
    let path = folder.path().join("a.tif");
    for tile in [json!({}), json!({"tile": [16, 16]})] {
        let mut options = json!({"compression": "jpeg", "photometric": "minisblack"});
        let more = tile.as_object().unwrap().clone();
        options.as_object_mut().unwrap().extend(more);
        let expected = oracle.write(&path, "u8", &SHAPE, &options);
        let read = f64s(grid(&path, &ReadOptions::default()).voxels());
        assert_eq!(read.len(), expected.len());
        let apart = read.iter().zip(&expected).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f64::max) <= 2.0, "{options}");
    }
}

#[test]
fn pages_of_several_slices_are_refused() {
    let (mut oracle, folder) = (Oracle::start(), folder());
    let path = folder.path().join("a.tif");
    let deep = json!({"volumetric": true, "tile": [16, 16, 16], "photometric": "minisblack"});
    oracle.write(&path, "u8", &[16, 32, 32], &deep);
    let error = io::read(&path).unwrap_err().to_string();
    assert!(error.contains("ImageDepth"), "{error}");
}

#[test]
fn values_are_as_they_are_stored() {
    let (mut oracle, folder) = (Oracle::start(), folder());
    let path = folder.path().join("a.tif");
    for (kind, photometric) in [("u8", "miniswhite"), ("u16", "miniswhite"), ("u8", "palette")] {
        for order in ["<", ">"] {
            for bigtiff in [false, true] {
                let options = json!({"photometric": photometric, "byteorder": order, "bigtiff": bigtiff});
                let expected = oracle.write(&path, kind, &SHAPE, &options);
                assert_eq!(
                    f64s(grid(&path, &ReadOptions::default()).voxels()),
                    expected,
                    "{kind} {options}"
                );
            }
        }
    }
}

#[test]
fn colours_are_their_luminance() {
    let (mut oracle, folder) = (Oracle::start(), folder());
    let path = folder.path().join("a.tif");
    for (planar, more) in [
        (false, json!({})),
        (true, json!({})),
        (false, json!({"compression": "lzw", "tile": [16, 32]})),
        (true, json!({"compression": "lzw", "tile": [16, 32], "predictor": true})),
    ] {
        for kind in ["u8", "u16"] {
            let (shape, config) = if planar {
                ([2, 3, 33, 40], "separate")
            } else {
                ([2, 33, 40, 3], "contig")
            };
            let mut options = json!({"photometric": "rgb", "planarconfig": config});
            options
                .as_object_mut()
                .unwrap()
                .extend(more.as_object().unwrap().clone());
            let expected = oracle.write(&path, kind, &shape, &options);
            let colour = |pixel: usize, c: usize| match planar {
                true => expected[(pixel / 1320 * 3 + c) * 1320 + pixel % 1320],
                false => expected[pixel * 3 + c],
            };
            for c in 0..3 {
                let values = f64s(grid(&path, &component(c)).voxels());
                let wanted: Vec<_> = (0..2 * 1320).map(|pixel| colour(pixel, c)).collect();
                assert_eq!(values, wanted, "{kind} {options}");
            }
            let luminance = |pixel: usize| {
                let [r, g, b] = [0, 1, 2].map(|c| colour(pixel, c));
                (0.2126 * r + 0.7152 * g + 0.0722 * b).round_ties_even()
            };
            let wanted: Vec<_> = (0..2 * 1320).map(luminance).collect();
            assert_eq!(
                f64s(grid(&path, &ReadOptions::default()).voxels()),
                wanted,
                "{kind} {options}"
            );
        }
    }
}

#[test]
fn real_stacks_are_read_as_tifffile_reads_them() {
    let path = Path::new("target/deps/data/img3d.tif");
    assert!(path.exists(), "{} is missing: run make setup", path.display());
    let read = grid(path, &ReadOptions::default());
    assert_eq!(read.dims(), [57, 61, 31]);
    assert_eq!(f64s(read.voxels()), Oracle::start().read(path));
}

#[test]
fn pages_of_another_size_are_named() {
    let (mut oracle, folder) = (Oracle::start(), folder());
    let path = folder.path().join("a.tif");
    oracle.write(
        &path,
        "u8",
        &[2, 33, 40],
        &json!({"photometric": "minisblack", "metadata": null}),
    );
    oracle.write(
        &path,
        "u8",
        &[30, 40],
        &json!({"photometric": "minisblack", "append": true, "metadata": null}),
    );
    let error = io::read(&path).unwrap_err().to_string();
    assert!(error.contains("page 3") && error.contains("40 x 30"), "{error}");
}

#[test]
fn small_copies_are_passed_over() {
    let (mut oracle, folder) = (Oracle::start(), folder());
    let path = folder.path().join("a.tif");
    let plain = json!({"photometric": "minisblack", "metadata": null});
    let small = json!({"photometric": "minisblack", "metadata": null, "append": true, "subfiletype": 1});
    let expected = oracle.write(&path, "u8", &[1, 33, 40], &plain);
    oracle.write(&path, "u8", &[16, 20], &small);
    assert_eq!(f64s(grid(&path, &ReadOptions::default()).voxels()), expected);
}
