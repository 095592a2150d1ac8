//! PLY, text and binary of both byte orders: `x y z` of `vertex` and `vertex_indices` (or `vertex_index`) of `face`. Other
//! elements and properties are passed over.
//!
//! Format: G. Turk, The PLY Polygon File Format (1994).

use glam::DVec3;

use super::TriangleMesh;
use super::bytes::{self, Cursor};
use super::error::Fault;
use super::ply_header::{Element, Header, Scalar, Storage};

/// Where numbers come from, one after the other.
trait Numbers {
    fn next(&mut self, scalar: Scalar) -> Result<f64, Fault>;

    /// A fault at the last number.
    fn fault(&self, fault: Fault) -> Fault;

    /// How many bytes are left.
    fn left(&self) -> usize;

    /// The least bytes that a number of this type takes.
    fn least(&self, scalar: Scalar) -> usize;
}

/// Reads a whole file.
pub fn read(file: &[u8]) -> Result<TriangleMesh, Fault> {
    let header = Header::read(file)?;
    let data = &file[header.bytes..];
    match header.storage {
        Storage::Text => {
            let words = bytes::words(data);
            let (line, left) = (header.lines, data.len());
            read_elements(
                &header,
                &mut Text {
                    words,
                    line,
                    left,
                    header: header.lines,
                },
            )
        }
        storage => read_elements(
            &header,
            &mut Binary {
                cursor: Cursor::new(data),
                is_big: storage == Storage::Big,
                header: header.bytes,
            },
        ),
    }
}

fn read_elements(header: &Header, numbers: &mut impl Numbers) -> Result<TriangleMesh, Fault> {
    for wanted in ["vertex", "face"] {
        let count = header.elements.iter().filter(|element| element.name == wanted).count();
        if count != 1 {
            return Err(Fault::new(format!("the header has {count} elements `{wanted}`")));
        }
    }
    let mut mesh = TriangleMesh::default();
    for element in &header.elements {
        check_count(element, numbers)?;
        match element.name.as_str() {
            "vertex" => read_vertices(element, numbers, &mut mesh)?,
            "face" => read_faces(element, numbers, &mut mesh)?,
            _ => each(element, numbers, |_, _| Ok(()))?,
        }
    }
    Ok(mesh)
}

/// Whether as many can be there as are declared.
fn check_count(element: &Element, numbers: &impl Numbers) -> Result<(), Fault> {
    let least = element
        .properties
        .iter()
        .map(|p| numbers.least(p.count.unwrap_or(p.scalar)));
    let bytes = u128::from(element.count) * least.sum::<usize>() as u128;
    if bytes > numbers.left() as u128 {
        let (count, name) = (element.count, &element.name);
        let what = format!(
            "the end of the {count} elements `{}` that it declares",
            bytes::shortened(name)
        );
        return Err(numbers.fault(Fault::truncated(what)));
    }
    Ok(())
}

/// Calls `list` with each property of each element, by its number, and the numbers in it.
fn each<N: Numbers>(
    element: &Element,
    numbers: &mut N,
    mut take: impl FnMut(usize, &[f64]) -> Result<(), Fault>,
) -> Result<(), Fault> {
    if element.properties.is_empty() {
        return Ok(());
    }
    let mut list = Vec::new();
    for _ in 0..element.count {
        for (n, property) in element.properties.iter().enumerate() {
            list.clear();
            let count = match property.count {
                Some(scalar) => length(scalar, numbers)?,
                None => 1,
            };
            // As long as there are numbers; a count alone makes nothing.
            for _ in 0..count {
                list.push(numbers.next(property.scalar)?);
            }
            take(n, &list).map_err(|fault| numbers.fault(fault))?;
        }
    }
    Ok(())
}

fn length(scalar: Scalar, numbers: &mut impl Numbers) -> Result<u64, Fault> {
    let count = numbers.next(scalar)?;
    match whole(count) {
        Some(count) => Ok(u64::from(count)),
        None => Err(numbers.fault(Fault::new(format!("a list cannot have {count} numbers")))),
    }
}

fn whole(number: f64) -> Option<u32> {
    let is_whole = number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number);
    is_whole.then_some(number as u32)
}

fn read_vertices(element: &Element, numbers: &mut impl Numbers, mesh: &mut TriangleMesh) -> Result<(), Fault> {
    let find = |name: &str| {
        let is_it = |p: &super::ply_header::Property| p.name == name && p.count.is_none();
        let missing = || Fault::new(format!("the vertices have no `{name}`"));
        element.properties.iter().position(is_it).ok_or_else(missing)
    };
    let axes = [find("x")?, find("y")?, find("z")?];
    let last = element.properties.len() - 1;
    let mut position = DVec3::ZERO;
    each(element, numbers, |n, values| {
        if let Some(axis) = axes.iter().position(|known| *known == n) {
            position[axis] = values[0];
        }
        if n == last {
            mesh.push(position)?;
        }
        Ok(())
    })
}

fn read_faces(element: &Element, numbers: &mut impl Numbers, mesh: &mut TriangleMesh) -> Result<(), Fault> {
    let is_corners = |p: &super::ply_header::Property| {
        ["vertex_indices", "vertex_index"].contains(&p.name.as_str()) && p.count.is_some()
    };
    let missing = || Fault::new("the faces have no list `vertex_indices`");
    let corners = element.properties.iter().position(is_corners).ok_or_else(missing)?;
    let mut fan = Vec::new();
    each(element, numbers, |n, values| {
        if n != corners {
            return Ok(());
        }
        if values.len() < 3 {
            return Err(Fault::new("the face has less than three corners"));
        }
        fan.clear();
        for value in values {
            fan.push(whole(*value).ok_or_else(|| Fault::new(format!("{value} is no vertex")))?);
        }
        mesh.push_fan(&fan);
        Ok(())
    })
}

/// Words of text.
struct Text<W> {
    words: W,
    /// Of the last word.
    line: usize,
    /// Bytes after the header, less two for each word that was read.
    left: usize,
    /// How many lines the header has.
    header: usize,
}

impl<'a, W: Iterator<Item = (usize, &'a str)>> Numbers for Text<W> {
    fn next(&mut self, _: Scalar) -> Result<f64, Fault> {
        let Some((line, word)) = self.words.next() else {
            return Err(self.fault(Fault::truncated("the last element")));
        };
        self.line = self.header + line;
        self.left = self.left.saturating_sub(2);
        bytes::number(word, self.line)
    }

    fn fault(&self, fault: Fault) -> Fault {
        fault.line(self.line)
    }

    /// The last word need not have anything behind it.
    fn left(&self) -> usize {
        self.left + 1
    }

    /// A digit, and what parts it from the next.
    fn least(&self, _: Scalar) -> usize {
        2
    }
}

struct Binary<'a> {
    cursor: Cursor<'a>,
    is_big: bool,
    /// How many bytes the header has.
    header: usize,
}

impl Numbers for Binary<'_> {
    fn next(&mut self, scalar: Scalar) -> Result<f64, Fault> {
        let taken = self.cursor.take(scalar.bytes(), "the last element");
        let at = self.header + self.cursor.at();
        let bytes = taken.map_err(|fault| fault.byte(at))?;
        let mut word = [0; 8];
        let word = &mut word[..bytes.len()];
        word.copy_from_slice(bytes);
        if self.is_big {
            word.reverse();
        }
        Ok(little_endian(word, scalar))
    }

    fn fault(&self, fault: Fault) -> Fault {
        fault.byte(self.header + self.cursor.at())
    }

    fn left(&self) -> usize {
        self.cursor.left()
    }

    fn least(&self, scalar: Scalar) -> usize {
        scalar.bytes()
    }
}

/// The number in as many bytes as its type has.
fn little_endian(word: &[u8], scalar: Scalar) -> f64 {
    let mut bits = [0; 8];
    bits[..word.len()].copy_from_slice(word);
    let bits = u64::from_le_bytes(bits);
    match scalar {
        Scalar::I8 => f64::from(bits as i8),
        Scalar::U8 => f64::from(bits as u8),
        Scalar::I16 => f64::from(bits as i16),
        Scalar::U16 => f64::from(bits as u16),
        Scalar::I32 => f64::from(bits as i32),
        Scalar::U32 => f64::from(bits as u32),
        Scalar::F32 => f64::from(f32::from_bits(bits as u32)),
        Scalar::F64 => f64::from_bits(bits),
    }
}
