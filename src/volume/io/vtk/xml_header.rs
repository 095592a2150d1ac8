//! The markup of a VTK XML file, without its data: which arrays there are, and where.
//!
//! *Practice.* Inline data is passed over, not kept, and appended data is not looked at, so a header costs as much memory as its
//! markup. Raw appended data is no XML: the parser stops before it.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::ops::Range;
use std::path::Path;
use std::str::FromStr;

use glam::{DMat3, DVec3};
use quick_xml::Reader;
use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};

use super::bits::BIT;
use super::{Array, Extent, Lattice, Of};
use crate::volume::io::error::ReadError;
use crate::volume::io::stored::{ByteOrder, Stored};
use crate::volume::voxel::VoxelType;

/// What compresses blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Compressor {
    Zlib,
    Lz4,
    Lzma,
}

/// The whole numbers before an array's bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Words {
    /// Whether they have 64 bits instead of 32.
    wide: bool,
    pub order: ByteOrder,
}

impl Words {
    /// Bytes of one.
    pub(super) fn bytes(self) -> usize {
        if self.wide { 8 } else { 4 }
    }

    /// The words in `bytes`.
    pub(super) fn all(self, bytes: &[u8]) -> impl Iterator<Item = u64> {
        bytes.chunks_exact(self.bytes()).map(move |word| {
            let shifted = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
            match self.order {
                ByteOrder::Little => word.iter().rev().fold(0, shifted),
                ByteOrder::Big => word.iter().fold(0, shifted),
            }
        })
    }

    /// The next words of `stream`.
    pub(super) fn read<const N: usize>(self, stream: &mut impl Read) -> io::Result<[u64; N]> {
        let mut bytes = vec![0; N * self.bytes()];
        stream.read_exact(&mut bytes)?;
        let mut words = self.all(&bytes);
        Ok(std::array::from_fn(|_| words.next().unwrap_or(0)))
    }
}

/// Where an array's data is.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Content {
    /// Numbers in text, at these bytes of the file.
    Ascii(Range<u64>),
    /// Base64, at these bytes of the file.
    Inline(Range<u64>),
    /// So far behind the start of what is appended.
    Appended(u64),
}

/// A part of the image.
pub(super) struct Piece {
    pub extent: Extent,
    pub arrays: Vec<(Array, Content)>,
}

/// What is appended to the markup.
#[derive(Clone, Copy)]
pub(super) struct Appended {
    /// Its first byte in the file.
    pub start: u64,
    pub is_base64: bool,
}

/// The markup.
pub(super) struct Header {
    pub words: Words,
    pub compressor: Option<Compressor>,
    pub lattice: Lattice,
    pub pieces: Vec<Piece>,
    /// Of a parallel file, the files of its pieces.
    pub sources: Vec<String>,
    pub appended: Option<Appended>,
}

impl Header {
    pub(super) fn read(path: &Path) -> Result<Self, ReadError> {
        let file = File::open(path).map_err(|e| ReadError::io(path, e))?;
        let mut parser = Parser {
            path,
            xml: Reader::from_reader(BufReader::new(file)),
            file: None,
            lattice: None,
            pieces: Vec::new(),
            sources: Vec::new(),
            of: None,
            active: None,
            appended: None,
        };
        parser.xml.config_mut().check_end_names = false;
        parser.run()?;
        let missing = |what: &str| ReadError::header(path, format!("it has no {what}"));
        let (words, compressor) = parser.file.ok_or_else(|| missing("VTKFile element"))?;
        Ok(Self {
            words,
            compressor,
            lattice: parser.lattice.ok_or_else(|| missing("ImageData element"))?,
            pieces: parser.pieces,
            sources: parser.sources,
            appended: parser.appended,
        })
    }
}

struct Parser<'a> {
    path: &'a Path,
    xml: Reader<BufReader<File>>,
    file: Option<(Words, Option<Compressor>)>,
    lattice: Option<Lattice>,
    pieces: Vec<Piece>,
    sources: Vec<String>,
    /// What the arrays that follow belong to.
    of: Option<Of>,
    /// The one of them that is meant.
    active: Option<String>,
    appended: Option<Appended>,
}

impl Parser<'_> {
    fn run(&mut self) -> Result<(), ReadError> {
        let mut buffer = Vec::new();
        while self.appended.is_none() {
            buffer.clear();
            let event = self.xml.read_event_into(&mut buffer);
            let at = self.xml.error_position();
            match event.map_err(|e| ReadError::header(self.path, format!("it is no XML: {e}")).byte(at))? {
                Event::Start(element) => self.start(&element, true)?,
                Event::Empty(element) => self.start(&element, false)?,
                Event::End(element) if matches!(element.name().as_ref(), "PointData" | "CellData" | "Piece") => {
                    self.of = None;
                }
                Event::Eof => break,
                _ => {}
            }
        }
        Ok(())
    }

    /// An element begins, which has content or none.
    fn start(&mut self, element: &BytesStart, has_content: bool) -> Result<(), ReadError> {
        let at = self.xml.buffer_position();
        let element = Element {
            path: self.path,
            at,
            element,
        };
        match element.element.name().as_ref() {
            "VTKFile" => self.file = Some(file(&element)?),
            "ImageData" | "PImageData" => self.lattice = Some(lattice(&element)?),
            "Piece" => match element.get("Source")? {
                Some(source) => self.sources.push(source),
                None => self.pieces.push(Piece {
                    extent: element.extent("Extent")?,
                    arrays: Vec::new(),
                }),
            },
            "PointData" => self.enter(Of::Points, &element, has_content)?,
            "CellData" => self.enter(Of::Cells, &element, has_content)?,
            "DataArray" => self.array(&element, has_content)?,
            "AppendedData" => {
                let is_base64 = element.get("encoding")?.as_deref() != Some("raw");
                let start = self.underscore().map_err(|e| ReadError::io(self.path, e))?;
                self.appended = Some(Appended { start, is_base64 });
            }
            _ => {}
        }
        Ok(())
    }

    fn enter(&mut self, of: Of, element: &Element, has_content: bool) -> Result<(), ReadError> {
        self.of = has_content.then_some(of);
        self.active = element.get("Scalars")?;
        Ok(())
    }

    fn array(&mut self, element: &Element, has_content: bool) -> Result<(), ReadError> {
        let format = element.get("format")?;
        let content = match (format.as_deref(), has_content) {
            (Some("appended"), _) => Content::Appended(element.number("offset", None)?),
            (Some("binary"), true) => Content::Inline(self.text()?),
            (_, true) => Content::Ascii(self.text()?),
            (_, false) => Content::Ascii(0..0),
        };
        let (Some(of), Some(piece)) = (self.of, self.pieces.last_mut()) else {
            return Ok(());
        };
        let name = element.get("Name")?.unwrap_or_default();
        let kind = element.get("type")?.unwrap_or_default().to_ascii_lowercase();
        let array = Array {
            of,
            is_active: self.active.as_ref() == Some(&name),
            components: element.number("NumberOfComponents", Some(1))?.max(1),
            kind: (kind.clone(), stored(&kind)),
            name,
        };
        piece.arrays.push((array, content));
        Ok(())
    }

    /// Passes over the text that an array holds, and elements before it, and says where it is.
    fn text(&mut self) -> Result<Range<u64>, ReadError> {
        let mut buffer = Vec::new();
        // Elements within the array that are open.
        let mut depth = 0_usize;
        loop {
            let (range, is_blank) = self.pass().map_err(|e| ReadError::io(self.path, e))?;
            if depth == 0 && !is_blank {
                return Ok(range);
            }
            buffer.clear();
            let event = self.xml.read_event_into(&mut buffer);
            match event.map_err(|e| ReadError::header(self.path, format!("it is no XML: {e}")).byte(range.end))? {
                Event::Start(_) => depth += 1,
                Event::End(_) if depth > 0 => depth -= 1,
                Event::End(_) | Event::Eof => return Ok(range),
                _ => {}
            }
        }
    }

    /// Moves on to the next markup; where the text before it is, and whether it is blank.
    fn pass(&mut self) -> io::Result<(Range<u64>, bool)> {
        let mut stream = self.xml.stream();
        let start = stream.offset();
        let mut is_blank = true;
        loop {
            let bytes = stream.fill_buf()?;
            let length = bytes.iter().position(|b| *b == b'<');
            let text = &bytes[..length.unwrap_or(bytes.len())];
            is_blank &= text.iter().all(u8::is_ascii_whitespace);
            let (used, ends) = (text.len(), length.is_some() || bytes.is_empty());
            stream.consume(used);
            if ends {
                return Ok((start..stream.offset(), is_blank));
            }
        }
    }

    /// The byte behind the underscore that appended data begins with.
    fn underscore(&mut self) -> io::Result<u64> {
        let mut stream = self.xml.stream();
        stream.skip_until(b'_')?;
        Ok(stream.offset())
    }
}

/// The type that VTK calls `name`, in lower case.
fn stored(name: &str) -> Option<Stored> {
    Some(match name {
        "int8" => Stored::Voxel(VoxelType::I8),
        BIT | "uint8" => Stored::Voxel(VoxelType::U8),
        "int16" => Stored::Voxel(VoxelType::I16),
        "uint16" => Stored::Voxel(VoxelType::U16),
        "int32" => Stored::Voxel(VoxelType::I32),
        "uint32" => Stored::Voxel(VoxelType::U32),
        "int64" => Stored::I64,
        "uint64" => Stored::U64,
        "float32" => Stored::Voxel(VoxelType::F32),
        "float64" => Stored::Voxel(VoxelType::F64),
        _ => return None,
    })
}

fn file(element: &Element) -> Result<(Words, Option<Compressor>), ReadError> {
    match element.get("type")?.as_deref() {
        Some("ImageData" | "PImageData") => {}
        kind => {
            let what = format!("it is VTK's `{}`, no image", kind.unwrap_or_default());
            return Err(ReadError::unsupported(element.path, what).hint("resample it to an image (vtkResampleToImage)"));
        }
    }
    let words = Words {
        wide: element.get("header_type")?.as_deref() == Some("UInt64"),
        order: match element.get("byte_order")?.as_deref() {
            Some("BigEndian") => ByteOrder::Big,
            _ => ByteOrder::Little,
        },
    };
    let compressor = match element.get("compressor")?.as_deref() {
        None | Some("") => None,
        Some("vtkZLibDataCompressor") => Some(Compressor::Zlib),
        Some("vtkLZ4DataCompressor") => Some(Compressor::Lz4),
        Some("vtkLZMADataCompressor") => Some(Compressor::Lzma),
        Some(other) => return Err(element.bad(format!("the compressor `{other}` is not known"))),
    };
    Ok((words, compressor))
}

fn lattice(element: &Element) -> Result<Lattice, ReadError> {
    let direction = element.numbers("Direction", Some([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]))?;
    Ok(Lattice {
        extent: element.extent("WholeExtent")?,
        origin: DVec3::from_array(element.numbers("Origin", Some([0.0; 3]))?),
        spacing: DVec3::from_array(element.numbers("Spacing", Some([1.0; 3]))?),
        direction: DMat3::from_cols_array(&direction).transpose(),
    })
}

/// An element's attributes.
struct Element<'a> {
    path: &'a Path,
    at: u64,
    element: &'a BytesStart<'a>,
}

impl Element<'_> {
    fn bad(&self, what: impl Into<String>) -> ReadError {
        ReadError::header(self.path, what).byte(self.at)
    }

    fn get(&self, name: &str) -> Result<Option<String>, ReadError> {
        let attribute = (self.element.try_get_attribute(name)).map_err(|e| self.bad(e.to_string()))?;
        let value = attribute.map(|a| a.normalized_value(XmlVersion::Implicit1_0).map(String::from));
        value.transpose().map_err(|e| self.bad(e.to_string()))
    }

    /// The numbers that the attribute `name` has, or `default`.
    fn numbers<T: FromStr, const N: usize>(&self, name: &str, default: Option<[T; N]>) -> Result<[T; N], ReadError> {
        let text = match (self.get(name)?, default) {
            (Some(text), _) => text,
            (None, Some(default)) => return Ok(default),
            (None, None) => return Err(self.bad(format!("`{name}` is missing"))),
        };
        let numbers: Vec<T> = text.split_whitespace().map_while(|word| word.parse().ok()).collect();
        let bad = |_| self.bad(format!("`{name}` is `{text}`, not {N} numbers"));
        numbers.try_into().map_err(bad)
    }

    fn number<T: FromStr>(&self, name: &str, default: Option<T>) -> Result<T, ReadError> {
        self.numbers(name, default.map(|n| [n])).map(|[n]| n)
    }

    fn extent(&self, name: &str) -> Result<Extent, ReadError> {
        let numbers = self.numbers(name, None)?;
        Extent::new(numbers).ok_or_else(|| self.bad(format!("`{name}` {numbers:?} holds no point")))
    }
}
