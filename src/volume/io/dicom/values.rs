//! From stored values to voxels.

use super::layout::Colour;
use super::series::Slice;
use crate::volume::grid::Voxels;
use crate::volume::io::error::ReadError;
use crate::volume::voxel::VoxelType;

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

/// The number of stored values a pixel, and which of them is meant; `None` for the luminance of all.
fn chosen(slice: &Slice, component: Option<usize>) -> (usize, Option<usize>) {
    match slice.image.layout.components() {
        1 => (1, Some(0)),
        several => (several, component),
    }
}

fn luminance(colour: &[i64]) -> f64 {
    LUMINANCE.iter().zip(colour).map(|(share, &v)| share * v as f64).sum()
}

/// The values of a slice after its slope and intercept.
fn values(slice: &Slice, component: Option<usize>) -> Result<Vec<f64>, ReadError> {
    let stored = slice.image.stored(slice.frame())?;
    let [slope, intercept] = rescale(slice);
    let values = match chosen(slice, component) {
        (1, _) => stored.iter().map(|&v| v as f64 * slope + intercept).collect(),
        (several, Some(c)) => stored.chunks_exact(several).map(|pixel| pixel[c] as f64).collect(),
        (several, None) => stored.chunks_exact(several).map(luminance).collect(),
    };
    Ok(values)
}

/// The same where they are integers; a luminance is rounded to one.
fn integers(slice: &Slice, component: Option<usize>) -> Result<Vec<i64>, ReadError> {
    let mut stored = slice.image.stored(slice.frame())?;
    let [slope, intercept] = rescale(slice).map(|v| v as i64);
    match chosen(slice, component) {
        (1, _) if (slope, intercept) != (1, 0) => stored.iter_mut().for_each(|v| *v = *v * slope + intercept),
        (1, _) => {}
        (several, Some(c)) => stored = stored.chunks_exact(several).map(|pixel| pixel[c]).collect(),
        (several, None) => {
            stored = stored
                .chunks_exact(several)
                .map(|pixel| luminance(pixel).round() as i64)
                .collect()
        }
    }
    Ok(stored)
}

/// A slice as voxels of type `voxel`, which is [`voxel_type`]'s.
pub(super) fn voxels(slice: &Slice, voxel: VoxelType, component: Option<usize>) -> Result<Voxels, ReadError> {
    let whole = || integers(slice, component).map(Vec::into_iter);
    let real = || values(slice, component).map(Vec::into_iter);
    Ok(match voxel {
        VoxelType::U8 => Voxels::U8(whole()?.map(|v| v as u8).collect()),
        VoxelType::I8 => Voxels::I8(whole()?.map(|v| v as i8).collect()),
        VoxelType::U16 => Voxels::U16(whole()?.map(|v| v as u16).collect()),
        VoxelType::I16 => Voxels::I16(whole()?.map(|v| v as i16).collect()),
        VoxelType::U32 => Voxels::U32(whole()?.map(|v| v as u32).collect()),
        VoxelType::I32 => Voxels::I32(whole()?.map(|v| v as i32).collect()),
        VoxelType::F32 => Voxels::F32(real()?.map(|v| v as f32).collect()),
        VoxelType::F64 => Voxels::F64(real()?.collect()),
    })
}

/// What lies between two slices, `part` of the way, as `f32`.
pub(super) fn between(slices: [&Slice; 2], part: f64, component: Option<usize>) -> Result<Voxels, ReadError> {
    let [a, b] = [values(slices[0], component)?, values(slices[1], component)?];
    let mixed = a.iter().zip(&b).map(|(a, b)| ((1.0 - part) * a + part * b) as f32);
    Ok(Voxels::F32(mixed.collect()))
}
