//! NRRD: what is written comes back, hand-made headers mean what the format says, and bad files are refused with the place.

use std::fs;
use std::io::Write;
use std::path::PathBuf;

use flate2::Compression;
use flate2::write::GzEncoder;
use glam::{DAffine3, DMat3, DVec3};
use tempfile::TempDir;
use vcsg::volume::Voxels;
use vcsg::volume::io::{self, Budget, Position, Problem, ReadError, ReadOptions, Volume};

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

/// A file of this folder with these bytes.
fn file(folder: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    path
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// Reads an attached NRRD of this header (without its magic and end) and data.
fn read(header: &str, data: &[u8]) -> Result<Volume, ReadError> {
    let folder = folder();
    let mut bytes = format!("NRRD0005\n{header}\n\n").into_bytes();
    bytes.extend(data);
    io::read(&file(&folder, "a.nrrd", &bytes))
}

/// The 24 values of [`HEADER`]'s grid.
const DATA: [u8; 24] = [
    0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23,
];

const HEADER: &str = "type: uint8\ndimension: 3\nsizes: 2 3 4\nencoding: raw";

fn u8s(volume: &Volume) -> &[u8] {
    match volume.grid.voxels() {
        Voxels::U8(v) => v,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_plain_header_is_read() {
    let volume = read(HEADER, &DATA).unwrap();
    assert_eq!(volume.grid.dims(), [2, 3, 4]);
    assert_eq!(u8s(&volume), DATA);
    assert_eq!(*volume.grid.world_from_index(), DAffine3::IDENTITY);
}

#[test]
fn comments_keys_and_line_ends_are_no_fields() {
    let header = HEADER.replace('\n', "\r\n") + "\r\n# a: b\r\nkey:=value: x\r\ncontent: c\r";
    assert_eq!(u8s(&read(&header, &DATA).unwrap()), DATA);
}

#[test]
fn spaces_are_turned_to_lps() {
    let directions = "space directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (5,6,7)";
    for (space, sign) in [
        ("left-posterior-superior", DVec3::ONE),
        ("LPS", DVec3::ONE),
        ("right-anterior-superior", DVec3::new(-1.0, -1.0, 1.0)),
        ("RAS", DVec3::new(-1.0, -1.0, 1.0)),
        ("left-anterior-superior", DVec3::new(1.0, -1.0, 1.0)),
        ("scanner-xyz", DVec3::ONE),
    ] {
        let volume = read(&format!("{HEADER}\nspace: {space}\n{directions}"), &DATA).unwrap();
        let place = volume.grid.world_from_index();
        assert_eq!(place.translation, sign * DVec3::new(5.0, 6.0, 7.0), "{space}");
        let expected = DMat3::from_diagonal(sign * DVec3::new(2.0, 3.0, 4.0));
        assert_eq!(place.matrix3, expected, "{space}");
    }
}

#[test]
fn spacings_and_units_scale() {
    let volume = read(&format!("{HEADER}\nspacings: 0.5 NaN 3"), &DATA).unwrap();
    let scale = DVec3::new(0.5, 1.0, 3.0);
    assert_eq!(*volume.grid.world_from_index(), DAffine3::from_scale(scale));
    let microns = "space dimension: 3\nspace directions: (2,0,0) (0,2,0) (0,0,2)\nspace units: \"um\" \"um\" \"um\"";
    let volume = read(&format!("{HEADER}\n{microns}"), &DATA).unwrap();
    assert_eq!(volume.grid.world_from_index().matrix3.x_axis.x, 2e-3);
}

#[test]
fn missing_axes_are_square_to_the_others() {
    let header = "type: uint8\ndimension: 2\nsizes: 6 4\nencoding: raw\nspace dimension: 3\n\
                  space directions: (0,2,0) (0,0,2)";
    let volume = read(header, &DATA).unwrap();
    assert_eq!(volume.grid.dims(), [6, 4, 1]);
    assert_eq!(volume.grid.world_from_index().matrix3.z_axis, DVec3::X);
    let header = "type: uint8\ndimension: 1\nsizes: 24\nencoding: raw";
    assert_eq!(read(header, &DATA).unwrap().grid.dims(), [24, 1, 1]);
}

#[test]
fn a_slow_fourth_axis_counts_frames() {
    for extra in [
        "",
        "\nspace directions: (1,0,0) (0,1,0) (0,0,1) none",
        "\nkinds: domain domain domain time",
    ] {
        let header = format!("type: uint8\ndimension: 4\nsizes: 2 3 2 2\nencoding: raw{extra}");
        let volume = read(&header, &DATA).unwrap();
        assert_eq!((volume.grid.dims(), volume.frames), ([2, 3, 2], 2));
        assert_eq!(u8s(&volume), &DATA[..12]);
    }
}

#[test]
fn an_axis_of_one_component_is_left_out() {
    let header = "type: uint8\ndimension: 4\nsizes: 1 2 3 4\nkinds: vector domain domain domain\nencoding: raw";
    assert_eq!(read(header, &DATA).unwrap().grid.dims(), [2, 3, 4]);
}

fn read_with(header: &str, data: &[u8], options: &ReadOptions) -> Result<Volume, ReadError> {
    let folder = folder();
    let bytes = [format!("NRRD0005\n{header}\n\n").as_bytes(), data].concat();
    io::read_with(&file(&folder, "a.nrrd", &bytes), options)
}

/// Of the component `component`.
fn component(component: usize) -> ReadOptions {
    ReadOptions {
        component: Some(component),
        ..ReadOptions::default()
    }
}

#[test]
fn components_are_read_wherever_their_axis_is() {
    for (kinds, dims, second) in [
        (
            "vector domain domain",
            [3, 4, 1],
            (0..12).map(|v| 2 * v + 1).collect::<Vec<u8>>(),
        ),
        (
            "domain covariant-vector domain",
            [2, 4, 1],
            vec![2, 3, 8, 9, 14, 15, 20, 21],
        ),
        ("space space list", [2, 3, 1], (6..12).collect()),
    ] {
        let header = format!("{HEADER}\nkinds: {kinds}");
        let volume = read_with(&header, &DATA, &component(1)).unwrap();
        assert_eq!((volume.grid.dims(), u8s(&volume)), (dims, &second[..]), "{kinds}");
        assert_eq!(volume.components, 24 / dims.iter().product::<usize>());
        let error = read_with(&header, &DATA, &component(volume.components)).unwrap_err();
        assert!(matches!(error.problem, Problem::Unsupported(_)), "{error}");
    }
}

#[test]
fn what_is_made_of_components_goes_by_their_kind() {
    let header = |kind: &str, size: usize| {
        format!("type: uint8\ndimension: 2\nsizes: {size} 1\nkinds: {kind} domain\nencoding: raw")
    };
    let made = |kind, data: &[u8]| read(&header(kind, data.len()), data).unwrap().grid.voxels().clone();
    assert_eq!(made("RGB-color", &[255, 0, 0]), Voxels::U8(vec![54]));
    assert_eq!(made("RGBA-color", &[0, 255, 0, 9]), Voxels::U8(vec![182]));
    assert_eq!(made("3-vector", &[2, 3, 6]), Voxels::F32(vec![7.0]));
    assert_eq!(made("complex", &[3, 4]), Voxels::F32(vec![5.0]));
    assert_eq!(made("list", &[3, 4]), Voxels::U8(vec![3]));
    let error = read(
        &HEADER.replace("encoding", "kinds: vector list domain\nencoding"),
        &DATA,
    )
    .unwrap_err();
    assert!(error.to_string().contains("several axes"), "{error}");
}

#[test]
fn a_frame_is_chosen_by_its_number() {
    let frame = |frame| ReadOptions {
        frame: Some(frame),
        ..ReadOptions::default()
    };
    let header = "type: uint8\ndimension: 4\nsizes: 2 3 2 2\nencoding: raw";
    assert_eq!(u8s(&read_with(header, &DATA, &frame(1)).unwrap()), &DATA[12..]);
    let packed = read_with(&header.replace("raw", "gzip"), &gzip(&DATA), &frame(1)).unwrap();
    assert_eq!(u8s(&packed), &DATA[12..]);
    let error = read_with(header, &DATA, &frame(2)).unwrap_err();
    assert!(error.to_string().contains("it holds 2"), "{error}");
    assert!(read_with(header, &DATA[..23], &frame(0)).is_err(), "cut off");
    let first = "type: uint8\ndimension: 3\nsizes: 2 3 4\nkinds: time domain domain\nencoding: raw";
    let volume = read_with(first, &DATA, &frame(1)).unwrap();
    assert_eq!((volume.frames, volume.components), (2, 1));
    assert_eq!(u8s(&volume), (0..12).map(|v| 2 * v + 1).collect::<Vec<u8>>());
}

#[test]
fn the_lowest_place_of_an_axis_is_a_border_unless_it_is_a_node() {
    let header = format!("{HEADER}\nspacings: 1 2 3\naxis mins: 10 20 30");
    for (centers, origin) in [
        ("", DVec3::new(10.5, 21.0, 31.5)),
        ("\ncenters: cell cell cell", DVec3::new(10.5, 21.0, 31.5)),
        ("\ncenterings: node node cell", DVec3::new(10.0, 20.0, 31.5)),
    ] {
        let volume = read(&format!("{header}{centers}"), &DATA).unwrap();
        assert_eq!(volume.grid.world_from_index().translation, origin, "{centers}");
    }
}

#[test]
fn both_ends_of_an_axis_tell_its_spacing() {
    let header = format!("{HEADER}\naxis mins: 0 0 0\naxis maxs: 4 9 nan");
    for (centers, spacing, origin) in [
        ("", DVec3::new(2.0, 3.0, 1.0), DVec3::new(1.0, 1.5, 0.5)),
        ("\ncenters: node node node", DVec3::new(4.0, 4.5, 1.0), DVec3::ZERO),
        (
            "\nspacings: 1 nan 5",
            DVec3::new(1.0, 3.0, 5.0),
            DVec3::new(0.5, 1.5, 2.5),
        ),
    ] {
        let place = *read(&format!("{header}{centers}"), &DATA)
            .unwrap()
            .grid
            .world_from_index();
        assert_eq!(place.matrix3, DMat3::from_diagonal(spacing), "{centers}");
        assert_eq!(place.translation, origin, "{centers}");
    }
}

/// Runs as long as the volume are in memory together, unless one component is read alone.
#[test]
fn components_in_long_runs_are_within_the_budget() {
    let header = "type: uint8\ndimension: 4\nsizes: 64 64 8 3\nencoding: raw\nkinds: domain domain domain vector";
    let folder = folder();
    let path = file(
        &folder,
        "a.nrrd",
        &[format!("NRRD0005\n{header}\n\n").as_bytes(), &[3; 3 << 15]].concat(),
    );
    let options = |budget, component| ReadOptions {
        budget: Budget::of_bytes(budget),
        component,
        ..ReadOptions::default()
    };
    let error = io::open(&path, &options(3 << 14, None)).unwrap_err();
    assert!(
        matches!(error.problem, Problem::Budget { bytes: 98_304, .. }),
        "{error}"
    );
    io::open(&path, &options(3 << 14, Some(1))).unwrap();
    io::open(&path, &options(3 << 15, None)).unwrap();
}

#[test]
fn bzip2_and_hexadecimal_are_read() {
    let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
    encoder.write_all(&DATA).unwrap();
    let packed = encoder.finish().unwrap();
    for encoding in ["bzip2", "bz2"] {
        assert_eq!(u8s(&read(&HEADER.replace("raw", encoding), &packed).unwrap()), DATA);
    }
    assert!(read(&HEADER.replace("raw", "bzip2"), &packed[..packed.len() - 4]).is_err());
    let hex: String = DATA.iter().map(|v| format!("{v:02X}\n")).collect();
    assert_eq!(u8s(&read(&HEADER.replace("raw", "hex"), hex.as_bytes()).unwrap()), DATA);
    assert!(read(&HEADER.replace("raw", "hex"), &[b'g'; 48]).is_err());
}

#[test]
fn data_in_several_files_is_put_together() {
    let folder = folder();
    for (n, part) in DATA.chunks(6).enumerate() {
        file(&folder, &format!("p{}.raw", n + 1), &[b"line\nXY", part].concat());
    }
    for named in [
        "LIST\np1.raw\np2.raw\np3.raw\np4.raw",
        "p%d.raw 1 4 1",
        "p%01d.raw 1 4 1 2",
    ] {
        let header = format!("NRRD0004\n{HEADER}\nline skip: 1\nbyte skip: 2\ndata file: {named}\n");
        let volume = io::read(&file(&folder, "a.nhdr", header.as_bytes())).unwrap();
        assert_eq!(u8s(&volume), DATA, "{named}");
    }
    for named in [
        "LIST\np1.raw\np2.raw",
        "p%d.raw 1 5 1",
        "p%d.raw 1 4 0",
        "p%x.raw 1 4 1",
        "LIST",
    ] {
        let header = format!("NRRD0004\n{HEADER}\nline skip: 1\nbyte skip: 2\ndata file: {named}\n");
        assert!(
            io::read(&file(&folder, "a.nhdr", header.as_bytes())).is_err(),
            "{named}"
        );
    }
}

#[test]
fn byte_orders_are_kept_apart() {
    for (endian, value) in [("little", 0x0201), ("big", 0x0102)] {
        let header = format!("type: short\ndimension: 1\nsizes: 1\nencoding: raw\nendian: {endian}");
        let volume = read(&header, &[1, 2]).unwrap();
        assert_eq!(*volume.grid.voxels(), Voxels::I16(vec![value]));
    }
    let error = read("type: short\ndimension: 1\nsizes: 1\nencoding: raw", &[1, 2]).unwrap_err();
    assert!(error.to_string().contains("endian"), "{error}");
}

#[test]
fn long_integers_become_doubles() {
    let header = "type: longlong\ndimension: 1\nsizes: 1\nencoding: raw\nendian: big";
    let volume = read(header, &(-5i64).to_be_bytes()).unwrap();
    assert_eq!(*volume.grid.voxels(), Voxels::F64(vec![-5.0]));
}

#[test]
fn text_is_read() {
    let header = "type: float\ndimension: 2\nsizes: 3 2\nencoding: ascii";
    let volume = read(header, b"1 -2.5 3e2\n4,5,nan\n").unwrap();
    let Voxels::F32(v) = volume.grid.voxels() else { panic!() };
    assert_eq!(v[..5], [1.0, -2.5, 300.0, 4.0, 5.0]);
    assert!(v[5].is_nan());
    let error = read(header, b"1 2 x 4 5 6 7").unwrap_err();
    assert!(matches!(&error.problem, Problem::Text(word) if word == "x"), "{error}");
    assert!(read(header, b"1 2 300000000000").is_err());
}

#[test]
fn skips_are_done() {
    let mut data = b"line one\nline two\nXYZ".to_vec();
    data.extend(DATA);
    let volume = read(&format!("{HEADER}\nline skip: 2\nbyte skip: 3"), &data).unwrap();
    assert_eq!(u8s(&volume), DATA);
    let volume = read(&format!("{HEADER}\nbyte skip: -1"), &data).unwrap();
    assert_eq!(u8s(&volume), DATA);
    let error = read(&format!("{HEADER}\nbyte skip: -2"), &data).unwrap_err();
    assert!(error.to_string().contains("byte skip"), "{error}");
    assert!(read(&format!("{HEADER}\nline skip: 99"), &data).is_err());
}

#[test]
fn gzip_is_read_with_skips() {
    let header = HEADER.replace("raw", "gzip");
    let padded = [b"XYZ".as_slice(), &DATA].concat();
    assert_eq!(u8s(&read(&header, &gzip(&DATA)).unwrap()), DATA);
    let volume = read(&format!("{header}\nbyte skip: 3"), &gzip(&padded)).unwrap();
    assert_eq!(u8s(&volume), DATA);
    let volume = read(&format!("{header}\nbyte skip: -1"), &gzip(&padded)).unwrap();
    assert_eq!(u8s(&volume), DATA);
    let lines = [b"a\nb\n".to_vec(), gzip(&DATA)].concat();
    assert_eq!(u8s(&read(&format!("{header}\nline skip: 2"), &lines).unwrap()), DATA);
    let members = [gzip(&DATA[..7]), gzip(&DATA[7..]), b"garbage".to_vec()].concat();
    assert_eq!(u8s(&read(&header, &members).unwrap()), DATA);
}

#[test]
fn damaged_gzip_is_refused() {
    let header = HEADER.replace("raw", "gzip");
    let error = read(&header, b"this is no gzip stream").unwrap_err();
    assert!(matches!(error.problem, Problem::Compressed(_)), "{error}");
    let whole = gzip(&DATA);
    let error = read(&header, &whole[..whole.len() / 2]).unwrap_err();
    assert!(matches!(error.problem, Problem::Truncated { .. }), "{error}");
    let mut flipped = whole.clone();
    let checksum = whole.len() - 8;
    flipped[checksum] ^= 1;
    let error = read(&header, &flipped).unwrap_err();
    assert!(matches!(error.problem, Problem::Compressed(_)), "{error}");
}

#[test]
fn a_small_file_cannot_claim_a_large_volume() {
    let large = "type: double\ndimension: 3\nsizes: 1000000 1000000 1000000\nendian: little\nencoding: ";
    let error = read(&format!("{large}raw"), &DATA).unwrap_err();
    assert!(matches!(error.problem, Problem::Truncated { found: 24, .. }), "{error}");
    let error = read(&format!("{large}gzip"), &gzip(&DATA)).unwrap_err();
    assert!(matches!(error.problem, Problem::Implausible { .. }), "{error}");
    let error = read(&format!("{large}text"), b"1 2 3").unwrap_err();
    assert!(matches!(error.problem, Problem::Truncated { .. }), "{error}");
    let overflow = large.replace("1000000", "60000000");
    let error = read(&format!("{overflow}raw"), &DATA).unwrap_err();
    assert!(matches!(error.problem, Problem::Grid(_)), "{error}");
}

#[test]
fn only_the_declared_part_of_a_gzip_bomb_is_read() {
    let bomb = gzip(&vec![7; 50_000_000]);
    let volume = read(&HEADER.replace("raw", "gzip"), &bomb).unwrap();
    assert_eq!(u8s(&volume), [7; 24]);
}

#[test]
fn bad_headers_name_the_line() {
    for (header, line) in [
        (HEADER.replace("uint8", "quaternion"), 2),
        (HEADER.replace("2 3 4", "2 3 x"), 4),
        (HEADER.replace("2 3 4", "2 -3 4"), 4),
        (HEADER.replace("2 3 4", "2 3"), 4),
        (format!("{HEADER}\nno field here"), 6),
        (format!("{HEADER}\nspace: outer"), 6),
        (format!("{HEADER}\nspace directions: (1,0 (0,1,0) (0,0,1)"), 6),
        (format!("{HEADER}\nencoding: raw"), 6),
        (HEADER.replace("raw", "zrl"), 5),
    ] {
        let error = read(&header, &DATA).unwrap_err();
        assert_eq!(error.position, Some(Position::Line(line)), "{error}");
    }
}

#[test]
fn impossible_volumes_are_refused() {
    for header in [
        HEADER.replace("2 3 4", "2 0 4"),
        format!("{}\nkinds: vector domain domain", HEADER.replace("2 3 4", "0 3 4")),
        format!("{}\nkinds: domain domain time", HEADER.replace("2 3 4", "2 3 0")),
        "type: uint8\nencoding: raw".to_owned(),
        format!("{HEADER}\nspace: LPS\nspace directions: (1,0,0) (1,0,0) (0,0,1)"),
        format!("{HEADER}\ndata file: LIST"),
        format!("{HEADER}\ndata file: nowhere.raw"),
        format!("{HEADER}\nbyte skip: 99999999999999"),
    ] {
        assert!(read(&header, &DATA).is_err(), "{header}");
    }
    let error = read(HEADER, &DATA[..23]).unwrap_err();
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
fn detached_headers_find_their_data() {
    let folder = folder();
    file(&folder, "a.raw.gz", &gzip(&DATA));
    let header = format!("NRRD0004\n{}\ndata file: a.raw.gz\n", HEADER.replace("raw", "gzip"));
    let volume = io::read(&file(&folder, "a.nhdr", header.as_bytes())).unwrap();
    assert_eq!(u8s(&volume), DATA);
}

#[test]
fn every_prefix_of_a_file_is_an_error() {
    let folder = folder();
    let whole = [format!("NRRD0005\n{HEADER}\n\n").into_bytes(), DATA.to_vec()].concat();
    for end in 0..whole.len() {
        let path = file(&folder, "a.nrrd", &whole[..end]);
        assert!(io::read(&path).is_err(), "{end}");
    }
}
