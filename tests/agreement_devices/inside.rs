//! Scenes with opaque meshes in them, and what their frames may be.

use glam::DVec3;
use vcsg::conformance::{Drawing, FrameBounds, MeshBounds};
use vcsg::image::Frame;
use vcsg::math::Aabb;
use vcsg::projection::composite::over_surfaces;
use vcsg::projection::{FrameSpec, Mode, TransferFunction, reference};
use vcsg::render::DepthScale;
use vcsg::surface::reference::{Hit, hits};
use vcsg::surface::{Mesh, MeshLook, SurfaceView};
use vcsg::target::VoxelTarget;

use crate::random::Random;
use crate::scene::{Recipe, Scene};
use crate::shapes::{look, sheet, sphere};

/// A scene with a wall across the line of sight, a ball and a slanting sheet: some of them.
pub struct Case {
    pub scene: Scene,
    pub meshes: Vec<(Mesh, MeshLook)>,
}

impl Case {
    pub fn new(seed: u64) -> Self {
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
        }
    }

    pub fn borrowed(&self) -> Vec<(&Mesh, MeshLook)> {
        self.meshes.iter().map(|(mesh, look)| (mesh, *look)).collect()
    }

    /// What a pixel may be: of the samples that are surely in front of the mesh all, of those that may be any.
    pub fn bounds(&self, drawing: &Drawing) -> FrameBounds {
        let spec = self.scene.spec();
        let positions = self.meshes.iter().flat_map(|(mesh, _)| mesh.positions.iter());
        let meshes = Aabb::of_points(positions.map(|p| DVec3::from_array(p.map(f64::from))));
        let all = spec.target.lattice.world_bounds().hull(&meshes);
        let scale = DepthScale::new(spec.camera, &all.transformed(&spec.camera.eye_from_world));
        let view = SurfaceView::beside(&spec);
        let meshes = MeshBounds::new(&view, &self.borrowed(), &scale, &drawing.precision);
        FrameBounds::among(&spec, drawing, &meshes)
    }

    /// The reference projector with only the samples in front of what rays hit, over that.
    pub fn reference(&self) -> Frame {
        let spec = self.scene.spec();
        let hits = hits(&SurfaceView::beside(&spec), &self.borrowed());
        let projection = in_front(&spec, &hits);
        over_surfaces(spec.settings.mode, &projection, &frame_of(&hits, spec.camera.size))
    }
}

/// The colours of what rays hit.
pub fn frame_of(hits: &[Option<Hit>], [width, height]: [u32; 2]) -> Frame {
    let pixel = |hit: &Option<Hit>| {
        hit.map_or([0.0; 4], |Hit { color: [r, g, b], .. }| {
            [r, g, b, 1.0].map(|c| c as f32)
        })
    };
    Frame::from_pixels(width, height, hits.iter().map(pixel).collect()).expect("as many pixels")
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
