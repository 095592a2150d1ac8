//! Zones are a partition of depth, and of a comb of slabs.

use proptest::prelude::*;
use vcsg::projection::levels::{Zones, footprint};
use vcsg::projection::{Camera, Lens};
use vcsg::target::Levels;

use crate::row::{eye_at, posts};

/// Depths are some hundred millimetres: this is far above their rounding and far below a slab.
const ROUNDING: f64 = 1e-9;

fn cases() -> ProptestConfig {
    ProptestConfig {
        cases: 200,
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

/// What is wrong with the zones of a frame.
fn complaint(levels: &Levels, camera: &Camera, zones: &Zones, depths: &[f64]) -> Option<String> {
    let all = levels.bounds.transformed(&camera.eye_from_world);
    let (near, far) = (all.min.z.max(camera.near_mm()), all.max.z);
    for depth in depths.iter().map(|t| near + t * (far - near)) {
        let holders = zones.zones.iter().filter(|zone| zone.holds(depth)).count();
        if holders != 1 {
            return Some(format!("{depth} is in {holders} zones: {zones:?}"));
        }
    }
    for pair in zones.zones.windows(2) {
        if pair[0].far_mm != pair[1].near_mm || pair[0].level >= pair[1].level {
            return Some(format!("{pair:?} do not follow one another"));
        }
        for zone in pair {
            let planes = zone.planes(&zones.comb);
            let slabs = (pair[0].far_mm - planes.first_mm) / planes.step_mm + 0.5;
            if (slabs - slabs.round()).abs() > ROUNDING {
                return Some(format!("a slab of {zone:?} is cut in {slabs} by {}", pair[0].far_mm));
            }
        }
    }
    None
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn every_depth_is_in_one_zone_and_every_slab_too(
        count in 1u32..=8,
        spacing in 0.3f64..3.0,
        samples in 0.5f64..3.0,
        y in -200.0f64..200.0,
        edge in 4u32..200,
        parallel in prop::option::weighted(0.3, 0.01f64..10.0),
        depths in prop::collection::vec(0.0f64..1.0, 50),
    ) {
        let model = posts(8, 30.0);
        let levels = Levels::new(&model, Some(spacing), count).expect("levels");
        let mut camera = eye_at(y, edge);
        if let Some(pixels_per_mm) = parallel {
            camera.lens = Lens::Orthographic { pixels_per_mm };
        }
        let zones = Zones::new(&levels, &camera, samples);
        prop_assert_eq!(complaint(&levels, &camera, &zones, &depths), None);
        if parallel.is_some() {
            prop_assert_eq!(zones.zones.len(), 1);
        }
    }

    #[test]
    fn a_zone_begins_where_a_pixel_covers_a_voxel_of_its_level(samples in 0.5f64..3.0, y in -200.0f64..-50.0) {
        let model = posts(40, 30.0);
        let levels = Levels::new(&model, Some(1.0), 4).expect("levels");
        let camera = eye_at(y, 96);
        let covered = footprint(&camera);
        let zones = Zones::new(&levels, &camera, samples);
        let world_from_eye = camera.eye_from_world.inverse();
        for zone in &zones.zones[1..] {
            let at = |depth: f64| covered.at(world_from_eye.transform_point3(glam::DVec3::Z * depth));
            let voxel_mm = levels.voxel_mm(zone.level);
            // A face may be half a slab off.
            let off = 0.5 * voxel_mm / samples;
            prop_assert!(at(zone.near_mm - off) <= voxel_mm + ROUNDING && voxel_mm <= at(zone.near_mm + off) + ROUNDING);
        }
    }
}

#[test]
fn a_gap_between_zones_and_a_cut_slab_are_seen() {
    let model = posts(8, 30.0);
    let levels = Levels::new(&model, Some(1.0), 3).expect("levels");
    let camera = eye_at(-60.0, 96);
    let zones = Zones::new(&levels, &camera, 1.0);
    let depths: Vec<f64> = (0..4000).map(|n| f64::from(n) / 4000.0).collect();
    assert!(zones.zones.len() > 1);
    assert_eq!(complaint(&levels, &camera, &zones, &depths), None);
    let mut gap = zones.clone();
    gap.zones[1].near_mm += 1.0;
    assert!(complaint(&levels, &camera, &gap, &depths).is_some());
    let mut cut = zones;
    cut.zones[0].far_mm += 0.3;
    cut.zones[1].near_mm = cut.zones[0].far_mm;
    assert!(complaint(&levels, &camera, &cut, &depths).is_some());
}
