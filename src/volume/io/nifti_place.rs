//! Where a NIfTI header puts its voxels: the rules are nibabel's.

use glam::{DAffine3, DQuat, DVec3};

use super::geometry::{LPS_FROM_RAS, from_axes};
use super::nifti_header::Header;
use crate::math::affine;

/// The sform when it is set and can be inverted, else the qform when it is set. With neither nothing is known of the
/// anatomy, and the index axes are taken as they are.
pub(super) fn world_from_index(header: &Header) -> DAffine3 {
    let millimetres = millimetres(header);
    let lps_from_ras = DAffine3::from_scale(LPS_FROM_RAS * millimetres);
    if let Some(ras_from_index) = sform(header) {
        return lps_from_ras * ras_from_index;
    }
    match header.qform_code > 0 {
        true => lps_from_ras * qform(header),
        false => DAffine3::from_scale(spacing(header) * millimetres),
    }
}

/// Millimetres in the header's unit of length.
fn millimetres(header: &Header) -> f64 {
    match header.units & 7 {
        1 => 1e3,
        3 => 1e-3,
        _ => 1.0,
    }
}

/// Method 3 of nifti1.h, when it is set and can be inverted. A third column of zeros, as images of one slice have, becomes
/// the others' normal.
fn sform(header: &Header) -> Option<DAffine3> {
    let column = |a: usize| DVec3::from_array(header.srow.map(|row| row[a]));
    let slices = Some(column(2)).filter(|c| *c != DVec3::ZERO);
    let map = from_axes([Some(column(0)), Some(column(1)), slices], column(3));
    (header.sform_code > 0 && affine::invert(&map).is_some()).then_some(map)
}

/// Method 2 of nifti1.h.
fn qform(header: &Header) -> DAffine3 {
    let [b, c, d] = header.quatern;
    let square = 1.0 - (b * b + c * c + d * d);
    let rotation = DQuat::from_xyzw(b, c, d, square.max(0.0).sqrt());
    let mirror = if header.pixdim[0] < 0.0 { -1.0 } else { 1.0 };
    DAffine3::from_scale_rotation_translation(
        spacing(header) * DVec3::new(1.0, 1.0, mirror),
        rotation.normalize(),
        DVec3::from_array(header.qoffset),
    )
}

/// The voxels' sizes; 1 for those that are none.
fn spacing(header: &Header) -> DVec3 {
    let size = |v: f64| if v.is_normal() { v.abs() } else { 1.0 };
    DVec3::new(size(header.pixdim[1]), size(header.pixdim[2]), size(header.pixdim[3]))
}
