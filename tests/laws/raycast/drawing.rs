//! How the ray caster computes a frame, as its bounds have it.
//!
//! The bounds are those that slices on a device are held to (`conformance`), for a device that is the ray caster: it puts rays
//! where they are in whole parts of a voxel, and samples in whole numbers of 16 bits.

use vcsg::conformance::{Drawing, DrawnBox, Precision, Storage};
use vcsg::projection::FrameSpec;

/// What is stored for the end of the value range.
const ONE: f64 = 32760.0;

/// A step of single precision at 1; a rounding is off by half of it.
const ULP: f64 = f32::EPSILON as f64;

/// How the ray caster computes the frame of `spec`.
pub fn drawing(spec: &FrameSpec) -> Drawing {
    let storage = Storage::without_pages(spec.target.value_range);
    Drawing {
        boxes: vec![DrawnBox {
            bounds: spec.target.lattice.bounds(),
            depths_mm: [f64::NEG_INFINITY, f64::INFINITY],
        }],
        storage: Storage {
            rounding: storage.rounding - 0.5 * Storage::STEP + 0.5 / ONE,
            ..storage
        },
        precision: Precision {
            vertex_px: 0.0,
            weight: place_rounding(),
            // The path is rounded once.
            interpolated: ULP,
            coordinate: 0.0,
            // Interpolations are rounded to the nearest part of what is stored, three times, which no later one makes more of; and
            // coverage where it is stored, to parts that are twice as large as is counted there.
            sum_steps: (1.5 + 0.5) / ONE / Storage::STEP,
            // What comes of it is a number of single precision, and scaled.
            sum: 2.0 * ULP,
            normals: normals(),
        },
        // Blended from the front, and rays end.
        bands: 2,
    }
}

/// Rounding of a place along an axis, voxels. It is counted in parts of 2^-14 voxel: the packet's low corner is rounded down to one, how far a
/// sample is from there is a part more, rounded down: together a part at most. That is counted in parts of 2^-24 voxel first, of a width
/// for each of 7 columns and 7 rows that is off by half a part, and the corner in parts of 2^-32, from the first of 128 planes on, which
/// is half of another part.
fn place_rounding() -> f64 {
    const PART: f64 = 1.0 / (1u32 << 14) as f64;
    const FINE_PART: f64 = 1.0 / (1u32 << 24) as f64;
    PART + (7.0 + 1.0) * FINE_PART
}

/// What a part of a sample of normals is off. Of each normal it is off by half of what it is counted in, the last part by half a 511th, and what slices
/// store by half a 32767th. It is weighed by eight weights in parts of 2^-15. Of the four that are the products of those along y and z, one is
/// rounded to the nearest, and the others are what that leaves of 2^15 - 1: each is off by half a part. All are told in parts of 2^15 - 1, so
/// each is more by as much of a part as it weighs, and the last one less by a part: 2 at most together. Each is divided between two that are
/// rounded to the nearest. Together that is 4/2 + 2 + 8/2 parts.
fn normals() -> f64 {
    0.5 / 511.0 + 0.5 / 32767.0 + 8.0 / 32767.0
}
