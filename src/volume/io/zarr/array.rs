//! What the metadata of a Zarr array says.
//!
//! Format: the Zarr storage specification, versions 2 and 3, with the numcodecs compressors.

use std::path::{Path, PathBuf};

use half::f16;
use serde::Deserialize;
use serde_json::Value;

use super::codec::{Chain, Codec};
use super::filters::filter;
use super::json::{Document, Named};
use crate::volume::grid::Voxels;
use crate::volume::io::error::ReadError;
use crate::volume::io::stored::{ByteOrder, Stored};
use crate::volume::voxel::{Voxel, VoxelType, for_type};

/// The most axes that an array may have.
const MAX_AXES: usize = 16;

/// A Zarr array, whose chunks are still to be read.
#[derive(Debug)]
pub(super) struct Array {
    /// Its folder.
    pub path: PathBuf,
    /// Elements along each axis, the fastest last.
    pub shape: Vec<usize>,
    /// Elements of a chunk along each axis.
    pub chunk: Vec<usize>,
    /// What an element is.
    pub element: Element,
    /// What the elements of absent chunks are.
    pub fill: f64,
    /// What the axes are called, where that is said.
    pub names: Vec<Option<String>>,
    /// How chunks' files are named.
    pub keys: Keys,
    /// How a chunk is stored in its file.
    pub coding: Coding,
}

/// What an element is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Element {
    /// A scalar that other formats have too.
    Scalar(Stored),
    /// A float of 16 bits, which is read as one of 32.
    Half,
}

impl Element {
    /// How it is stored: of a half float, its bits.
    pub fn stored(self) -> Stored {
        match self {
            Self::Scalar(stored) => stored,
            Self::Half => Stored::Voxel(VoxelType::U16),
        }
    }

    /// The type that it is kept in.
    pub fn voxel(self) -> VoxelType {
        match self {
            Self::Scalar(stored) => stored.voxel(),
            Self::Half => VoxelType::F32,
        }
    }
}

/// How the files of chunks are named: their indices behind a prefix.
#[derive(Debug)]
pub(super) struct Keys {
    /// The first part of the name.
    pub prefix: Option<&'static str>,
    /// Whether each index is a folder, rather than a part of one name.
    pub are_folders: bool,
}

/// How a chunk is stored in its file.
#[derive(Debug)]
pub(super) enum Coding {
    /// As a whole.
    Whole(Chain),
    /// In chunks of its own, of which an index tells where they are.
    Sharded {
        /// Elements of a chunk within, along each axis.
        chunk: Vec<usize>,
        /// How those chunks are stored.
        chain: Chain,
        /// How the index is stored: pairs of offset and length.
        index: Chain,
        /// Whether the index comes before the chunks, not after them.
        index_is_first: bool,
    },
}

#[derive(Deserialize)]
struct Version2 {
    shape: Vec<u64>,
    chunks: Vec<u64>,
    dtype: Value,
    compressor: Option<Value>,
    #[serde(default)]
    fill_value: Value,
    order: String,
    filters: Option<Vec<Value>>,
    dimension_separator: Option<String>,
}

#[derive(Deserialize)]
struct Version3 {
    shape: Vec<u64>,
    data_type: Value,
    chunk_grid: Named,
    chunk_key_encoding: Named,
    #[serde(default)]
    fill_value: Value,
    codecs: Vec<Named>,
    dimension_names: Option<Vec<Option<String>>>,
    #[serde(default)]
    storage_transformers: Vec<Value>,
}

#[derive(Deserialize)]
struct Regular {
    chunk_shape: Vec<u64>,
}

#[derive(Deserialize)]
struct Sharding {
    chunk_shape: Vec<u64>,
    codecs: Vec<Named>,
    index_codecs: Vec<Named>,
    index_location: Option<String>,
}

impl Array {
    /// The array in `folder` that `document` describes.
    pub fn new(folder: &Path, document: &Document) -> Result<Self, ReadError> {
        let array = match document.is_version_3() {
            true => Self::of_version_3(folder, document)?,
            false => Self::of_version_2(folder, document)?,
        };
        let axes = array.shape.len();
        if axes == 0 || axes > MAX_AXES || array.chunk.len() != axes || array.names.len() != axes {
            let chunk = array.chunk.len();
            return Err(document.wrong(format!("it has {axes} axes, and its chunks {chunk}")));
        }
        if array.chunk.contains(&0) || array.shape.contains(&0) {
            return Err(document.wrong("an axis of it or of its chunks has no elements"));
        }
        if !array
            .chunk
            .iter()
            .zip(array.unit())
            .all(|(shard, n)| shard.is_multiple_of(*n))
        {
            return Err(document.wrong("its shards are no multiples of the chunks in them"));
        }
        Ok(array)
    }

    /// The file of the chunk of these indices.
    pub fn file(&self, indices: &[usize]) -> PathBuf {
        let prefix = self.keys.prefix.map(str::to_owned);
        let words: Vec<String> = prefix.into_iter().chain(indices.iter().map(usize::to_string)).collect();
        let separator = if self.keys.are_folders { "/" } else { "." };
        self.path.join(words.join(separator))
    }

    /// Whether a file holds several chunks.
    pub fn is_sharded(&self) -> bool {
        matches!(self.coding, Coding::Sharded { .. })
    }

    /// Elements along each axis of what is decoded as a whole.
    pub fn unit(&self) -> &[usize] {
        match &self.coding {
            Coding::Whole(_) => &self.chunk,
            Coding::Sharded { chunk, .. } => chunk,
        }
    }

    /// Bytes of the elements of what is decoded as a whole.
    pub fn unit_bytes(&self) -> usize {
        let size = self.unit().iter();
        size.fold(self.element.stored().bytes(), |bytes, n| bytes.saturating_mul(*n))
    }

    /// How what is decoded as a whole is stored.
    pub fn chain(&self) -> &Chain {
        match &self.coding {
            Coding::Whole(chain) | Coding::Sharded { chain, .. } => chain,
        }
    }

    fn of_version_2(folder: &Path, document: &Document) -> Result<Self, ReadError> {
        let fields: Version2 = document.parse()?;
        let (element, order) = match fields.dtype.as_str().and_then(element_version_2) {
            Some(known) => known,
            None => return Err(document.unsupported(format!("elements of type {}", fields.dtype))),
        };
        let filters = fields.filters.as_deref().unwrap_or_default();
        let mut codecs: Vec<Codec> = filters
            .iter()
            .map(|described| filter(document, described, &fields.dtype, (element, order)))
            .collect::<Result<_, _>>()?;
        let axes: Vec<usize> = (0..fields.shape.len()).collect();
        let axes = match fields.order.as_str() {
            "C" => axes,
            "F" => axes.into_iter().rev().collect(),
            other => return Err(document.wrong(format!("`order` is `{other}`, not C or F"))),
        };
        if let Some(compressor) = &fields.compressor {
            codecs.push(compressor_version_2(document, compressor)?);
        }
        Ok(Self {
            path: folder.to_owned(),
            names: vec![None; fields.shape.len()],
            shape: sizes(document, &fields.shape)?,
            chunk: sizes(document, &fields.chunks)?,
            element,
            fill: fill(document, &fields.fill_value, element)?,
            keys: Keys {
                prefix: None,
                are_folders: are_folders(document, fields.dimension_separator.as_deref().unwrap_or("."))?,
            },
            coding: Coding::Whole(Chain { axes, order, codecs }),
        })
    }

    fn of_version_3(folder: &Path, document: &Document) -> Result<Self, ReadError> {
        let fields: Version3 = document.parse()?;
        let Some(element) = fields.data_type.as_str().and_then(element_version_3) else {
            return Err(document.unsupported(format!("elements of type {}", fields.data_type)));
        };
        if fields.chunk_grid.name != "regular" {
            return Err(document.unsupported(format!("the chunk grid `{}`", fields.chunk_grid.name)));
        }
        if !fields.storage_transformers.is_empty() {
            return Err(document.unsupported("storage transformers"));
        }
        let grid: Regular = document.parse_value(fields.chunk_grid.configuration)?;
        let shape = sizes(document, &fields.shape)?;
        Ok(Self {
            path: folder.to_owned(),
            names: fields.dimension_names.unwrap_or_else(|| vec![None; shape.len()]),
            chunk: sizes(document, &grid.chunk_shape)?,
            element,
            fill: fill(document, &fields.fill_value, element)?,
            keys: keys_version_3(document, &fields.chunk_key_encoding)?,
            coding: coding(document, fields.codecs, shape.len())?,
            shape,
        })
    }
}

/// How a chunk of `axes` axes is stored after `codecs`.
fn coding(document: &Document, mut codecs: Vec<Named>, axes: usize) -> Result<Coding, ReadError> {
    let Some(at) = codecs.iter().position(|codec| codec.name == "sharding_indexed") else {
        return Ok(Coding::Whole(Chain::new(document, &codecs, axes)?));
    };
    if codecs.len() != 1 {
        return Err(document.unsupported("shards behind or before other codecs"));
    }
    let sharding: Sharding = document.parse_value(codecs.swap_remove(at).configuration)?;
    if sharding.codecs.iter().any(|codec| codec.name == "sharding_indexed") {
        return Err(document.unsupported("shards in shards"));
    }
    let chunk = sizes(document, &sharding.chunk_shape)?;
    if chunk.len() != axes || chunk.contains(&0) {
        return Err(document.wrong("its chunks within shards have another number of axes, or no elements"));
    }
    let index = Chain::new(document, &sharding.index_codecs, axes + 1)?;
    if index.codecs.iter().any(|codec| *codec != Codec::Crc32c) || !index.is_in_order() {
        return Err(document.unsupported("a compressed index of shards"));
    }
    Ok(Coding::Sharded {
        chunk,
        chain: Chain::new(document, &sharding.codecs, axes)?,
        index,
        index_is_first: match sharding.index_location.as_deref() {
            None | Some("end") => false,
            Some("start") => true,
            Some(other) => return Err(document.wrong(format!("`index_location` is `{other}`"))),
        },
    })
}

fn keys_version_3(document: &Document, encoding: &Named) -> Result<Keys, ReadError> {
    let separator = encoding.configuration.get("separator").and_then(Value::as_str);
    let (prefix, usual) = match encoding.name.as_str() {
        "default" => (Some("c"), "/"),
        "v2" => (None, "."),
        other => return Err(document.unsupported(format!("the chunk key encoding `{other}`"))),
    };
    Ok(Keys {
        prefix,
        are_folders: are_folders(document, separator.unwrap_or(usual))?,
    })
}

fn are_folders(document: &Document, separator: &str) -> Result<bool, ReadError> {
    match separator {
        "/" => Ok(true),
        "." => Ok(false),
        other => Err(document.wrong(format!("chunk indices are separated by `{other}`, not by `.` or `/`"))),
    }
}

fn sizes(document: &Document, sizes: &[u64]) -> Result<Vec<usize>, ReadError> {
    let size = |n: &u64| usize::try_from(*n).ok().filter(|n| *n <= isize::MAX as usize);
    let sizes: Option<_> = sizes.iter().map(size).collect();
    sizes.ok_or_else(|| document.wrong("a size is too large for this machine"))
}

/// The element type of a NumPy type string.
fn element_version_2(dtype: &str) -> Option<(Element, ByteOrder)> {
    let order = match dtype.chars().next()? {
        '<' => ByteOrder::Little,
        '>' => ByteOrder::Big,
        '|' => ByteOrder::NATIVE,
        _ => return None,
    };
    let stored = match dtype.get(1..)? {
        "f2" => return Some((Element::Half, order)),
        "b1" | "u1" => Stored::Voxel(VoxelType::U8),
        "i1" => Stored::Voxel(VoxelType::I8),
        "u2" => Stored::Voxel(VoxelType::U16),
        "i2" => Stored::Voxel(VoxelType::I16),
        "u4" => Stored::Voxel(VoxelType::U32),
        "i4" => Stored::Voxel(VoxelType::I32),
        "u8" => Stored::U64,
        "i8" => Stored::I64,
        "f4" => Stored::Voxel(VoxelType::F32),
        "f8" => Stored::Voxel(VoxelType::F64),
        _ => return None,
    };
    Some((Element::Scalar(stored), order))
}

fn element_version_3(name: &str) -> Option<Element> {
    Some(Element::Scalar(match name {
        "float16" => return Some(Element::Half),
        "bool" | "uint8" => Stored::Voxel(VoxelType::U8),
        "int8" => Stored::Voxel(VoxelType::I8),
        "uint16" => Stored::Voxel(VoxelType::U16),
        "int16" => Stored::Voxel(VoxelType::I16),
        "uint32" => Stored::Voxel(VoxelType::U32),
        "int32" => Stored::Voxel(VoxelType::I32),
        "uint64" => Stored::U64,
        "int64" => Stored::I64,
        "float32" => Stored::Voxel(VoxelType::F32),
        "float64" => Stored::Voxel(VoxelType::F64),
        _ => return None,
    }))
}

/// The compressor of version 2, by the name that numcodecs gives it.
fn compressor_version_2(document: &Document, compressor: &Value) -> Result<Codec, ReadError> {
    let id = compressor.get("id").and_then(Value::as_str).unwrap_or_default();
    let codec = match id {
        "lz4" => Some(Codec::Lz4),
        "zlib" => Some(Codec::Zlib),
        "bz2" => Some(Codec::Bzip2),
        _ => Codec::named(id),
    };
    codec.ok_or_else(|| document.unsupported(format!("the compressor `{id}`")))
}

/// The value of absent elements.
fn fill(document: &Document, value: &Value, element: Element) -> Result<f64, ReadError> {
    let wrong = || document.wrong(format!("`fill_value` {value} is no element of its type"));
    let fill = match value {
        Value::Null => 0.0,
        Value::Bool(bit) => f64::from(u8::from(*bit)),
        Value::Number(number) => number.as_f64().ok_or_else(wrong)?,
        Value::String(text) => fill_text(text, element).ok_or_else(wrong)?,
        _ => return Err(wrong()),
    };
    let is_of_type = match element {
        Element::Half => true,
        Element::Scalar(Stored::Voxel(voxel)) => voxel.is_float() || is_exact(voxel, fill),
        Element::Scalar(Stored::I64 | Stored::U64) => fill.fract() == 0.0,
    };
    is_of_type.then_some(fill).ok_or_else(wrong)
}

/// Whether a type has exactly this value.
fn is_exact(voxel: VoxelType, value: f64) -> bool {
    fn of<T: Voxel>(_: &[T], value: f64) -> bool {
        T::nearest(value).to_f64() == value
    }
    for_type!(Voxels, &Voxels::none(voxel), v => of(v, value))
}

/// A value in words, or a float by its bits.
fn fill_text(text: &str, element: Element) -> Option<f64> {
    match (text, element) {
        ("NaN", _) => Some(f64::NAN),
        ("Infinity", _) => Some(f64::INFINITY),
        ("-Infinity", _) => Some(f64::NEG_INFINITY),
        (_, Element::Half) => {
            let bits = u16::from_str_radix(text.strip_prefix("0x")?, 16).ok()?;
            Some(f16::from_bits(bits).to_f64())
        }
        (_, Element::Scalar(Stored::Voxel(VoxelType::F32))) => {
            let bits = u32::from_str_radix(text.strip_prefix("0x")?, 16).ok()?;
            Some(f64::from(f32::from_bits(bits)))
        }
        (_, Element::Scalar(Stored::Voxel(VoxelType::F64))) => {
            let bits = u64::from_str_radix(text.strip_prefix("0x")?, 16).ok()?;
            Some(f64::from_bits(bits))
        }
        _ => None,
    }
}
