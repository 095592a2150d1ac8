//! The scalar types a voxel can have.

use std::convert::identity;

use serde::Serialize;

/// A scalar that a voxel can be.
pub trait Voxel: bytemuck::Pod + PartialEq + PartialOrd + Send + Sync + 'static {
    /// The type's tag.
    const TYPE: VoxelType;

    /// The value that sampling sees, rounded to the nearest `f32`.
    fn to_f32(self) -> f32;

    /// The value in `f64`, exact for every type.
    fn to_f64(self) -> f64;

    /// The smallest value that is not below `v`, which is not NaN; `None` where the type ends below it.
    fn not_below(v: f64) -> Option<Self>;

    /// The value of this type that is nearest to `v`, of two equally near integers the even one; 0 for NaN in an integer type.
    fn nearest(v: f64) -> Self;

    /// The value as [`Bricks`](super::Bricks) keep it: a negative zero is made positive, so that equal values have equal
    /// bits, and what is not finite or above half of `f32::MAX`, so that a difference could overflow, becomes NaN.
    fn regular(self) -> Self;
}

/// The type of a grid's voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum VoxelType {
    /// Unsigned 8 bit.
    U8,
    /// Signed 8 bit.
    I8,
    /// Unsigned 16 bit.
    U16,
    /// Signed 16 bit.
    I16,
    /// Unsigned 32 bit.
    U32,
    /// Signed 32 bit.
    I32,
    /// Single precision.
    F32,
    /// Double precision.
    F64,
}

impl VoxelType {
    /// Rust's name of the type: `u8`, `f32`, …
    pub const fn name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }

    /// Bytes of one voxel.
    pub const fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// Whether it is `f32` or `f64`.
    pub const fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }
}

macro_rules! impl_voxel {
    ($($scalar:ident $tag:ident $regular:expr, $not_below:expr;)*) => {$(
        impl Voxel for $scalar {
            const TYPE: VoxelType = VoxelType::$tag;

            #[inline(always)]
            fn to_f32(self) -> f32 {
                self as f32
            }

            #[inline(always)]
            fn to_f64(self) -> f64 {
                self as f64
            }

            fn not_below(v: f64) -> Option<Self> {
                $not_below(v)
            }

            #[inline(always)]
            fn nearest(v: f64) -> Self {
                let v = if Self::TYPE.is_float() { v } else { v.round_ties_even() };
                v as $scalar
            }

            #[inline(always)]
            fn regular(self) -> Self {
                $regular(self)
            }
        }
    )*};
}

fn regular_f32(v: f32) -> f32 {
    // In IEEE arithmetic -0 + 0 = +0, and every other value is kept.
    if v.abs() <= f32::MAX / 2.0 { v + 0.0 } else { f32::NAN }
}

fn not_below_f32(v: f64) -> f32 {
    let nearest = v as f32;
    if f64::from(nearest) < v {
        nearest.next_up()
    } else {
        nearest
    }
}

fn regular_f64(v: f64) -> f64 {
    if v.abs() <= f64::from(f32::MAX / 2.0) {
        v + 0.0
    } else {
        f64::NAN
    }
}

impl_voxel! {
    u8 U8 identity, |v: f64| (v <= f64::from(u8::MAX)).then_some(v.ceil() as u8);
    i8 I8 identity, |v: f64| (v <= f64::from(i8::MAX)).then_some(v.ceil() as i8);
    u16 U16 identity, |v: f64| (v <= f64::from(u16::MAX)).then_some(v.ceil() as u16);
    i16 I16 identity, |v: f64| (v <= f64::from(i16::MAX)).then_some(v.ceil() as i16);
    u32 U32 identity, |v: f64| (v <= f64::from(u32::MAX)).then_some(v.ceil() as u32);
    i32 I32 identity, |v: f64| (v <= f64::from(i32::MAX)).then_some(v.ceil() as i32);
    f32 F32 regular_f32, |v: f64| Some(not_below_f32(v));
    f64 F64 regular_f64, Some;
}

/// Evaluates `$body` with `$v` bound to what the variant of `$value` holds; `$enum` has one variant a [`VoxelType`].
macro_rules! for_type {
    ($enum:ident, $value:expr, $v:ident => $body:expr) => {
        match $value {
            $enum::U8($v) => $body,
            $enum::I8($v) => $body,
            $enum::U16($v) => $body,
            $enum::I16($v) => $body,
            $enum::U32($v) => $body,
            $enum::I32($v) => $body,
            $enum::F32($v) => $body,
            $enum::F64($v) => $body,
        }
    };
}

/// [`for_type`] whose result is wrapped in the variant of `$to` of the same name.
macro_rules! map_type {
    ($from:ident, $value:expr, $to:ident, $v:ident => $body:expr) => {
        match $value {
            $from::U8($v) => $to::U8($body),
            $from::I8($v) => $to::I8($body),
            $from::U16($v) => $to::U16($body),
            $from::I16($v) => $to::I16($body),
            $from::U32($v) => $to::U32($body),
            $from::I32($v) => $to::I32($body),
            $from::F32($v) => $to::F32($body),
            $from::F64($v) => $to::F64($body),
        }
    };
}

pub(crate) use {for_type, map_type};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_value_not_below() {
        assert_eq!(u8::not_below(-7.5), Some(0));
        assert_eq!(u8::not_below(2.25), Some(3));
        assert_eq!(u8::not_below(255.0), Some(255));
        assert_eq!(u8::not_below(255.5), None);
        assert_eq!(i16::not_below(-2.5), Some(-2));
        assert_eq!(f32::not_below(0.1), Some(0.1));
        assert_eq!(f32::not_below(f64::from(0.1_f32) + 1e-12), Some(0.1_f32.next_up()));
        assert_eq!(f32::not_below(f64::from(0.1_f32) - 1e-12), Some(0.1));
        assert_eq!(f32::not_below(f64::MAX), Some(f32::INFINITY));
    }
}
