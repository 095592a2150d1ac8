//! How scalars lie in a file.

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
            $(Stored::Voxel(VoxelType::$tag) => {
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
pub(super) use for_stored;
