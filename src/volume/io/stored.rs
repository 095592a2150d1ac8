//! How scalars lie in a file.

use std::path::Path;

use bytemuck::Pod;

use super::error::{Problem, ReadError};
use crate::volume::grid::Voxels;
use crate::volume::voxel::VoxelType;

/// A scalar's type in a file. The 64-bit integers, for which [`Voxels`](crate::volume::Voxels) has no type, become `f64`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stored {
    /// As the type.
    Voxel(VoxelType),
    /// Signed 64 bit.
    I64,
    /// Unsigned 64 bit.
    U64,
}

impl Stored {
    /// The type that they are kept in.
    pub(super) fn voxel(self) -> VoxelType {
        match self {
            Self::Voxel(voxel) => voxel,
            Self::I64 | Self::U64 => VoxelType::F64,
        }
    }

    /// Bytes of one.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::Voxel(voxel) => voxel.bytes(),
            Self::I64 | Self::U64 => 8,
        }
    }
}

/// Byte order of the scalars in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ByteOrder {
    /// Least significant byte first.
    Little,
    /// Most significant byte first.
    Big,
}

impl ByteOrder {
    /// This machine's.
    pub const NATIVE: Self = if cfg!(target_endian = "little") {
        Self::Little
    } else {
        Self::Big
    };
}

/// Evaluates `$body` with `$T` as the Rust type of `$stored`.
macro_rules! for_stored {
    ($stored:expr, $T:ident => $body:expr) => {
        for_stored!(@ $stored, $T, $body, U8 u8, I8 i8, U16 u16, I16 i16, U32 u32, I32 i32, F32 f32, F64 f64)
    };
    (@ $stored:expr, $T:ident, $body:expr, $($tag:ident $scalar:ident),*) => {
        match $stored {
            $(Stored::Voxel($crate::volume::VoxelType::$tag) => {
                type $T = $scalar;
                $body
            })*
            Stored::I64 => {
                type $T = i64;
                $body
            }
            Stored::U64 => {
                type $T = u64;
                $body
            }
        }
    };
}

/// [`for_stored`] of a `Vec<$T>`, as [`Voxels`].
macro_rules! voxels {
    ($stored:expr, $T:ident => $body:expr) => {
        voxels!(@ $stored, $T, $body, U8 u8, I8 i8, U16 u16, I16 i16, U32 u32, I32 i32, F32 f32, F64 f64)
    };
    (@ $stored:expr, $T:ident, $body:expr, $($tag:ident $scalar:ident),*) => {
        match $stored {
            $(Stored::Voxel($crate::volume::VoxelType::$tag) => {
                type $T = $scalar;
                Voxels::$tag($body)
            })*
            Stored::I64 => {
                type $T = i64;
                Voxels::F64($body.into_iter().map(|v| v as f64).collect())
            }
            Stored::U64 => {
                type $T = u64;
                Voxels::F64($body.into_iter().map(|v| v as f64).collect())
            }
        }
    };
}

pub(super) use {for_stored, voxels};

/// Scalars that are read before there is room for more.
const CHUNK: usize = 1 << 20;

/// `count` scalars of the file at `path`, whose bytes `fill` gives in turn. Room for them grows with what comes.
pub(super) fn decode(
    path: &Path,
    stored: Stored,
    order: ByteOrder,
    count: usize,
    mut fill: impl FnMut(&mut [u8]) -> Result<(), ReadError>,
) -> Result<Voxels, ReadError> {
    Ok(voxels!(stored, T => decode_as::<T>(path, order, count, &mut fill)?))
}

fn decode_as<T: Pod>(
    path: &Path,
    order: ByteOrder,
    count: usize,
    fill: &mut impl FnMut(&mut [u8]) -> Result<(), ReadError>,
) -> Result<Vec<T>, ReadError> {
    let bytes = (count as u64).saturating_mul(size_of::<T>() as u64);
    let mut scalars: Vec<T> = Vec::new();
    while scalars.len() < count {
        let start = scalars.len();
        let more = CHUNK.min(count - start);
        let reserved = scalars.try_reserve(more);
        reserved.map_err(|_| ReadError::new(path, Problem::Memory(bytes)))?;
        scalars.resize(start + more, T::zeroed());
        let bytes = bytemuck::cast_slice_mut(&mut scalars[start..]);
        fill(bytes)?;
        if order != ByteOrder::NATIVE {
            bytes.chunks_exact_mut(size_of::<T>()).for_each(<[u8]>::reverse);
        }
    }
    Ok(scalars)
}
