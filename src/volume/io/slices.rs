//! Slices in files of their own, in one folder: TIFF, PNG or JPEG; and a PNG or JPEG file, as a volume of one slice.
//!
//! *Practice.* Files are in the order of the numbers in their names, 2 before 10. Of a folder with several kinds of images, those of
//! which there are most are the slices. A slice is read when its turn comes.

use std::cmp::{Ordering, Reverse};
use std::fs::File;
use std::path::{Path, PathBuf};

use glam::{DAffine3, DVec3};
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};

use super::budget::Budget;
use super::components::Components;
use super::error::{Problem, ReadError};
use super::format::Format;
use super::open::{Declared, Opened, ReadOptions};
use super::tiff;
use crate::volume::grid::Voxels;

/// Kinds of images, by the ends of their names.
const KINDS: [&[&str]; 3] = [&[".tif", ".tiff"], &[".png"], &[".jpg", ".jpeg"]];

/// Bytes of pixels, as they are stored, for a byte of the file: deflate's best ratio. JPEG's is 1024, of blocks of 64 samples in a bit,
/// half of whose colours' rows and columns are left out.
const BEST_RATIO: u64 = 1032;

/// Folders of slices among the formats.
pub(super) const FORMAT: Format = Format {
    name: "slices",
    suffixes: &[".png", ".jpg", ".jpeg"],
    reads: "a folder of TIFF, PNG or JPEG slices, in the order of the numbers in their names; one PNG or JPEG",
    recognises: |probe| match probe.is_folder {
        true => files(&probe.path).is_ok_and(|(files, _)| !files.is_empty()),
        false => !probe.has_layout && probe.is_named(&FORMAT),
    },
    open: |path, options| Ok(vec![open(path, options)?]),
    writer: None,
};

/// Pixels of one image.
pub(super) struct Picture {
    /// Pixels along x and y.
    pub dims: [usize; 2],
    pub components: Components,
    /// All numbers, pixel after pixel.
    pub numbers: Voxels,
}

fn open(path: &Path, options: &ReadOptions) -> Result<Opened, ReadError> {
    let (files, others) = match path.is_dir() {
        true => files(path).map_err(|e| ReadError::io(path, e))?,
        false => (vec![path.to_owned()], 0),
    };
    let Some(first_file) = files.first() else {
        return Err(ReadError::unsupported(path, "it holds no slice"));
    };
    let (first, spacing) = picture(first_file, options)?;
    let mut notes = Vec::new();
    if others > 0 {
        notes.push(format!("{others} images of other kinds are left out"));
    }
    let [dx, dy, _] = spacing;
    let [x, y] = [dx.or(dy).unwrap_or(1.0), dy.or(dx).unwrap_or(1.0)];
    notes.push(match dx.or(dy) {
        None => "slices give no size of a pixel: voxels are taken to be cubes of 1 mm".to_owned(),
        Some(_) => format!("slices give no distance between them: it is taken to be that of columns, {x} mm"),
    });
    let kind = Kind::of(&first);
    let declared = Declared {
        format: FORMAT.name,
        name: String::new(),
        dims: [first.dims[0], first.dims[1], files.len()],
        voxel: first.components.voxel(first.numbers.voxel_type()),
        world_from_index: DAffine3::from_scale(DVec3::new(x, y, x)),
        frames: 1,
        components: first.components.count(),
        notes,
    };
    let (mut first, options) = (Some(first), options.clone());
    let chunks = files.into_iter().map(move |file| {
        let picture = match first.take() {
            Some(first) => first,
            None => picture(&file, &options)?.0,
        };
        kind.check(&file, &picture)?;
        Ok(picture.components.one(picture.numbers))
    });
    Opened::new(path.to_owned(), declared, Box::new(chunks))
}

/// What slices of one volume have in common.
#[derive(PartialEq)]
struct Kind {
    dims: [usize; 2],
    components: Components,
    voxel: crate::volume::VoxelType,
}

impl Kind {
    fn of(picture: &Picture) -> Self {
        Self {
            dims: picture.dims,
            components: picture.components,
            voxel: picture.numbers.voxel_type(),
        }
    }

    /// Whether the picture in the file at `path` is like the first.
    fn check(&self, path: &Path, picture: &Picture) -> Result<(), ReadError> {
        let other = Self::of(picture);
        if other == *self {
            return Ok(());
        }
        let text = |kind: &Self| {
            let ([x, y], count) = (kind.dims, kind.components.count());
            format!("{x} x {y} pixels of {count} {}", kind.voxel.name())
        };
        let what = format!("it has {}, the first slice {}", text(&other), text(self));
        Err(ReadError::unsupported(path, what).hint("keep slices of one size and type in a folder of their own"))
    }
}

/// The slices in the folder at `path`, in their order, and how many other images there are.
fn files(path: &Path) -> std::io::Result<(Vec<PathBuf>, usize)> {
    let mut kinds = [const { Vec::new() }; KINDS.len()];
    for entry in path.read_dir()? {
        let file = entry?.path();
        let name = file
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .to_ascii_lowercase();
        let kind = KINDS.iter().position(|ends| ends.iter().any(|end| name.ends_with(end)));
        if let (Some(kind), false) = (kind, name.starts_with('.')) {
            kinds[kind].push((name, file));
        }
    }
    kinds.sort_by_key(|files| Reverse(files.len()));
    let others = kinds[1..].iter().map(Vec::len).sum();
    let mut slices = std::mem::take(&mut kinds[0]);
    slices.sort_by(|(a, _), (b, _)| natural(a, b));
    Ok((slices.into_iter().map(|(_, file)| file).collect(), others))
}

/// The order of names in which runs of digits are numbers.
fn natural(a: &str, b: &str) -> Ordering {
    let (mut rest_a, mut rest_b) = (a, b);
    while let (Some(x), Some(y)) = (rest_a.chars().next(), rest_b.chars().next()) {
        let order = if x.is_ascii_digit() && y.is_ascii_digit() {
            let (n, m) = (digits(&mut rest_a), digits(&mut rest_b));
            // Without leading zeros, the longer number is the larger.
            n.len().cmp(&m.len()).then(n.cmp(m))
        } else {
            (rest_a, rest_b) = (&rest_a[x.len_utf8()..], &rest_b[y.len_utf8()..]);
            x.cmp(&y)
        };
        if order.is_ne() {
            return order;
        }
    }
    rest_a.len().cmp(&rest_b.len()).then_with(|| a.cmp(b))
}

/// Takes the digits off the start of `text`; they without leading zeros.
fn digits<'a>(text: &mut &'a str) -> &'a str {
    let end = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let (number, rest) = text.split_at(end);
    *text = rest;
    number.trim_start_matches('0')
}

/// The image in the file at `path`, and millimetres between its pixels, as far as they are known.
fn picture(path: &Path, options: &ReadOptions) -> Result<(Picture, [Option<f64>; 3]), ReadError> {
    let name = path.to_string_lossy().to_ascii_lowercase();
    if KINDS[0].iter().any(|end| name.ends_with(end)) {
        return tiff::picture(path, options);
    }
    let image = decoded(path, options.budget)?;
    let (dims, count) = (
        [image.width() as usize, image.height() as usize],
        image.color().channel_count(),
    );
    let numbers = match image {
        DynamicImage::ImageLuma8(image) => Voxels::U8(image.into_raw()),
        DynamicImage::ImageLumaA8(image) => Voxels::U8(image.into_raw()),
        DynamicImage::ImageRgb8(image) => Voxels::U8(image.into_raw()),
        DynamicImage::ImageRgba8(image) => Voxels::U8(image.into_raw()),
        DynamicImage::ImageLuma16(image) => Voxels::U16(image.into_raw()),
        DynamicImage::ImageLumaA16(image) => Voxels::U16(image.into_raw()),
        DynamicImage::ImageRgb16(image) => Voxels::U16(image.into_raw()),
        DynamicImage::ImageRgba16(image) => Voxels::U16(image.into_raw()),
        other => {
            return Err(ReadError::unsupported(
                path,
                format!("pixels of {:?} are not read", other.color()),
            ));
        }
    };
    // Of grey with an opacity, the grey.
    let chosen = options.component.or((count == 2).then_some(0));
    let picture = Picture {
        dims,
        components: Components::new(path, usize::from(count), chosen)?,
        numbers,
    };
    Ok((picture, [None; 3]))
}

/// The PNG or JPEG image in the file at `path`, whose size is held against the file's bytes and the budget first.
fn decoded(path: &Path, budget: Budget) -> Result<DynamicImage, ReadError> {
    let io_error = |e| ReadError::io(path, e);
    let length = File::open(path).and_then(|f| f.metadata()).map_err(io_error)?.len();
    let reader = ImageReader::open(path).and_then(ImageReader::with_guessed_format);
    let mut reader = reader.map_err(io_error)?;
    if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg)) {
        return Err(ReadError::unsupported(
            path,
            "it is neither PNG nor JPEG, whatever its name says",
        ));
    }
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(budget.bytes());
    reader.limits(limits);
    let image_error = |e| match e {
        ImageError::IoError(e) if e.kind() != std::io::ErrorKind::UnexpectedEof => ReadError::io(path, e),
        ImageError::Limits(_) => ReadError::unsupported(path, "it is too large an image"),
        e => ReadError::header(path, e.to_string()).hint("copy or export it again"),
    };
    let decoder = reader.into_decoder().map_err(image_error)?;
    let (width, height) = decoder.dimensions();
    let bits = u64::from(decoder.original_color_type().bits_per_pixel());
    let expected = (u64::from(width) * u64::from(height)).saturating_mul(bits) / 8;
    if expected / BEST_RATIO > length {
        let compressed = length;
        return Err(ReadError::new(path, Problem::Implausible { expected, compressed }));
    }
    budget.check(path, decoder.total_bytes())?;
    DynamicImage::from_decoder(decoder).map_err(image_error)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_names_are_numbers() {
        let mut names = ["s10.png", "s2.png", "s1.png", "s02b.png", "r9.png", "s2.png.png"];
        names.sort_by(|a, b| natural(a, b));
        assert_eq!(
            names,
            ["r9.png", "s1.png", "s2.png", "s2.png.png", "s02b.png", "s10.png"]
        );
        assert_eq!(natural("a1", "a01"), natural("a1", "a01"));
        assert_eq!(natural("a1", "a1"), Ordering::Equal);
    }
}
