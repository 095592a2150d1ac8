//! Where the voxels of a NRRD header lie, and how they are written down.

use std::path::{Path, PathBuf};

use super::error::ReadError;
use super::files;
use super::nrrd_header::{Field, Header};
use super::source::{Coding, Skip, Stretch, after_lines};
use super::stored::{ByteOrder, Stored};
use crate::volume::voxel::VoxelType;

/// Where `bytes` of voxels lie for the header at `path`: behind it, or in the files that it names, each with as many of them.
pub(super) fn stretches(path: &Path, header: &Header, bytes: u64) -> Result<Vec<Stretch>, ReadError> {
    let lines: u64 = header.number("lineskip", 0)?;
    let (skip, coding) = (skip(path, header)?, coding(path, header)?);
    let (files, start) = match header.get("datafile") {
        None => (vec![path.to_owned()], header.end),
        Some(field) => (data_files(path, header, field)?, 0),
    };
    let count = files.len() as u64;
    if count == 0 || !bytes.is_multiple_of(count) {
        let what = format!("{bytes} bytes of voxels cannot be spread evenly over {count} files");
        return Err(ReadError::header(path, what));
    }
    let stretch = |path: PathBuf| {
        if !path.is_file() {
            let what = "the data file that the header names is not there";
            return Err(ReadError::header(&path, what).hint("the header's `data file` names it: put it there"));
        }
        let start = after_lines(&path, start, lines)?;
        // Of text the bytes in the file are meant, of compressed data those that it becomes.
        let (start, skip) = match (coding, skip) {
            (Coding::Numbers(_) | Coding::Hexadecimal, Skip::Bytes(skip)) => {
                (start.saturating_add(skip), Skip::Bytes(0))
            }
            (_, skip) => (start, skip),
        };
        Ok(Stretch {
            path,
            start,
            coding,
            skip,
            bytes: bytes / count,
        })
    };
    files.into_iter().map(stretch).collect()
}

/// The files that the header names.
fn data_files(path: &Path, header: &Header, field: &Field) -> Result<Vec<PathBuf>, ReadError> {
    let words: Vec<&str> = field.value.split_ascii_whitespace().collect();
    let names = match words[..] {
        ["LIST", ..] => header.list.clone(),
        [pattern, first, last, step, ..] if pattern.contains('%') => {
            let number = |word: &str| word.parse().map_err(|_| header.bad(field, word));
            files::numbered(pattern, number(first)?, number(last)?, number(step)?)
                .ok_or_else(|| header.bad(field, &field.value))?
        }
        _ => vec![field.value.clone()],
    };
    let folder = path.with_file_name("");
    Ok(names.iter().map(|name| folder.join(name)).collect())
}

fn skip(path: &Path, header: &Header) -> Result<Skip, ReadError> {
    match header.number("byteskip", 0_i64)? {
        -1 => Ok(Skip::AllBefore),
        skip => match u64::try_from(skip) {
            Ok(skip) => Ok(Skip::Bytes(skip)),
            Err(_) => Err(ReadError::header(path, "`byte skip` is below -1")),
        },
    }
}

fn coding(path: &Path, header: &Header) -> Result<Coding, ReadError> {
    let field = header.need("encoding")?;
    match field.value.to_ascii_lowercase().as_str() {
        "raw" => Ok(Coding::Plain),
        "gzip" | "gz" => Ok(Coding::Deflate),
        "bzip2" | "bz2" => Ok(Coding::Bzip2),
        "hex" => Ok(Coding::Hexadecimal),
        "text" | "txt" | "ascii" => Ok(Coding::Numbers(stored(header)?)),
        _ => Err(
            ReadError::unsupported(path, format!("the encoding `{}` is not read", field.value))
                .line(field.line)
                .hint("save it with the encoding raw or gzip"),
        ),
    }
}

/// The scalars' type.
pub(super) fn stored(header: &Header) -> Result<Stored, ReadError> {
    let field = header.need("type")?;
    Ok(match field.value.as_str() {
        "signed char" | "int8" | "int8_t" | "char" => Stored::Voxel(VoxelType::I8),
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Stored::Voxel(VoxelType::U8),
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => {
            Stored::Voxel(VoxelType::I16)
        }
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Stored::Voxel(VoxelType::U16),
        "int" | "signed int" | "int32" | "int32_t" => Stored::Voxel(VoxelType::I32),
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Stored::Voxel(VoxelType::U32),
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => Stored::I64,
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => Stored::U64,
        "float" => Stored::Voxel(VoxelType::F32),
        "double" => Stored::Voxel(VoxelType::F64),
        other => return Err(header.bad(field, other)),
    })
}

/// The data's byte order, which only scalars of several bytes in binary need.
pub(super) fn byte_order(path: &Path, header: &Header) -> Result<ByteOrder, ReadError> {
    let Some(field) = header.get("endian") else {
        let text = header.need("encoding")?.value.to_ascii_lowercase();
        return match stored(header)?.bytes() == 1 || ["text", "txt", "ascii"].contains(&&*text) {
            true => Ok(ByteOrder::NATIVE),
            false => {
                Err(ReadError::header(path, "the header has no `endian`").hint("add the line `endian: little`, or big"))
            }
        };
    };
    match field.value.to_ascii_lowercase().as_str() {
        "little" => Ok(ByteOrder::Little),
        "big" => Ok(ByteOrder::Big),
        other => Err(header.bad(field, other)),
    }
}
