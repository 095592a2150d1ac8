//! From stored values to voxels.

use super::layout::Colour;
use super::series::Slice;
use crate::volume::grid::Voxels;
use crate::volume::io::error::ReadError;
use crate::volume::voxel::{Voxel, VoxelType};

/// Shares of red, green and blue in luminance (ITU-R BT.709).
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// The smallest type that holds the values of all `slices` exactly; `f32` where a slope or an intercept is no integer.
pub(super) fn voxel_type(slices: &[Slice]) -> VoxelType {
    let mut range = [0i64; 2];
    for slice in slices {
        let stored = match (slice.image.layout.colour, slice.image.palette_most()) {
            (Colour::Gray, _) => slice.image.layout.range(),
            (_, Some(most)) => [0, most],
            _ => [0, slice.image.layout.range()[1]],
        };
        let [slope, intercept] = rescale(slice);
        if slope.fract() != 0.0 || intercept.fract() != 0.0 {
            return VoxelType::F32;
        }
        for v in stored {
            let v = v as f64 * slope + intercept;
            range = [range[0].min(v as i64), range[1].max(v as i64)];
        }
    }
    let holds = |lo: i64, hi: i64| lo <= range[0] && range[1] <= hi;
    let types = [
        (VoxelType::U8, 0, i64::from(u8::MAX)),
        (VoxelType::I8, i64::from(i8::MIN), i64::from(i8::MAX)),
        (VoxelType::I16, i64::from(i16::MIN), i64::from(i16::MAX)),
        (VoxelType::U16, 0, i64::from(u16::MAX)),
        (VoxelType::I32, i64::from(i32::MIN), i64::from(i32::MAX)),
        (VoxelType::U32, 0, i64::from(u32::MAX)),
    ];
    types
        .into_iter()
        .find(|&(_, lo, hi)| holds(lo, hi))
        .map_or(VoxelType::F32, |(voxel, ..)| voxel)
}

/// The slope and the intercept of a slice; colours have none.
fn rescale(slice: &Slice) -> [f64; 2] {
    match slice.image.layout.colour {
        Colour::Gray => slice.frame().rescale,
        _ => [1.0, 0.0],
    }
}

/// The values of a slice after its slope and intercept, or of colours the luminance or one `component`.
fn values(slice: &Slice, component: Option<usize>) -> Result<impl Iterator<Item = f64>, ReadError> {
    let stored = slice.image.stored(slice.frame())?;
    let [slope, intercept] = rescale(slice);
    let components = slice.image.layout.components();
    let value = move |i: usize| match (components, component) {
        (1, _) => stored[i] as f64 * slope + intercept,
        (_, Some(c)) => stored[i * components + c] as f64,
        _ => (0..3).map(|c| LUMINANCE[c] * stored[i * 3 + c] as f64).sum(),
    };
    Ok((0..slice.image.layout.pixels()).map(value))
}

/// A slice as voxels of type `voxel`.
pub(super) fn voxels(slice: &Slice, voxel: VoxelType, component: Option<usize>) -> Result<Voxels, ReadError> {
    fn nearest<T: Voxel>(values: impl Iterator<Item = f64>) -> Vec<T> {
        values.map(T::nearest).collect()
    }
    let values = values(slice, component)?;
    Ok(match voxel {
        VoxelType::U8 => Voxels::U8(nearest(values)),
        VoxelType::I8 => Voxels::I8(nearest(values)),
        VoxelType::U16 => Voxels::U16(nearest(values)),
        VoxelType::I16 => Voxels::I16(nearest(values)),
        VoxelType::U32 => Voxels::U32(nearest(values)),
        VoxelType::I32 => Voxels::I32(nearest(values)),
        VoxelType::F32 => Voxels::F32(nearest(values)),
        VoxelType::F64 => Voxels::F64(nearest(values)),
    })
}

/// What lies between two slices, `part` of the way, as `f32`.
pub(super) fn between(slices: [&Slice; 2], part: f64, component: Option<usize>) -> Result<Voxels, ReadError> {
    let [a, b] = [values(slices[0], component)?, values(slices[1], component)?];
    Ok(Voxels::F32(
        a.zip(b).map(|(a, b)| ((1.0 - part) * a + part * b) as f32).collect(),
    ))
}
