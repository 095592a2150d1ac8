//! The pages of a file, which have one layout, and how they are read.
//!
//! *Practice.* A file may declare any size, and any number of pages on the same bytes. All pages together are held against the
//! file's bytes, and the best ratio of a compression, before one is decoded; a page's room is made when it is read.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use tiff::TiffError;
use tiff::decoder::ifd::Value;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::{
    ByteOrder as TiffOrder, CompressionMethod, PlanarConfiguration, SampleFormat, Tag, Type, ValueBuffer,
};

use super::lzw_tiles::LzwTiles;
use super::page::Layout;
use super::shown::Shown;
use crate::volume::grid::Voxels;
use crate::volume::io::error::{Problem, ReadError};
use crate::volume::io::stored::{ByteOrder, Stored, decode};

/// No compression that is read makes less of so many bytes than one: the best is Zstandard's, four bytes for 128 KiB that are equal.
const MAX_RATIO: u64 = 1 << 15;

/// How many slices a page holds, and a tile: SGI's tags of volumes in one page.
const DEPTHS: [Tag; 2] = [Tag::Unknown(32997), Tag::Unknown(32998)];

/// The largest page that is believed, bytes.
const MAX_PAGE: u64 = 1 << 32;

/// How dense pixels lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Resolution {
    /// Pixels along x and y in a unit, which ImageJ gives itself.
    pub pixels: [Option<f64>; 2],
    /// The unit, millimetres, where the file itself gives one.
    unit_mm: Option<f64>,
}

impl Resolution {
    /// Millimetres between pixels, as far as they are known. What programs write that know nothing, 72 or 96 pixels an inch, is
    /// nothing.
    pub(super) fn millimetres(&self) -> [Option<f64>; 3] {
        let is_screen = |n: f64| self.unit_mm == Some(25.4) && (n == 72.0 || n == 96.0);
        let [x, y] = self.pixels.map(|n| Some(self.unit_mm? / n.filter(|n| !is_screen(*n))?));
        [x, y, None]
    }
}

/// Planes that lie one behind the other, without compression.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contiguous {
    /// The first one's first byte.
    pub start: u64,
    /// Bytes of the file.
    pub length: u64,
    stored: Stored,
    order: ByteOrder,
}

impl Contiguous {
    /// Whether the file has `count` numbers.
    pub(super) fn check(&self, path: &Path, count: usize) -> Result<(), ReadError> {
        let expected = (count as u64).saturating_mul(self.stored.bytes() as u64);
        let found = self.length.saturating_sub(self.start);
        match found < expected {
            true => Err(ReadError::new(path, Problem::Truncated { expected, found })),
            false => Ok(()),
        }
    }

    /// `count` numbers of the file at `path`, from the one numbered `first` on.
    pub(super) fn read(&self, path: &Path, first: usize, count: usize) -> Result<Voxels, ReadError> {
        let io_error = |e| ReadError::io(path, e);
        let mut file = File::open(path).map_err(io_error)?;
        let before = (first as u64).saturating_mul(self.stored.bytes() as u64);
        file.seek(SeekFrom::Start(self.start.saturating_add(before)))
            .map_err(io_error)?;
        decode(path, self.stored, self.order, count, |bytes| {
            file.read_exact(bytes).map_err(io_error)
        })
    }
}

/// The pages that are read.
pub(super) struct Pages {
    path: PathBuf,
    decoder: Decoder<Shown<BufReader<File>>>,
    /// Their places among the file's directories.
    directories: Vec<usize>,
    /// Whether any is compressed.
    is_compressed: bool,
    /// Bytes of the file.
    length: u64,
    pub layout: Layout,
    /// What the first page says of itself.
    pub description: String,
    pub resolution: Resolution,
    /// Where planes would follow the first page's.
    pub contiguous: Option<Contiguous>,
}

impl Pages {
    pub(super) fn open(path: &Path) -> Result<Self, ReadError> {
        let file = File::open(path).map_err(|e| ReadError::io(path, e))?;
        let length = file.metadata().map_err(|e| ReadError::io(path, e))?.len();
        let mut decoder = Decoder::new(Shown::new(BufReader::new(file))).map_err(|e| error(path, 0, e))?;
        let mut limits = Limits::default();
        limits.ifd_value_size = usize::try_from(length).unwrap_or(usize::MAX);
        limits.intermediate_buffer_size = limits.ifd_value_size;
        limits.decoding_buffer_size =
            usize::try_from(MAX_PAGE.min(length.saturating_mul(MAX_RATIO))).unwrap_or(usize::MAX);
        decoder = decoder.with_limits(limits);
        let mut first = None;
        let (mut directories, mut is_compressed) = (Vec::new(), false);
        for directory in 0.. {
            let at = |e| error(path, directory, e);
            if directory > 0 && !decoder.more_images() {
                break;
            }
            see(&mut decoder, directory).map_err(at)?;
            if is_reduced(&mut decoder).map_err(at)? {
                continue;
            }
            if is_deep(&mut decoder).map_err(at)? {
                return Err(unsupported(
                    path,
                    directory,
                    "pages of several slices (ImageDepth) are not read",
                ));
            }
            let layout = layout(&mut decoder).map_err(|e| unsupported(path, directory, &e))?;
            match &first {
                None => first = Some((layout, directory)),
                Some((known, _)) if *known != layout => return Err(differs(path, directory, known, &layout)),
                Some(_) => {}
            }
            let compression = decoder.find_tag_unsigned(Tag::Compression).map_err(at)?;
            is_compressed |= compression.is_some_and(|method: u16| method != CompressionMethod::None.to_u16());
            directories.push(directory);
        }
        let (layout, directory) =
            first.ok_or_else(|| ReadError::unsupported(path, "it holds no page of full resolution"))?;
        let at = |e| error(path, directory, e);
        see(&mut decoder, directory).map_err(at)?;
        let mut pages = Self {
            path: path.to_owned(),
            description: description(&mut decoder, length).map_err(at)?,
            resolution: resolution(&mut decoder).map_err(at)?,
            contiguous: None,
            decoder,
            directories,
            is_compressed,
            length,
            layout,
        };
        pages.contiguous = pages.behind_first().map_err(at)?;
        Ok(pages)
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.directories.len()
    }

    /// Which of them is the file's directory of this number.
    pub(super) fn index(&self, directory: usize) -> Option<usize> {
        self.directories.binary_search(&directory).ok()
    }

    /// Whether the file can hold so many pages.
    pub(super) fn check(&self, count: usize) -> Result<(), ReadError> {
        let expected = self.layout.bytes().saturating_mul(count as u64);
        let found = self.length;
        if self.layout.bytes() > MAX_PAGE {
            return Err(ReadError::new(&self.path, Problem::Memory(self.layout.bytes())));
        }
        match self.is_compressed {
            false if expected > found => Err(ReadError::new(&self.path, Problem::Truncated { expected, found })),
            true if expected / MAX_RATIO > found => Err(ReadError::new(
                &self.path,
                Problem::Implausible {
                    expected,
                    compressed: found,
                },
            )),
            _ => Ok(()),
        }
    }

    /// The numbers of a page, pixel after pixel.
    pub(super) fn read(&mut self, page: usize) -> Result<Voxels, ReadError> {
        self.check(1)?;
        let directory = self.directories[page];
        let mut pixels = DecodingResult::U8(Vec::new());
        let decoder = &mut self.decoder;
        let at = |e| error(&self.path, directory, e);
        see(decoder, directory).map_err(at)?;
        match LzwTiles::of(decoder, &self.layout).map_err(at)? {
            Some(tiles) => {
                let read = tiles.read(decoder.inner(), &self.layout);
                pixels = read.map_err(|e| at(TiffError::IoError(e)))?;
            }
            None => {
                decoder.read_image_to_buffer(&mut pixels).map_err(at)?;
            }
        }
        let numbers = self.layout.numbers(pixels);
        let (expected, found) = (self.layout.pixels() * self.layout.samples, numbers.len());
        match expected == found {
            true => Ok(numbers),
            false => Err(unsupported(
                &self.path,
                directory,
                &format!("it has {found} numbers instead of {expected}"),
            )),
        }
    }

    /// Where planes would follow the first page's, if that is not compressed and in one piece.
    fn behind_first(&mut self) -> Result<Option<Contiguous>, TiffError> {
        if self.is_compressed || self.layout.is_planar || self.layout.bits < 8 {
            return Ok(None);
        }
        let offsets: Vec<u64> = self
            .decoder
            .find_tag_unsigned_vec(Tag::StripOffsets)?
            .unwrap_or_default();
        let sizes: Vec<u64> = self
            .decoder
            .find_tag_unsigned_vec(Tag::StripByteCounts)?
            .unwrap_or_default();
        let ends = offsets
            .iter()
            .zip(&sizes)
            .map(|(offset, size)| offset.saturating_add(*size));
        let is_one = offsets.iter().skip(1).zip(ends).all(|(next, end)| *next == end);
        let order = match self.decoder.byte_order() {
            TiffOrder::LittleEndian => ByteOrder::Little,
            TiffOrder::BigEndian => ByteOrder::Big,
        };
        let half = self.layout.bits == 16 && self.layout.stored.bytes() == 4;
        Ok(offsets.first().filter(|_| is_one && !half).map(|&start| Contiguous {
            start,
            length: self.length,
            stored: self.layout.stored,
            order,
        }))
    }
}

/// Moves on to a directory. Palettes and images in which white is 0 are shown as images in which black is 0.
fn see<R: Read + Seek>(decoder: &mut Decoder<Shown<R>>, directory: usize) -> Result<(), TiffError> {
    decoder.inner().show(None);
    decoder.seek_to_image(directory)?;
    let photometry: Option<u16> = decoder.find_tag_unsigned(Tag::PhotometricInterpretation)?;
    if let Some(0 | 3) = photometry {
        let place = photometry_place(decoder)?;
        decoder.inner().show(place);
        decoder.seek_to_image(directory)?;
    }
    Ok(())
}

/// The bytes that say that black is 0, where this directory says something else, if it has room for them.
fn photometry_place<R: Read + Seek>(decoder: &mut Decoder<Shown<R>>) -> Result<Option<(u64, [u8; 2])>, TiffError> {
    let Some(pointer) = decoder.ifd_pointer() else {
        return Ok(None);
    };
    decoder.inner().seek(SeekFrom::Start(0))?;
    let (order, mut version) = (decoder.byte_order(), [0; 4]);
    decoder.inner().read_exact(&mut version)?;
    let is_big = version[2..].contains(&43);
    decoder.goto_offset_u64(pointer.0)?;
    let (entries, head, size) = match is_big {
        true => (decoder.read_long8()?, 8, 20),
        false => (u64::from(decoder.read_short()?), 2, 12),
    };
    for entry in 0..entries {
        let at = pointer.0.saturating_add(head + entry * size);
        decoder.goto_offset_u64(at)?;
        let (tag, kind) = (decoder.read_short()?, decoder.read_short()?);
        if tag == Tag::PhotometricInterpretation.to_u16() && kind == Type::SHORT.to_u16() {
            let one = match order {
                TiffOrder::LittleEndian => 1_u16.to_le_bytes(),
                TiffOrder::BigEndian => 1_u16.to_be_bytes(),
            };
            return Ok(Some((at + if is_big { 12 } else { 8 }, one)));
        }
    }
    Ok(None)
}

/// Whether the page is a smaller copy of another, or a mask.
fn is_reduced<R: Read + Seek>(decoder: &mut Decoder<R>) -> Result<bool, TiffError> {
    let new: Option<u32> = decoder.find_tag_unsigned(Tag::NewSubfileType)?;
    let old: Option<u16> = decoder.find_tag_unsigned(Tag::SubfileType)?;
    Ok(new.is_some_and(|flags| flags & 0b101 != 0) || (new.is_none() && old == Some(2)))
}

/// Whether the page holds several slices.
fn is_deep<R: Read + Seek>(decoder: &mut Decoder<R>) -> Result<bool, TiffError> {
    for tag in DEPTHS {
        let depth: Option<u32> = decoder.find_tag_unsigned(tag)?;
        if depth.is_some_and(|depth| depth > 1) {
            return Ok(true);
        }
    }
    Ok(false)
}

fn layout<R: Read + Seek>(decoder: &mut Decoder<R>) -> Result<Layout, String> {
    let text = |e: TiffError| e.to_string();
    let dims = decoder.dimensions().map_err(text)?;
    let color = decoder.colortype().map_err(text)?;
    let formats: Option<Vec<u16>> = decoder.find_tag_unsigned_vec(Tag::SampleFormat).map_err(text)?;
    let format = formats.and_then(|all| all.first().copied()).unwrap_or(1);
    let planar: Option<u16> = decoder.find_tag_unsigned(Tag::PlanarConfiguration).map_err(text)?;
    let is_planar = planar == Some(PlanarConfiguration::Planar.to_u16());
    Layout::new(dims, color, &SampleFormat::from_u16_exhaustive(format), is_planar)
}

/// The page's description, in a file of so many bytes. The crate would make room for any length that is declared.
fn description<R: Read + Seek>(decoder: &mut Decoder<R>, length: u64) -> Result<String, TiffError> {
    let mut value = ValueBuffer::empty(Type::ASCII);
    let mut directory = decoder.image_ifd();
    let entry = directory.find_entry(Tag::ImageDescription);
    if entry.is_some_and(|entry| entry.count() > length) {
        return Err(TiffError::LimitsExceeded);
    }
    let found = directory.find_tag_buf(Tag::ImageDescription, &mut value)?;
    let bytes = if found.is_some() { value.as_bytes() } else { &[] };
    let text = String::from_utf8(bytes.to_vec()).unwrap_or_else(|_| bytes.iter().map(|b| char::from(*b)).collect());
    Ok(text.trim_end_matches('\0').to_owned())
}

fn resolution<R: Read + Seek>(decoder: &mut Decoder<R>) -> Result<Resolution, TiffError> {
    let mut pixels = [None; 2];
    for (pixels, tag) in pixels.iter_mut().zip([Tag::XResolution, Tag::YResolution]) {
        if let Some(Value::Rational(n, d)) = decoder.find_tag(tag)? {
            *pixels = Some(f64::from(n) / f64::from(d)).filter(|n| n.is_normal());
        }
    }
    let unit: Option<u16> = decoder.find_tag_unsigned(Tag::ResolutionUnit)?;
    let unit_mm = match unit {
        None | Some(2) => Some(25.4),
        Some(3) => Some(10.0),
        Some(_) => None,
    };
    Ok(Resolution { pixels, unit_mm })
}

fn differs(path: &Path, directory: usize, known: &Layout, layout: &Layout) -> ReadError {
    let ([x, y], [w, h]) = (layout.dims, known.dims);
    let what = match layout.dims == known.dims {
        true => "other pixels than the first page".to_owned(),
        false => format!("{x} x {y} pixels, the first {w} x {h}"),
    };
    unsupported(path, directory, &format!("it has {what}"))
        .hint("keep pages of one size and type, and put others in files of their own")
}

fn unsupported(path: &Path, directory: usize, what: &str) -> ReadError {
    ReadError::unsupported(path, format!("page {}: {what}", directory + 1))
        .hint("save it as grey or RGB, of 8, 16 or 32 bits")
}

fn error(path: &Path, directory: usize, error: TiffError) -> ReadError {
    let page = directory + 1;
    match error {
        TiffError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
            ReadError::header(path, format!("page {page}: the file ends before its data"))
                .hint("copy or export it again")
        }
        TiffError::IoError(e) => ReadError::io(path, e),
        TiffError::UnsupportedError(e) => unsupported(path, directory, &e.to_string()),
        other => ReadError::header(path, format!("page {page}: {other}")).hint("copy or export it again"),
    }
}
