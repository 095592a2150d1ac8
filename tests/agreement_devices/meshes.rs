//! Meshes on a device are within bounds derived from its precision, and so are rays cast at their triangles.

use glam::DVec3;
use vcsg::conformance::MeshBounds;
use vcsg::image::Frame;
use vcsg::math::Aabb;
use vcsg::projection::{Settings, View};
use vcsg::render::{DepthScale, DeviceMesh, ShownMesh};
use vcsg::surface::reference::{Hit, hits};
use vcsg::surface::{Mesh, MeshColor, MeshLook, MeshShading, SurfaceView};

use crate::device::{Bench, on_device};
use crate::inside::frame_of;
use crate::shapes::{FRAME_PX, Shapes, sheet};

/// Names the variable with the number of random scenes, for longer runs.
const SCENES: &str = "VCSG_TEST_SCENES";

pub struct OnDevice {
    meshes: Vec<(DeviceMesh, MeshLook)>,
}

impl OnDevice {
    pub fn new(bench: &Bench, meshes: &[(&Mesh, MeshLook)]) -> Self {
        let device = bench.renderer.device();
        let upload = |mesh| DeviceMesh::new(device, mesh).expect("a mesh on the device");
        Self {
            meshes: meshes.iter().map(|(mesh, look)| (upload(mesh), *look)).collect(),
        }
    }

    pub fn shown(&self) -> Vec<ShownMesh<'_>> {
        let shown = self.meshes.iter();
        shown.map(|(mesh, look)| ShownMesh { mesh, look: *look }).collect()
    }

    pub fn bounds(&self) -> Aabb {
        self.meshes
            .iter()
            .fold(Aabb::EMPTY, |all, (mesh, _)| all.hull(&mesh.bounds()))
    }
}

/// A scene's meshes alone, on the device and as they may be.
struct Case {
    shapes: Shapes,
    on_device: OnDevice,
    bounds: MeshBounds,
}

impl Case {
    fn new(bench: &Bench, shapes: Shapes) -> Self {
        let on_device = OnDevice::new(bench, &shapes.borrowed());
        let world = on_device.bounds();
        let view = SurfaceView::alone(&shapes.camera, &shapes.settings, &world);
        let scale = DepthScale::new(&shapes.camera, &world.transformed(&shapes.camera.eye_from_world));
        let bounds = MeshBounds::new(&view, &shapes.borrowed(), &scale, &bench.precision);
        Self {
            shapes,
            on_device,
            bounds,
        }
    }

    fn frame(&self, bench: &mut Bench) -> Frame {
        let Shapes { camera, settings, .. } = &self.shapes;
        let drawn = bench.renderer.draw_meshes(camera, settings, &self.on_device.shown());
        drawn.expect("a frame")
    }

    fn depths_mm(&self, bench: &mut Bench) -> Vec<f32> {
        let drawn = bench.renderer.mesh_depths(&self.shapes.camera, &self.on_device.shown());
        drawn.expect("depths")
    }

    fn reference(&self) -> Vec<Option<Hit>> {
        let world = self.on_device.bounds();
        let view = SurfaceView::alone(&self.shapes.camera, &self.shapes.settings, &world);
        hits(&view, &self.shapes.borrowed())
    }
}

pub fn meshes_are_within_bounds() {
    let scenes = std::env::var(SCENES).map_or(40, |n| n.parse().expect("a number of scenes"));
    on_device(|bench| {
        let mut covered = 0;
        for seed in 0..scenes {
            let case = Case::new(bench, Shapes::random(seed));
            let reference = case.reference();
            let outside = case
                .bounds
                .pixels_outside(&frame_of(&reference, case.shapes.camera.size));
            assert_eq!(outside, 0, "the reference of scene {seed}");
            let depth = |hit: &Option<Hit>| hit.map_or(f32::INFINITY, |hit| hit.depth_mm as f32);
            let depths: Vec<f32> = reference.iter().map(depth).collect();
            assert_eq!(
                case.bounds.depths_outside(&depths),
                0,
                "depths of the reference of scene {seed}"
            );
            let outside = case.bounds.pixels_outside(&case.frame(bench));
            assert_eq!(outside, 0, "scene {seed}");
            let outside = case.bounds.depths_outside(&case.depths_mm(bench));
            assert_eq!(outside, 0, "depths of scene {seed}");
            covered += case.bounds.covered();
        }
        println!("meshes: {covered} pixels surely covered");
        assert!(covered as u64 > 500 * scenes, "{covered}");
    });
}

/// A sheet straight across the line of sight whose colour goes up and down by 1 from column to column: it is known up to how far it
/// changes over twice what a vertex may be off, and what interpolation adds twice, to a numerator and to a denominator, either way.
pub fn a_sheet_has_narrow_bounds() {
    on_device(|bench| {
        let cube = Aabb::new(DVec3::splat(-20.0), DVec3::splat(20.0));
        let camera = View::default().camera(&cube, FRAME_PX);
        let across = [DVec3::X * 15.0, DVec3::NEG_Z * 15.0];
        let mut mesh = sheet(DVec3::X * 5.0, across);
        let color = |position: &[f32; 3]| {
            [if (position[0] / 10.0).round() as i32 % 2 == 0 {
                0
            } else {
                255
            }; 4]
        };
        mesh.colors = mesh.positions.iter().map(color).collect();
        let look = MeshLook {
            color: MeshColor::OfVertices,
            ..MeshLook::default()
        };
        let settings = Settings {
            shading: None,
            ..Settings::default()
        };
        let case = Case::new(
            bench,
            Shapes {
                meshes: vec![(mesh, look)],
                camera,
                settings,
            },
        );
        let column_px = 10.0 * camera.pixels_per_mm(40.0);
        let expected = 2.0 * bench.precision.vertex_px / column_px + 4.0 * bench.precision.interpolated;
        let mean = case.bounds.mean_width();
        println!("a sheet's bounds are {mean:.2e} wide, {expected:.2e} by first principles");
        assert!(mean > expected && mean < 1.25 * expected, "{mean} and {expected}");
    });
}

/// What is no mesh is refused, and what is nowhere is not drawn.
pub fn odd_meshes_do_no_harm() {
    on_device(|bench| {
        let mut shapes = Shapes::random(3);
        shapes.meshes.truncate(1);
        let right = Case::new(bench, shapes).frame(bench);
        let mut shapes = Shapes::random(3);
        shapes.meshes.truncate(1);
        let mesh = &mut shapes.meshes[0].0;
        let first = mesh.positions.len() as u32;
        mesh.positions
            .to_mut()
            .extend([[f32::NAN; 3], [f32::INFINITY, 0.0, 0.0]]);
        mesh.triangles.to_mut().extend([[0, 1, first], [first + 1, 1, 2]]);
        let on_device = OnDevice::new(bench, &shapes.borrowed());
        let drawn = bench
            .renderer
            .draw_meshes(&shapes.camera, &shapes.settings, &on_device.shown());
        assert!(
            drawn.expect("a frame") == right,
            "as without triangles that are nowhere"
        );
        shapes.meshes[0].0.triangles.to_mut().push([0, 1, first + 2]);
        let refused = DeviceMesh::new(bench.renderer.device(), &shapes.meshes[0].0);
        let message = refused.err().expect("an error").to_string();
        assert!(message.contains(&format!("vertex {}", first + 2)), "{message}");
        let empty = [(&Mesh::default(), MeshLook::default())];
        let on_device = OnDevice::new(bench, &empty);
        for meshes in [on_device.shown(), Vec::new()] {
            let drawn = bench.renderer.draw_meshes(&shapes.camera, &shapes.settings, &meshes);
            let nothing = Frame::transparent(FRAME_PX[0], FRAME_PX[1]);
            assert!(drawn.expect("a frame") == nothing, "nothing is drawn of no triangles");
        }
        let mut camera = shapes.camera;
        camera.size[1] = 0;
        assert!(
            bench.renderer.draw_meshes(&camera, &shapes.settings, &[]).is_err(),
            "no pixels"
        );
    });
}

/// Law 9: what is wrong is out of bounds.
pub fn wrong_meshes_are_out_of_bounds() {
    on_device(|bench| {
        let mut faults = [0usize; 5];
        for seed in 0..12 {
            let case = Case::new(bench, Shapes::random(seed));
            let right = case.frame(bench);
            let mut shifted = right.clone();
            shifted.pixels_mut().rotate_right(1);
            faults[0] += case.bounds.pixels_outside(&shifted);
            // Each further fault is in what the device is given.
            let mut wrong = |change: &dyn Fn(&mut Shapes)| {
                let mut shapes = Shapes::random(seed);
                change(&mut shapes);
                let on_device = OnDevice::new(bench, &shapes.borrowed());
                let drawn = bench
                    .renderer
                    .draw_meshes(&shapes.camera, &shapes.settings, &on_device.shown());
                case.bounds.pixels_outside(&drawn.expect("a frame"))
            };
            faults[1] += wrong(&|shapes| {
                let last = shapes.meshes.len() - 1;
                shapes.meshes[last].0.triangles.to_mut().pop();
            });
            faults[2] += wrong(&|shapes| {
                for (_, look) in &mut shapes.meshes {
                    look.shading = match look.shading {
                        MeshShading::Gouraud => MeshShading::Phong,
                        MeshShading::Phong => MeshShading::Gouraud,
                    };
                }
            });
            faults[3] += wrong(&|shapes| {
                if let Some(shading) = &mut shapes.settings.shading {
                    shading.lights.pop();
                }
            });
            faults[4] += wrong(&|shapes| {
                for (mesh, look) in &mut shapes.meshes {
                    mesh.colors.rotate_left(1);
                    if let MeshColor::Uniform(rgb) = &mut look.color {
                        rgb[1] += 0.02;
                    }
                }
            });
        }
        println!(
            "pixels out of bounds: shifted, a triangle less, another shading, a light less, another colour: {faults:?}"
        );
        assert!(faults.iter().all(|pixels| *pixels > 300), "{faults:?}");
    });
}
