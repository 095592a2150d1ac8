//! How the ray caster computes a frame, as its bounds have it.
//!
//! The bounds are those that slices on a device are held to (`conformance`), for a device that is the ray caster: it puts rays
//! where they are in double precision and goes on from there in single precision, among voxels of 16 bits.

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
            weight: place_rounding(spec) + 0.5 / 32768.0,
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

/// Rounding of a place along an axis, voxels. It is counted from a whole number, and at most 7 steps further: the first part,
/// the step, their product and their sum are each off by half a unit.
fn place_rounding(spec: &FrameSpec) -> f64 {
    let lattice = &spec.target.lattice;
    let [width, height] = spec.camera.size;
    let corners = [[0, 0], [width, 0], [0, height], [width, height]];
    let steepest = corners
        .map(|[x, y]| spec.camera.path_per_depth(x, y))
        .into_iter()
        .fold(1.0, f64::max);
    let step = spec.planes().step_mm * steepest / lattice.spacing_mm().min_element();
    0.5 * ULP * (2.0 + 21.0 * step)
}
