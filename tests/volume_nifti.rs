//! NIfTI-1: hand-made headers mean what nifti1.h says, and bad files are refused.

mod nifti_header;

use std::fs;
use std::io::Write;
use std::path::PathBuf;

use flate2::Compression;
use flate2::write::GzEncoder;
use glam::{DMat3, DQuat, DVec3};
use nifti_header::Header;
use tempfile::TempDir;
use vcsg::math::affine;
use vcsg::volume::Voxels;
use vcsg::volume::io::{self, Problem, ReadError, ReadOptions, Volume};

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn file(folder: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    path
}

fn read(bytes: &[u8]) -> Result<Volume, ReadError> {
    let folder = tempfile::tempdir().unwrap();
    io::read(&file(&folder, "a.nii", bytes))
}

const DATA: [u8; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

fn small() -> Header {
    Header::new(&[2, 2, 2], 2)
}

#[test]
fn every_type_is_read_in_both_byte_orders() {
    let cases: [(i16, Vec<u8>, Voxels); 10] = [
        (2, vec![200], Voxels::U8(vec![200])),
        (256, vec![200], Voxels::I8(vec![-56])),
        (4, (-300i16).to_le_bytes().into(), Voxels::I16(vec![-300])),
        (512, 40_000u16.to_le_bytes().into(), Voxels::U16(vec![40_000])),
        (8, (-70_000i32).to_le_bytes().into(), Voxels::I32(vec![-70_000])),
        (
            768,
            3_000_000_000u32.to_le_bytes().into(),
            Voxels::U32(vec![3_000_000_000]),
        ),
        (16, 0.1f32.to_le_bytes().into(), Voxels::F32(vec![0.1])),
        (64, 0.1f64.to_le_bytes().into(), Voxels::F64(vec![0.1])),
        (1024, (-9i64).to_le_bytes().into(), Voxels::F64(vec![-9.0])),
        (1280, 9u64.to_le_bytes().into(), Voxels::F64(vec![9.0])),
    ];
    for (code, mut data, voxels) in cases {
        let little = read(&Header::new(&[1, 1, 1], code).with(&data)).unwrap();
        assert_eq!(*little.grid.voxels(), voxels);
        data.reverse();
        let big = read(&Header::swapped(&[1, 1, 1], code).with(&data)).unwrap();
        assert_eq!(*big.grid.voxels(), voxels);
    }
}

/// All 48 ways to lay index axes along the axes of the body: as matrices whose columns are ± unit vectors, RAS.
fn axis_orders() -> Vec<DMat3> {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let signs = |bits: usize| move |a: usize| if bits >> a & 1 == 0 { 1.0 } else { -1.0 };
    let matrix = |order: [usize; 3], sign: &dyn Fn(usize) -> f64| {
        let column = |a: usize| DVec3::AXES[order[a]] * sign(a);
        DMat3::from_cols(column(0), column(1), column(2))
    };
    (0..48).map(|n| matrix(orders[n / 8], &signs(n % 8))).collect()
}

#[test]
fn axes_in_any_order_come_out_in_lps() {
    let size = DVec3::new(2.0, 3.0, 4.0);
    let origin = DVec3::new(10.0, 20.0, 30.0);
    for axes in axis_orders() {
        let mut by_sform = small();
        by_sform.sform(axes * DMat3::from_diagonal(size), origin);
        let mut by_qform = small();
        let qfac = axes.determinant();
        let rotation = axes * DMat3::from_diagonal(DVec3::new(1.0, 1.0, qfac));
        for axis in 0..3 {
            by_qform.f32(80 + 4 * axis, size[axis] as f32);
        }
        by_qform.qform(DQuat::from_mat3(&rotation), qfac as f32, origin);
        for header in [by_sform, by_qform] {
            let grid = read(&header.with(&DATA)).unwrap().grid;
            let index = DVec3::new(1.0, 2.0, 3.0);
            let ras = axes * (size * index) + origin;
            let lps = DVec3::new(-ras.x, -ras.y, ras.z);
            let got = affine::point(grid.world_from_index(), index);
            // The quaternion's `f32` components, and its fourth, the root of a difference, are good to some 1e-3.5 at worst.
            assert!((got - lps).length() < 1e-2, "{got} {lps}");
        }
    }
}

#[test]
fn the_sform_goes_before_the_qform_and_keeps_its_shear() {
    let mut header = small();
    let sheared = DMat3::from_cols(DVec3::X, DVec3::new(0.5, 1.0, 0.0), DVec3::Z);
    header.qform(DQuat::from_rotation_z(1.0), 1.0, DVec3::ZERO);
    header.sform(sheared, DVec3::ZERO);
    let grid = read(&header.with(&DATA)).unwrap().grid;
    assert_eq!(grid.world_from_index().matrix3.y_axis, DVec3::new(-0.5, -1.0, 0.0));
    header.sform(DMat3::ZERO, DVec3::ZERO);
    let grid = read(&header.with(&DATA)).unwrap().grid;
    assert!((grid.world_from_index().matrix3.x_axis.x + 1f64.cos()).abs() < 1e-6);
}

#[test]
fn without_transform_only_the_spacing_is_known() {
    let mut header = small();
    for (axis, v) in [2.0, -3.0, 0.0].into_iter().enumerate() {
        header.f32(80 + 4 * axis, v);
    }
    let grid = read(&header.with(&DATA)).unwrap().grid;
    let expected = DMat3::from_diagonal(DVec3::new(2.0, 3.0, 1.0));
    assert_eq!(grid.world_from_index().matrix3, expected);
}

#[test]
fn units_are_turned_to_millimetres() {
    for (code, factor) in [(0, 1.0), (1, 1000.0), (2, 1.0), (3, 0.001), (2 + 8, 1.0)] {
        let mut header = small();
        header.bytes[123] = code;
        let grid = read(&header.with(&DATA)).unwrap().grid;
        assert_eq!(grid.world_from_index().matrix3.x_axis.x, factor);
    }
}

#[test]
fn slope_and_intercept_are_applied() {
    let scaled = |slope: f32, intercept: f32| {
        let mut header = small();
        header.f32(112, slope);
        header.f32(116, intercept);
        read(&header.with(&DATA)).unwrap().grid.voxels().clone()
    };
    let floats = |f: &dyn Fn(f32) -> f32| Voxels::F32(DATA.map(|v| f(f32::from(v))).to_vec());
    assert_eq!(scaled(2.0, -3.0), floats(&|v| 2.0 * v - 3.0));
    assert_eq!(scaled(1.0, 5.0), floats(&|v| v + 5.0));
    for identity in [(1.0, 0.0), (0.0, 7.0), (f32::NAN, 0.0), (f32::INFINITY, 1.0)] {
        assert_eq!(scaled(identity.0, identity.1), Voxels::U8(DATA.to_vec()));
    }
}

#[test]
fn the_first_of_several_frames_is_read() {
    let header = Header::new(&[2, 2, 1, 2], 2);
    let volume = read(&header.with(&DATA)).unwrap();
    assert_eq!((volume.frames, volume.grid.dims()), (2, [2, 2, 1]));
    assert_eq!(*volume.grid.voxels(), Voxels::U8(DATA[..4].to_vec()));
    let error = read(&header.with(&DATA[..7])).unwrap_err();
    assert!(
        matches!(error.problem, Problem::Truncated { expected: 8, found: 7 }),
        "{error}"
    );
}

#[test]
fn compressed_files_and_pairs_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let expected = Voxels::U8(DATA.to_vec());
    let path = file(&folder, "a.nii.gz", &gzip(&small().with(&DATA)));
    assert_eq!(*io::read(&path).unwrap().grid.voxels(), expected);

    let mut header = small();
    header.f32(108, 0.0);
    header.bytes[344..].copy_from_slice(b"ni1\0");
    let header = file(&folder, "b.hdr", &header.bytes);
    let error = io::read(&header).unwrap_err();
    assert!(error.to_string().contains(".img"), "{error}");
    let data = file(&folder, "b.img.gz", &gzip(&DATA));
    assert_eq!(*io::read(&header).unwrap().grid.voxels(), expected);
    assert_eq!(*io::read(&data).unwrap().grid.voxels(), expected);
    let data = file(&folder, "b.img", &DATA);
    assert_eq!(*io::read(&data).unwrap().grid.voxels(), expected);
}

#[test]
fn an_extension_is_skipped() {
    let mut header = small();
    header.f32(108, 368.0);
    let bytes = [header.with(&[1; 16]), DATA.to_vec()].concat();
    assert_eq!(*read(&bytes).unwrap().grid.voxels(), Voxels::U8(DATA.to_vec()));
}

#[test]
fn what_has_no_place_in_memory_is_refused_by_name() {
    for (code, name) in [(1, "single bits"), (1536, "128-bit"), (2048, "128-bit")] {
        let error = read(&Header::new(&[2, 2, 2], code).with(&[0; 256])).unwrap_err();
        assert!(matches!(error.problem, Problem::Unsupported(_)), "{error}");
        assert!(error.to_string().contains(name), "{error}");
    }
}

fn read_with(bytes: &[u8], options: &ReadOptions) -> Result<Volume, ReadError> {
    let folder = tempfile::tempdir().unwrap();
    io::read_with(&file(&folder, "a.nii", bytes), options)
}

fn chosen(frame: usize, component: usize) -> ReadOptions {
    ReadOptions {
        frame: Some(frame),
        component: Some(component),
        ..ReadOptions::default()
    }
}

#[test]
fn colours_complex_numbers_and_vectors_are_read() {
    let mut colours = Header::new(&[2, 1, 1], 128);
    // Slopes are for numbers, not for colours.
    colours.f32(112, 5.0);
    let volume = read(&colours.with(&[255, 0, 0, 0, 255, 0])).unwrap();
    assert_eq!(
        (volume.components, volume.grid.voxels()),
        (3, &Voxels::U8(vec![54, 182]))
    );
    let volume = read(&Header::new(&[1, 1, 1], 2304).with(&[0, 0, 255, 9])).unwrap();
    assert_eq!((volume.components, volume.grid.voxels()), (4, &Voxels::U8(vec![18])));
    let complex: Vec<u8> = [3.0f32, -4.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let volume = read(&Header::new(&[1, 1, 1], 32).with(&complex)).unwrap();
    assert_eq!((volume.components, volume.grid.voxels()), (2, &Voxels::F32(vec![5.0])));
    let complex: Vec<u8> = [3.0f64, -4.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let volume = read(&Header::new(&[1, 1, 1], 1792).with(&complex)).unwrap();
    assert_eq!(*volume.grid.voxels(), Voxels::F64(vec![5.0]));
    let imaginary = read_with(&Header::new(&[1, 1, 1], 1792).with(&complex), &chosen(0, 1)).unwrap();
    assert_eq!(*imaginary.grid.voxels(), Voxels::F64(vec![-4.0]));
}

#[test]
fn a_fifth_axis_of_components_has_all_frames_of_each() {
    // Two voxels, two frames, three components.
    let data: Vec<u8> = (0..12).collect();
    let mut header = Header::new(&[2, 1, 1, 2, 3], 2);
    header.i16(68, 1007);
    let bytes = header.with(&data);
    for bytes in [bytes.clone(), gzip(&bytes)] {
        for frame in 0..2 {
            for component in 0..3 {
                let volume = read_with(&bytes, &chosen(frame, component)).unwrap();
                let first = (4 * component + 2 * frame) as u8;
                assert_eq!((volume.frames, volume.components), (2, 3));
                assert_eq!(*volume.grid.voxels(), Voxels::U8(vec![first, first + 1]));
            }
        }
        assert!(read_with(&bytes, &chosen(2, 0)).is_err());
        assert!(read_with(&bytes, &chosen(0, 3)).is_err());
    }
    let length = |a: f32, b: f32, c: f32| (a * a + b * b + c * c).sqrt();
    let volume = read(&bytes).unwrap();
    assert_eq!(
        *volume.grid.voxels(),
        Voxels::F32(vec![length(0.0, 4.0, 8.0), length(1.0, 5.0, 9.0)])
    );
    // Without an intent of components the fifth axis counts volumes.
    let mut header = Header::new(&[2, 1, 1, 2, 3], 2);
    header.i16(68, 0);
    assert_eq!(read(&header.with(&data)).unwrap().frames, 6);
}

#[test]
fn nifti_2_is_read_in_both_byte_orders() {
    for big in [false, true] {
        let mut bytes = vec![0; 544];
        let mut put = |at: usize, value: &[u8]| {
            bytes[at..at + value.len()].copy_from_slice(value);
            if big {
                bytes[at..at + value.len()].reverse();
            }
        };
        put(0, &540_i32.to_le_bytes());
        put(12, &4_i16.to_le_bytes());
        for (axis, n) in [3_i64, 2, 1, 2].into_iter().enumerate() {
            put(16 + 8 * axis, &n.to_le_bytes());
        }
        put(168, &544_i64.to_le_bytes());
        put(348, &2_i32.to_le_bytes());
        for (place, value) in [
            (400, 0.1),
            (400 + 24, 5.0),
            (432 + 8, 0.2),
            (464 + 16, 0.3),
            (464 + 24, -1e-9),
        ] {
            put(place, &f64::to_le_bytes(value));
        }
        let magic = b"n+2\0\r\n\x1a\n";
        bytes[4..12].copy_from_slice(magic);
        for value in [1_i16, -2, 300, 4] {
            bytes.extend(if big { value.to_be_bytes() } else { value.to_le_bytes() });
        }
        let volume = read(&bytes).unwrap();
        assert_eq!(volume.format, "NIfTI-2");
        assert_eq!(*volume.grid.voxels(), Voxels::I16(vec![1, -2, 300, 4]));
        let place = volume.grid.world_from_index();
        assert_eq!(place.matrix3, DMat3::from_diagonal(DVec3::new(-0.1, -0.2, 0.3)));
        assert_eq!(place.translation, DVec3::new(-5.0, 0.0, -1e-9));
        for end in 0..bytes.len() {
            assert!(read(&bytes[..end]).is_err(), "{end}");
        }
    }
}

#[test]
fn analyze_has_sizes_and_no_more() {
    for mut header in [Header::new(&[2, 2, 2], 2), Header::swapped(&[2, 2, 2], 2)] {
        let folder = tempfile::tempdir().unwrap();
        header.bytes[344..].fill(0);
        // A vox_offset of 0; no slope, whatever is where NIfTI has one.
        header.f32(108, 0.0);
        header.f32(112, 3.0);
        for (axis, size) in [2.0, 3.0, 4.0].into_iter().enumerate() {
            header.f32(80 + 4 * axis, size);
        }
        let path = file(&folder, "a.hdr", &header.bytes);
        file(&folder, "a.img", &DATA);
        let volume = io::read(&path).unwrap();
        assert_eq!(volume.format, "ANALYZE 7.5");
        assert_eq!(*volume.grid.voxels(), Voxels::U8(DATA.to_vec()));
        let expected = DMat3::from_diagonal(DVec3::new(2.0, 3.0, 4.0));
        assert_eq!(volume.grid.world_from_index().matrix3, expected);
        assert!(
            io::read(&file(&folder, "a.nii", &header.with(&DATA))).is_err(),
            "without magic letters"
        );
    }
}

#[test]
fn lying_headers_are_refused() {
    let mut cases = vec![
        Header::new(&[32767, 32767, 32767], 64).with(&DATA),
        Header::new(&[2, 0, 2], 2).with(&DATA),
        Header::new(&[2, -2, 2], 2).with(&DATA),
        Header::new(&[2, 2, 2], 77).with(&DATA),
        small().with(&DATA[..7]),
        b"this is no NIfTI".to_vec(),
    ];
    for offset in [-1.0, f32::NAN, 1e30, 1e6] {
        let mut header = small();
        header.f32(108, offset);
        cases.push(header.with(&DATA));
    }
    let mut header = small();
    header.i16(40, 9);
    cases.push(header.with(&DATA));
    let mut header = small();
    header.sform(DMat3::from_diagonal(DVec3::splat(f64::NAN)), DVec3::ZERO);
    header.qform(DQuat::IDENTITY, 1.0, DVec3::splat(f64::INFINITY));
    cases.push(header.with(&DATA));
    for (n, bytes) in cases.iter().enumerate() {
        let plain = read(bytes);
        assert!(plain.is_err(), "{n}: {plain:?}");
        assert!(read(&gzip(bytes)).is_err(), "{n} compressed");
    }
}

#[test]
fn every_prefix_of_a_file_is_an_error() {
    let whole = small().with(&DATA);
    for bytes in [whole.clone(), gzip(&whole)] {
        for end in 0..bytes.len() {
            assert!(read(&bytes[..end]).is_err(), "{end}");
        }
    }
}

#[test]
fn wild_quaternions_do_not_panic() {
    for v in [2.0, -1e30, f64::INFINITY, f64::NAN] {
        let mut header = small();
        header.qform(DQuat::from_xyzw(v, v, v, 0.0), 0.5, DVec3::ZERO);
        header.f32(80, -2.0);
        // Whether such a header is refused or read is all one.
        let _ = read(&header.with(&DATA));
    }
}
