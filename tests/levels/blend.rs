//! Nothing pops: a density changes with the eye's distance no faster than the blend between two levels does.

use glam::{DAffine3, DVec3};
use vcsg::model::Tree;
use vcsg::projection::levels::{Zones, footprint};
use vcsg::target::Levels;
use vcsg::voxelize::Grade;

use crate::row::{FOCAL_PX, eye_at, posts};

const COUNT: u32 = 4;

/// How far the eye goes at a time, millimetres.
const STEP_MM: f64 = 0.05;

/// The coverage at points about a post from the eye at `y`, as the zone that holds it gives it; from level to level in one step
/// where it is not `blended`.
fn coverages(levels: &Levels, y: f64, points: &[DVec3], blended: bool) -> Vec<f64> {
    let camera = eye_at(y, 96);
    let zones = Zones::new(levels, &camera, 1.0);
    let trees: Vec<Tree> = zones
        .zones
        .iter()
        .map(|zone| {
            let (footprint, voxel_mm) = (footprint(&camera), levels.voxel_mm(zone.level));
            let grade = (blended && zone.level + 1 < COUNT).then_some(Grade { footprint, voxel_mm });
            Tree::graded(levels.model, &DAffine3::IDENTITY, voxel_mm, grade).expect("a tree")
        })
        .collect();
    let at = |p: &DVec3| {
        let depth = camera.eye_from_world.transform_point3(*p).z;
        let zone = zones.zones.iter().position(|zone| zone.holds(depth)).expect("a zone");
        f64::from(trees[zone].sample(*p).coverage)
    };
    points.iter().map(at).collect()
}

/// The largest change of a coverage in one step of the eye, in parts of what the blend allows.
///
/// The share is log2 of the depth d in voxels of the level, so in a step h it changes by h / (d ln 2) at most, and a coverage by
/// no more. A face that is half a slab off adds a change of share of half a slab over d ln 2: with slabs of 2^l voxels at a depth of
/// 2^l f voxels that is 0.72 / f, f being the focal length in pixels. Coverages are of single precision.
fn worst(blended: bool) -> f64 {
    let model = posts(1, 1.0);
    let levels = Levels::new(&model, Some(0.5), COUNT).expect("levels");
    let points: Vec<DVec3> = (0..12)
        .map(|n| DVec3::new(-5.0, 0.0, 9.0 + 0.5 * f64::from(n)))
        .collect();
    let mut worst: f64 = 0.0;
    let mut before: Option<Vec<f64>> = None;
    for n in 0..8000 {
        let distance = 30.0 + f64::from(n) * STEP_MM;
        let now = coverages(&levels, -distance, &points, blended);
        let allowed = (STEP_MM / distance + 0.5 / FOCAL_PX) / 2f64.ln() + 2.0 * f64::from(f32::EPSILON);
        for (a, b) in before.iter().flatten().zip(&now) {
            worst = worst.max((a - b).abs() / allowed);
        }
        before = Some(now);
    }
    worst
}

#[test]
fn a_density_changes_no_faster_than_the_blend() {
    let blended = worst(true);
    assert!(blended <= 1.0, "{blended} of what is allowed");
    let hard = worst(false);
    assert!(
        hard > 4.0,
        "levels that switch change by only {hard} of what is allowed"
    );
    println!("largest change of a coverage: blended {blended:.3}, switched {hard:.1} of what is allowed");
}
