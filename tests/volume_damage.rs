//! Damaged files of every header format are read or refused, and never more than that; what fuzzing sets out from is read.

#[path = "../tools/fuzz/input.rs"]
mod input;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use glam::{DAffine3, DVec3};
use proptest::prelude::*;
use tempfile::TempDir;
use vcsg::volume::io::{self, Encoding, FORMATS, ReadOptions, open_all};
use vcsg::volume::{Grid, Voxels};

/// A folder with a small volume in each format, and the files that are damaged: headers, and files of header and voxels.
static SOUND: LazyLock<(TempDir, Vec<PathBuf>)> = LazyLock::new(sound_files);

fn sound_files() -> (TempDir, Vec<PathBuf>) {
    let folder = tempfile::tempdir().unwrap();
    let place = DAffine3::from_scale(DVec3::new(1.0, 2.0, 3.0));
    let grid = Grid::new([4, 3, 2], place, Voxels::I16((0..24).collect())).unwrap();
    let mut paths = Vec::new();
    for (name, encoding) in [
        ("a.nrrd", Encoding::Raw),
        ("b.nrrd", Encoding::Gzip),
        ("c.nhdr", Encoding::Raw),
        ("d.mha", Encoding::Raw),
        ("e.mha", Encoding::Gzip),
        ("f.mhd", Encoding::Gzip),
        ("g.nii", Encoding::Raw),
        ("h.nii.gz", Encoding::Gzip),
        ("i.vti", Encoding::Raw),
        ("j.vti", Encoding::Gzip),
    ] {
        let path = folder.path().join(name);
        io::write(&path, &grid, encoding).unwrap();
        paths.push(path);
    }
    let text =
        "NRRD0004\ntype: short\ndimension: 4\nsizes: 3 4 2 1\nkinds: vector domain domain time\nencoding: text\n\n";
    let numbers: Vec<String> = (0..24).map(|v| v.to_string()).collect();
    let path = folder.path().join("k.nrrd");
    fs::write(&path, format!("{text}{}", numbers.join(" "))).unwrap();
    paths.push(path);
    (folder, paths)
}

/// One change of a file.
#[derive(Clone, Debug)]
enum Damage {
    /// Another byte at a place.
    Byte(prop::sample::Index, u8),
    /// A number in the text made another.
    Digit(prop::sample::Index, u8),
    /// Its end is missing.
    Cut(prop::sample::Index),
    /// A part of it twice.
    Twice(prop::sample::Index, prop::sample::Index),
}

fn damage() -> impl Strategy<Value = Damage> {
    let place = any::<prop::sample::Index>;
    prop_oneof![
        (place(), any::<u8>()).prop_map(|(at, to)| Damage::Byte(at, to)),
        (place(), b'0'..=b'9').prop_map(|(at, to)| Damage::Digit(at, to)),
        place().prop_map(Damage::Cut),
        (place(), place()).prop_map(|(from, to)| Damage::Twice(from, to)),
    ]
}

impl Damage {
    fn apply(&self, bytes: &mut Vec<u8>) {
        if bytes.is_empty() {
            return;
        }
        match self {
            Self::Byte(at, to) => {
                let at = at.index(bytes.len());
                bytes[at] = *to;
            }
            Self::Digit(at, to) => {
                let digits: Vec<usize> = (0..bytes.len()).filter(|&i| bytes[i].is_ascii_digit()).collect();
                if !digits.is_empty() {
                    bytes[digits[at.index(digits.len())]] = *to;
                }
            }
            Self::Cut(at) => bytes.truncate(at.index(bytes.len())),
            Self::Twice(from, to) => {
                let (from, to) = (from.index(bytes.len()), to.index(bytes.len()));
                let part = bytes[from.min(to)..from.max(to)].to_vec();
                bytes.splice(from..from, part);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_damage_panics(changes in prop::collection::vec(damage(), 1..5), component in prop::option::of(0_usize..4)) {
        let (folder, paths) = &*SOUND;
        let options = ReadOptions { component, frame: component.map(|_| 0), ..ReadOptions::default() };
        for path in paths {
            let mut bytes = fs::read(path).unwrap();
            changes.iter().for_each(|change| change.apply(&mut bytes));
            let name = path.file_name().unwrap().to_str().unwrap();
            let damaged = folder.path().join(format!("x{name}"));
            fs::write(&damaged, bytes).unwrap();
            if let Err(error) = io::read_with(&damaged, &options) {
                prop_assert!(error.to_string().len() > 10);
            }
        }
    }
}

const PYTHON: &str = "target/deps/vtk/bin/python";

/// Voxels in the volumes that an input holds.
fn voxels(format: &io::Format, bytes: &[u8]) -> Result<usize, io::ReadError> {
    let folder = tempfile::tempdir().unwrap();
    let path = input::written(folder.path(), format, bytes).expect("an input that can be unpacked");
    let volumes = open_all(&path, &input::options(format))?;
    // NIfTI's versions are called by their own names.
    let is_its = |found: &str| found == format.name || format.name == "NIfTI";
    assert!(
        volumes.iter().all(|volume| is_its(volume.declared().format)),
        "{}",
        format.name
    );
    volumes.into_iter().map(|v| Ok(v.grid()?.voxels().len())).sum()
}

#[test]
fn every_seed_of_fuzzing_is_a_volume_of_its_format() {
    assert!(Path::new(PYTHON).exists(), "{PYTHON} is missing: run make setup");
    let seeds = tempfile::tempdir().unwrap();
    let written = Command::new(PYTHON).arg("tools/fuzz/seeds").arg(seeds.path()).status();
    assert!(written.unwrap().success(), "tools/fuzz/seeds");
    let mut refused = Vec::new();
    for format in FORMATS {
        let folder = seeds.path().join(input::name(format));
        let files: Vec<_> = fs::read_dir(&folder).expect("seeds of the format").collect();
        assert!(files.len() > 1, "{}", format.name);
        for file in files {
            let path = file.unwrap().path();
            match voxels(format, &fs::read(&path).unwrap()) {
                Ok(count) if count >= 12 => {}
                other => refused.push(format!("{}: {other:?}", path.display())),
            }
        }
    }
    assert!(refused.is_empty(), "{}", refused.join("\n"));
}
