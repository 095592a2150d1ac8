//! Slices stop at opaque meshes: in every mode, in one band and in several, a frame is the volume in front of the mesh over the mesh.

use glam::DVec3;
use vcsg::conformance::{Drawing, FrameBounds, Storage};
use vcsg::image::Frame;
use vcsg::projection::composite::Blending;
use vcsg::projection::{Mode, bands};
use vcsg::surface::SurfaceView;
use vcsg::surface::reference::hits;

use crate::device::{Bench, Prepared, on_device};
use crate::inside::Case;
use crate::meshes::OnDevice;

/// In how many bands a case is drawn: modes take turns, and each is drawn in any number of them.
pub fn bands_of(seed: u64) -> usize {
    1 + (seed as usize / Mode::ALL.len()) % 4
}

pub fn prepared(bench: &Bench, case: &Case, bands: usize) -> Prepared {
    let spec = case.scene.spec();
    let mut prepared = bench.prepare(&spec);
    if bands > 1 && spec.settings.mode.blending() == Blending::Over {
        prepared.plan = bands::cut_into(prepared.plan, bands);
    }
    prepared
}

pub fn bounds(bench: &Bench, case: &Case, prepared: &Prepared) -> FrameBounds {
    let storage = Storage::of(&prepared.paged, case.scene.target.value_range);
    case.bounds(&Drawing::new(&prepared.plan, storage, bench.precision))
}

pub fn draw(bench: &mut Bench, case: &Case, prepared: &Prepared, on_device: &OnDevice) -> Frame {
    let spec = case.scene.spec();
    let drawn = bench
        .renderer
        .draw_plan(&spec, &prepared.paged, &prepared.plan, &on_device.shown());
    drawn.expect("a frame").0
}

/// Names the variable with the number of random scenes, for longer runs.
const SCENES: &str = "VCSG_TEST_SCENES";

pub fn slices_stop_at_meshes() {
    let scenes = std::env::var(SCENES).map_or(18, |n| n.parse().expect("a number of scenes"));
    on_device(|bench| {
        let (mut in_bands, mut with_meshes) = (0, 0);
        for seed in 2000..2000 + scenes {
            let case = Case::new(seed);
            let prepared = prepared(bench, &case, bands_of(seed));
            let on_device = OnDevice::new(bench, &case.borrowed());
            let bounds = bounds(bench, &case, &prepared);
            let what = format!(
                "{:?} {seed} with {} meshes",
                case.scene.settings.mode,
                case.meshes.len()
            );
            println!(
                "{what}: {} bands, mean width {:.2e}",
                prepared.plan.band_faces_mm.len() + 1,
                bounds.mean_width()
            );
            bench.require_within(&format!("reference of {what}"), &case.reference(), &bounds);
            let frame = draw(bench, &case, &prepared, &on_device);
            bench.require_within(&what, &frame, &bounds);
            in_bands += usize::from(!prepared.plan.band_faces_mm.is_empty() && !case.meshes.is_empty());
            with_meshes += usize::from(!case.meshes.is_empty());
        }
        assert!(
            3 * with_meshes > 2 * scenes as usize,
            "{with_meshes} scenes have meshes"
        );
        assert!(8 * in_bands > scenes as usize, "{in_bands} of them are drawn in bands");
    });
}

/// Law 9: a mesh two slabs farther back shows two slices too many.
pub fn a_mesh_too_far_back_is_out_of_bounds() {
    on_device(|bench| {
        for bands in [1, 4] {
            let (mut shown, mut outside) = (0, 0);
            for seed in (2004..2034).step_by(Mode::ALL.len()) {
                let case = Case::new(seed);
                let spec = case.scene.spec();
                let prepared = prepared(bench, &case, bands);
                let away = spec.camera.eye_from_world.matrix3.transpose().z_axis * 2.0 * spec.planes().step_mm;
                let mut moved = case.meshes.clone();
                for position in moved.iter_mut().flat_map(|(mesh, _)| mesh.positions.iter_mut()) {
                    *position = (DVec3::from_array(position.map(f64::from)) + away).as_vec3().to_array();
                }
                let moved: Vec<_> = moved.iter().map(|(mesh, look)| (mesh, *look)).collect();
                let on_device = OnDevice::new(bench, &moved);
                let bounds = bounds(bench, &case, &prepared);
                let wrong = draw(bench, &case, &prepared, &on_device);
                outside += bounds.pixels_outside(&wrong);
                shown += hits(&SurfaceView::beside(&spec), &case.borrowed())
                    .iter()
                    .flatten()
                    .count();
            }
            println!("two slabs too far back, {bands} bands: {outside} of {shown} pixels are out of bounds");
            assert!(10 * outside > shown, "{outside} of {shown}");
        }
    });
}
