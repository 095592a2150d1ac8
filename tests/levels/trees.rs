//! Colour trees, deformations and masks by levels: what holds of values and plain solids holds of them.

use glam::DVec3;
use tempfile::TempDir;
use vcsg::model::Model;
use vcsg::model::deform::Morph;
use vcsg::projection::levels::{Zones, footprint};
use vcsg::projection::{Camera, Mode};
use vcsg::scene::{NoVolumes, Scene, VolumeFiles};
use vcsg::target::{Levels, Target};

use crate::frames::{FOG_MM, FOG_OPACITY, Look, cast, cast_one, draw, draw_one, largest_change, subdivision};
use crate::row::eye_at;

/// Fog, from 20 mm behind the eye on, and wide enough for the rays in its middle on every level.
const FOG: &str = "box min=\"-30 -20 -30\" max=\"30 150 30\"";

const PAIRS: &str = "
    pair from=\"-30 -20 -30\" to=\"-30 -20 -30\"
    pair from=\"30 -20 30\" to=\"30 -20 30\"
    pair from=\"-30 150 30\" to=\"-30 150 30\"
    pair from=\"30 150 -30\" to=\"30 152 -32\"
    pair from=\"0 70 0\" to=\"5 78 3\"
    pair from=\"0 150 0\" to=\"-4 158 2\"";

fn parsed(text: &str) -> Model {
    Scene::parse("a.kdl", text, ".".as_ref(), &mut NoVolumes)
        .expect("a scene")
        .model
}

/// Fog in two colours, of which the second has its own opacity. Their far ends are in one place: only of the product family is what
/// both cover the sum of what each does, however soft the ends are.
fn colored_fog() -> Model {
    parsed(&format!(
        "scene {{ union rule=\"over\" family=\"product\" {{
            classify {{ point 1 opacity={FOG_OPACITY} color=\"#c08040\"; {FOG} }}
            classify unit-mm=2 {{ point 1 opacity={FOG_OPACITY} color=\"#4080c0\"; box min=\"-30 80 -30\" max=\"30 150 30\" }}
        }} }}"
    ))
}

fn deformed(inner: &str) -> Model {
    parsed(&format!("scene {{ deform {{ {PAIRS}\n{inner} }} }}"))
}

/// Fog where a mask of 10 mm wide voxels says so. The folder holds the mask's file.
fn masked_fog() -> (TempDir, Model) {
    let folder = tempfile::tempdir().unwrap();
    let header = "NRRD0004\ntype: uchar\ndimension: 3\nspace: left-posterior-superior\nsizes: 6 17 6\nspace directions: (10,0,0) (0,10,0) (0,0,10)\nspace origin: (-25,-15,-25)\nencoding: raw\n\n";
    let bytes = [header.as_bytes(), &[1; 6 * 17 * 6]].concat();
    std::fs::write(folder.path().join("mask.nrrd"), bytes).unwrap();
    let scene = Scene::parse("a.kdl", "scene { mask \"mask.nrrd\" }", folder.path(), &mut VolumeFiles);
    (folder, scene.expect("a scene").model)
}

const MODES: [Mode; 3] = [Mode::Composite, Mode::Additive, Mode::XRay];

/// The middle pixel of fog by one level and by four.
fn pixels(model: &Model, mode: Mode) -> [[f32; 4]; 2] {
    let (camera, look) = (eye_at(0.0, 16), Look::of_fog(mode));
    let drawn = draw(model, &camera, 4, &look);
    let levels: Vec<_> = drawn.zones.iter().map(|drawn| drawn.zone.level).collect();
    assert_eq!(levels, [0, 1, 2, 3]);
    let one = draw_one(model, &camera, &look);
    [one, drawn.frame].map(|frame| frame.pixel(8, 8).expect("a pixel"))
}

/// The same by rays on the processor.
fn cast_pixels(model: &Model, mode: Mode) -> [[f32; 4]; 2] {
    let (camera, look) = (eye_at(0.0, 16), Look::of_fog(mode));
    let frames = [cast_one(model, &camera, &look), cast(model, &camera, 4, &look).frame];
    frames.map(|frame| frame.pixel(8, 8).expect("a pixel"))
}

/// As of values: within 0.6 % by the softness of the far end and the coarser slabs.
const FOG_BOUND: f64 = 0.006;

fn assert_alike(what: &str, [one, several]: [[f32; 4]; 2], bound: f64) {
    println!("{what}: {one:?} and {several:?}");
    for (one, several) in one.into_iter().zip(several) {
        let apart = (f64::from(several) - f64::from(one)).abs();
        assert!(apart <= bound * f64::from(one), "{what}: {one} and {several}");
    }
}

#[test]
fn one_level_of_any_tree_is_the_target_alone() {
    let (_folder, masked) = masked_fog();
    let ball = deformed("sphere radius=20 center=\"0 60 0\"");
    let camera = eye_at(-400.0, 48);
    for (what, model) in [("colours", colored_fog()), ("a deformation", ball), ("a mask", masked)] {
        for mode in MODES {
            let look = Look::of_posts(mode);
            let (one, levels) = (draw_one(&model, &camera, &look), draw(&model, &camera, 1, &look).frame);
            assert_eq!(largest_change(&one, &levels), 0.0, "{what}, {mode:?}");
            let (one_cast, levels_cast) = (cast_one(&model, &camera, &look), cast(&model, &camera, 1, &look).frame);
            assert_eq!(
                largest_change(&one_cast, &levels_cast),
                0.0,
                "{what}, {mode:?}, by rays"
            );
            assert!(one.pixels().iter().any(|p| p[3] > 0.0), "{what}, {mode:?}");
        }
    }
}

/// Where both fogs end softly their colours are weighted by a product of two densities, which is quadratic between voxels: its sum over
/// planes as far apart as voxels, h, is off by h/6 times the sum of squared steps of the density. With a filter of two voxels a
/// step is at most ½, and all steps add up to 1. There h is 8 mm, and the second fog 70 mm deep.
#[test]
fn colored_fog_is_as_dense_in_zones_and_of_the_same_colour() {
    let bound = FOG_BOUND + 8.0 / 12.0 / 70.0;
    for mode in MODES {
        assert_alike(&format!("{mode:?}"), pixels(&colored_fog(), mode), bound);
        assert_alike(&format!("{mode:?} by rays"), cast_pixels(&colored_fog(), mode), bound);
    }
}

#[test]
fn deformed_fog_is_as_dense_in_zones() {
    // Its far end is off by a tenth of a voxel at most, there 8 mm wide.
    let bound = FOG_BOUND + 0.1 * 8.0 / FOG_MM;
    for mode in MODES {
        assert_alike(&format!("{mode:?}"), pixels(&deformed(FOG), mode), bound);
        assert_alike(&format!("{mode:?} by rays"), cast_pixels(&deformed(FOG), mode), bound);
    }
}

#[test]
fn masked_fog_is_as_dense_in_zones() {
    // A mask has no filter: its far end lies between two voxels of the level there.
    let bound = FOG_BOUND + 0.5 * 8.0 / FOG_MM;
    for mode in MODES {
        assert_alike(&format!("{mode:?}"), pixels(&masked_fog().1, mode), bound);
    }
}

/// The part of each level that the eye sees.
fn parts<'a>(levels: &Levels<'a>, camera: &Camera) -> Vec<(u32, Target)> {
    let zones = Zones::new(levels, camera, 1.0);
    let part = |zone: &vcsg::projection::levels::Zone| {
        let sides = zone.sides(camera, levels.voxel_mm(zone.level));
        let part = levels.part(zone.level, &footprint(camera), &sides, &subdivision());
        Some((zone.level, part.expect("a target")?))
    };
    zones.zones.iter().filter_map(part).collect()
}

/// Places of a lattice at even distances, about a thousand.
fn some_places(dims: [usize; 3]) -> impl Iterator<Item = DVec3> {
    let count: usize = dims.iter().product();
    (0..count).step_by(count / 1500 + 1).map(move |n| {
        DVec3::new(
            (n % dims[0]) as f64,
            (n / dims[0] % dims[1]) as f64,
            (n / (dims[0] * dims[1])) as f64,
        )
    })
}

#[test]
fn a_deformation_keeps_to_its_error_on_every_level() {
    let model = deformed(FOG);
    let levels = Levels::new(&model, Some(1.0), 4).expect("levels");
    let parts = parts(&levels, &eye_at(0.0, 16));
    assert_eq!(parts.len(), 4);
    for (level, target) in &parts {
        let (morph, report): (&Morph, _) = target.tree.deformations().next().expect("a deformation");
        let world = target.lattice.world_from_grid();
        let mut compared = 0;
        for p in some_places(target.lattice.dims).map(|p| target.lattice.grid_point(p)) {
            let source = target.tree.in_space(Some(0), p);
            let truth = morph.spline().inverse(world.transform_point3(p));
            if let Some(truth) = truth.filter(|_| source.is_finite()) {
                let off = world.inverse().transform_point3(truth).distance(source);
                assert!(off <= 0.1, "{off} voxels on level {level} at {p}");
                compared += 1;
            }
        }
        println!("level {level}: {} cells, {compared} places", report.cells);
        assert!(compared > 50, "{compared} places of level {level}");
    }
}

#[test]
fn a_part_of_the_last_level_has_its_colours_and_its_places() {
    let (_folder, masked) = masked_fog();
    for (what, model) in [
        ("colours", colored_fog()),
        ("a deformation", deformed(FOG)),
        ("a mask", masked),
    ] {
        let levels = Levels::new(&model, Some(1.0), 4).expect("levels");
        let camera = eye_at(0.0, 16);
        let zones = Zones::new(&levels, &camera, 1.0);
        let (level, part) = parts(&levels, &camera).pop().expect("a zone");
        assert_eq!(level, 3);
        let lattice = levels.whole(level).expect("a lattice");
        let whole = Target::on_lattice(&model, lattice, &subdivision()).expect("the whole level");
        assert!(part.lattice.shares_grid(&whole.lattice), "{what}");
        let last = zones.zones.last().expect("a zone");
        let eye = camera.eye_from_world * part.lattice.world_from_lattice;
        // What is drawn: in the zone, and within a frame that is as wide as its focal length.
        let is_seen = |p: &DVec3| {
            let p = eye.transform_point3(*p);
            last.holds(p.z) && p.x.abs().max(p.y.abs()) < 0.5 * p.z
        };
        let mut covered = 0;
        for p in some_places(part.lattice.dims).filter(is_seen) {
            let at = part.lattice.grid_point(p);
            let [ours, meant] = [&part, &whole].map(|target| target.tree.color_sample(at));
            // Filters of the last level are graded by nothing.
            let apart = (ours.sample.coverage - meant.sample.coverage)
                .abs()
                .max((ours.sample.value - meant.sample.value).abs());
            assert!(
                apart < 1e-6 && ours.rgb == meant.rgb,
                "{what}: {ours:?} instead of {meant:?} at {p}"
            );
            covered += usize::from(meant.sample.coverage > 0.0);
        }
        assert!(covered > 50, "{what}: {covered} places");
    }
}
