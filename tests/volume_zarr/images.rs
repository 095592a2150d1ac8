//! OME-Zarr: axes, places, resolutions and channels.

use glam::DVec3;
use serde_json::{Value, json};
use vcsg::volume::io::{self, ReadOptions};

use crate::folder::{Folder, version_2};

/// The attributes of an image of version 0.5.
fn group(ome: &Value) -> Value {
    json!({"zarr_format": 3, "node_type": "group", "attributes": {"ome": ome}})
}

fn axes() -> Value {
    json!([
        {"name": "t", "type": "time", "unit": "second"}, {"name": "c", "type": "channel"},
        {"name": "z", "type": "space", "unit": "micrometer"}, {"name": "y", "type": "space", "unit": "nanometer"},
        {"name": "x", "type": "space", "unit": "millimeter"},
    ])
}

/// An image of two resolutions, two channels and two times.
fn image() -> Folder {
    let folder = Folder::new();
    let scale = |z: f64, x: f64| json!({"type": "scale", "scale": [1.0, 1.0, z, 5e5, x]});
    let multiscale = json!({
        "axes": axes(),
        "datasets": [
            {"path": "0", "coordinateTransformations": [scale(2e3, 0.25)]},
            {"path": "1", "coordinateTransformations": [scale(4e3, 0.5), {"type": "translation", "translation": [0, 0, 1e3, 1e6, 0.125]}]},
        ],
        "coordinateTransformations": [{"type": "scale", "scale": [0.1, 1.0, 1.0, 1.0, 2.0]}],
    });
    folder.json(
        "zarr.json",
        &group(&json!({"version": "0.5", "multiscales": [multiscale]})),
    );
    folder.array("0", &[2, 2, 2, 3, 4]);
    folder.array("1", &[2, 2, 1, 3, 2]);
    folder
}

#[test]
fn a_resolution_a_channel_and_a_time_are_chosen() {
    let options = |resolution, component, frame| ReadOptions {
        resolution,
        component,
        frame,
        ..ReadOptions::default()
    };
    let folder = image();
    for (options, first, dims) in [
        (options(None, None, None), 0.0, [4, 3, 2]),
        (options(Some(0), Some(1), None), 24.0, [4, 3, 2]),
        (options(None, Some(1), Some(1)), 72.0, [4, 3, 2]),
        (options(Some(1), None, Some(1)), 12.0, [2, 3, 1]),
    ] {
        let grid = folder.open(&options).unwrap().grid().unwrap();
        assert_eq!((grid.dims(), grid.value_at([0, 0, 0])), (dims, first));
        let last = dims.map(|n| n - 1);
        assert_eq!(grid.value_at(last), first + (dims.iter().product::<usize>() - 1) as f64);
    }
    let opened = folder.open(&options(None, None, None)).unwrap();
    assert_eq!((opened.declared().frames, opened.declared().components), (2, 2));
    for (options, word) in [
        (options(Some(2), None, None), "2 resolutions"),
        (options(None, Some(2), None), "2 channels"),
        (options(None, None, Some(2)), "2 frames"),
    ] {
        let error = folder.open(&options).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
}

#[test]
fn scale_translation_and_units_are_a_place_in_millimetres() {
    let fine = image().open(&ReadOptions::default()).unwrap();
    let place = fine.declared().world_from_index;
    assert_eq!(place.matrix3.x_axis, DVec3::new(0.5, 0.0, 0.0));
    // 5e5 nm and 2e3 µm, as products of numbers that have no exact binary form.
    assert!((place.matrix3.y_axis - DVec3::new(0.0, 0.5, 0.0)).length() < 1e-15);
    assert!((place.matrix3.z_axis - DVec3::new(0.0, 0.0, 2.0)).length() < 1e-15);
    assert_eq!(place.translation, DVec3::ZERO);
    let options = ReadOptions {
        resolution: Some(1),
        ..ReadOptions::default()
    };
    let coarse = image().open(&options).unwrap();
    let place = coarse.declared().world_from_index;
    assert_eq!(place.matrix3.x_axis, DVec3::new(1.0, 0.0, 0.0));
    assert!(
        (place.translation - DVec3::new(0.25, 1.0, 1.0)).length() < 1e-15,
        "{place:?}"
    );
}

#[test]
fn first_versions_have_five_axes() {
    let folder = Folder::new();
    folder.json(".zgroup", &json!({"zarr_format": 2}));
    folder.json(
        ".zattrs",
        &json!({"multiscales": [{"datasets": [{"path": "a"}], "version": "0.1"}]}),
    );
    folder.json("a/.zarray", &version_2(&[1, 1, 2, 2, 2], &[1, 1, 2, 2, 2]));
    folder.file("a/0.0.0.0.0", &[1, 2, 3, 4, 5, 6, 7, 8]);
    let grid = folder.open(&ReadOptions::default()).unwrap().grid().unwrap();
    assert_eq!((grid.dims(), grid.value_at([1, 0, 1])), ([2, 2, 2], 6.0));
}

#[test]
fn axes_in_another_order_stay_where_they_point() {
    let folder = Folder::new();
    let axes = json!([{"name": "x", "type": "space"}, {"name": "y", "type": "space"}, {"name": "z", "type": "space"}]);
    let scale = json!([{"type": "scale", "scale": [2.0, 3.0, 4.0]}]);
    let datasets = json!([{"path": "0", "coordinateTransformations": scale}]);
    folder.json(
        "zarr.json",
        &group(&json!({"multiscales": [{"axes": axes, "datasets": datasets}]})),
    );
    folder.array("0", &[2, 3, 4]);
    let opened = folder.open(&ReadOptions::default()).unwrap();
    let place = opened.declared().world_from_index;
    assert_eq!(opened.declared().dims, [4, 3, 2]);
    assert_eq!(place.matrix3.x_axis, DVec3::new(0.0, 0.0, 4.0));
    assert_eq!(place.matrix3.z_axis, DVec3::new(2.0, 0.0, 0.0));
}

#[test]
fn series_of_a_microscope_are_several_volumes() {
    let folder = Folder::new();
    folder.json("zarr.json", &group(&json!({"bioformats2raw.layout": 3})));
    for series in ["0", "1"] {
        let axes = json!(["z", "y", "x"]);
        let image = json!({"multiscales": [{"axes": axes, "datasets": [{"path": "0"}]}]});
        folder.json(&format!("{series}/zarr.json"), &group(&image));
        folder.array(&format!("{series}/0"), &[2, 2, 2]);
    }
    assert_eq!(io::open_all(folder.path(), &ReadOptions::default()).unwrap().len(), 2);
    let error = folder.open(&ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("2 volumes: `0`, `1`"), "{error}");
    let series = ReadOptions {
        series: Some("1".to_owned()),
        ..ReadOptions::default()
    };
    assert_eq!(folder.open(&series).unwrap().declared().name, "1");
}

#[test]
fn named_axes_of_an_array_are_taken_by_their_names() {
    let folder = Folder::new();
    let mut array = crate::folder::version_3(&[2, 2, 3], &[1, 2, 3]);
    array["dimension_names"] = json!(["c", "y", "x"]);
    folder.json("zarr.json", &array);
    folder.file("c/1/0/0", &[1, 2, 3, 4, 5, 6]);
    let options = ReadOptions {
        component: Some(1),
        ..ReadOptions::default()
    };
    let grid = folder.open(&options).unwrap().grid().unwrap();
    assert_eq!((grid.dims(), grid.value_at([2, 1, 0])), ([3, 2, 1], 6.0));
    let first = folder.open(&ReadOptions::default()).unwrap().grid().unwrap();
    assert_eq!(first.value_at([2, 1, 0]), 9.0, "an absent chunk is the fill value");
}
