//! Planes are not without end.

use vcsg::projection::raycast::RayCaster;
use vcsg::projection::{ProjectError, Projector};

use crate::scene::Recipe;

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
