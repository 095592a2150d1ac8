//! Inputs of the readers: a file of the format, or several.
//!
//! Several are, behind `FILES`, the name of the one to open (none is their folder), and then names and contents, each behind its
//! length (a byte; four, the lowest first).

use std::fs;
use std::path::{Component, Path, PathBuf};

use glam::DAffine3;
use vcsg::volume::VoxelType;
use vcsg::volume::io::raw::RawLayout;
use vcsg::volume::io::{ByteOrder, Format, ReadOptions};

/// How an input of several files begins.
const FILES: &[u8] = b"FILES";

/// What a format is called in names of folders.
pub fn name(format: &Format) -> String {
    format.name.to_lowercase().replace(' ', "-")
}

/// What the files of the format without a header are taken to hold.
const LAYOUT: RawLayout = RawLayout {
    dims: [5, 4, 3],
    voxel: VoxelType::I16,
    order: ByteOrder::Big,
    offset: 7,
    world_from_index: DAffine3::IDENTITY,
};

/// How its files are read.
pub fn options(format: &Format) -> ReadOptions {
    ReadOptions {
        raw: (format.name == "raw").then_some(LAYOUT),
        ..ReadOptions::default()
    }
}

/// Writes an input into `folder`; what is to be opened of it.
pub fn written(folder: &Path, format: &Format, bytes: &[u8]) -> Option<PathBuf> {
    let Some(mut rest) = bytes.strip_prefix(FILES) else {
        let path = folder.join(format!("input{}", format.suffixes.first().unwrap_or(&"")));
        return fs::write(&path, bytes).ok().map(|()| path);
    };
    let opened = inside(folder, text(&mut rest)?)?;
    while let Some(path) = text(&mut rest) {
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

/// A text behind its length.
fn text<'a>(bytes: &mut &'a [u8]) -> Option<&'a str> {
    let (length, rest) = bytes.split_first()?;
    let (name, rest) = rest.split_at_checked(usize::from(*length))?;
    *bytes = rest;
    std::str::from_utf8(name).ok()
}

/// A path that stays in `folder`.
fn inside(folder: &Path, name: &str) -> Option<PathBuf> {
    let stays = Path::new(name)
        .components()
        .all(|part| matches!(part, Component::Normal(_)));
    (stays && !name.contains('\0')).then(|| folder.join(name))
}
