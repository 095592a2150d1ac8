//! Law 3: the ray caster's frames lie between the bounds of single precision, and so does the reference.
//!
//! The bounds are those that slices on a device are held to (`conformance`), for a device that is the ray caster: it puts rays
//! where they are in double precision and goes on from there in single precision, among voxels of 16 bits.

use vcsg::conformance::{Drawing, FrameBounds, Precision, Storage};
use vcsg::image::Frame;
use vcsg::projection::{FrameSpec, Projector, Reference, raycast::RayCaster};

use crate::scene::Recipe;

/// A step of single precision at 1; a rounding is off by half of it.
const ULP: f64 = f32::EPSILON as f64;

/// How the ray caster computes the frame of `spec`.
fn drawing(spec: &FrameSpec) -> Drawing {
    Drawing {
        boxes: vec![spec.target.lattice.bounds()],
        storage: Storage {
            rounding: 0.5 * Storage::STEP + fraction_rounding(spec),
            page_edge: 1.0,
        },
        precision: Precision {
            vertex_px: 0.0,
            weight: place_rounding(spec),
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

/// A voxel's fraction of the value range: a quotient, two products and a sum of numbers that are rounded themselves.
fn fraction_rounding(spec: &FrameSpec) -> f64 {
    let range = spec.target.value_range;
    let magnitude = f64::from(range.lo.abs().max(range.hi.abs()));
    let width = f64::from(range.width());
    if width > 0.0 {
        4.0 * ULP * (magnitude / width + 1.0)
    } else {
        0.0
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

/// How far the ray caster's frame is from the middle of its bounds, the worst channel, in half widths; and from the reference.
fn deviations(spec: &FrameSpec) -> [f64; 2] {
    let bounds = FrameBounds::new(spec, &drawing(spec));
    let cast = RayCaster.project(spec).expect("a frame");
    let reference = Reference.project(spec).expect("a frame");
    assert_eq!(
        bounds.pixels_outside(&reference),
        0,
        "the reference itself: {}",
        worst(&bounds, &reference, &cast)
    );
    assert_eq!(bounds.pixels_outside(&cast), 0, "{}", worst(&bounds, &cast, &reference));
    let worst = bounds.deviations(&cast).into_iter().fold(0.0, f64::max);
    let channels = |frame: &Frame| frame.pixels().as_flattened().to_vec();
    let differences = channels(&cast)
        .into_iter()
        .zip(channels(&reference))
        .map(|(a, b)| f64::from(a - b).abs());
    [worst, differences.fold(0.0, f64::max)]
}

fn worst(bounds: &FrameBounds, cast: &Frame, reference: &Frame) -> String {
    let all = bounds.deviations(cast);
    let worst = (0..all.len()).max_by(|a, b| all[*a].total_cmp(&all[*b])).unwrap_or(0);
    let at = |frame: &Frame| frame.pixels()[worst / 4];
    let [cast, reference, low, high] = [at(cast), at(reference), at(&bounds.low), at(&bounds.high)];
    format!(
        "pixel {}: {cast:?} where the reference has {reference:?}, within {low:?} and {high:?}",
        worst / 4
    )
}

#[test]
fn scenes_agree_with_the_reference() {
    let mut worst = [0.0f64; 2];
    for seed in 0..120 {
        let scene = Recipe::random(seed).scene();
        let found = deviations(&scene.spec());
        worst = [0, 1].map(|n| worst[n].max(found[n]));
    }
    println!(
        "at most {:.3} of the bounds' half width, and {:.2e} from the reference",
        worst[0], worst[1]
    );
}
