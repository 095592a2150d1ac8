//! MetaImage: hand-made headers mean what ITK makes of them, and bad files are refused.

use std::fs;
use std::io::Write;
use std::path::PathBuf;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use glam::{DMat3, DVec3};
use tempfile::TempDir;
use vcsg::volume::Voxels;
use vcsg::volume::io::{self, Position, Problem, ReadError, ReadOptions, Volume};

const HEADER: &str = "ObjectType = Image\nNDims = 3\nDimSize = 2 3 4\n";

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn data() -> Vec<u8> {
    (0..24).collect()
}

fn file(folder: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    path
}

/// Reads a file of [`HEADER`], these lines, and the data behind them.
fn read_with(lines: &str, data: &[u8], options: &ReadOptions) -> Result<Volume, ReadError> {
    let folder = tempfile::tempdir().unwrap();
    let header = format!("{HEADER}{lines}\nElementDataFile = LOCAL\n");
    io::read_with(&file(&folder, "a.mha", &[header.as_bytes(), data].concat()), options)
}

fn read(lines: &str, data: &[u8]) -> Result<Volume, ReadError> {
    read_with(lines, data, &ReadOptions::default())
}

const U8: &str = "ElementType = MET_UCHAR";

#[test]
fn every_type_is_read_in_both_byte_orders() {
    let cases: [(&str, Vec<u8>, Voxels); 12] = [
        ("UCHAR", vec![200], Voxels::U8(vec![200])),
        ("CHAR", vec![200], Voxels::I8(vec![-56])),
        ("SHORT", (-300i16).to_le_bytes().into(), Voxels::I16(vec![-300])),
        ("USHORT", 40_000u16.to_le_bytes().into(), Voxels::U16(vec![40_000])),
        ("INT", (-70_000i32).to_le_bytes().into(), Voxels::I32(vec![-70_000])),
        ("LONG", (-70_000i32).to_le_bytes().into(), Voxels::I32(vec![-70_000])),
        ("UINT", u32::MAX.to_le_bytes().into(), Voxels::U32(vec![u32::MAX])),
        (
            "ULONG_ARRAY",
            u32::MAX.to_le_bytes().into(),
            Voxels::U32(vec![u32::MAX]),
        ),
        ("LONG_LONG", (-9i64).to_le_bytes().into(), Voxels::F64(vec![-9.0])),
        ("ULONG_LONG", 9u64.to_le_bytes().into(), Voxels::F64(vec![9.0])),
        ("FLOAT", 0.1f32.to_le_bytes().into(), Voxels::F32(vec![0.1])),
        ("DOUBLE", 0.1f64.to_le_bytes().into(), Voxels::F64(vec![0.1])),
    ];
    let folder = tempfile::tempdir().unwrap();
    for (name, mut bytes, voxels) in cases {
        let read = |order: &str, bytes: &[u8]| {
            let header =
                format!("NDims = 1\nDimSize = 1\n{order}\nElementType = MET_{name}\nElementDataFile = LOCAL\n");
            let path = file(&folder, "a.mha", &[header.as_bytes(), bytes].concat());
            io::read(&path).unwrap().grid.voxels().clone()
        };
        assert_eq!(read("", &bytes), voxels);
        bytes.reverse();
        assert_eq!(read("ElementByteOrderMSB = True", &bytes), voxels);
        assert_eq!(read("BinaryDataByteOrderMSB = True", &bytes), voxels);
    }
}

#[test]
fn keys_may_be_told_from_values_by_colons() {
    let volume = read("ElementSpacing: 1 2 3\nComment: a = b\nElementType: MET_UCHAR", &data()).unwrap();
    assert_eq!(
        volume.grid.world_from_index().matrix3,
        DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0))
    );
}

#[test]
fn axes_follow_each_other_in_the_matrix() {
    let lines = format!(
        "TransformMatrix = 0 1 0 0 0 1 1 0 0\nOffset = 7 8 9\nElementSpacing = 2 -3 4\nElementSize = 9 9 9\n{U8}"
    );
    let place = *read(&lines, &data()).unwrap().grid.world_from_index();
    assert_eq!(place.translation, DVec3::new(7.0, 8.0, 9.0));
    assert_eq!(
        place.matrix3,
        DMat3::from_cols(DVec3::Y * 2.0, DVec3::Z * -3.0, DVec3::X * 4.0)
    );
    for key in ["Orientation", "Rotation"] {
        let place = *read(&lines.replace("TransformMatrix", key), &data())
            .unwrap()
            .grid
            .world_from_index();
        assert_eq!(place.matrix3.x_axis, DVec3::Y * 2.0);
    }
    for key in ["Position", "Origin"] {
        let place = *read(&lines.replace("Offset", key), &data())
            .unwrap()
            .grid
            .world_from_index();
        assert_eq!(place.translation.x, 7.0);
    }
    let sized = *read(&lines.replace("ElementSpacing", "X"), &data())
        .unwrap()
        .grid
        .world_from_index();
    assert_eq!(sized.matrix3.x_axis, DVec3::Y * 9.0);
    let small = *read(&format!("{lines}\nDistanceUnits = um"), &data())
        .unwrap()
        .grid
        .world_from_index();
    assert_eq!(small.matrix3.x_axis.y, 2e-3);
}

#[test]
fn compressed_data_needs_no_right_size() {
    for size in ["CompressedDataSize = 5\n", "", "CompressedDataSize = 999999\n"] {
        let volume = read(&format!("CompressedData = True\n{size}{U8}"), &zlib(&data())).unwrap();
        assert_eq!(*volume.grid.voxels(), Voxels::U8(data()));
    }
    let mut damaged = zlib(&data());
    *damaged.last_mut().unwrap() ^= 1;
    assert!(read(&format!("CompressedData = True\n{U8}"), &damaged).is_err());
    let half = &zlib(&data())[..12];
    assert!(read(&format!("CompressedData = True\n{U8}"), half).is_err());
    let error = read(&format!("CompressedData = True\n{U8}"), b"no zlib stream at all").unwrap_err();
    assert!(matches!(error.problem, Problem::Compressed(_)), "{error}");
    let bomb = zlib(&vec![7; 10_000_000]);
    let volume = read(&format!("CompressedData = True\n{U8}"), &bomb).unwrap();
    assert_eq!(*volume.grid.voxels(), Voxels::U8(vec![7; 24]));
}

#[test]
fn headers_of_data_are_skipped() {
    let folder = tempfile::tempdir().unwrap();
    file(&folder, "a.raw", &[b"skip".to_vec(), data()].concat());
    for size in [4, -1] {
        let header = format!("{HEADER}{U8}\nHeaderSize = {size}\nElementDataFile = a.raw\n");
        let volume = io::read(&file(&folder, "a.mhd", header.as_bytes())).unwrap();
        assert_eq!(*volume.grid.voxels(), Voxels::U8(data()));
    }
    let behind = [b"skip".to_vec(), data()].concat();
    let volume = read(&format!("HeaderSize = -1\n{U8}"), &behind).unwrap();
    assert_eq!(*volume.grid.voxels(), Voxels::U8(data()));
    assert!(read(&format!("HeaderSize = -2\n{U8}"), &behind).is_err());
}

#[test]
fn lists_and_patterns_name_slices() {
    let folder = tempfile::tempdir().unwrap();
    for (n, slice) in data().chunks(6).enumerate() {
        file(&folder, &format!("s{:02}.raw", 2 * n), slice);
        file(&folder, &format!("z{n}.zraw"), &zlib(slice));
    }
    let list = |names: &[&str]| format!("LIST\n{}\n", names.join("\n"));
    for (extra, named) in [
        ("", list(&["s00.raw", "s02.raw", "s04.raw", "", "s06.raw"])),
        ("", "s%02d.raw 0 6 2\n".to_owned()),
        ("CompressedData = True\n", "z%d.zraw 0 3\n".to_owned()),
    ] {
        let header = format!("{HEADER}{extra}{U8}\nElementDataFile = {named}");
        let volume = io::read(&file(&folder, "a.mhd", header.as_bytes())).unwrap();
        assert_eq!(*volume.grid.voxels(), Voxels::U8(data()), "{named}");
    }
    for named in [
        "LIST\n".to_owned(),
        list(&["s00.raw"; 3]),
        list(&["s00.raw"; 5]),
        list(&["s00.raw", "s02.raw", "s04.raw", "gone.raw"]),
        "s%02d.raw 0 9 2\n".to_owned(),
        "s%02d.raw\n".to_owned(),
        "s%s.raw 0 6 2\n".to_owned(),
    ] {
        let header = format!("{HEADER}{U8}\nElementDataFile = {named}");
        assert!(io::read(&file(&folder, "a.mhd", header.as_bytes())).is_err(), "{named}");
    }
}

#[test]
fn components_and_frames_are_told_and_chosen() {
    let colours: Vec<u8> = data().iter().flat_map(|v| [*v, 0, 255 - v]).collect();
    let lines = format!("ElementNumberOfChannels = 3\n{U8}");
    let volume = read(&lines, &colours).unwrap();
    assert_eq!(volume.components, 3);
    let grey = |v: &u8| (0.2126 * f64::from(*v) + 0.0722 * f64::from(255 - v)).round_ties_even() as u8;
    assert_eq!(*volume.grid.voxels(), Voxels::U8(data().iter().map(grey).collect()));
    let component = |component| ReadOptions {
        component: Some(component),
        ..ReadOptions::default()
    };
    let volume = read_with(&lines, &colours, &component(2)).unwrap();
    assert_eq!(
        *volume.grid.voxels(),
        Voxels::U8(data().iter().map(|v| 255 - v).collect())
    );
    let error = read_with(&lines, &colours, &component(3)).unwrap_err();
    assert!(error.to_string().contains('3'), "{error}");
    assert!(read(&lines.replace("= 3", "= 0"), &colours).is_err());

    let folder = tempfile::tempdir().unwrap();
    let header = format!("NDims = 4\nDimSize = 2 3 2 2\n{U8}\nElementDataFile = LOCAL\n");
    let path = file(&folder, "t.mha", &[header.as_bytes(), &data()].concat());
    let frame = |frame| ReadOptions {
        frame: Some(frame),
        ..ReadOptions::default()
    };
    let volume = io::read_with(&path, &frame(1)).unwrap();
    assert_eq!((volume.frames, volume.grid.dims()), (2, [2, 3, 2]));
    assert_eq!(*volume.grid.voxels(), Voxels::U8(data()[12..].to_vec()));
    let error = io::read_with(&path, &frame(2)).unwrap_err();
    assert!(error.to_string().contains("it holds 2"), "{error}");
}

#[test]
fn text_is_read() {
    let text: Vec<String> = data().iter().map(u8::to_string).collect();
    let lines = "BinaryData = False\nElementType = MET_SHORT\nBinaryDataByteOrderMSB = True";
    let volume = read(lines, text.join(" ").as_bytes()).unwrap();
    assert_eq!(*volume.grid.voxels(), Voxels::I16((0..24).collect()));
}

#[test]
fn bad_headers_are_refused() {
    for (lines, line) in [
        ("ElementType = MET_STRING", Some(4)),
        ("ElementType = MET_UCHAR\nElementSpacing = 1 1", Some(5)),
        ("ElementType = MET_UCHAR\nno key here", Some(5)),
        ("", None),
    ] {
        let error = read(lines, &data()).unwrap_err();
        assert_eq!(error.position, line.map(Position::Line), "{error}");
    }
    let folder = tempfile::tempdir().unwrap();
    for header in [
        "NDims = 3\n",
        "NDims = 0\nDimSize = 1\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
        "NDims = 999\nDimSize = 1\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
        "NDims = 3\nDimSize = 2 0 4\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
        "NDims = 3\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
        "NDims = 4\nDimSize = 1 1 1 0\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
        "NDims = 3\nDimSize = 60000000 60000000 60000000\nElementType = MET_DOUBLE\nElementDataFile = LOCAL\n",
        "NDims = 3\nDimSize = 90000 90000 90000\nElementType = MET_UCHAR\nElementDataFile = a.mha\n",
    ] {
        let path = file(&folder, "a.mha", header.as_bytes());
        assert!(io::read(&path).is_err(), "{header}");
    }
    let error = read(U8, &data()[..23]).unwrap_err();
    assert!(
        matches!(
            error.problem,
            Problem::Truncated {
                expected: 24,
                found: 23
            }
        ),
        "{error}"
    );
}

#[test]
fn every_prefix_of_a_file_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    // Of a zlib stream the last four bytes are a checksum, which is tested only if it is there.
    for (extra, data, checksum) in [("", data(), 0), ("CompressedData = True\n", zlib(&data()), 4)] {
        let header = format!("{HEADER}{extra}{U8}\nElementDataFile = LOCAL\n");
        let whole = [header.as_bytes(), &data].concat();
        for end in 0..whole.len() - checksum {
            let read = io::read(&file(&folder, "a.mha", &whole[..end]));
            assert!(read.is_err(), "{end}");
        }
    }
}
