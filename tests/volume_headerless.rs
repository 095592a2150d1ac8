//! Files with little or no header: VolPack's densities, and what raw files are offered to be.

use std::fs;
use std::path::Path;

use vcsg::volume::Voxels;
use vcsg::volume::io::{self, Problem};

fn den(version: [u8; 2], dims: [u8; 3], order: fn([u8; 2]) -> [u8; 2], data: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0; 62];
    bytes[..2].copy_from_slice(&version);
    for (axis, dim) in dims.into_iter().enumerate() {
        bytes[50 + 2 * axis..52 + 2 * axis].copy_from_slice(&order([dim, 0]));
    }
    let count = order([dims.iter().product(), 0]);
    let at = if version == [1, 0] { 58 } else { 60 };
    bytes[at..at + 2].copy_from_slice(&count);
    bytes.extend(data);
    bytes
}

fn read(name: &str, bytes: &[u8]) -> Result<io::Volume, io::ReadError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    io::read(&path)
}

#[test]
fn densities_are_read_in_either_order() {
    let data = [1, 2, 3, 4, 5, 6];
    for bytes in [
        den([1, 0], [3, 2, 1], |n| n, &data),
        den([0, 1], [3, 2, 1], |[a, b]| [b, a], &data),
    ] {
        let volume = read("a.den", &bytes).unwrap();
        assert_eq!(volume.grid.dims(), [3, 2, 1]);
        assert_eq!(*volume.grid.voxels(), Voxels::U8(data.to_vec()));
    }
}

#[test]
fn bad_densities_are_refused() {
    let bytes = den([1, 0], [3, 2, 1], |n| n, &[0; 5]);
    let cut = read("a.den", &bytes).unwrap_err();
    assert!(
        matches!(cut.problem, Problem::Truncated { expected: 6, found: 5 }),
        "{cut}"
    );
    for length in [0, 1, 2, 61] {
        assert!(read("a.den", &bytes[..length]).is_err());
    }
    let mut other = bytes.clone();
    other[58] = 7;
    let error = read("a.den", &other).unwrap_err().to_string();
    assert!(error.contains("byte 58"), "{error}");
}

#[test]
fn the_brain_of_volpack_is_read() {
    let path = Path::new("target/deps/data/brainsmall.den");
    assert!(path.exists(), "{} is missing: run make setup", path.display());
    let grid = io::read(path).unwrap().grid;
    assert_eq!(grid.dims(), [128, 128, 84]);
    let Voxels::U8(voxels) = grid.voxels() else {
        panic!("bytes");
    };
    assert_eq!(voxels[..], fs::read(path).unwrap()[62..]);
}

#[test]
fn what_a_raw_file_may_be_is_offered_and_not_taken() {
    let error = read("bolt_uint8_7x5x3.raw", &[0; 105]).unwrap_err().to_string();
    assert!(error.contains("--raw-dims 7,5,3 --raw-type u8"), "{error}");
    let error = read("a.raw", &[0; 64]).unwrap_err().to_string();
    assert!(error.contains("--raw-dims 4,4,4 --raw-type u8"), "{error}");
}
