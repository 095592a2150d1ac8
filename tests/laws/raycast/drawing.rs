//! How the ray caster computes a frame, as its bounds have it.
//!
//! The bounds are those that slices on a device are held to (`conformance`), for a device that is the ray caster: it puts rays
//! where they are in whole parts of a voxel and goes on from there in single precision, among voxels of 16 bits.

use vcsg::conformance::{Drawing, DrawnBox, Precision, Storage};
use vcsg::projection::FrameSpec;

/// A step of single precision at 1; a rounding is off by half of it.
const ULP: f64 = f32::EPSILON as f64;

/// How the ray caster computes the frame of `spec`.
pub fn drawing(spec: &FrameSpec) -> Drawing {
    Drawing {
        boxes: vec![DrawnBox {
            bounds: spec.target.lattice.bounds(),
            depths_mm: [f64::NEG_INFINITY, f64::INFINITY],
        }],
        storage: Storage::without_pages(spec.target.value_range),
        precision: Precision {
            vertex_px: 0.0,
            // Along one axis weights are rounded to whole numbers of 2^-15.
            weight: place_rounding() + 0.5 / 32768.0,
            // The path is rounded once.
            interpolated: ULP,
            coordinate: 0.0,
            sum_steps: 0.0,
            // Of numbers up to 1: an interpolation rounds a difference, a product and a sum, 5 half units at most; there are
            // three.
            sum: 8.0 * ULP,
        },
        // Blended from the front, and rays end.
        bands: 2,
    }
}

/// Rounding of a place along an axis, voxels. It is counted in parts of 2^-24 voxel: the packet's low corner is rounded down to one, and from
/// there it is at most 7 columns and 7 rows, of a width that is off by half a part. The corner itself is counted in parts of 2^-32,
/// from the first of 128 planes on, which is half of another part.
fn place_rounding() -> f64 {
    const PART: f64 = 1.0 / (1u32 << 24) as f64;
    (1.0 + 7.0 + 1.0) * PART
}
