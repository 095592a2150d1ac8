//! A frame cast in parts of its depth is the whole one, and planes are not without end.

use vcsg::projection::raycast::{CastTarget, Depths, RayCaster, accumulate};
use vcsg::projection::{Mode, ProjectError, Projector};

use crate::scene::{Content, Recipe};

/// Maxima do not round, so the greater of two parts is the whole bit for bit, wherever it is cut.
#[test]
fn a_frame_cast_in_two_parts_is_the_whole_one() {
    for seed in 0..40 {
        let scene = Recipe {
            content: Content::Volume,
            mode: Mode::Mip,
            ..Recipe::random(seed)
        }
        .scene();
        let spec = scene.spec();
        let (target, all) = (CastTarget::of(&spec), Depths::of(&spec));
        let [near_mm, far_mm] = all.within_mm;
        let cut_mm = near_mm + (far_mm - near_mm) * (seed as f64 / 39.0);
        let cast = |within_mm| accumulate(&spec, &target, &Depths { within_mm, ..all }, None).expect("a frame");
        let [whole, near, far] = [[near_mm, far_mm], [near_mm, cut_mm], [cut_mm, far_mm]].map(cast);
        let parts = near.pixels().as_flattened().iter().zip(far.pixels().as_flattened());
        let both: Vec<f32> = parts.map(|(a, b)| a.max(*b)).collect();
        assert_eq!(whole.pixels().as_flattened(), both, "seed {seed}");
    }
}

#[test]
fn more_planes_than_can_be_counted_are_refused() {
    for samples_per_voxel in [1e9, 1e300, f64::INFINITY] {
        let mut scene = Recipe::random(3).scene();
        scene.settings.samples_per_voxel = samples_per_voxel;
        let refused = RayCaster.project(&scene.spec());
        assert!(
            matches!(refused, Err(ProjectError::Planes { .. })),
            "{samples_per_voxel}"
        );
    }
}
