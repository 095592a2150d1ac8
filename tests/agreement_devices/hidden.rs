//! Frames that are planned slab by slab, as they are closed: what is passed over does not show.

use vcsg::conformance::{Drawing, FrameBounds, Storage};
use vcsg::projection::composite::Blending;
use vcsg::projection::{Camera, Lens, TransferFunction};

use crate::device::{Bench, on_device};
use crate::inside::Case;
use crate::meshes::OnDevice;
use crate::scene::Scene;

/// So opaque that most rays end soon, on so many planes that there are several slabs, and so near that most of the frame is covered.
fn make_opaque(scene: &mut Scene) {
    let points = scene.transfer.points().to_vec();
    scene.transfer = TransferFunction::new(points, 0.05).expect("the same points");
    scene.settings.samples_per_voxel *= 3.0;
    scene.camera = nearer(scene.camera);
}

fn nearer(camera: Camera) -> Camera {
    let lens = match camera.lens {
        Lens::Orthographic { pixels_per_mm } => Lens::Orthographic {
            pixels_per_mm: 1.6 * pixels_per_mm,
        },
        Lens::Perspective { focal_px, near_mm } => Lens::Perspective {
            focal_px: 1.6 * focal_px,
            near_mm,
        },
    };
    Camera { lens, ..camera }
}

/// The slices that a frame is drawn with, and those that it would be if nothing were hidden. The frame is required to be within bounds.
fn require_agreement(bench: &mut Bench, seed: u64, case: &Case) -> [usize; 2] {
    let spec = case.scene.spec();
    let prepared = bench.prepare(&spec);
    let meshes = OnDevice::new(bench, &case.borrowed());
    let drawn = bench.renderer.draw_told(&spec, &prepared.paged, &meshes.shown());
    let drawn = drawn.expect("a frame");
    let storage = Storage::of(&prepared.paged, case.scene.target.value_range);
    let bounds: FrameBounds = case.bounds(&Drawing::new(&drawn.plan, storage, bench.precision));
    bench.require_within(&format!("hidden, seed {seed}"), &drawn.frame, &bounds);
    [drawn.plan.slices.len(), prepared.plan.slices.len()]
}

/// Some slices are passed over, and the picture is that of all of them; among meshes too.
pub fn closed_tiles_are_passed_over() {
    on_device(|bench| {
        let (mut scenes, mut less) = (0, 0);
        for seed in 3000..3060 {
            let mut case = Case::new(seed);
            if case.scene.settings.mode.blending() != Blending::Over {
                continue;
            }
            make_opaque(&mut case.scene);
            let [drawn, all] = require_agreement(bench, seed, &case);
            scenes += 1;
            less += usize::from(drawn < all);
        }
        println!("in {less} of {scenes} scenes slices are passed over");
        assert!(less > 2, "{less} of {scenes}");
    });
}
