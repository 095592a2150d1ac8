//! What no writer of ours makes, but the formats allow.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use vcsg::volume::Voxels;
use vcsg::volume::io::{self, Problem, ReadError, ReadOptions, Volume};

use crate::{f64s, file, folder, named, read};

fn vti(attributes: &str, body: &str) -> String {
    format!(
        "<VTKFile type=\"ImageData\" {attributes}><ImageData WholeExtent=\"0 1 0 1 0 1\">{body}</ImageData></VTKFile>"
    )
}

const NUMBERS: &str = "0 1 2 3 4 5 6 7";

fn open(text: &str) -> Result<Volume, ReadError> {
    read("a.vti", text.as_bytes(), &ReadOptions::default())
}

fn array(name: &str, more: &str, text: &str) -> String {
    format!("<DataArray type=\"Int16\" Name=\"{name}\" format=\"ascii\" {more}>{text}</DataArray>")
}

fn piece(data: &str) -> String {
    vti("", &format!("<Piece Extent=\"0 1 0 1 0 1\">{data}</Piece>"))
}

#[test]
fn the_array_is_the_active_one_or_of_one_component() {
    let pair = array("pair", "NumberOfComponents=\"2\"", &format!("{NUMBERS} {NUMBERS}"));
    let ones = array("ones", "", "1 1 1 1 1 1 1 1");
    let twos = array("twos", "", "2 2 2 2 2 2 2 2");
    let of = |active: &str| open(&piece(&format!("<PointData {active}>{pair}{ones}{twos}</PointData>"))).unwrap();
    assert_eq!(*of("").grid.voxels(), Voxels::I16(vec![1; 8]));
    assert_eq!(*of("Scalars=\"twos\"").grid.voxels(), Voxels::I16(vec![2; 8]));
    assert_eq!(of("Scalars=\"pair\"").components, 2);
    let text = piece(&format!("<PointData>{pair}{ones}</PointData>"));
    let volume = read("a.vti", text.as_bytes(), &named("pair")).unwrap();
    assert_eq!(volume.grid.voxels().get(1), 13_f64.sqrt() as f32 as f64);
    let error = read("a.vti", text.as_bytes(), &named("three")).unwrap_err();
    assert!(error.to_string().contains("`ones`"), "{error}");
}

#[test]
fn other_elements_may_stand_in_an_array() {
    let key = "<InformationKey name=\"a\">7</InformationKey>\n";
    let text = piece(&format!(
        "<PointData>{}</PointData>",
        array("a", "", &format!("\n{key}{NUMBERS}"))
    ));
    assert_eq!(
        f64s(open(&text).unwrap().grid.voxels()),
        [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]
    );
}

/// How often this process has a file open.
fn times_open(path: &Path) -> usize {
    let links = fs::read_dir("/proc/self/fd").unwrap().flatten();
    let is_it = |link: &fs::DirEntry| fs::read_link(link.path()).is_ok_and(|file| file == path);
    links.filter(is_it).count()
}

/// Slices in pieces of their own: each is open only while it is read.
#[test]
fn many_pieces_are_opened_when_their_turn_comes() {
    let count = 1500;
    let piece = |z: usize| {
        let data = array("a", "", &format!("{z}"));
        format!("<Piece Extent=\"0 0 0 0 {z} {z}\"><PointData>{data}</PointData></Piece>")
    };
    let pieces: String = (0..count).map(piece).collect();
    let text = vti("", &pieces).replace("0 1 0 1 0 1", &format!("0 0 0 0 0 {}", count - 1));
    let folder = folder();
    let path = file(&folder, "a.vti", text.as_bytes());
    let opened = io::open(&path, &ReadOptions::default()).unwrap();
    assert!(
        times_open(&path) <= 1,
        "{} are open before they are read",
        times_open(&path)
    );
    let most = Arc::new(AtomicUsize::new(0));
    let (seen, file) = (Arc::clone(&most), path.clone());
    let watched = opened.watched(move |_| {
        seen.fetch_max(times_open(&file), Ordering::Relaxed);
    });
    let expected: Vec<i16> = (0..count as i16).collect();
    assert_eq!(*watched.grid().unwrap().voxels(), Voxels::I16(expected));
    assert!(
        most.load(Ordering::Relaxed) <= 1,
        "{most:?} are open while they are read"
    );
}

#[test]
fn cells_are_voxels_at_their_centres() {
    let text = piece(&format!("<CellData>{}</CellData>", array("a", "", "9")));
    let grid = open(&text).unwrap().grid;
    assert_eq!(grid.dims(), [1; 3]);
    assert_eq!(grid.world_from_index().translation, DVec3::splat(0.5));
}

#[test]
fn what_is_missing_is_said() {
    let data = format!("<PointData>{}</PointData>", array("a", "", NUMBERS));
    let cases = [
        (piece(""), "no array of numbers"),
        (vti("", ""), "no Piece"),
        (
            vti("", &format!("<Piece Extent=\"0 1 0 1 0 0\">{data}</Piece>")),
            "do not fill",
        ),
        (
            vti("", &format!("<Piece Extent=\"0 1 0 1 1 2\">{data}</Piece>")),
            "outside",
        ),
        (vti("compressor=\"zip\"", ""), "compressor `zip`"),
        (piece(&data).replace("ImageData\"", "PolyData\""), "PolyData"),
        (piece(&data).replace("0 1 0 1 0 1", "0 1 0 1 0 x"), "6 numbers"),
        (piece(&data).replace(NUMBERS, "0 1 2 3 4 5 6"), "numbers"),
        (piece(&data).replace(NUMBERS, "0 1 2 3 4 5 6 x"), "`x`"),
        (piece(&data).replace("ascii", "appended"), "offset"),
        (
            piece(&data).replace("0 1 0 1 0 1", "0 99999 0 99999 0 99999"),
            "numbers",
        ),
    ];
    for (text, expected) in cases {
        let error = open(&text).unwrap_err().to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    }
}

/// A parallel file that names its pieces.
#[test]
fn files_of_pieces_are_there_once_and_hold_pieces() {
    let folder = folder();
    let parallel = |sources: &[&str]| {
        let piece = |source: &&str| format!("<Piece Extent=\"0 1 0 1 0 1\" Source=\"{source}\"/>");
        let pieces: String = sources.iter().map(piece).collect();
        let text = vti("", &pieces).replace("ImageData", "PImageData");
        io::read(&file(&folder, "a.pvti", text.as_bytes()))
    };
    let data = format!("<PointData>{}</PointData>", array("a", "", NUMBERS));
    file(&folder, "b.vti", piece(&data).as_bytes());
    let expected: Vec<i16> = (0..8).collect();
    assert_eq!(*parallel(&["b.vti"]).unwrap().grid.voxels(), Voxels::I16(expected));
    for (sources, expected) in [
        (&["b.vti", "b.vti"][..], "twice"),
        (&["a.pvti"], "one itself"),
        (&["c.vti"], "c.vti"),
        (&[], "no Piece"),
    ] {
        let error = parallel(sources).unwrap_err().to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    }
}

fn legacy(header: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = format!("# vtk DataFile Version 3.0\ntitle\n{header}").into_bytes();
    bytes.extend(data);
    bytes
}

#[test]
fn old_words_are_known() {
    let header = "BINARY\n\ndataset STRUCTURED_POINTS\nDIMENSIONS 2 1 1\nASPECT_RATIO 2 3 4\nORIGIN 5 6 7\nPOINT_DATA 2\nSCALARS a%20b short\n";
    for table in ["", "LOOKUP_TABLE default\n"] {
        let bytes = legacy(&format!("{header}{table}"), &[1, 2, 255, 254]);
        let volume = read("a.vtk", &bytes, &named("a b")).unwrap();
        assert_eq!(*volume.grid.voxels(), Voxels::I16(vec![258, -2]));
        assert_eq!(volume.grid.world_from_index().translation, DVec3::new(5.0, 6.0, 7.0));
    }
}

#[test]
fn arrays_are_found_behind_others() {
    let header = "ASCII\nFIELD FieldData 1\nTIME 1 1 double\n0.5\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 1 1\nSPACING 1 1 1\n\
        ORIGIN 0 0 0\nCELL_DATA 1\nSCALARS c float\nLOOKUP_TABLE t\n9\nLOOKUP_TABLE t 2\n0 0 0 1 1 1 1 1\nPOINT_DATA 2\nVECTORS v \
        float\n3 4 0\n0 0 2\nMETADATA\nINFORMATION 0\n\nFIELD f 2\nx 1 2 int\n7 8\ny 2 2 int\n1 2 3 4\n";
    let values = |options: &ReadOptions| f64s(read("a.vtk", &legacy(header, b""), options).unwrap().grid.voxels());
    assert_eq!(values(&ReadOptions::default()), [7.0, 8.0]);
    assert_eq!(values(&named("v")), [5.0, 2.0]);
    assert_eq!(values(&named("c")), [9.0]);
    let second = ReadOptions {
        component: Some(1),
        ..named("y")
    };
    assert_eq!(values(&second), [2.0, 4.0]);
}

#[test]
fn bad_legacy_files_are_refused() {
    let header =
        "BINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\nPOINT_DATA 8\nSCALARS a short\nLOOKUP_TABLE default\n";
    let cut = read("a.vtk", &legacy(header, &[0; 15]), &ReadOptions::default()).unwrap_err();
    assert!(
        matches!(
            cut.problem,
            Problem::Truncated {
                expected: 16,
                found: 15
            }
        ),
        "{cut}"
    );
    for (from, to, expected) in [
        ("STRUCTURED_POINTS", "POLYDATA", "POLYDATA"),
        ("DIMENSIONS 2 2 2", "DIMENSIONS 2 2", "3 numbers"),
        ("POINT_DATA 8", "POINT_DATA 7", "7 values for 8"),
        ("BINARY", "BOTH", "BINARY"),
        ("short", "string", "`string` is not read"),
    ] {
        let error = read(
            "a.vtk",
            &legacy(&header.replace(from, to), &[0; 16]),
            &ReadOptions::default(),
        )
        .unwrap_err();
        assert!(error.to_string().contains(expected), "{expected}: {error}");
    }
}
