//! Affine maps, with one fixed order of operations.
//!
//! *Practice.* The tree and a block's flat program must agree bit for bit (design law 1), and a program steps along a row of
//! voxels with the row's constant part hoisted. So a point is always mapped as `x·X + (y·Y + (z·Z + t))`: the part in
//! brackets is the same for every voxel of a row.

use glam::{DAffine3, DMat3, DVec3};

/// `dst_from_src` applied to the point `p`.
#[inline]
pub fn point(dst_from_src: &DAffine3, p: DVec3) -> DVec3 {
    step(dst_from_src, row(dst_from_src, p.y, p.z), p.x)
}

/// The part of [`point`] that `y` and `z` decide.
#[inline]
pub fn row(dst_from_src: &DAffine3, y: f64, z: f64) -> DVec3 {
    let m = &dst_from_src.matrix3;
    m.y_axis * y + (m.z_axis * z + dst_from_src.translation)
}

/// [`point`] from its row part and `x`.
#[inline]
pub fn step(dst_from_src: &DAffine3, row: DVec3, x: f64) -> DVec3 {
    dst_from_src.matrix3.x_axis * x + row
}

/// The inverse of a map, or `None` when it is singular or not finite.
pub fn invert(m: &DAffine3) -> Option<DAffine3> {
    let determinant = m.matrix3.determinant();
    if !m.is_finite() || !determinant.is_normal() {
        return None;
    }
    let inverse = m.inverse();
    inverse.is_finite().then_some(inverse)
}

/// The map with entries that lie within 1e-9 of an integer set to it.
///
/// Composed maps that are the identity, a mirror, a quarter turn or a whole-voxel shift on paper come out a few ulps off;
/// set right, a volume on its own lattice is copied and not resampled. Over 4096 voxels 1e-9 is 4e-6 voxel.
pub fn snapped(m: &DAffine3) -> DAffine3 {
    let snap = |v: DVec3| {
        let nearest = v.round();
        DVec3::select((v - nearest).abs().cmplt(DVec3::splat(1e-9)), nearest, v)
    };
    DAffine3 {
        matrix3: DMat3::from_cols(snap(m.matrix3.x_axis), snap(m.matrix3.y_axis), snap(m.matrix3.z_axis)),
        translation: snap(m.translation),
    }
}

/// The lengths of the images of the unit axes: a lattice's spacing, from its `world_from_index`.
pub fn spacing(world_from_index: &DAffine3) -> DVec3 {
    let m = &world_from_index.matrix3;
    DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length())
}
