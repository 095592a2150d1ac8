//! From a format's axes to LPS millimetres.

use glam::{DAffine3, DMat3, DVec3};

/// LPS from RAS, the axes of NIfTI: left for right, posterior for anterior.
pub(super) const LPS_FROM_RAS: DVec3 = DVec3::new(-1.0, -1.0, 1.0);

/// LPS from LAS.
pub(super) const LPS_FROM_LAS: DVec3 = DVec3::new(1.0, -1.0, 1.0);

/// The map of three index axes, of which the missing ones become unit vectors square to the others.
pub(super) fn from_axes(axes: [Option<DVec3>; 3], origin: DVec3) -> DAffine3 {
    let [x, y, z] = match axes {
        [Some(x), Some(y), Some(z)] => [x, y, z],
        [Some(x), Some(y), None] => [x, y, x.cross(y).normalize_or(DVec3::Z)],
        [Some(x), ..] => {
            let y = across(x);
            [x, y, x.cross(y).normalize_or(DVec3::Z)]
        }
        [None, ..] => DVec3::AXES,
    };
    DAffine3::from_mat3_translation(DMat3::from_cols(x, y, z), origin)
}

/// The unit coordinate axis most square to `x`, made square.
fn across(x: DVec3) -> DVec3 {
    let x = x.normalize_or(DVec3::X);
    let axis = DVec3::AXES[x.abs().min_position()];
    (axis - x * x.dot(axis)).normalize_or(DVec3::Y)
}

/// Millimetres in one of the named unit; 1 for names that are no length.
pub(super) fn millimetres(unit: &str) -> f64 {
    match unit {
        "m" | "meter" | "metre" => 1e3,
        "cm" => 10.0,
        "um" | "µm" | "μm" | "micron" | "microns" | "micrometer" => 1e-3,
        "nm" | "nanometer" => 1e-6,
        _ => 1.0,
    }
}
