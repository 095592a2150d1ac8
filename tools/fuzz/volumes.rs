//! Arbitrary files for the reader that `VCSG_FORMAT` names: reading them is voxels or an error, within a budget of memory and time.
//!
//! An input is a file of the format, or several: behind `FILES` come the name of the one to open (none is their folder), and then
//! names and contents, each behind its length (a byte; four, the lowest first).

#![no_main]

use std::fs;
use std::path::{Component, Path, PathBuf};
use std::sync::LazyLock;

use glam::DAffine3;
use libfuzzer_sys::fuzz_target;
use tempfile::TempDir;
use vcsg::volume::VoxelType;
use vcsg::volume::io::raw::RawLayout;
use vcsg::volume::io::{Budget, ByteOrder, FORMATS, Format, Opened, ReadError, ReadOptions, open_all};

/// How an input of several files begins.
const FILES: &[u8] = b"FILES";

/// The memory that reading may take.
const BUDGET: Budget = Budget::of_bytes(64 << 20);

/// The format whose reader is tried; `None` where none is named.
static FORMAT: LazyLock<Option<&Format>> = LazyLock::new(|| {
    let wanted = std::env::var("VCSG_FORMAT").ok()?.to_lowercase();
    let is_wanted = |format: &&&Format| format.name.to_lowercase().replace(' ', "-") == wanted;
    let found = FORMATS.iter().find(is_wanted);
    Some(found.unwrap_or_else(|| panic!("no format is called {wanted}")))
});

fuzz_target!(
    init: if FORMAT.is_none() {
        FORMATS.iter().for_each(|format| println!("{}", format.name.to_lowercase().replace(' ', "-")));
        std::process::exit(0);
    },
    |bytes: &[u8]| {
        if let Some(format) = *FORMAT {
            read(format, bytes);
        }
    }
);

/// Reads the volumes of an input to their ends, in both ways that take no grid.
fn read(format: &Format, bytes: &[u8]) {
    let folder = folder();
    let Some(path) = written(folder.path(), format, bytes) else {
        return;
    };
    let options = ReadOptions {
        budget: BUDGET,
        raw: (format.name == "raw").then_some(LAYOUT),
        ..ReadOptions::default()
    };
    each(&path, &options, |volume| volume.info().map(drop));
    each(&path, &options, |volume| volume.bricks().map(drop));
}

/// What the files of the format without a header are taken to hold.
const LAYOUT: RawLayout = RawLayout {
    dims: [5, 4, 3],
    voxel: VoxelType::I16,
    order: ByteOrder::Big,
    offset: 7,
    world_from_index: DAffine3::IDENTITY,
};

fn each(path: &Path, options: &ReadOptions, read: impl Fn(Opened) -> Result<(), ReadError>) {
    for volume in open_all(path, options).into_iter().flatten() {
        // An error is as good as voxels; its text must be one.
        let _ = read(volume).map_err(|error| error.to_string());
    }
}

/// A folder that goes away, in memory where there is such a place.
fn folder() -> TempDir {
    tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).expect("a folder for the input")
}

/// Writes an input into `folder`; what is to be opened of it.
fn written(folder: &Path, format: &Format, bytes: &[u8]) -> Option<PathBuf> {
    let Some(mut rest) = bytes.strip_prefix(FILES) else {
        let path = folder.join(format!("input{}", format.suffixes.first().unwrap_or(&"")));
        return fs::write(&path, bytes).ok().map(|()| path);
    };
    let opened = inside(folder, name(&mut rest)?)?;
    while let Some(path) = name(&mut rest) {
        let (length, contents) = rest.split_first_chunk()?;
        let length = (u32::from_le_bytes(*length) as usize).min(contents.len());
        let (contents, after) = contents.split_at(length);
        rest = after;
        let path = inside(folder, path)?;
        fs::create_dir_all(path.parent()?).ok()?;
        fs::write(path, contents).ok()?;
    }
    Some(opened)
}

/// A name behind its length.
fn name<'a>(bytes: &mut &'a [u8]) -> Option<&'a str> {
    let (length, rest) = bytes.split_first()?;
    let (name, rest) = rest.split_at_checked(usize::from(*length))?;
    *bytes = rest;
    std::str::from_utf8(name).ok()
}

/// A path that stays in `folder`.
fn inside(folder: &Path, name: &str) -> Option<PathBuf> {
    let stays = Path::new(name).components().all(|part| matches!(part, Component::Normal(_)));
    (stays && !name.contains('\0')).then(|| folder.join(name))
}
