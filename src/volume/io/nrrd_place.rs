//! Where a NRRD header puts its voxels.

use std::path::Path;

use glam::{DAffine3, DVec3};

use super::error::ReadError;
use super::geometry::{LPS_FROM_LAS, LPS_FROM_RAS, from_axes, millimetres};
use super::nrrd_axes::Axes;
use super::nrrd_header::Header;

/// Where the header puts the voxels in LPS millimetres.
pub(super) fn world_from_index(path: &Path, header: &Header, axes: &Axes) -> Result<DAffine3, ReadError> {
    let (columns, origin) = match header.vectors("spacedirections")? {
        Some(directions) => {
            let origin = header.vectors("spaceorigin")?.unwrap_or_default();
            let origin = origin.first().copied().flatten();
            let column = |a: usize| directions.get(*axes.spatial.get(a)?).copied()?;
            (std::array::from_fn(column), origin.unwrap_or(DVec3::ZERO))
        }
        None => spacings(path, header, axes)?,
    };
    let scale = unit(header) * lps_from_space(path, header)?;
    Ok(DAffine3::from_scale(scale) * from_axes(columns, origin))
}

/// The axes and origin of a header without `space directions`.
fn spacings(path: &Path, header: &Header, axes: &Axes) -> Result<([Option<DVec3>; 3], DVec3), ReadError> {
    let number = |name: &str| {
        let numbers: Vec<f64> = header.numbers(name)?.unwrap_or_default();
        if !numbers.is_empty() && numbers.len() != axes.count {
            let what = format!("`{name}` has {} numbers for {} axes", numbers.len(), axes.count);
            return Err(ReadError::header(path, what));
        }
        let at = |a: usize| axes.spatial.get(a).and_then(|&axis| numbers.get(axis));
        Ok(std::array::from_fn(|a| at(a).copied().filter(|v: &f64| v.is_finite())))
    };
    let said: [Option<f64>; 3] = number("spacings")?;
    let [lowest, highest]: [[Option<f64>; 3]; 2] = [number("axismins")?, number("axismaxs")?];
    let centers = [header.words("centers"), header.words("centerings")].concat();
    let is_node = |a: usize| {
        let centering = axes.spatial.get(a).and_then(|&axis| centers.get(axis));
        centering.is_some_and(|c| c == "node")
    };
    // Both ends of an axis tell how far apart its voxels are, where nothing else does.
    let between_ends = |a: usize| {
        let steps = if is_node(a) { axes.dims[a] - 1 } else { axes.dims[a] };
        Some((highest[a]? - lowest[a]?) / steps as f64).filter(|v| v.is_finite())
    };
    let is_step = |v: &f64| *v != 0.0;
    let spacing: [f64; 3] = std::array::from_fn(|a| {
        let said = said[a].filter(is_step);
        said.or_else(|| between_ends(a).filter(is_step)).unwrap_or(1.0)
    });
    // The lowest place is a voxel's border, as teem and ITK take it unless the header says otherwise.
    let origin = |a: usize| lowest[a].map_or(0.0, |v| if is_node(a) { v } else { v + 0.5 * spacing[a] });
    let columns = std::array::from_fn(|a| Some(DVec3::AXES[a] * spacing[a]));
    Ok((columns, DVec3::from_array(std::array::from_fn(origin))))
}

/// Millimetres in the unit of the header's space.
fn unit(header: &Header) -> f64 {
    let units = header.words("spaceunits");
    units.first().map_or(1.0, |unit| millimetres(unit))
}

/// The signs that turn the header's space into LPS; spaces that name no anatomy stay as they are.
fn lps_from_space(path: &Path, header: &Header) -> Result<DVec3, ReadError> {
    let Some(field) = header.get("space") else {
        return Ok(DVec3::ONE);
    };
    match field.value.to_ascii_lowercase().trim_end_matches("-time") {
        "right-anterior-superior" | "ras" | "rast" => Ok(LPS_FROM_RAS),
        "left-anterior-superior" | "las" | "last" => Ok(LPS_FROM_LAS),
        "left-posterior-superior" | "lps" | "lpst" | "scanner-xyz" | "3d-right-handed" | "3d-left-handed" => {
            Ok(DVec3::ONE)
        }
        _ => Err(
            ReadError::unsupported(path, format!("the space `{}` is not known", field.value))
                .line(field.line)
                .hint("use left-posterior-superior, right-anterior-superior or left-anterior-superior"),
        ),
    }
}
