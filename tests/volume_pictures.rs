//! One head in every format that is written, and as DICOM; and one volume with its axes in every order: the same pictures.

#[path = "oracle/process.rs"]
mod process;

use std::io::BufRead;
use std::path::{Path, PathBuf};
use std::process::Command;

use glam::{DAffine3, DMat3, DVec3};
use process::Process;
use rayon::prelude::*;
use serde_json::json;
use vcsg::volume::io::{self, Encoding};
use vcsg::volume::{Grid, Voxels};

const HEAD: &str = "target/deps/data/ch2.nii.gz";

const ASLANT: [&str; 2] = ["30", "20"];

fn vcsg(arguments: &[&str]) {
    let output = Command::new(env!("CARGO_BIN_EXE_vcsg"))
        .args(arguments)
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {message}");
}

/// The pixels that the program draws of a volume, from an azimuth and an elevation.
fn picture(volume: &Path, renderer: &str, size: &str, [azimuth, elevation]: [&str; 2]) -> Vec<u8> {
    let png = PathBuf::from(format!("{}.png", volume.display()));
    let (from, to) = (volume.to_str().unwrap(), png.to_str().unwrap());
    let view = ["--size", size, "--azimuth", azimuth, "--elevation", elevation];
    vcsg(&[&["render", from, "-o", to, "--renderer", renderer], &view[..]].concat());
    image::open(&png).unwrap().to_rgba8().into_raw()
}

#[test]
fn a_head_is_the_same_picture_in_every_format() {
    assert!(Path::new(HEAD).exists(), "{HEAD} is missing: run make setup");
    let folder = tempfile::tempdir().unwrap();
    let from_dir = |name: &str| folder.path().join(name);
    let first = from_dir("head.nii.gz");
    std::fs::copy(HEAD, &first).unwrap();
    let expected = picture(&first, "slices", "96x96", ASLANT);
    assert!(expected.iter().any(|v| *v != expected[0]), "a picture of something");
    for (name, raw) in [
        ("a.nrrd", false),
        ("b.nhdr", true),
        ("c.nii", true),
        ("d.mha", false),
        ("e.mhd", true),
        ("f.vti", false),
        ("g.vti", true),
    ] {
        let path = from_dir(name);
        let raw: &[&str] = if raw { &["--raw"] } else { &[] };
        vcsg(&[&["convert", HEAD, path.to_str().unwrap()], raw].concat());
        assert!(picture(&path, "slices", "96x96", ASLANT) == expected, "{name}");
    }
    let raw = from_dir("h.raw");
    vcsg(&["convert", HEAD, raw.to_str().unwrap()]);
    assert!(
        picture(&from_dir("h.nhdr"), "slices", "96x96", ASLANT) == expected,
        "h.raw"
    );
}

/// Has pydicom write the head as a series of slices, whose numbers in decimals are exact.
fn write_series(folder: &Path) {
    let head = io::read(Path::new(HEAD)).unwrap().grid;
    let Voxels::U8(voxels) = head.voxels() else {
        panic!("{HEAD} has bytes")
    };
    let place = head.world_from_index();
    let steps = DVec3::AXES.map(|axis| (place.matrix3 * axis).to_array());
    let origin = place.translation.to_array();
    assert!(
        steps.iter().flatten().chain(&origin).all(|v| v.fract() == 0.0),
        "{place:?}"
    );
    let mut pydicom = Process::start("tests/oracle/write_series.py");
    pydicom.send(
        &json!({"folder": folder, "dims": head.dims(), "origin": origin, "steps": steps}),
        &[voxels],
    );
    let mut answer = String::new();
    assert_eq!(
        pydicom.answers.read_line(&mut answer).unwrap(),
        1,
        "see its message above"
    );
}

#[test]
fn a_head_is_the_same_picture_as_dicom() {
    let folder = tempfile::tempdir().unwrap();
    let (nifti, series) = (folder.path().join("head.nii.gz"), folder.path().join("series"));
    std::fs::copy(HEAD, &nifti).unwrap_or_else(|e| panic!("{HEAD}: {e}: run make setup"));
    write_series(&series);
    let picture = |path| picture(path, "slices", "96x96", ASLANT);
    assert!(picture(&series) == picture(&nifti));
}

/// All 48 ways to lay index axes along the world's: the axis of the world along which each runs, and the ways it runs.
fn axis_orders() -> Vec<([usize; 3], [bool; 3])> {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let ways = |bits: usize| std::array::from_fn(|a| bits >> a & 1 == 1);
    (0..48).map(|n| (orders[n / 8], ways(n % 8))).collect()
}

/// Of a volume of 18 × 14 × 10 voxels that is like itself in no other order.
fn value([x, y, z]: [usize; 3]) -> u8 {
    (4 * x + 2 * y + 5 * z + 40 * usize::from(x > 11 && y < 5) + 60 * usize::from(z > 6)) as u8
}

const DIMS: [usize; 3] = [18, 14, 10];

/// All edges are whole numbers of the least, so that seen along an axis the planes of samples, which begin half a step behind a corner
/// of the lattice, are the same whichever corner is its first.
const SPACING: [f64; 3] = [1.0, 1.5, 2.0];

/// The volume, with its index axes laid along the world's in this order and these ways. All numbers of its place are `f32`.
fn laid(order: [usize; 3], backwards: [bool; 3]) -> Grid {
    let dims = order.map(|axis| DIMS[axis]);
    let mut origin = DVec3::ZERO;
    let columns: [DVec3; 3] = std::array::from_fn(|a| {
        let step = DVec3::AXES[order[a]] * SPACING[order[a]];
        match backwards[a] {
            true => {
                origin += step * (dims[a] - 1) as f64;
                -step
            }
            false => step,
        }
    });
    let mut voxels = Vec::new();
    for k in 0..dims[2] {
        for j in 0..dims[1] {
            for i in 0..dims[0] {
                let mut at = [0; 3];
                for (a, n) in [i, j, k].into_iter().enumerate() {
                    at[order[a]] = if backwards[a] { dims[a] - 1 - n } else { n };
                }
                voxels.push(value(at));
            }
        }
    }
    let [x, y, z] = columns;
    let place = DAffine3::from_mat3_translation(DMat3::from_cols(x, y, z), origin);
    Grid::new(dims, place, Voxels::U8(voxels)).unwrap()
}

/// All take the same samples then, and the reference interpolates them in `f64` by eight products, whose sum in another order is a
/// few 2⁻⁵³ off. A ray adds some twenty of them: before it is rounded to 8 bits its colour is far less than a level off, so that
/// levels differ by one at most.
#[test]
fn axes_in_any_order_are_the_same_picture() {
    let folder = tempfile::tempdir().unwrap();
    for view in [["0", "0"], ["90", "0"]] {
        let pictures: Vec<_> = axis_orders()
            .into_par_iter()
            .enumerate()
            .map(|(n, (order, backwards))| {
                let path = folder.path().join(format!("{n}.nii"));
                io::write(&path, &laid(order, backwards), Encoding::Raw).unwrap();
                picture(&path, "reference", "40x32", view)
            })
            .collect();
        let first = &pictures[0];
        assert!(first.iter().any(|v| *v != first[0]), "a picture of something");
        for (n, picture) in pictures.iter().enumerate() {
            let most = first.iter().zip(picture).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
            assert!(most <= 1, "order {:?}: {most} levels apart", axis_orders()[n]);
        }
    }
}
