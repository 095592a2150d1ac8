//! Volumes that are written: SimpleITK and VTK, and this program, read the same values at the same place.

use std::fs;
use std::path::PathBuf;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use tempfile::TempDir;
use vcsg::math::affine;
use vcsg::volume::io::{self, Encoding, FORMATS};
use vcsg::volume::{Grid, VoxelType, Voxels};

use crate::readers;

const DIMS: [usize; 3] = [5, 4, 3];

/// Sixty voxels of each type, its extremes among them.
fn every_type() -> Vec<Voxels> {
    let n = || 0..60_i64;
    vec![
        Voxels::U8(n().map(|i| (i * 37) as u8).collect()),
        Voxels::I8(n().map(|i| (i * 91) as i8).collect()),
        Voxels::U16(n().map(|i| (i * 7919) as u16).collect()),
        Voxels::I16(n().map(|i| (i * 7919 - 32768) as i16).collect()),
        Voxels::U32(n().map(|i| (i * 123_456_789) as u32).collect()),
        Voxels::I32(n().map(|i| (i * 123_456_789) as i32).collect()),
        Voxels::F32(n().map(|i| (i as f32 - 29.5) * 0.1).collect()),
        Voxels::F64(n().map(|i| (i as f64 - 29.5) / 3.0).collect()),
    ]
}

/// NumPy's name of a type.
fn numpy_name(voxel: VoxelType) -> &'static str {
    match voxel {
        VoxelType::U8 => "u1",
        VoxelType::I8 => "i1",
        VoxelType::U16 => "u2",
        VoxelType::I16 => "i2",
        VoxelType::U32 => "u4",
        VoxelType::I32 => "i4",
        VoxelType::F32 => "f4",
        VoxelType::F64 => "f8",
    }
}

/// The checksum of voxels in little-endian order.
fn checksum(voxels: &Voxels) -> u32 {
    fn of<T: bytemuck::Pod>(voxels: &[T]) -> u32 {
        let mut crc = flate2::Crc::new();
        for voxel in voxels {
            let mut bytes = bytemuck::bytes_of(voxel).to_vec();
            if cfg!(target_endian = "big") {
                bytes.reverse();
            }
            crc.update(&bytes);
        }
        crc.sum()
    }
    match voxels {
        Voxels::U8(v) => of(v),
        Voxels::I8(v) => of(v),
        Voxels::U16(v) => of(v),
        Voxels::I16(v) => of(v),
        Voxels::U32(v) => of(v),
        Voxels::I32(v) => of(v),
        Voxels::F32(v) => of(v),
        Voxels::F64(v) => of(v),
    }
}

/// Places of right-handed, turned and mirrored axes.
fn places() -> Vec<DAffine3> {
    let turned = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 2.1));
    let size = DMat3::from_diagonal(DVec3::new(0.9, 1.0 / 3.0, 2.5));
    let origin = DVec3::new(-123.456, 10.1, 1.0 / 7.0);
    [
        DMat3::IDENTITY,
        DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 1.0)),
        DMat3::from_cols(DVec3::Y, DVec3::NEG_Z, DVec3::X),
        turned,
        turned * DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0)),
    ]
    .map(|axes| DAffine3::from_mat3_translation(axes * size, origin))
    .to_vec()
}

/// A file of each format and encoding, with the reader that is asked of it.
const FILES: [(&str, Encoding, &str); 10] = [
    ("a.nrrd", Encoding::Raw, "itk"),
    ("b.nrrd", Encoding::Gzip, "itk"),
    ("c.nhdr", Encoding::Gzip, "itk"),
    ("d.mha", Encoding::Raw, "itk"),
    ("e.mha", Encoding::Gzip, "itk"),
    ("f.mhd", Encoding::Gzip, "itk"),
    ("g.nii", Encoding::Raw, "itk"),
    ("h.nii.gz", Encoding::Gzip, "itk"),
    ("i.vti", Encoding::Raw, "vtk"),
    ("j.vti", Encoding::Gzip, "vtk"),
];

/// The header that tells what a raw file holds.
const RAW: (&str, &str) = ("k.raw", "k.nhdr");

/// How far a number that was written may be from `exact`: a spacing and a direction are each a rounding off what they were made of,
/// and so is their product; NIfTI rounds all to `f32`, and its readers go on in `f32`: some four roundings of 2⁻²⁴.
fn rounding(name: &str, exact: f64) -> f64 {
    let part = if name.contains(".nii") {
        4.0 / f64::from(1 << 24)
    } else {
        4.0 * f64::EPSILON
    };
    part * exact.abs().max(1.0)
}

fn write_all(folder: &TempDir, grid: &Grid) -> Vec<(&'static str, PathBuf)> {
    let mut requests = Vec::new();
    for (name, encoding, reader) in FILES {
        let path = folder.path().join(name);
        io::write(&path, grid, encoding).unwrap();
        requests.push((reader, path));
    }
    io::write(&folder.path().join(RAW.0), grid, Encoding::Gzip).unwrap();
    requests.push(("itk", folder.path().join(RAW.1)));
    requests
}

#[test]
fn itk_and_vtk_read_what_is_written() {
    let mut written = Vec::new();
    let mut requests = Vec::new();
    for (voxels, place) in every_type().into_iter().zip(places().into_iter().cycle()) {
        let folder = tempfile::tempdir().unwrap();
        let grid = Grid::new(DIMS, place, voxels).unwrap();
        requests.extend(write_all(&folder, &grid));
        written.push((folder, grid));
    }
    let found = readers::read(&requests);
    let files = found.chunks(FILES.len() + 1);
    for ((_folder, grid), found) in written.iter().zip(files) {
        let names = FILES.iter().map(|(name, ..)| *name).chain([RAW.1]);
        for (name, read) in names.zip(found) {
            assert_eq!(read.size, DIMS, "{name}");
            assert_eq!(read.voxel, numpy_name(grid.voxel_type()), "{name}");
            assert_eq!(
                read.checksum,
                checksum(grid.voxels()),
                "{name}: {:?}",
                grid.voxel_type()
            );
            assert_placed(name, read, grid.world_from_index());
        }
    }
}

fn assert_placed(name: &str, read: &readers::Read, place: &DAffine3) {
    let spacing = affine::spacing(place);
    let columns = place.matrix3.to_cols_array_2d();
    for axis in 0..3 {
        let near = |found: f64, exact: f64| {
            assert!(
                (found - exact).abs() <= rounding(name, exact),
                "{name}: {found} for {exact}"
            );
        };
        near(read.spacing[axis], spacing[axis]);
        near(read.origin[axis], place.translation[axis]);
        for (row, exact) in columns[axis].into_iter().enumerate() {
            near(read.direction[3 * row + axis] * read.spacing[axis], exact);
        }
    }
}

#[test]
fn what_is_written_comes_back() {
    for (voxels, place) in every_type().into_iter().zip(places().into_iter().cycle()) {
        let folder = tempfile::tempdir().unwrap();
        let grid = Grid::new(DIMS, place, voxels).unwrap();
        for (_, path) in write_all(&folder, &grid) {
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            let read = io::read(&path).unwrap().grid;
            assert_eq!(read.voxels(), grid.voxels(), "{name}");
            let exact = place.to_cols_array();
            for (found, exact) in read.world_from_index().to_cols_array().into_iter().zip(exact) {
                let allowed = if name.contains(".n") && !name.contains(".nii") {
                    0.0
                } else {
                    rounding(&name, exact)
                };
                assert!((found - exact).abs() <= allowed, "{name}: {found} for {exact}");
            }
        }
        // Beside the files named: c.raw.gz, f.zraw and the header k.nhdr, which is named, for k.raw.
        assert_eq!(
            fs::read_dir(folder.path()).unwrap().count(),
            FILES.len() + 4,
            "nothing else is left"
        );
    }
}

#[test]
fn sheared_axes_are_kept_where_the_format_can() {
    let folder = tempfile::tempdir().unwrap();
    let sheared = DMat3::from_cols(DVec3::X, DVec3::new(0.5, 1.0, 0.0), DVec3::new(0.0, 0.25, 2.0));
    let place = DAffine3::from_mat3_translation(sheared, DVec3::new(1.0, 2.0, 3.0));
    let grid = Grid::new([1, 1, 1], place, Voxels::U8(vec![7])).unwrap();
    for name in ["a.nrrd", "a.mha", "a.nii", "a.vti"] {
        let path = folder.path().join(name);
        io::write(&path, &grid, Encoding::Raw).unwrap();
        let found = *io::read(&path).unwrap().grid.world_from_index();
        assert!(found.abs_diff_eq(place, 4.0 / f64::from(1 << 24)), "{name}: {found}");
    }
}

#[test]
fn what_cannot_be_written_is_refused_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let long = Grid::new([40_000, 1, 1], DAffine3::IDENTITY, Voxels::U8(vec![0; 40_000])).unwrap();
    let error = io::write(&folder.path().join("a.nii"), &long, Encoding::Raw).unwrap_err();
    assert!(error.to_string().contains("32767"), "{error}");
    let far = DAffine3::from_translation(DVec3::splat(1e300));
    let far = Grid::new([1; 3], far, Voxels::U8(vec![0])).unwrap();
    assert!(io::write(&folder.path().join("b.nii"), &far, Encoding::Raw).is_err());
    let error = io::write(&folder.path().join("c.txt"), &long, Encoding::Raw).unwrap_err();
    for format in FORMATS {
        for suffix in format.writer.iter().flat_map(|writer| writer.suffixes) {
            assert!(error.to_string().contains(suffix), "{error}");
        }
    }
    assert!(io::write(&folder.path().join("none/a.mhd"), &long, Encoding::Gzip).is_err());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}
