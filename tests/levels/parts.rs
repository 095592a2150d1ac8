//! The part of a level that a zone is drawn from: the same voxels wherever the eye is, and few of them.

use glam::DVec3;
use vcsg::model::Tree;
use vcsg::projection::levels::{Zones, footprint};
use vcsg::target::{Levels, Subdivision, Target};

use crate::row::{eye_at, posts};

fn subdivision() -> Subdivision {
    Subdivision {
        min_block: 8,
        ..Subdivision::default()
    }
}

/// The targets of the zones that the eye at `y` sees.
fn targets(levels: &Levels, y: f64) -> Vec<(u32, Target)> {
    let camera = eye_at(y, 96);
    let zones = Zones::new(levels, &camera, 1.0);
    let target = |zone: &vcsg::projection::levels::Zone| {
        let sides = zone.sides(&camera, levels.voxel_mm(zone.level));
        let part = levels.part(zone.level, &footprint(&camera), &sides, &subdivision());
        Some((zone.level, part.expect("a target")?))
    };
    zones.zones.iter().filter_map(target).collect()
}

fn stored(target: &Target) -> usize {
    target.blocks.iter().map(|block| block.stored_len()).sum()
}

#[test]
fn a_deep_scene_needs_a_small_part_of_the_voxels() {
    let model = posts(24, 40.0);
    let levels = Levels::new(&model, Some(0.25), 5).expect("levels");
    let fine = Target::build(&model, Some(0.25), &subdivision()).expect("a target");
    let parts = targets(&levels, -30.0);
    let needed: usize = parts.iter().map(|(_, target)| stored(target)).sum();
    println!("{needed} voxels in {} zones instead of {}", parts.len(), stored(&fine));
    assert_eq!(parts.len(), 5);
    assert!(8 * needed < stored(&fine), "{needed} voxels of {}", stored(&fine));
}

#[test]
fn voxels_do_not_move_with_the_eye() {
    let model = posts(24, 40.0);
    let levels = Levels::new(&model, Some(1.0), 4).expect("levels");
    let mut first: [Option<DVec3>; 4] = [None; 4];
    for y in [-80.0, -79.3, -61.7, 12.9] {
        for (level, target) in targets(&levels, y) {
            let place = &target.lattice.world_from_lattice;
            assert_eq!(
                place.matrix3,
                glam::DMat3::from_diagonal(DVec3::splat(levels.voxel_mm(level)))
            );
            let origin = place.translation / levels.voxel_mm(level);
            let whole = origin - *first[level as usize].get_or_insert(origin);
            assert!(
                (whole - whole.round()).abs().max_element() < 1e-9,
                "{whole} of level {level}"
            );
        }
    }
}

#[test]
fn a_part_of_the_last_level_is_that_level() {
    let model = posts(24, 40.0);
    let levels = Levels::new(&model, Some(1.0), 3).expect("levels");
    let camera = eye_at(-30.0, 96);
    let zones = Zones::new(&levels, &camera, 1.0);
    let (level, part) = targets(&levels, -30.0).pop().expect("a zone");
    assert_eq!(level, 2);
    let whole = levels.whole(level).expect("a lattice");
    let truth = Tree::new(&model, &whole.world_from_lattice).expect("a tree");
    let whole_from_part = whole.world_from_lattice.inverse() * part.lattice.world_from_lattice;
    let last = zones.zones.last().expect("a zone");
    let mut covered = 0;
    for n in 0..part.lattice.len() {
        let [nx, ny, _] = part.lattice.dims;
        let p = DVec3::new((n % nx) as f64, (n / nx % ny) as f64, (n / (nx * ny)) as f64);
        let eye = camera.eye_from_world * part.lattice.world_from_lattice;
        if last.holds(eye.transform_point3(p).z) {
            let (seen, meant) = (
                part.sample(p).coverage,
                truth.sample(whole_from_part.transform_point3(p)).coverage,
            );
            // The frames' rounding moves a point by some 1e-13 voxels.
            assert!((seen - meant).abs() < 1e-6, "{seen} instead of {meant} at {p}");
            covered += usize::from(meant > 0.0);
        }
    }
    assert!(covered > 100);
}
