//! The header of a PLY file: its elements and their properties.

use super::bytes;
use super::error::Fault;

/// How the data is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Storage {
    Text,
    Little,
    Big,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    /// Both sets of names that are in use.
    const NAMES: [(&'static str, Self); 16] = [
        ("char", Self::I8),
        ("int8", Self::I8),
        ("uchar", Self::U8),
        ("uint8", Self::U8),
        ("short", Self::I16),
        ("int16", Self::I16),
        ("ushort", Self::U16),
        ("uint16", Self::U16),
        ("int", Self::I32),
        ("int32", Self::I32),
        ("uint", Self::U32),
        ("uint32", Self::U32),
        ("float", Self::F32),
        ("float32", Self::F32),
        ("double", Self::F64),
        ("float64", Self::F64),
    ];

    pub fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// A property of an element.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Property {
    pub name: String,
    pub scalar: Scalar,
    /// The type of the count, for a list.
    pub count: Option<Scalar>,
}

/// What a file has several of.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

/// A header, and where the data after it begins.
#[derive(Debug, PartialEq)]
pub(super) struct Header {
    pub storage: Storage,
    pub elements: Vec<Element>,
    pub bytes: usize,
    pub lines: usize,
}

impl Header {
    pub fn read(file: &[u8]) -> Result<Self, Fault> {
        let mut header = Self {
            storage: Storage::Text,
            elements: Vec::new(),
            bytes: 0,
            lines: 0,
        };
        let mut storage = None;
        for line in file.split_inclusive(|byte| *byte == b'\n') {
            header.bytes += line.len();
            header.lines += 1;
            let text = std::str::from_utf8(line).unwrap_or_default();
            let words: Vec<&str> = text.split_ascii_whitespace().collect();
            let is_whole = line.ends_with(b"\n");
            match words[..] {
                ["ply"] if header.lines == 1 => {}
                _ if header.lines == 1 => return Err(Fault::new("the file does not begin with `ply`").line(1)),
                ["end_header"] if is_whole => {
                    header.storage = storage.ok_or_else(|| Fault::new("the header has no `format`"))?;
                    return Ok(header);
                }
                ["format", name, _] => storage = Some(storage_of(name).ok_or_else(|| bad(text, header.lines))?),
                _ => header.line(&words).ok_or_else(|| bad(text, header.lines))?,
            }
        }
        Err(Fault::truncated("`end_header`").line(header.lines))
    }

    /// A line about elements and properties, or one that says nothing.
    fn line(&mut self, words: &[&str]) -> Option<()> {
        match *words {
            [] | ["comment" | "obj_info", ..] => {}
            ["element", name, count] => self.elements.push(Element {
                name: name.into(),
                count: count.parse().ok()?,
                properties: Vec::new(),
            }),
            ["property", "list", count, scalar, name] => self.property(name, scalar, Some(scalar_of(count)?))?,
            ["property", scalar, name] => self.property(name, scalar, None)?,
            _ => return None,
        }
        Some(())
    }

    fn property(&mut self, name: &str, scalar: &str, count: Option<Scalar>) -> Option<()> {
        self.elements.last_mut()?.properties.push(Property {
            name: name.into(),
            scalar: scalar_of(scalar)?,
            count,
        });
        Some(())
    }
}

fn bad(text: &str, line: usize) -> Fault {
    Fault::new(format!(
        "`{}` is not of a PLY header",
        bytes::shortened(text.trim_end())
    ))
    .line(line)
}

fn scalar_of(name: &str) -> Option<Scalar> {
    Scalar::NAMES.iter().find(|(known, _)| *known == name).map(|(_, s)| *s)
}

fn storage_of(name: &str) -> Option<Storage> {
    match name {
        "ascii" => Some(Storage::Text),
        "binary_little_endian" => Some(Storage::Little),
        "binary_big_endian" => Some(Storage::Big),
        _ => None,
    }
}
