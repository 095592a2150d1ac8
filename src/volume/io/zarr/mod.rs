//! Zarr arrays of versions 2 and 3, and OME-Zarr images in them.
//!
//! Format: the Zarr storage specification, versions 2 and 3, and OME-NGFF 0.1 to 0.5. A folder holds an array, or an image at several
//! resolutions; chunks are read when they are asked for.

mod array;
mod blosc;
mod chunks;
mod codec;
mod filters;
mod image;
mod json;
mod listing;
mod shard;

use std::path::{Path, PathBuf};

use serde_json::Value;

use self::array::Array;
use self::chunks::{COPIES, Chunks, Selection};
use self::image::{Axis, Image, Kind};
use self::json::Document;
use super::error::ReadError;
use super::format::Format;
use super::open::{Declared, Opened, ReadOptions};

/// The files that tell that a folder is of a Zarr hierarchy.
const DOCUMENTS: [&str; 4] = ["zarr.json", ".zarray", ".zgroup", ".zattrs"];

/// Zarr among the formats.
pub(super) const FORMAT: Format = Format {
    name: "Zarr",
    suffixes: &[".zarr"],
    reads: "OME-Zarr images and arrays of versions 2 and 3: raw, gzip, zlib, zstd, lz4, blosc; shards",
    recognises: |probe| match probe.is_folder {
        true => probe.is_named(&FORMAT) || DOCUMENTS.iter().any(|name| probe.path.join(name).is_file()),
        false => DOCUMENTS.contains(&probe.name.as_str()),
    },
    open: |path, options| match path.is_dir() {
        true => open(path, options),
        false => open(&path.with_file_name(""), options),
    },
    writer: None,
};

/// Opens the volumes in the folder at `path`.
fn open(path: &Path, options: &ReadOptions) -> Result<Vec<Opened>, ReadError> {
    if let Some(document) = array_document(path)? {
        let array = Array::new(path, &document)?;
        let image = Image::of_array(&document, &array)?;
        return Ok(vec![open_array(String::new(), array, &image, 0, options)?]);
    }
    let document = attributes(path)?;
    if let Some(image) = Image::of_group(&document)? {
        return Ok(vec![open_image(path, String::new(), &document, &image, options)?]);
    }
    let series = images(path)?;
    let is_asked = |name: &str| options.series.as_deref().is_none_or(|asked| asked == name);
    let asked = series.iter().filter(|(name, ..)| is_asked(name));
    let opened = asked.map(|(name, document, image)| {
        let folder = path.join(name);
        open_image(&folder, name.clone(), document, image, options)
    });
    let opened: Vec<_> = opened.collect::<Result<_, _>>()?;
    match opened.is_empty() {
        false => Ok(opened),
        true => {
            let names: Vec<_> = series.into_iter().map(|(name, ..)| name).collect();
            let hint = match names.is_empty() {
                true => "name the folder of an image or of an array in it".to_owned(),
                false => format!("images in it are {}", names.join(", ")),
            };
            Err(ReadError::unsupported(path, "the group is no image").hint(hint))
        }
    }
}

/// The document of the array in a folder; `None` where there is no array.
fn array_document(folder: &Path) -> Result<Option<Document>, ReadError> {
    let is_array = |document: &Document| document.get("node_type").and_then(Value::as_str) == Some("array");
    match Document::read(&folder.join("zarr.json"))? {
        Some(document) => Ok(is_array(&document).then_some(document)),
        None => Document::read(&folder.join(".zarray")),
    }
}

/// What says what the group in a folder is.
fn attributes(folder: &Path) -> Result<Document, ReadError> {
    for name in ["zarr.json", ".zattrs", ".zgroup"] {
        if let Some(document) = Document::read(&folder.join(name))? {
            return Ok(document);
        }
    }
    Err(
        ReadError::header(folder, "the folder has no zarr.json, .zarray or .zattrs")
            .hint("name the folder that has one"),
    )
}

/// The images in the folders of a group that is none itself, by name, as microscopes' series are stored.
fn images(folder: &Path) -> Result<Vec<(String, Document, Image)>, ReadError> {
    let entries = folder.read_dir().map_err(|e| ReadError::io(folder, e))?;
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut names: Vec<String> = names.filter(|name| folder.join(name).is_dir()).collect();
    names.sort_by_key(|name| (name.len(), name.clone()));
    let mut images = Vec::new();
    for name in names {
        let folder = folder.join(&name);
        if !DOCUMENTS.iter().any(|document| folder.join(document).is_file()) {
            continue;
        }
        let document = attributes(&folder)?;
        if let Some(image) = Image::of_group(&document)? {
            images.push((name, document, image));
        }
    }
    Ok(images)
}

/// Opens the resolution of an image that `options` name.
fn open_image(
    folder: &Path,
    name: String,
    document: &Document,
    image: &Image,
    options: &ReadOptions,
) -> Result<Opened, ReadError> {
    let (level, levels) = (options.resolution.unwrap_or(0), image.levels.len());
    let Some(path) = image.levels.get(level).map(|level| &level.path) else {
        return Err(document.wrong(format!("it has {levels} resolutions, from 0 on, and not {level}")));
    };
    let folder: PathBuf = folder.join(path);
    let Some(document) = array_document(&folder)? else {
        return Err(ReadError::header(
            &folder,
            "the array that the image's `datasets` name is not there",
        ));
    };
    open_array(name, Array::new(&folder, &document)?, image, level, options)
}

/// Opens the volume of `array`, which is a level of `image`.
fn open_array(
    name: String,
    array: Array,
    image: &Image,
    level: usize,
    options: &ReadOptions,
) -> Result<Opened, ReadError> {
    let selection = selection(&array, &image.axes, options)?;
    options
        .budget
        .check(&array.path, (array.unit_bytes() as u64).saturating_mul(COPIES))?;
    let along = |kind: Kind| image.axes.iter().position(|axis| axis.kind == kind);
    let count = |kind: Kind| along(kind).map_or(1, |axis| array.shape[axis]);
    let mut notes = image.notes.clone();
    if image.levels.len() > 1 {
        notes.push(format!(
            "resolution {level} of {}, from 0, the finest, on",
            image.levels.len()
        ));
    }
    if count(Kind::Channel) > 1 {
        let channel = options.component.unwrap_or(0);
        notes.push(format!("channel {channel} of {}, from 0 on", count(Kind::Channel)));
    }
    let declared = Declared {
        format: FORMAT.name,
        name,
        dims: selection.of(&array.shape),
        voxel: array.element.voxel(),
        world_from_index: image.world_from_index(level, &selection),
        frames: count(Kind::Time),
        components: count(Kind::Channel),
        notes,
    };
    let path = array.path.clone();
    Opened::in_parts(path, declared, Box::new(Chunks::new(array, selection, options.budget)))
}

/// The volume of an array that `options` name.
fn selection(array: &Array, axes: &[Axis], options: &ReadOptions) -> Result<Selection, ReadError> {
    if axes.len() != array.shape.len() {
        let what = format!("it has {} axes, and the image {}", array.shape.len(), axes.len());
        return Err(ReadError::header(&array.path, what));
    }
    let mut spatial: Vec<usize> = (0..axes.len()).filter(|a| axes[*a].kind == Kind::Space).collect();
    spatial.reverse();
    let mut index = vec![0; axes.len()];
    for (axis, size) in array.shape.iter().enumerate() {
        let (asked, what, option) = match axes[axis].kind {
            Kind::Space => continue,
            Kind::Time => (options.frame, "frames", "--volume-frame"),
            Kind::Channel => (options.component, "channels", "--component"),
            Kind::Other if *size == 1 => continue,
            Kind::Other => {
                let what = format!("its axis {axis} of {size} elements is neither space, time nor channel");
                return Err(ReadError::unsupported(&array.path, what).hint("take a part of it first"));
            }
        };
        index[axis] = asked.unwrap_or(0);
        if index[axis] >= *size {
            let what = format!("it has {size} {what}, from 0 on, and not {}", index[axis]);
            return Err(ReadError::unsupported(&array.path, what).hint(format!("choose one with {option}")));
        }
    }
    Ok(Selection { spatial, index })
}
