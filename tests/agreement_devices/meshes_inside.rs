//! Slices stop at opaque meshes: in every mode, in one band and in several, a frame is the volume in front of the mesh over the mesh.

use glam::DVec3;
use vcsg::conformance::{Drawing, FrameBounds, MeshBounds, Storage};
use vcsg::image::Frame;
use vcsg::projection::composite::{Blending, over_surfaces};
use vcsg::projection::{FrameSpec, Mode, TransferFunction, bands, reference};
use vcsg::render::DepthScale;
use vcsg::surface::reference::{Hit, hits};
use vcsg::surface::{Mesh, MeshLook, SurfaceView};
use vcsg::target::VoxelTarget;

use crate::device::{Bench, Prepared, on_device};
use crate::meshes::{OnDevice, frame_of};
use crate::random::Random;
use crate::scene::{Recipe, Scene};
use crate::shapes::{look, sheet, sphere};

/// A scene with a wall across the line of sight, a ball and a slanting sheet: some of them.
struct Case {
    scene: Scene,
    meshes: Vec<(Mesh, MeshLook)>,
    bands: usize,
}

impl Case {
    fn new(seed: u64) -> Self {
        let random = &mut Random(seed ^ 0x5EED);
        let mut scene = Recipe {
            mode: Mode::ALL[seed as usize % Mode::ALL.len()],
            ..Recipe::random(seed)
        }
        .scene();
        let opaque = random.below(2) == 0;
        if opaque {
            let points = scene.transfer.points().to_vec();
            scene.transfer = TransferFunction::new(points, 0.2).expect("the same points");
        }
        let bounds = scene.target.lattice.world_bounds();
        let (center, radius) = (bounds.center(), bounds.size().min_element() * 0.5);
        let world_from_eye = scene.camera.eye_from_world.matrix3.transpose();
        let [right, down, away] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| world_from_eye * axis);
        let off = |random: &mut Random| center + away * radius * random.between(-0.6, 0.6);
        let all = [
            sheet(off(random), [right * radius * 0.8, down * radius * 0.5]),
            sphere(off(random), radius * random.between(0.3, 0.7)),
            sheet(off(random), [(right + away) * radius * 0.6, down * radius]),
        ];
        let meshes = all.into_iter().filter(|_| random.below(2) == 0).collect::<Vec<_>>();
        Self {
            scene,
            meshes: meshes.into_iter().map(|mesh| (mesh, look(random))).collect(),
            bands: 1 + random.below(4),
        }
    }

    fn borrowed(&self) -> Vec<(&Mesh, MeshLook)> {
        self.meshes.iter().map(|(mesh, look)| (mesh, *look)).collect()
    }

    fn prepared(&self, bench: &Bench) -> Prepared {
        let spec = self.scene.spec();
        let mut prepared = bench.prepare(&spec);
        if self.bands > 1 && spec.settings.mode.blending() == Blending::Over {
            prepared.plan = bands::cut_into(prepared.plan, self.bands);
        }
        prepared
    }

    /// What a pixel may be: of the slices that are surely in front of the mesh all, of those that may be any.
    fn bounds(&self, bench: &Bench, prepared: &Prepared, on_device: &OnDevice) -> FrameBounds {
        let spec = self.scene.spec();
        let eye = &spec.camera.eye_from_world;
        let all = spec.target.lattice.world_bounds().transformed(eye);
        let scale = DepthScale::new(spec.camera, &all.hull(&on_device.bounds().transformed(eye)));
        let view = SurfaceView::beside(&spec);
        let meshes = MeshBounds::new(&view, &self.borrowed(), &scale, &bench.precision);
        let storage = Storage::of(&prepared.paged, spec.target.value_range);
        let drawing = Drawing::new(&prepared.plan, storage, bench.precision);
        FrameBounds::among(&spec, &drawing, &meshes)
    }

    /// The reference projector with only the samples in front of what rays hit, over that.
    fn reference(&self) -> Frame {
        let spec = self.scene.spec();
        let hits = hits(&SurfaceView::beside(&spec), &self.borrowed());
        let projection = in_front(&spec, &hits);
        over_surfaces(spec.settings.mode, &projection, &frame_of(&hits, spec.camera.size))
    }
}

fn in_front(spec: &FrameSpec, hits: &[Option<Hit>]) -> Frame {
    let eye_from_lattice = vcsg::projection::eye_from_lattice(&spec.target.lattice, spec.camera);
    let [width, height] = spec.camera.size;
    let shown = |at: DVec3| {
        let eye = eye_from_lattice.transform_point3(at);
        let px = spec.camera.project(eye).floor();
        let (x, y) = (
            px.x.clamp(0.0, f64::from(width - 1)),
            px.y.clamp(0.0, f64::from(height - 1)),
        );
        let hit = hits[y as usize * width as usize + x as usize];
        hit.is_none_or(|hit| eye.z < hit.depth_mm)
    };
    reference::render_where(&VoxelTarget::new(spec.target), spec, &shown)
}

fn draw(bench: &mut Bench, case: &Case, prepared: &Prepared, on_device: &OnDevice) -> Frame {
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
            let prepared = case.prepared(bench);
            let on_device = OnDevice::new(bench, &case.borrowed());
            let bounds = case.bounds(bench, &prepared, &on_device);
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
                let case = Case {
                    bands,
                    ..Case::new(seed)
                };
                let spec = case.scene.spec();
                let prepared = case.prepared(bench);
                let away = spec.camera.eye_from_world.matrix3.transpose().z_axis * 2.0 * spec.planes().step_mm;
                let mut moved = case.meshes.clone();
                for position in moved.iter_mut().flat_map(|(mesh, _)| mesh.positions.iter_mut()) {
                    *position = (DVec3::from_array(position.map(f64::from)) + away).as_vec3().to_array();
                }
                let moved: Vec<_> = moved.iter().map(|(mesh, look)| (mesh, *look)).collect();
                let on_device = OnDevice::new(bench, &moved);
                let bounds = case.bounds(bench, &prepared, &on_device);
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
