//! What makes a series a volume: order, spacing, tilt, time.

use std::path::Path;

use glam::DVec3;
use tempfile::tempdir;
use vcsg::volume::Voxels;
use vcsg::volume::io::{self, ReadOptions, Volume};

use crate::file::{Elements, File, Value};

fn read(folder: &Path) -> Volume {
    io::read(folder).unwrap_or_else(|e| panic!("{e}"))
}

fn options(change: impl Fn(&mut ReadOptions)) -> ReadOptions {
    let mut options = ReadOptions::default();
    change(&mut options);
    options
}

/// The first value of each slice.
fn firsts(volume: &Volume) -> Vec<f64> {
    (0..volume.grid.dims()[2])
        .map(|k| volume.grid.value_at([0, 0, k]))
        .collect()
}

#[test]
fn slices_are_sorted_by_position_and_not_by_name() {
    let folder = tempdir().unwrap();
    for (name, number) in [("1", 4), ("10", 3), ("11", 2), ("2", 1)] {
        File::slice(number, 10.0 - f64::from(number) * 2.0).write(folder.path(), name);
    }
    let volume = read(folder.path());
    assert_eq!(volume.grid.dims(), [4, 3, 4]);
    assert_eq!(firsts(&volume), [400.0, 300.0, 200.0, 100.0]);
    let map = volume.grid.world_from_index();
    // Rows are 0.5 mm apart, columns 0.25 mm.
    assert_eq!(map.matrix3.x_axis, DVec3::new(0.25, 0.0, 0.0));
    assert_eq!(map.matrix3.y_axis, DVec3::new(0.0, 0.5, 0.0));
    assert_eq!(map.matrix3.z_axis, DVec3::new(0.0, 0.0, 2.0));
    assert_eq!(map.translation, DVec3::new(0.0, 0.0, 2.0));
    assert_eq!(volume.grid.value_at([1, 2, 0]), 409.0);
}

#[test]
fn a_tilted_gantry_shears_the_grid() {
    let folder = tempdir().unwrap();
    for number in 1..=4 {
        let mut file = File::slice(number, 0.0);
        // The axes are tilted about x; the table moves along z.
        file.text((0x20, 0x37), "DS", "1\\0\\0\\0\\0.8\\-0.6");
        file.place([0.0, 0.0, f64::from(number)]);
        file.write(folder.path(), &number.to_string());
    }
    let opened = io::open(folder.path(), &ReadOptions::default()).unwrap();
    assert!(
        opened.declared().notes.iter().any(|note| note.contains("36.87°")),
        "{opened:?}"
    );
    let map = opened.declared().world_from_index;
    // Unit vectors are made so: an ulp or two.
    assert!(map.matrix3.y_axis.abs_diff_eq(DVec3::new(0.0, 0.4, -0.3), 1e-15));
    assert_eq!(map.matrix3.z_axis, DVec3::Z);
}

#[test]
fn a_small_unevenness_is_told_and_a_gap_is_refused_with_its_place() {
    let folder = tempdir().unwrap();
    for (number, z) in [(1, 0.0), (2, 1.02), (3, 2.0), (4, 3.0)] {
        File::slice(number, z).write(folder.path(), &format!("slice{number}.dcm"));
    }
    let opened = io::open(folder.path(), &ReadOptions::default()).unwrap();
    let note = &opened.declared().notes[0];
    assert!(note.contains("slice2.dcm, is 0.0200 mm off"), "{note}");
    File::slice(5, 5.0).write(folder.path(), "slice5.dcm");
    let error = io::read(folder.path()).unwrap_err().to_string();
    for part in ["between slice4.dcm and slice5.dcm", "3.000 and 5.000 mm", "--resample"] {
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn a_gap_is_filled_between_its_neighbours_when_that_is_asked_for() {
    let folder = tempdir().unwrap();
    for (number, z) in [(1, 0.0), (2, 1.0), (4, 3.0), (5, 4.0)] {
        File::slice(number, z).write(folder.path(), &number.to_string());
    }
    let volume = io::read_with(folder.path(), &options(|o| o.resample = true)).unwrap();
    assert_eq!(firsts(&volume), [100.0, 200.0, 300.0, 400.0, 500.0]);
    assert_eq!(volume.grid.world_from_index().matrix3.z_axis, DVec3::Z);
    // Even slices stay as they are.
    File::slice(3, 2.0).write(folder.path(), "3");
    let volume = io::read_with(folder.path(), &options(|o| o.resample = true)).unwrap();
    assert!(matches!(volume.grid.voxels(), Voxels::U16(_)));
}

#[test]
fn slices_at_one_place_are_volumes_in_time() {
    let folder = tempdir().unwrap();
    for time in 0..3 {
        for k in 0..2 {
            File::slice(1 + time * 2 + k, f64::from(k)).write(folder.path(), &format!("{time}{k}"));
        }
    }
    for frame in 0..3 {
        let volume = io::read_with(folder.path(), &options(|o| o.frame = Some(frame))).unwrap();
        assert_eq!((volume.frames, volume.grid.dims()), (3, [4, 3, 2]));
        assert_eq!(firsts(&volume), [1.0, 2.0].map(|k| 100.0 * (2.0 * frame as f64 + k)));
    }
    let error = io::read_with(folder.path(), &options(|o| o.frame = Some(3))).unwrap_err();
    assert!(error.to_string().contains("it holds 3"), "{error}");
    // One more at a place, and they are no volumes in time.
    File::slice(9, 1.0).write(folder.path(), "more");
    let error = io::read(folder.path()).unwrap_err().to_string();
    assert!(error.contains("3 at the place of 00, 4 at the place of 01"), "{error}");
}

#[test]
fn a_copy_of_a_file_is_left_out() {
    let folder = tempdir().unwrap();
    for (name, number) in [("1", 1), ("2", 2), ("copy of 2", 2)] {
        File::slice(number, f64::from(number)).write(folder.path(), name);
    }
    let opened = io::open(folder.path(), &ReadOptions::default()).unwrap();
    assert_eq!((opened.declared().dims, opened.declared().frames), ([4, 3, 2], 1));
    assert!(opened.declared().notes[0].starts_with("images that are there twice are taken once; copies: 1"));
}

#[test]
fn series_of_a_folder_are_listed_and_chosen() {
    let folder = tempdir().unwrap();
    std::fs::create_dir(folder.path().join("in")).unwrap();
    std::fs::write(folder.path().join("README"), "no image").unwrap();
    for number in 1..=3 {
        File::slice(number, f64::from(number)).write(folder.path(), &number.to_string());
        let mut file = File::slice(number + 10, f64::from(number));
        file.text((0x20, 0xe), "UI", "1.2.4");
        file.text((0x8, 0x103e), "LO", "Other");
        file.write(&folder.path().join("in"), &number.to_string());
    }
    let names: Vec<_> = io::open_all(folder.path(), &ReadOptions::default()).unwrap();
    let names: Vec<_> = names.iter().map(|v| v.declared().name.as_str()).collect();
    assert_eq!(names, ["1.2.3", "1.2.4"]);
    let error = io::read(folder.path()).unwrap_err().to_string();
    assert!(
        error.contains("`1.2.3`, `1.2.4`") && error.contains("--series"),
        "{error}"
    );
    for wanted in ["2.4", "other"] {
        let volume = io::read_with(folder.path(), &options(|o| o.series = Some(wanted.into()))).unwrap();
        assert_eq!(firsts(&volume), [1100.0, 1200.0, 1300.0]);
    }
    let error = io::read_with(folder.path(), &options(|o| o.series = Some("9".into()))).unwrap_err();
    assert!(error.to_string().contains("`1.2.4` (Other)"), "{error}");
}

#[test]
fn a_localizer_in_a_series_is_a_volume_of_its_own() {
    let folder = tempdir().unwrap();
    for number in 1..=3 {
        let mut file = File::slice(number, f64::from(number));
        if number == 3 {
            file.text((0x20, 0x37), "DS", "0\\1\\0\\0\\0\\-1");
        }
        file.write(folder.path(), &number.to_string());
    }
    let volumes = io::open_all(folder.path(), &ReadOptions::default()).unwrap();
    let all: Vec<_> = volumes
        .iter()
        .map(|v| (v.declared().name.as_str(), v.declared().dims[2]))
        .collect();
    assert_eq!(all, [("1.2.3#0", 2), ("1.2.3#1", 1)]);
}

#[test]
fn what_one_series_is_refused_for_does_not_hide_behind_another() {
    let folder = tempdir().unwrap();
    for (number, z) in [(1, 0.0), (2, 1.0), (3, 3.0)] {
        File::slice(number, z).write(folder.path(), &number.to_string());
    }
    let mut scout = File::slice(7, 0.0);
    scout.text((0x20, 0xe), "UI", "1.2.4");
    scout.write(folder.path(), "scout");
    let error = io::read(folder.path()).unwrap_err().to_string();
    assert!(
        error.contains("slices are missing") && error.contains("choose series `1.2.4`"),
        "{error}"
    );
}

/// Functional groups of a frame at `z` whose values have `slope`.
fn groups(z: f64, slope: f64) -> Elements {
    let text = |tag, text: String| Elements::from([(tag, Value::Text("DS", text))]);
    let mut values = text((0x28, 0x1053), slope.to_string());
    values.insert((0x28, 0x1052), Value::Text("DS", "-1".into()));
    Elements::from([
        (
            (0x20, 0x9113),
            Value::Items(vec![text((0x20, 0x32), format!("5\\6\\{z}"))]),
        ),
        ((0x28, 0x9145), Value::Items(vec![values])),
    ])
}

#[test]
fn enhanced_frames_have_places_and_slopes_of_their_own() {
    let folder = tempdir().unwrap();
    let mut file = File::slice(1, 0.0);
    for tag in [(0x20, 0x32), (0x20, 0x37), (0x28, 0x30)] {
        file.elements.remove(&tag);
    }
    let text = |tag, text: &str| Value::Items(vec![Elements::from([(tag, Value::Text("DS", text.into()))])]);
    let shared = Elements::from([
        ((0x20, 0x9116), text((0x20, 0x37), "0\\1\\0\\0\\0\\-1")),
        ((0x28, 0x9110), text((0x28, 0x30), "2\\3")),
    ]);
    file.elements.insert((0x5200, 0x9229), Value::Items(vec![shared]));
    // The normal is -x; the second frame is farther along it.
    let places = [7.0, 4.0].map(|x| format!("{x}\\6\\0"));
    let mut frames = vec![groups(0.0, 0.5), groups(0.0, 2.0)];
    for (frame, place) in frames.iter_mut().zip(&places) {
        frame.insert((0x20, 0x9113), text((0x20, 0x32), place));
    }
    file.elements.insert((0x5200, 0x9230), Value::Items(frames));
    file.text((0x28, 0x8), "IS", "2");
    file.frames.push(file.frames[0].clone());
    let volume = read(&file.write(folder.path(), "enhanced.dcm"));
    assert_eq!(volume.grid.dims(), [4, 3, 2]);
    assert!(matches!(volume.grid.voxels(), Voxels::F32(_)));
    assert_eq!(firsts(&volume), [100.0 * 0.5 - 1.0, 100.0 * 2.0 - 1.0]);
    let map = volume.grid.world_from_index();
    assert_eq!(
        map.matrix3.to_cols_array(),
        [0.0, 3.0, 0.0, 0.0, 0.0, -2.0, -3.0, 0.0, 0.0]
    );
    assert_eq!(map.translation, DVec3::new(7.0, 6.0, 0.0));
}

#[test]
fn values_are_signed_masked_and_rescaled_as_the_header_says() {
    let folder = tempdir().unwrap();
    let read = |change: &dyn Fn(&mut File)| {
        let mut file = File::slice(1, 0.0);
        file.frames[0][..4].copy_from_slice(&[0xff, 0xff, 0x34, 0xf2]);
        change(&mut file);
        let volume = read(&file.write(folder.path(), "a.dcm"));
        let [a, b] = [0, 1].map(|i| volume.grid.value_at([i, 0, 0]));
        (volume.grid.voxel_type().name(), a, b)
    };
    assert_eq!(read(&|_| {}), ("u16", 65535.0, f64::from(0xf234)));
    let signed = |file: &mut File| file.us((0x28, 0x103), 1);
    assert_eq!(read(&signed), ("i16", -1.0, f64::from(0xf234u16 as i16)));
    // Twelve bits: what is above them, overlays once, does not count.
    let twelve = |file: &mut File| {
        file.us((0x28, 0x101), 12);
        file.us((0x28, 0x102), 11);
    };
    assert_eq!(read(&twelve), ("i16", 4095.0, f64::from(0x234)));
    let high = |file: &mut File| file.us((0x28, 0x101), 12);
    assert_eq!(read(&high), ("i16", 4095.0, f64::from(0xf23)));
    let ct = |file: &mut File| {
        twelve(file);
        file.text((0x28, 0x1052), "DS", "-1024");
        file.text((0x28, 0x1053), "DS", "1");
    };
    assert_eq!(read(&ct), ("i16", 3071.0, f64::from(0x234 - 1024)));
    let pet = |file: &mut File| file.text((0x28, 0x1053), "DS", "0.25");
    assert_eq!(read(&pet), ("f32", 65535.0 / 4.0, f64::from(0xf234) / 4.0));
    // The smallest is the brightest: bright is high, as in ITK.
    let inverse = |file: &mut File| file.text((0x28, 0x4), "CS", "MONOCHROME1");
    assert_eq!(read(&inverse), ("u16", 0.0, f64::from(!0xf234_u16)));
}

/// Frames of one file keep their order, from whichever end it begins; where they lie tells the same.
#[test]
fn frames_that_come_backwards_stay_so() {
    let folder = tempdir().unwrap();
    let mut file = File::slice(1, 7.0);
    file.text((0x28, 0x8), "IS", "3");
    file.text((0x3004, 0xc), "DS", "0\\-2\\-4");
    file.frames = [1_u16, 2, 3].map(|n| n.to_le_bytes().repeat(12)).to_vec();
    let volume = read(&file.write(folder.path(), "a.dcm"));
    assert_eq!(firsts(&volume), [1.0, 2.0, 3.0]);
    let map = volume.grid.world_from_index();
    assert_eq!(map.translation, DVec3::new(0.0, 0.0, 7.0));
    assert_eq!(map.matrix3.z_axis, DVec3::new(0.0, 0.0, -2.0));
}
