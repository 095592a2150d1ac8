//! Arbitrary files for the reader that `VCSG_FORMAT` names: reading them is voxels or an error, within a budget of memory and time.

#![no_main]

mod input;

use std::panic;
use std::path::Path;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use tempfile::TempDir;
use vcsg::volume::io::{Budget, FORMATS, Format, Opened, ReadError, ReadOptions, is_caught, open_all};

/// The memory that reading may take.
const BUDGET: Budget = Budget::of_bytes(64 << 20);

/// The format whose reader is tried; `None` where none is named.
static FORMAT: LazyLock<Option<&Format>> = LazyLock::new(|| {
    let wanted = std::env::var("VCSG_FORMAT").ok()?.to_lowercase();
    let found = FORMATS.iter().find(|format| input::name(format) == wanted);
    Some(found.unwrap_or_else(|| panic!("no format is called {wanted}")))
});

fuzz_target!(
    init: if FORMAT.is_some() {
        let abort = panic::take_hook();
        panic::set_hook(Box::new(move |panic| if !is_caught() { abort(panic) }));
    } else {
        FORMATS.iter().for_each(|format| println!("{}", input::name(format)));
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
    let Some(path) = input::written(folder.path(), format, bytes) else {
        return;
    };
    let options = ReadOptions {
        budget: BUDGET,
        ..input::options(format)
    };
    each(&path, &options, |volume| volume.info().map(drop));
    each(&path, &options, |volume| volume.bricks().map(drop));
}

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
