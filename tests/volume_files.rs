//! Volume files whatever their format: what is written comes back, raw files, files of other formats, descriptions.

use std::fs;
use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3};
use tempfile::TempDir;
use vcsg::volume::io::{self, ByteOrder, Encoding, ReadOptions, raw};
use vcsg::volume::{Grid, VoxelType, Voxels};

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

/// A file of this folder with these bytes.
fn file(folder: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    path
}

fn every_type() -> Vec<Voxels> {
    vec![
        Voxels::U8(vec![0, 255]),
        Voxels::I8(vec![-128, 127]),
        Voxels::U16(vec![1, 65535]),
        Voxels::I16(vec![-32768, 258]),
        Voxels::U32(vec![1, u32::MAX]),
        Voxels::I32(vec![i32::MIN, 66051]),
        Voxels::F32(vec![-0.1, f32::INFINITY]),
        Voxels::F64(vec![0.1, -1e300]),
    ]
}

#[test]
fn what_is_written_comes_back() {
    let folder = folder();
    let place = DAffine3 {
        matrix3: DMat3::from_cols(
            DVec3::new(0.1, 0.2, 1e-7),
            DVec3::new(-0.7, 1.0 / 3.0, 0.0),
            DVec3::new(0.0, 1.1, -2.5),
        ),
        translation: DVec3::new(-123.456, 1e10, 1.0 / 7.0),
    };
    for voxels in every_type() {
        for encoding in [Encoding::Raw, Encoding::Gzip] {
            let grid = Grid::new([1, 2, 1], place, voxels.clone()).unwrap();
            let path = folder.path().join("a.nrrd");
            io::write_nrrd(&path, &grid, encoding).unwrap();
            assert_eq!(io::read(&path).unwrap().grid, grid);
        }
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing else is left");
}

#[test]
fn an_unwritable_place_is_named() {
    let grid = Grid::new([1; 3], DAffine3::IDENTITY, Voxels::U8(vec![1])).unwrap();
    let path = Path::new("/nonexistent/a.nrrd");
    let error = io::write_nrrd(path, &grid, Encoding::Raw).unwrap_err();
    assert!(error.to_string().contains("/nonexistent/a.nrrd"), "{error}");
}

#[test]
fn raw_files_are_what_the_caller_says() {
    let folder = folder();
    let path = file(&folder, "a.raw", &[9, 1, 2, 3, 4]);
    let mut layout = raw::RawLayout {
        dims: [1, 1, 2],
        voxel: VoxelType::U16,
        order: ByteOrder::Big,
        offset: 1,
        world_from_index: DAffine3::IDENTITY,
    };
    let read = |layout| {
        let raw = Some(layout);
        io::read_with(
            &path,
            &ReadOptions {
                raw,
                ..ReadOptions::default()
            },
        )
    };
    let volume = read(layout).unwrap();
    assert_eq!(*volume.grid.voxels(), Voxels::U16(vec![0x0102, 0x0304]));
    layout.dims = [3, 1, 1];
    assert!(read(layout).is_err());
    let error = io::read(&path).unwrap_err();
    assert!(error.to_string().contains("voxel type"), "{error}");
}

#[test]
fn other_files_are_refused_by_name() {
    let folder = folder();
    let error = io::read(&file(&folder, "a.txt", b"something")).unwrap_err();
    for word in ["no volume file", "NRRD", "NIfTI"] {
        assert!(error.to_string().contains(word), "{error}");
    }
    assert!(io::read(folder.path()).is_err());
    assert!(io::read(&folder.path().join("absent.nrrd")).is_err());
}

#[test]
fn the_description_is_itks() {
    let columns = [
        DVec3::new(0.0, -2.0, 0.0),
        DVec3::new(-3.0, 0.0, 0.0),
        DVec3::new(0.0, 0.0, 4.0),
    ];
    let place = DAffine3 {
        matrix3: DMat3::from_cols(columns[0], columns[1], columns[2]),
        translation: DVec3::new(-1.0, -2.0, 3.0),
    };
    let grid = Grid::new([2, 3, 4], place, Voxels::U8((0..24).collect())).unwrap();
    let folder = folder();
    let path = folder.path().join("a.nrrd");
    io::write_nrrd(&path, &grid, Encoding::Raw).unwrap();
    let info = io::open(&path, &ReadOptions::default()).unwrap().info().unwrap();
    assert_eq!(info.spacing, [2.0, 3.0, 4.0]);
    assert_eq!(info.origin, [-1.0, -2.0, 3.0]);
    assert_eq!(info.direction, [0.0, -1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    assert_eq!((info.min, info.max, info.mean), (0.0, 23.0, 11.5));
}
