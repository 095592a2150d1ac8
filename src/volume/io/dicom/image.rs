//! A DICOM file with pixels: its layout, what it belongs to, and where each frame's bytes, place and rescaling are.

use std::ops::Range;
use std::path::{Path, PathBuf};

use dicom_core::Tag;
use dicom_dictionary_std::tags;
use glam::DVec3;

use super::codec::{self, Codec};
use super::dataset::{Dataset, Pixels};
use super::fragments;
use super::layout::{Colour, Layout};
use super::palette::Palette;
use super::source::{Bytes, Opened, printable};
use crate::volume::io::error::{Problem, ReadError};

/// The most frames that a file may have: what is kept of each is a few hundred bytes, and its pixels may be one bit.
const MAX_FRAMES: f64 = 262_144.0;

/// A file with pixels.
#[derive(Debug)]
pub(super) struct Image {
    /// The file.
    pub path: PathBuf,
    /// The series' UID.
    pub series: String,
    /// What the series is called.
    pub description: String,
    /// The image's own UID, and its number in the series.
    pub instance: (String, i64),
    /// Whether a Siemens scanner put slices beside each other.
    pub is_mosaic: bool,
    /// The pixels' layout.
    pub layout: Layout,
    /// Its frames in their order.
    pub frames: Vec<Frame>,
    /// What should be known of how it is read.
    pub notes: Vec<String>,
    codec: Codec,
    palette: Option<Palette>,
    bytes: Bytes,
    /// Whether the bytes of uncompressed pixels come in words.
    words: bool,
}

/// A frame of a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Frame {
    /// Its first pixel's centre; `None` where nothing says it.
    pub position: Option<DVec3>,
    /// The directions in which columns and rows are counted.
    pub axes: [DVec3; 2],
    /// Millimetres between columns, and between rows.
    pub spacing: [f64; 2],
    /// Millimetres to the next slice, as the header says it.
    pub step: f64,
    /// What a stored value is multiplied with, and what is then added.
    pub rescale: [f64; 2],
    /// What orders frames at one place: points in time, echoes.
    pub order: [i64; 3],
    bytes: Place,
}

/// Where a frame's bytes are.
#[derive(Clone, Debug, PartialEq)]
struct Place {
    ranges: Vec<Range<u64>>,
    /// How many of its first bits are the frame's before.
    skip: usize,
}

impl Image {
    /// Reads the header of the file at `path`; `None` if it has no pixels.
    pub(super) fn open(path: &Path) -> Result<Option<Self>, ReadError> {
        let opened = Opened::read(path)?;
        let Some(pixels) = opened.pixels else {
            return Ok(None);
        };
        let dataset = &opened.dataset;
        let codec = Codec::of(&opened.syntax).ok_or_else(|| {
            let what = format!("pixels of transfer syntax {} are not read", printable(&opened.syntax));
            ReadError::unsupported(path, what).hint("convert it to Explicit VR Little Endian")
        })?;
        let layout = Layout::new(path, dataset, opened.order)?;
        let frames = Locator {
            path,
            opened: &opened,
            layout: &layout,
            codec,
        };
        let places = frames.places(pixels)?;
        let text = |tag| printable(&dataset.text(tag).unwrap_or_default());
        let whole = |tag| dataset.number(tag).unwrap_or(0.0) as i64;
        Ok(Some(Self {
            path: path.to_owned(),
            series: text(tags::SERIES_INSTANCE_UID),
            description: text(tags::SERIES_DESCRIPTION),
            instance: (text(tags::SOP_INSTANCE_UID), whole(tags::INSTANCE_NUMBER)),
            is_mosaic: dataset
                .text(tags::IMAGE_TYPE)
                .unwrap_or_default()
                .split('\\')
                .any(|word| word == "MOSAIC"),
            frames: frames_of(path, dataset, places)?,
            palette: (layout.colour == Colour::Palette)
                .then(|| Palette::new(path, dataset))
                .transpose()?,
            layout,
            notes: notes(dataset),
            codec,
            bytes: opened.bytes,
            words: matches!(pixels, Pixels::Native { words: true, .. }),
        }))
    }

    /// The stored values of a frame, those of a pixel together; of a palette's, luma's or an inverse image's, what they stand for.
    pub(super) fn stored(&self, frame: &Frame) -> Result<Vec<i64>, ReadError> {
        let mut bytes = self.bytes.read(&self.path, &frame.bytes.ranges)?;
        let layout = &self.layout;
        if layout.swaps(self.words) {
            bytes.chunks_exact_mut(2).for_each(<[u8]>::reverse);
        }
        let (mut values, is_rgb) = match self.codec {
            Codec::Native => (layout.native(&bytes, frame.bytes.skip), false),
            codec => codec.decode(&bytes, layout).map_err(|what| self.damaged(frame, what))?,
        };
        drop(bytes);
        if self.codec == Codec::Native && layout.planar {
            values = codec::interleaved(&values, layout);
        }
        if layout.is_inverse {
            values.iter_mut().for_each(|v| *v = layout.turned(*v));
        }
        match (&self.palette, layout.colour) {
            (Some(palette), _) => values = palette.colours(&values),
            (_, Colour::Ybr422) if self.codec == Codec::Native => values = super::palette::rgb_of_422(&values, layout),
            (_, Colour::Ybr | Colour::Ybr422) if !is_rgb => super::palette::make_rgb(&mut values, layout),
            _ => {}
        }
        Ok(values)
    }

    /// The largest value of its palette's colours.
    pub(super) fn palette_most(&self) -> Option<i64> {
        self.palette.as_ref().map(|palette| palette.most)
    }

    fn damaged(&self, frame: &Frame, what: String) -> ReadError {
        let at = frame.bytes.ranges.first().map_or(0, |range| range.start);
        ReadError::header(&self.path, format!("a frame cannot be decompressed: {what}"))
            .byte(at)
            .hint("the file is incomplete or damaged: copy or export it again")
    }
}

fn notes(dataset: &Dataset) -> Vec<String> {
    let mut notes = Vec::new();
    if !dataset.items(tags::MODALITY_LUT_SEQUENCE).is_empty() {
        notes.push("its modality lookup table is not applied: values are as stored".to_owned());
    }
    if Sayings::of(dataset, 0).spacing().is_none() {
        notes.push("the distance of pixels is not said: 1 mm is taken".to_owned());
    }
    notes
}

/// What finds frames' bytes.
struct Locator<'a> {
    path: &'a Path,
    opened: &'a Opened,
    layout: &'a Layout,
    codec: Codec,
}

impl Locator<'_> {
    /// The bytes of each frame.
    fn places(&self, pixels: Pixels) -> Result<Vec<Place>, ReadError> {
        let dataset = &self.opened.dataset;
        let frames = dataset.number(tags::NUMBER_OF_FRAMES).unwrap_or(1.0).max(1.0);
        if frames > MAX_FRAMES {
            return Err(ReadError::header(
                self.path,
                format!("{frames} frames are not believed"),
            ));
        }
        let frames = frames as u64;
        match (pixels, self.codec) {
            (Pixels::Native { offset, bytes, words }, Codec::Native) => self.native(offset, bytes, words, frames),
            (Pixels::Encapsulated { offset }, Codec::Native) => Err(ReadError::header(
                self.path,
                "its pixels are compressed, its transfer syntax says they are not",
            )
            .byte(offset)),
            (Pixels::Native { offset, .. }, _) => Err(ReadError::header(
                self.path,
                "its pixels are not compressed, its transfer syntax says they are",
            )
            .byte(offset)),
            (Pixels::Encapsulated { offset }, _) => self.encapsulated(offset, frames),
        }
    }

    fn native(&self, offset: u64, declared: u64, words: bool, frames: u64) -> Result<Vec<Place>, ReadError> {
        let bits = self.layout.native_samples() as u64 * u64::from(self.layout.allocated);
        let expected = frames.saturating_mul(bits).div_ceil(8);
        let found = declared.min(self.opened.bytes.len().saturating_sub(offset));
        if found < expected {
            return Err(ReadError::new(self.path, Problem::Truncated { expected, found }).byte(offset));
        }
        // Bytes that are swapped in pairs are read in pairs.
        let unit = if self.layout.swaps(words) { 16 } else { 8 };
        let frame = |i: u64| {
            let first = i * bits / unit * (unit / 8);
            let end = ((i + 1) * bits).div_ceil(unit) * (unit / 8);
            let range = offset + first..offset + end.min(found);
            Place {
                ranges: vec![range],
                skip: (i * bits % unit) as usize,
            }
        };
        Ok((0..frames).map(frame).collect())
    }

    fn encapsulated(&self, offset: u64, frames: u64) -> Result<Vec<Place>, ReadError> {
        let Opened { dataset, bytes, .. } = self.opened;
        let table: Vec<u64> = dataset
            .numbers(tags::EXTENDED_OFFSET_TABLE)
            .iter()
            .map(|&v| v as u64)
            .collect();
        let frames = fragments::frames(self.path, bytes, offset, frames as usize, &table)?;
        let samples = (self.layout.pixels() * self.layout.samples) as u64;
        for ranges in &frames {
            let compressed = ranges.iter().map(|r| r.end - r.start).sum();
            if samples > self.codec.can_hold(compressed) {
                let expected = samples * u64::from(self.layout.allocated) / 8;
                let at = ranges.first().map_or(offset, |r| r.start);
                return Err(ReadError::new(self.path, Problem::Implausible { expected, compressed }).byte(at));
            }
        }
        Ok(frames.into_iter().map(|ranges| Place { ranges, skip: 0 }).collect())
    }
}

/// The data sets that say something of a frame, the most particular first: the frame's functional groups, the shared ones, a
/// detector's, the image's.
struct Sayings<'a> {
    groups: Vec<&'a Dataset>,
    image: &'a Dataset,
}

impl<'a> Sayings<'a> {
    fn of(image: &'a Dataset, frame: usize) -> Self {
        let per_frame = image.items(tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE).get(frame);
        let shared = image.items(tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE).first();
        Self {
            groups: per_frame.into_iter().chain(shared).collect(),
            image,
        }
    }

    /// What `get` finds in the first item of the macro `group`, or in the image itself.
    fn find<T>(&self, group: Tag, get: impl Fn(&Dataset) -> Option<T>) -> Option<T> {
        let groups = self.groups.iter().filter_map(|groups| groups.items(group).first());
        let detector = self.image.items(tags::DETECTOR_INFORMATION_SEQUENCE).first();
        groups.chain([self.image]).chain(detector).find_map(get)
    }

    /// Millimetres between rows, and between columns; those on a detector, or of a scan, if none of the object are known.
    fn spacing(&self) -> Option<[f64; 2]> {
        self.find(tags::PIXEL_MEASURES_SEQUENCE, |d| d.vector::<2>(tags::PIXEL_SPACING))
            .or_else(|| self.image.vector(tags::IMAGER_PIXEL_SPACING))
            .or_else(|| self.image.vector(tags::NOMINAL_SCANNED_PIXEL_SPACING))
            .filter(|spacing| spacing.iter().all(|&v| v > 0.0))
    }
}

fn frames_of(path: &Path, dataset: &Dataset, places: Vec<Place>) -> Result<Vec<Frame>, ReadError> {
    let offsets = dataset.numbers(tags::GRID_FRAME_OFFSET_VECTOR);
    let slices = dataset.numbers(tags::SLICE_VECTOR);
    let several = places.len() > 1;
    let mut frames = Vec::new();
    for (i, place) in places.into_iter().enumerate() {
        let sayings = Sayings::of(dataset, i);
        let mut frame = frame(path, &sayings, place)?;
        let own = sayings
            .groups
            .iter()
            .any(|g| !g.items(tags::PLANE_POSITION_SEQUENCE).is_empty());
        if several && !own {
            let normal = frame.axes[0].cross(frame.axes[1]);
            let along = match (offsets.get(i).zip(offsets.first()), slices.get(i)) {
                (Some((offset, first)), _) => offset - first,
                (None, Some(slice)) => (slice - 1.0) * frame.step,
                (None, None) => i as f64 * frame.step,
            };
            frame.position = Some(frame.position.unwrap_or_default() + normal * along);
        }
        frame.order[2] = i as i64;
        frames.push(frame);
    }
    Ok(frames)
}

fn frame(path: &Path, sayings: &Sayings, bytes: Place) -> Result<Frame, ReadError> {
    let image = sayings.image;
    let spacing = sayings.spacing().unwrap_or([1.0; 2]);
    let step = sayings.find(tags::PIXEL_MEASURES_SEQUENCE, |d| {
        d.number(tags::SPACING_BETWEEN_SLICES)
    });
    let axes = sayings.find(tags::PLANE_ORIENTATION_SEQUENCE, |d| {
        d.vector(tags::IMAGE_ORIENTATION_PATIENT)
    });
    let position = sayings.find(tags::PLANE_POSITION_SEQUENCE, |d| {
        d.vector(tags::IMAGE_POSITION_PATIENT)
    });
    let transformation = |tag| sayings.find(tags::PIXEL_VALUE_TRANSFORMATION_SEQUENCE, |d| d.number(tag));
    let slope = transformation(tags::RESCALE_SLOPE).or_else(|| image.number(tags::DOSE_GRID_SCALING));
    let whole = |tag| image.number(tag).unwrap_or(0.0) as i64;
    let time = sayings.find(tags::FRAME_CONTENT_SEQUENCE, |d| {
        d.number(tags::TEMPORAL_POSITION_INDEX)
    });
    Ok(Frame {
        position: position.map(DVec3::from_array),
        axes: unit_axes(path, axes.unwrap_or([1.0, 0.0, 0.0, 0.0, 1.0, 0.0]))?,
        // The file's order is down a column first.
        spacing: [spacing[1], spacing[0]],
        step: step.map(f64::abs).filter(|&v| v > 0.0).unwrap_or(1.0),
        rescale: [
            slope.filter(|&v| v != 0.0).unwrap_or(1.0),
            transformation(tags::RESCALE_INTERCEPT).unwrap_or(0.0),
        ],
        order: [time.unwrap_or(0.0) as i64, whole(tags::INSTANCE_NUMBER), 0],
        bytes,
    })
}

fn unit_axes(path: &Path, [a, b, c, d, e, f]: [f64; 6]) -> Result<[DVec3; 2], ReadError> {
    let [x, y] = [DVec3::new(a, b, c), DVec3::new(d, e, f)].map(|v| v.normalize_or_zero());
    // A thousandth: below, the axes are one, and no writer rounds so badly.
    match x.cross(y).length() > 1e-3 {
        true => Ok([x, y]),
        false => Err(ReadError::header(
            path,
            format!("its axes ({a}, {b}, {c}) and ({d}, {e}, {f}) do not span a plane"),
        )),
    }
}
