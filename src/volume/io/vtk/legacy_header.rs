//! Where the arrays of a legacy VTK file are.
//!
//! *Practice.* The file is gone through once; binary data is skipped, and of text the words are counted. What cannot be gone
//! past ends the list of arrays.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;
use std::str::FromStr;

use glam::{DMat3, DVec3};

use super::bits::{self, BIT};
use super::{Array, Extent, Lattice, Of};
use crate::volume::io::error::{Problem, ReadError};
use crate::volume::io::stored::Stored;
use crate::volume::voxel::VoxelType;

/// The longest line of a header that is believed.
const LONGEST_LINE: u64 = 4096;

/// Bytes that text has as numbers from 0 to 1, as it has colours.
pub(super) const FRACTIONS: &str = "colours";

/// Where an array's data is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Data {
    /// Its first byte in the file.
    pub start: u64,
    /// Its bytes, or in text those to the file's end.
    pub bytes: u64,
    /// Voxels.
    pub tuples: usize,
}

/// What the file declares.
pub(super) struct Header {
    pub is_binary: bool,
    pub lattice: Lattice,
    pub arrays: Vec<(Array, Data)>,
}

impl Header {
    pub(super) fn read(path: &Path) -> Result<Self, ReadError> {
        let file = File::open(path).map_err(|e| ReadError::io(path, e))?;
        let length = file.metadata().map_err(|e| ReadError::io(path, e))?.len();
        let mut scan = Scan {
            path,
            file: BufReader::new(file),
            length,
            is_binary: false,
            of: None,
            arrays: Vec::new(),
        };
        scan.is_binary = scan.magic()?;
        let lattice = scan.lattice()?;
        match scan.attributes() {
            Err(error) if matches!(error.problem, Problem::Unsupported(_)) && !scan.arrays.is_empty() => {}
            other => other?,
        }
        Ok(Self {
            is_binary: scan.is_binary,
            lattice,
            arrays: scan.arrays,
        })
    }
}

struct Scan<'a> {
    path: &'a Path,
    file: BufReader<File>,
    length: u64,
    is_binary: bool,
    /// What the arrays that follow belong to, and how many values they have; `None` for a field of the whole file.
    of: Option<(Of, usize)>,
    arrays: Vec<(Array, Data)>,
}

impl Scan<'_> {
    fn bad(&mut self, what: impl Into<String>) -> ReadError {
        let at = self.file.stream_position().unwrap_or(0);
        ReadError::header(self.path, what).byte(at)
    }

    fn io(&self, error: io::Error) -> ReadError {
        ReadError::io(self.path, error)
    }

    /// The next line; `None` at the end.
    fn line(&mut self) -> Result<Option<String>, ReadError> {
        let mut bytes = Vec::new();
        let read = (self.file.by_ref().take(LONGEST_LINE)).read_until(b'\n', &mut bytes);
        match read.map_err(|e| self.io(e))? as u64 {
            0 => Ok(None),
            LONGEST_LINE => Err(self.bad(format!("a line has more than {LONGEST_LINE} bytes"))),
            _ => Ok(Some(String::from_utf8_lossy(&bytes).into_owned())),
        }
    }

    /// The words of the next line that has some; none at the end. The first is in lower case, as VTK takes it.
    fn words(&mut self) -> Result<Vec<String>, ReadError> {
        while let Some(line) = self.line()? {
            let mut words: Vec<_> = line.split_ascii_whitespace().map(str::to_owned).collect();
            if let Some(first) = words.first_mut() {
                first.make_ascii_lowercase();
                return Ok(words);
            }
        }
        Ok(Vec::new())
    }

    /// Reads the first lines; whether the data is binary.
    fn magic(&mut self) -> Result<bool, ReadError> {
        let magic = self.line()?.unwrap_or_default();
        if !magic.starts_with("# vtk DataFile") {
            return Err(self.bad("it does not begin with `# vtk DataFile Version`"));
        }
        self.line()?;
        match self.words()?.first().map(String::as_str) {
            Some("ascii") => Ok(false),
            Some("binary") => Ok(true),
            _ => Err(self.bad("its third line is neither ASCII nor BINARY")),
        }
    }

    /// Reads the kind of data and where its points lie, up to the first array.
    fn lattice(&mut self) -> Result<Lattice, ReadError> {
        let mut words = self.words()?;
        if words.first().is_some_and(|word| word == "field") {
            self.field(&words)?;
            words = self.words()?;
        }
        let kind = words.get(1).cloned().unwrap_or_default().to_ascii_lowercase();
        if words.first().is_none_or(|word| word != "dataset") || kind != "structured_points" {
            let what = format!("it is VTK's `{}`, not structured points", kind.to_ascii_uppercase());
            return Err(ReadError::unsupported(self.path, what).hint("resample it to an image (vtkResampleToImage)"));
        }
        let (mut extent, mut origin, mut spacing) = (None, [0.0; 3], [1.0; 3]);
        let mut direction = DMat3::IDENTITY.to_cols_array();
        loop {
            let words = self.words()?;
            match words.first().map(String::as_str) {
                Some("dimensions") => {
                    let dims: [i64; 3] = self.numbers(&words)?;
                    let last = |a: usize| dims[a].saturating_sub(1);
                    extent = Extent::new([0, last(0), 0, last(1), 0, last(2)]);
                }
                Some("extent") => extent = Extent::new(self.numbers(&words)?),
                Some("spacing" | "aspect_ratio") => spacing = self.numbers(&words)?,
                Some("origin") => origin = self.numbers(&words)?,
                Some("direction") => direction = self.numbers(&words)?,
                Some("field") => self.field(&words)?,
                Some("metadata") => self.metadata()?,
                Some("point_data") => break self.begin(Of::Points, &words)?,
                Some("cell_data") => break self.begin(Of::Cells, &words)?,
                Some(other) => return Err(self.bad(format!("`{other}` is not known here"))),
                None => break,
            }
        }
        Ok(Lattice {
            extent: extent.ok_or_else(|| self.bad("it has no DIMENSIONS, or some are 0"))?,
            origin: DVec3::from_array(origin),
            spacing: DVec3::from_array(spacing),
            direction: DMat3::from_cols_array(&direction).transpose(),
        })
    }

    /// The numbers behind the first of `words`.
    fn numbers<T: FromStr, const N: usize>(&mut self, words: &[String]) -> Result<[T; N], ReadError> {
        let numbers: Vec<T> = words[1..].iter().map_while(|word| word.parse().ok()).collect();
        let bad = |_| self.bad(format!("`{}` takes {N} numbers", words.join(" ")));
        numbers.try_into().map_err(bad)
    }

    fn begin(&mut self, of: Of, words: &[String]) -> Result<(), ReadError> {
        let [count] = self.numbers(words)?;
        self.of = Some((of, count));
        Ok(())
    }

    /// Reads what belongs to points and cells, to the end.
    fn attributes(&mut self) -> Result<(), ReadError> {
        loop {
            let words = self.words()?;
            let word = |i: usize| words.get(i).map_or("", String::as_str);
            let count = |i: usize| words.get(i).and_then(|word| word.parse::<usize>().ok());
            let tuples = self.of.map_or(0, |(_, count)| count);
            match word(0) {
                "point_data" => self.begin(Of::Points, &words)?,
                "cell_data" => self.begin(Of::Cells, &words)?,
                "scalars" => {
                    self.lookup_table()?;
                    self.array(word(1), word(2), count(3).unwrap_or(1), tuples, true)?;
                }
                "color_scalars" => {
                    let kind = if self.is_binary { "unsigned_char" } else { FRACTIONS };
                    self.array(word(1), kind, count(2).unwrap_or(1), tuples, true)?;
                }
                "vectors" | "normals" => self.array(word(1), word(2), 3, tuples, false)?,
                "tensors" => self.array(word(1), word(2), 9, tuples, false)?,
                "tensors6" => self.array(word(1), word(2), 6, tuples, false)?,
                "texture_coordinates" => self.array(word(1), word(3), count(2).unwrap_or(1), tuples, false)?,
                "global_ids" | "pedigree_ids" | "edge_flags" => self.array(word(1), word(2), 1, tuples, false)?,
                "lookup_table" => self.skip_table(count(2).unwrap_or(0))?,
                "field" => self.field(&words)?,
                "metadata" => self.metadata()?,
                _ => return Ok(()),
            }
        }
    }

    /// The line that names the table of colours of the scalars that follow.
    fn lookup_table(&mut self) -> Result<(), ReadError> {
        let start = self.file.stream_position().map_err(|e| self.io(e))?;
        let words = self.words()?;
        if words.first().is_none_or(|word| word != "lookup_table") {
            self.file.seek(SeekFrom::Start(start)).map_err(|e| self.io(e))?;
        }
        Ok(())
    }

    /// Passes over a table of so many colours.
    fn skip_table(&mut self, colours: usize) -> Result<(), ReadError> {
        let kind = if self.is_binary { "unsigned_char" } else { "float" };
        self.skip(kind, colours.saturating_mul(4)).map(|_| ())
    }

    /// Arrays of a field; those of points or cells are kept.
    fn field(&mut self, words: &[String]) -> Result<(), ReadError> {
        let arrays = words.get(2).and_then(|word| word.parse::<usize>().ok()).unwrap_or(0);
        for _ in 0..arrays {
            let mut words = self.words()?;
            if words.first().is_some_and(|word| word == "metadata") {
                self.metadata()?;
                words = self.words()?;
            }
            let [name, components, tuples, kind] = &words[..] else {
                return Err(self.bad("an array of a field takes a name, two numbers and a type"));
            };
            match (components.parse(), tuples.parse()) {
                (Ok(components), Ok(tuples)) => self.array(name, kind, components, tuples, false)?,
                _ => return Err(self.bad("an array of a field takes a name, two numbers and a type")),
            }
        }
        Ok(())
    }

    /// Passes over what is said of arrays, up to an empty line.
    fn metadata(&mut self) -> Result<(), ReadError> {
        while self.line()?.is_some_and(|line| !line.trim().is_empty()) {}
        Ok(())
    }

    /// Notes an array, and passes over its data.
    fn array(
        &mut self,
        name: &str,
        kind: &str,
        components: usize,
        tuples: usize,
        scalars: bool,
    ) -> Result<(), ReadError> {
        let kind = kind.to_ascii_lowercase();
        let (start, bytes) = self.skip(&kind, components.saturating_mul(tuples))?;
        let Some((of, _)) = self.of else {
            return Ok(());
        };
        let is_first = !self.arrays.iter().any(|(array, _)| array.of == of && array.is_active);
        let array = Array {
            of,
            name: unescaped(name),
            kind: (kind.clone(), stored(&kind)),
            components: components.max(1),
            is_active: scalars && is_first,
        };
        self.arrays.push((array, Data { start, bytes, tuples }));
        Ok(())
    }

    /// Passes over `count` numbers; their first byte, and how many bytes there are.
    fn skip(&mut self, kind: &str, count: usize) -> Result<(u64, u64), ReadError> {
        let start = self.file.stream_position().map_err(|e| self.io(e))?;
        let left = self.length.saturating_sub(start);
        let size = match (self.is_binary, kind) {
            (false, _) => None,
            (true, BIT) => Some(bits::bytes(count as u64)),
            (true, kind) => match stored(kind) {
                Some(stored) => Some((count as u64).saturating_mul(stored.bytes() as u64)),
                None => return Err(ReadError::unsupported(self.path, format!("`{kind}` is not read")).byte(start)),
            },
        };
        match size {
            Some(expected) if expected > left => {
                Err(ReadError::new(self.path, Problem::Truncated { expected, found: left }).byte(start))
            }
            Some(bytes) => {
                self.file.seek(SeekFrom::Start(start + bytes)).map_err(|e| self.io(e))?;
                Ok((start, bytes))
            }
            None if left.saturating_add(1) / 2 < count as u64 => {
                Err(self.bad(format!("its text has less than {count} numbers")))
            }
            None => {
                self.skip_words(count)?;
                Ok((start, left))
            }
        }
    }

    /// Passes over `count` words of text.
    fn skip_words(&mut self, mut count: usize) -> Result<(), ReadError> {
        let mut in_word = false;
        while count > 0 {
            let bytes = self.file.fill_buf().map_err(|e| ReadError::io(self.path, e))?;
            if bytes.is_empty() {
                return Ok(());
            }
            let mut used = 0;
            for byte in bytes {
                let ends = in_word && byte.is_ascii_whitespace();
                in_word = !byte.is_ascii_whitespace();
                count -= usize::from(ends);
                if count == 0 {
                    break;
                }
                used += 1;
            }
            self.file.consume(used);
        }
        Ok(())
    }
}

/// The type that legacy files call `name`. Its `long` has 64 bits, as where VTK is mostly at home.
fn stored(name: &str) -> Option<Stored> {
    Some(match name {
        "char" | "signed_char" | "vtktypeint8" => Stored::Voxel(VoxelType::I8),
        BIT | FRACTIONS | "unsigned_char" | "vtktypeuint8" => Stored::Voxel(VoxelType::U8),
        "short" | "vtktypeint16" => Stored::Voxel(VoxelType::I16),
        "unsigned_short" | "vtktypeuint16" => Stored::Voxel(VoxelType::U16),
        "int" | "vtkidtype" | "vtktypeint32" => Stored::Voxel(VoxelType::I32),
        "unsigned_int" | "vtktypeuint32" => Stored::Voxel(VoxelType::U32),
        "long" | "long_long" | "vtktypeint64" => Stored::I64,
        "unsigned_long" | "unsigned_long_long" | "vtktypeuint64" => Stored::U64,
        "float" => Stored::Voxel(VoxelType::F32),
        "double" => Stored::Voxel(VoxelType::F64),
        _ => return None,
    })
}

/// `name` with `%20` and the like as what they stand for.
fn unescaped(name: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = name.as_bytes();
    while let [first, after @ ..] = rest {
        let code = (*first == b'%' && after.len() >= 2)
            .then(|| std::str::from_utf8(&after[..2]).ok())
            .flatten()
            .and_then(|digits| u8::from_str_radix(digits, 16).ok());
        bytes.push(code.unwrap_or(*first));
        rest = if code.is_some() { &after[2..] } else { after };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
